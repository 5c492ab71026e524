"""Dressed bodies: what helmets, shoes, gloves and vests add to measures, contacts and files."""

from __future__ import annotations

import re

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT, box_part, environment_of
from tests.family import write_family
from workbench import measure
from workbench.body.wear import wear
from workbench.cli import main
from workbench.files.body.encumbrances import load_encumbrance, load_encumbrances
from workbench.files.postures import posture_pose

STUDY = (ROOT / "studies" / "trainer_clearance.yaml").read_text()


def dressed(body, *names):
    return wear(body, load_encumbrances(list(names), body))


def added(body, *names):
    """What things worn add to the measures, in mm."""
    bare = measure(body)
    more = measure(dressed(body, *names))
    return {name: round(1000 * (more[name] - bare[name]), 2) for name in bare}


def test_shoes_add_25_mm_to_heights_from_the_floor_and_30_mm_to_the_foot(bubbleman):
    more = added(bubbleman, "shoes")
    heights = (
        "stature",
        "knee_height_sitting",
        "popliteal_height",
        "trochanterion_height",
        "acromial_height",
    )
    assert [more[name] for name in heights] == [25.0] * 5
    assert more["foot_length"] == 30.0
    assert more["foot_breadth_horizontal"] == 10.0
    assert more["sitting_height"] == more["hand_length"] == 0.0


def test_a_helmet_adds_40_mm_above_37_at_the_sides_and_47_behind(bubbleman):
    more = added(bubbleman, "helmet")
    assert more["stature"] == more["sitting_height"] == 40.0
    assert 74.0 <= more["head_breadth"] <= 94.0  # with the ears in their cups
    assert more["head_length"] == pytest.approx(50.0, abs=3)
    assert more["eye_height_sitting"] == more["interpupillary_breadth"] == 0.0


def test_gloves_add_their_leather_to_the_hand_and_leave_the_joints(bubbleman):
    more = added(bubbleman, "gloves")
    assert more["hand_length"] == more["forearm_hand_length"] == 2.0
    assert more["hand_breadth"] == 4.0
    assert more["radiale_stylion_length"] == 0.0


def test_a_vest_adds_its_thickness_to_front_and_back(bubbleman):
    more = added(bubbleman, "vest")
    assert more["chest_depth"] == more["abdominal_extension_depth_sitting"] == 40.0
    assert more["waist_breadth"] == 40.0


def test_two_things_worn_do_not_lie_on_one_another(bubbleman):
    both = dressed(bubbleman, "helmet", "boots")
    one = dressed(bubbleman, "boots")
    assert len(both.sphere_names) - len(one.sphere_names) == len(
        dressed(bubbleman, "helmet").sphere_names
    ) - len(bubbleman.sphere_names)
    assert both.mass.sum() == pytest.approx(bubbleman.mass[0].sum() + 1.4 + 1.7)


def test_a_dressed_body_stands_on_its_soles(bubbleman):
    body = dressed(bubbleman, "boots")
    placed = wb.place(body, wb.pose(body, {}))
    assert (placed.centres[0, :, 2] - body.radius[0]).min() == pytest.approx(0, abs=1e-9)


def test_a_dressed_body_is_in_no_contact_with_itself_standing_or_seated(bubbleman, postures):
    body = dressed(bubbleman, "helmet", "boots", "gloves", "vest")
    poses = wb.join_poses(
        [wb.pose(body, {}, reference="LT"), posture_pose(body, postures, "seated")]
    )
    assert wb.self_contacts(wb.place(body, poses)).excess.max(initial=-1) < 1e-9


def test_people_dressed_alike_are_rows_of_one_body(bubbleman):
    sizes = [wb.scale(bubbleman, {"stature": stature}) for stature in (1.5, 1.9)]
    boots = load_encumbrances(["boots"], bubbleman)
    both = wear(wb.stack_bodies(sizes), boots, like=bubbleman)
    assert both.sphere_names == dressed(bubbleman, "boots").sphere_names
    for k, body in enumerate(sizes):
        assert np.array_equal(both.centre[k], wear(body, boots, like=bubbleman).centre[0])


def test_a_contact_names_what_is_worn(bubbleman):
    body = dressed(bubbleman, "gloves")
    hand = body.sphere_names[body.spheres(body.segment("RHN"))]
    assert "middle fingertip (gloves)" in hand
    assert len({name for name in hand if name}) == len([name for name in hand if name])


def test_spheres_of_every_segment_stay_together_with_their_own_first(bubbleman):
    body = dressed(bubbleman, "boots")
    for n in range(len(body.segments)):
        own = bubbleman.spheres(n)
        now = body.spheres(n)
        assert np.array_equal(body.centre[0, now][: own.stop - own.start], bubbleman.centre[0, own])


def test_body_scale_dresses_the_body_it_writes(tmp_path):
    out = tmp_path / "dressed.yaml"
    flags = ["--stature", "1755 mm", "--wear", "helmet", "shoes", "-o", str(out)]
    assert main(["body", "scale", "bubbleman", *flags]) == 0
    assert measure(wb.load_body(out), ["stature"])["stature"] == pytest.approx(
        1.755 + 0.065, abs=1e-5
    )


def test_a_dressed_member_of_a_family_is_written_without_it(tmp_path):
    write_family(tmp_path)
    out = tmp_path / "dressed.yaml"
    assert (
        main(
            [
                "body",
                "scale",
                str(tmp_path / "adult.yaml"),
                "--stature",
                "1700 mm",
                "--wear",
                "gloves",
                "-o",
                str(out),
            ]
        )
        == 0
    )
    assert wb.load_body(out).basis is None


def test_a_person_of_a_study_wears_what_it_says(tmp_path):
    path = tmp_path / "dressed.yaml"
    path.write_text(STUDY.replace("seat: left", "seat: left, clothes: [helmet]", 1))
    result = wb.run(wb.load_study(path))
    (pilot, _) = result.postures[0].people
    assert any(name.endswith("(helmet)") for name in pilot.placed.body.sphere_names)
    assert "helmet of pilot" in result.study.inputs
    bare = wb.run(wb.load_study("trainer_clearance"))
    head = pilot.placed.body.segment("H")
    canopy = [k for k, part in enumerate(result.postures[0].environment.parts) if "canopy" in part]
    near, far = (
        each.postures[0].people[0].clearance.distance[:, head][:, canopy].min()
        for each in (result, bare)
    )
    assert near < far - 0.02


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            "[helmt]",
            "people.pilot.clothes: no bodies/encumbrance entry named 'helmt'; did you mean 'helmet'?",
        ),
        ("[helmet, helmet]", "clothes[1]: 'helmet' is worn already; name it once"),
        ("helmet", "a list is needed"),
    ],
)
def test_what_cannot_be_worn_is_told(tmp_path, given, words):
    path = tmp_path / "wrong.yaml"
    path.write_text(STUDY.replace("seat: left", f"seat: left, clothes: {given}", 1))
    with pytest.raises(wb.InputError) as caught:
        wb.load_study(path)
    assert words in str(caught.value)


GOOD = (ROOT / "bodies" / "encumbrance" / "shoes.yaml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("thickness: 5}", "thickness: -5}", "layers[0].thickness: 0 or more is needed"),
        ("thickness: 5}", "thickness: 0}", "a layer has a thickness, a shift or both"),
        ("source: assumption", "sorce: assumption", "unknown key 'sorce'"),
        (
            "thickness: 5}",
            "thickness: 5, beyond: [{direction: up, of: heel}]}",
            "beyond[0].direction",
        ),
    ],
)
def test_a_wrong_encumbrance_file_is_told(tmp_path, old, new, words):
    path = tmp_path / "wrong.yaml"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(wb.InputError) as caught:
        load_encumbrance(path)
    assert words in str(caught.value)
    assert "wrong.yaml:" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[LF, RF], thickness: 5}", "[LFT], thickness: 5}", "worn on segment 'LFT'"),
        (
            "thickness: 5}",
            "thickness: 5, beyond: [{direction: top, of: heal}]}",
            "no sphere named 'heal'; did you mean",
        ),
        ("thickness: 5}", "thickness: 5, subparts: [sole]}", "has no sphere where it is worn"),
    ],
)
def test_what_does_not_fit_a_body_is_told(bubbleman, tmp_path, old, new, words):
    path = tmp_path / "wrong.yaml"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(wb.InputError, match=words):
        dressed(bubbleman, str(path))


def test_what_is_worn_is_named_as_worn_and_without_numbers(bubbleman):
    booted = dressed(bubbleman, "boots", "helmet")
    standing = wb.place(booted, wb.pose(booted, {}))
    everywhere = environment_of(box_part("block", [-3, -3, -3], [3, 3, 3]))
    found = wb.contacts(standing, everywhere)
    names = {
        booted.sphere_names[int(sphere)]: found.name(row)
        for row, sphere in enumerate(found.sphere)
        if booted.sphere_names[int(sphere)].endswith(")")
    }
    assert any(name.endswith(" 2)") for name in names)
    assert all(" in boots" in where or " in helmet" in where for where in names.values())
    assert not any(re.search(r"[(] |\d", where) for where in names.values())
