"""Every body, environment and study that comes along loads, checks and runs; names follow the
paper."""

from __future__ import annotations

import csv
import json
import subprocess
import sys

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import workbench as wb
from tests.accommodations import ACCOMMODATIONS, smaller_study
from tests.conftest import REFERENCE, ROOT, real_input, tracked
from tests.paper_tables import PAPER_JOINTS, PAPER_SEGMENTS
from workbench.files.kinds import check_file, json_schemas
from workbench.report.folder import write_report
from workbench.report.result_rows import result_file

YAML = tracked(
    "bodies/*.yaml",
    "bodies/populations/*.yaml",
    "bodies/encumbrance/*.yaml",
    "environments/*/environment.yaml",
    "studies/*.yaml",
)
STUDIES = [path.stem for path in tracked("studies/*.yaml")]


def is_data(path):
    head = path.read_text()[:4000]
    keys = ("body", "environment", "study", "postures", "population", "growth", "encumbrance")
    return any(f"\n{key}:" in "\n" + head for key in keys)


@pytest.mark.parametrize(
    "path",
    [p for p in YAML if is_data(p)],
    ids=lambda p: p.name if "env" not in p.name else p.parent.name,
)
def test_every_file_of_the_catalogue_checks_without_a_warning(path):
    assert check_file(path).warnings == ()


def test_bubbleman_has_the_papers_segments_with_their_numbers_and_names(bubbleman):
    table = {
        (n, s, name)
        for n, s, name in zip(
            bubbleman.segment_numbers, bubbleman.segments, bubbleman.segment_names, strict=True
        )
    }
    assert table == set(PAPER_SEGMENTS)


def test_bubbleman_has_the_papers_joints_between_the_papers_segments(bubbleman):
    rows = set()
    for j, name in enumerate(bubbleman.joints):
        parent = bubbleman.segments[bubbleman.parent[j + 1]]
        rows.add(
            (
                bubbleman.joint_numbers[j],
                name,
                bubbleman.joint_names[j],
                parent,
                bubbleman.segments[j + 1],
            )
        )
    assert rows == set(PAPER_JOINTS)


def test_bubbleman_is_of_250_to_400_spheres_and_median_mass(bubbleman):
    assert 250 <= len(bubbleman.sphere_names) <= 400
    assert bubbleman.mass[0].sum() == pytest.approx(84.6, abs=0.05)


def test_the_right_hand_has_the_papers_directions(bubbleman):
    table = dict(
        zip(
            ("front", "back", "left", "right", "top", "bottom"),
            bubbleman.directions[bubbleman.segment("RHN")].tolist(),
            strict=True,
        )
    )
    assert (table["back"], table["top"], table["left"]) == ([0, -1, 0], [0, 0, -1], [1, 0, 0])


def median(name):
    path = real_input(REFERENCE / "ansur2_percentiles.csv")
    return next(
        float(row["M50"])
        for row in csv.DictReader(path.read_text().splitlines())
        if row["dim"] == name
    )


def extent(library, posture, *, segments, axis):
    placed, names = library
    body = placed.body
    p = names.index(posture)
    rows = np.isin(body.sphere_segment, [body.segment(s) for s in segments])
    c = placed.centres[p, rows, axis]
    r = body.radius[0, rows]
    return 1000 * (c - r).min(), 1000 * (c + r).max()


def test_bubbleman_stands_1755_mm_tall(library):
    low, high = extent(library, "standing", segments=library[0].body.segments, axis=2)
    assert high - low == pytest.approx(median("stature"), abs=3)


@pytest.mark.parametrize(
    ("measure", "segments", "axis"),
    [
        ("footlength", ["LF"], 0),
        ("footbreadthhorizontal", ["LF"], 1),
        ("headbreadth", ["H"], 1),
        ("handlength", ["LHN"], 2),
    ],
)
def test_bubblemans_parts_have_median_extents(library, measure, segments, axis):
    low, high = extent(library, "standing", segments=segments, axis=axis)
    # ears stand out from the head's breadth; the hand is measured to its wrist crease
    slack = {"headbreadth": 30, "handlength": 35}.get(measure, 8)
    assert high - low == pytest.approx(median(measure), abs=slack)


def test_bubbleman_sits_918_mm_tall(library):
    low, _ = extent(library, "seated", segments=["LT"], axis=2)
    _, high = extent(library, "seated", segments=["H"], axis=2)
    assert high - low == pytest.approx(median("sittingheight"), abs=5)


def test_left_and_right_mirror_each_other(bubbleman):
    for name in bubbleman.segments:
        if name.startswith("L") and name not in ("LT",):
            left, right = (
                bubbleman.centre[0, bubbleman.spheres(bubbleman.segment(s))]
                for s in (name, "R" + name[1:])
            )
            assert np.allclose(left * [1, -1, 1], right, atol=1e-9), name


def test_all_library_postures_are_within_the_joint_stops(bubbleman, postures):
    from workbench.files.postures import posture_pose

    for name in postures.postures:
        margins = wb.stops(bubbleman, posture_pose(bubbleman, postures, name))
        assert margins.margin.min() >= -1e-9, name


def test_bubbleman_is_made_by_its_script_to_the_byte(tmp_path):
    subprocess.run(
        [sys.executable, ROOT / "tools" / "bodies" / "make_bubbleman.py", tmp_path],
        check=True,
        capture_output=True,
    )
    assert (tmp_path / "bubbleman.yaml").read_bytes() == (
        ROOT / "bodies" / "bubbleman.yaml"
    ).read_bytes()


def test_the_trainer_is_made_by_its_script_to_the_byte(tmp_path):
    path = ROOT / "environments" / "trainer" / "trainer.obj"
    subprocess.run(
        [sys.executable, ROOT / "tools" / "environments" / "trainer" / "make.py", tmp_path],
        check=True,
        capture_output=True,
    )
    assert (tmp_path / "trainer.obj").read_bytes() == path.read_bytes()


def test_the_trainer_has_25_parts_and_20_controls_and_all_are_solid():
    trainer = wb.load_environment("trainer")
    assert len(trainer.parts) >= 25
    assert len(trainer.controls) >= 20
    assert trainer.solid.all() and not trainer.warnings
    assert {c.zone for c in trainer.controls} == {1, 2, 3}


def test_a_seat_reference_point_is_where_cushion_and_back_planes_meet():
    from workbench.posture.seating.seating import seat_planes

    trainer = wb.load_environment("trainer")
    for seat in trainer.seats:
        cushion, back, _ = seat_planes(seat)
        for part, normal in ((seat.cushion.part, cushion), (seat.back.part, back)):
            polygons = trainer.polygons(trainer.part_index(part))
            height = trainer.normal[polygons] @ normal
            facing = np.flatnonzero(height > 1 - 1e-4) + polygons.start
            gap = np.abs(trainer.normal[facing] @ np.array(seat.srp) - trainer.offset[facing])
            assert gap.min() < 1e-4, (seat.name, part)


def ran(name, folder, *, people):
    """The files that a study writes, by name; accommodation studies with so many people."""
    study = smaller_study(name, folder, people=people) if name in ACCOMMODATIONS else name
    write_report(wb.run(wb.load_study(study)), folder / "out")
    return {path.name: path.read_bytes() for path in (folder / "out").iterdir()}


SAID = {
    "contact": ("sphere", "polygon"),
    "clearance": ("sphere", "polygon"),
    "seated": ("sphere", "polygon"),
    "excursion": ("sphere",),
    "self_contact": ("sphere", "other_sphere"),
    "between_people": ("sphere", "other_sphere", "other_person"),
}
"""What a finding of a check must say besides person, limb and value."""


def unsaid(result):
    """What findings of a result do not say: criterion and key."""
    limbs = tuple(wb.load_body("adult_male").segment_names)
    found = []
    for verdict in result["verdicts"]:
        if verdict["check"] not in SAID or verdict["interval"]:  # a share of people has no limb
            continue
        for finding in filter(None, [verdict["worst"], *verdict["breaches"]]):
            keys = [key for key in SAID[verdict["check"]] if finding[key] is None]
            keys += [] if finding["subject"].startswith(limbs) else ["subject"]
            if "polygon" in SAID[verdict["check"]]:
                keys += [] if f"polygon {finding['polygon']}" in finding["target"] else ["target"]
            elif "other_sphere" in SAID[verdict["check"]]:
                keys += [] if finding["target"].startswith(limbs) else ["target"]
            found += [(verdict["name"], key) for key in [*keys, *_empty(finding)]]
    return found


def _empty(finding):
    return [key for key in ("case", "person", "sentence") if not finding[key]]


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_runs_and_writes_a_result_of_its_schema(name, tmp_path):
    files = ran(name, tmp_path, people=2 if name.startswith("car_") else 4)
    result = json.loads(files["result.json"])
    Draft202012Validator(json_schemas()["result"]).validate(result)
    assert not unsaid(result)
    assert files["report.html"].startswith(b"<!doctype html>")
    assert len(files["report.html"]) < (1_500_000 if name == "trainer_clearance" else 2_500_000)


@pytest.mark.nightly
@pytest.mark.parametrize("name", STUDIES)
def test_every_study_runs_to_the_same_bytes_twice(name, tmp_path):
    """By default small studies do so in test_cli, test_crash and test_accommodation_study, and
    reaches in test_reach."""
    for number in ("first", "second"):
        (tmp_path / number).mkdir()
    assert ran(name, tmp_path / "first", people=20) == ran(name, tmp_path / "second", people=20)


def test_the_first_study_passes_and_its_sitters_rest_on_their_seats():
    result = wb.run(wb.load_study("trainer_clearance"))
    assert [v.criterion.name for v in result.verdicts if not v.passed] == []
    rows = result_file(result)
    rest = {(c.person, c.part) for c in rows.postures[0].contacts if c.part and "seat" in c.part}
    assert {("pilot", "left_seat_pan"), ("pilot", "left_seat_back")} <= rest
    deep = [c for c in rows.postures[0].contacts if c.part == "left_seat_pan" and c.segment == "LT"]
    assert max(-c.distance_mm for c in deep) == pytest.approx(20, abs=0.5)


@pytest.mark.parametrize("kind", sorted(json_schemas()))
def test_published_schemas_are_those_of_the_code(kind):
    published = json.loads((ROOT / "docs" / "schemas" / f"{kind}.schema.json").read_text())
    assert published == json_schemas()[kind]
