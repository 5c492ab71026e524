"""Families of bodies: members at any coefficients and detail, bodies to measures within the family,
bad basis files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.family import write_family
from workbench import load_population_model, measure, person_body, scale
from workbench.body.scaling.morph import morph
from workbench.body.scaling.scale import scale_many
from workbench.body.scaling.space import shape_space
from workbench.cli import main
from workbench.model.basis import in_order

SIX = (
    "stature",
    "sitting_height",
    "bideltoid_breadth",
    "knee_height_sitting",
    "shoulder_elbow_length",
    "foot_length",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("family")
    write_family(made)
    return made


@pytest.fixture(scope="module")
def adult(folder):
    return wb.load_body(folder / "adult.yaml")


def changed(folder, to, **arrays):
    """A copy of the family with other arrays (None: left out); returns the path of its body."""
    to.mkdir(exist_ok=True)
    with np.load(folder / "family.npz") as old:
        new = {name: old[name] for name in old.files} | arrays
    np.savez(to / "family.npz", **{name: value for name, value in new.items() if value is not None})
    (to / "adult.yaml").write_text((folder / "adult.yaml").read_text())
    return to / "adult.yaml"


# -------------------------------------------------------------------------------------------------
# members


def test_a_body_file_names_its_family_and_its_place_in_it(adult):
    assert repr(adult.basis) == "ShapeBasis(family.npz: 13 coefficients, coarse, fine)"
    assert adult.basis_at[0].tolist() == [0.0] * 13


def test_the_member_at_a_bodys_own_coefficients_is_that_body(adult):
    same = morph(adult, adult.basis_at[0], "fine")
    for field in (
        "centre",
        "radius",
        "joint_in_parent",
        "joint_in_child",
        "mass",
        "twist_share",
        "enclosing_radius",
    ):
        assert np.allclose(getattr(same, field), getattr(adult, field), atol=1e-9), field


def test_the_component_of_size_makes_the_body_four_per_cent_larger_in_every_measure(adult):
    large = morph(adult, np.eye(13)[0], "fine")
    before = measure(adult, SIX)
    after = measure(large, SIX)
    assert all(after[name] == pytest.approx(1.04 * before[name]) for name in SIX)
    assert large.mass[0].sum() == pytest.approx(1.04**3 * adult.mass[0].sum())


def test_a_coarse_member_has_fewer_spheres_and_the_same_joints(adult):
    coarse = morph(adult, adult.basis_at[0], "coarse")
    assert len(coarse.sphere_names) == 240
    assert np.allclose(coarse.joint_in_parent[0], adult.joint_in_parent[0])


@pytest.mark.parametrize("level", ["coarse", "fine"])
def test_mass_is_the_persons_at_every_level_of_detail(adult, level):
    tall = {"stature": 1.05 * measure(adult)["stature"]}
    for kept in (morph(adult, adult.basis_at[0], level), scale(adult, {}, detail=level)):
        assert np.allclose(kept.mass, adult.mass, rtol=0, atol=1e-9)
    shown = scale(adult, tall, detail=level)
    [among] = scale_many(adult, [tall], detail=level)
    assert np.array_equal(shown.mass, scale(adult, tall).mass)
    assert np.array_equal(among.mass, shown.mass)


def test_a_persons_segments_weigh_the_same_at_every_level_of_detail(adult):
    people = load_population_model("ansur2")
    tall = {"stature": 1.05 * measure(adult)["stature"]}
    own, coarse = (
        person_body(adult, people, sex="male", measures=tall, detail=detail).body
        for detail in (None, "coarse")
    )
    assert np.array_equal(own.mass, coarse.mass)


@given(st.lists(st.floats(-2, 2), min_size=13, max_size=13))
def test_every_member_weighs_the_same_at_every_level_of_detail(adult, z):
    coarse, fine = (morph(adult, z, level) for level in ("coarse", "fine"))
    assert np.array_equal(coarse.mass, fine.mass)
    back = morph(coarse, adult.basis_at[0], "coarse")
    assert back.mass.sum() == pytest.approx(adult.mass.sum(), rel=0.06)


@given(st.lists(st.floats(-2, 2), min_size=13, max_size=13), st.sampled_from(["coarse", "fine"]))
def test_every_member_stands_on_the_floor_with_spheres_at_its_joints(adult, z, level):
    body = morph(adult, z, level)
    for j in range(len(body.joints)):
        ends = (
            (body.parent[j + 1], body.joint_in_parent[0, j]),
            (j + 1, body.joint_in_child[0, j]),
        )
        gaps = [
            np.linalg.norm(body.centre[0, body.spheres(int(n))] - at, axis=1).min(initial=9)
            for n, at in ends
        ]
        assert min(gaps) == 0.0, body.joints[j]
    assert np.all(body.radius[0] > 0)


@pytest.mark.parametrize(
    ("at", "words"),
    [
        ([0.0] * 12, "13 finite coefficients are needed"),
        ([np.nan] * 13, "13 finite"),
        ([-40.0] + [0.0] * 12, "no body has these coefficients"),
    ],
)
def test_coefficients_that_cannot_be_are_refused(adult, at, words):
    with pytest.raises(wb.InputError, match=words):
        morph(adult, at, "fine")


def test_a_level_that_is_not_there_is_answered_with_those_that_are(adult, bubbleman):
    with pytest.raises(wb.InputError, match=r"did you mean 'fine'\? valid: coarse, fine"):
        morph(adult, adult.basis_at[0], "fin")
    with pytest.raises(wb.InputError, match="belongs to no family"):
        scale(bubbleman, {"stature": 1.7}, detail="coarse")


# ---------------------------------------------------------------------------------------------------
# scaling


def test_scaling_to_all_its_own_measures_returns_the_body(adult):
    same = scale(adult, measure(adult))
    assert np.allclose(same.centre[0], adult.centre[0], atol=1e-12)
    assert np.allclose(same.radius[0], adult.radius[0], atol=1e-12)
    assert np.allclose(same.mass[0], adult.mass[0])


@given(st.lists(st.floats(-2, 2), min_size=13, max_size=13))
def test_the_measures_of_any_member_are_met_to_a_hundredth_of_a_millimetre(adult, z):
    wanted = measure(morph(adult, z, "fine"), SIX)
    found = measure(scale(adult, wanted), SIX)
    assert max(abs(found[name] - wanted[name]) for name in SIX) < 1e-5


def test_a_stature_alone_changes_mostly_what_makes_people_tall(adult):
    tall = scale(adult, {"stature": measure(adult)["stature"] + 0.1})
    off = tall.basis_at[0] - adult.basis_at[0]
    assert np.abs(off[:3]).min() > 0.3
    assert np.abs(off[[4, 5, 7, 8]]).max() < 0.05


def test_what_the_family_does_not_reach_is_closed_by_stretching(adult):
    # no component makes the hand broader
    wider = scale(
        adult, measure(adult, SIX) | {"hand_breadth": measure(adult)["hand_breadth"] + 0.004}
    )
    assert measure(wider)["hand_breadth"] == pytest.approx(
        measure(adult)["hand_breadth"] + 0.004, abs=1e-5
    )
    assert np.abs(wider.basis_at[0]).max() < 0.8


def test_a_mix_that_nobody_has_is_refused_with_the_measure_that_causes_it(adult):
    given = measure(adult, SIX)
    with pytest.raises(
        wb.InputError, match=r"no such person: .*; stature 2400 mm does not go with the others"
    ):
        scale(adult, given | {"stature": 2.4})


def test_how_improbable_the_mix_is_stands_in_standard_deviations(adult):
    with pytest.raises(wb.InputError, match=r"[0-9.]+ standard deviations from people like adult"):
        scale(adult, {"stature": 2.75})


def test_a_length_is_what_its_knobs_add_to_it(adult):
    from workbench.body.scaling.measure import lengths
    from workbench.body.scaling.rig import ON_A_SEAT

    space = shape_space(adult)
    rng = np.random.default_rng(1)
    for name, length in lengths(space.base).items():
        step = rng.normal(size=len(space.neutral)) * 1e-2
        change = space.manikin(space.neutral + step).value(length) - space.base.value(length)
        # where flesh spreads, how much a sphere moves depends a little on where it is
        off = 1e-4 if any(reach.posture in ON_A_SEAT for _, reach in length.terms) else 1e-12
        assert change == pytest.approx(space.row(length) @ step, abs=off), name


def test_blended_spheres_are_measured_where_they_are_placed(adult):
    from workbench.body.scaling.manikin import Manikin
    from workbench.body.scaling.rig import ON_A_SEAT, POSTURES

    blended = replace(adult, blend_share=np.where(adult.blend_joint >= 0, 0.4, 0.0)[None])
    manikin = Manikin(blended)
    for name, angles in POSTURES.items():
        shown = wb.seated(blended) if name in ON_A_SEAT else blended
        placed = wb.place(shown, wb.pose(shown, angles))
        assert np.allclose(placed.centres[0], manikin.centres(name), atol=1e-12)


def test_many_people_are_scaled_as_each_by_itself(adult):
    model = load_population_model("ansur2")
    drawn = wb.draw_people(model, 12, seed=4, men=1).of(SIX)
    people = [dict(zip(SIX, row.tolist(), strict=True)) for row in drawn.measures]
    for made, wanted in zip(scale_many(adult, people), people, strict=True):
        assert isinstance(made, wb.Body)
        found = measure(made, SIX)
        assert max(abs(found[name] - wanted[name]) for name in SIX) < 1e-5
        alone = scale(adult, wanted)
        assert np.array_equal(made.centre, alone.centre)
        assert np.array_equal(made.radius, alone.radius)


def test_among_many_people_one_who_cannot_be_is_an_error_in_place(adult):
    people = [{"stature": 1.7}, {"stature": -1.0}, {"stature": 1.8}]
    made = list(scale_many(adult, people))
    assert [isinstance(one, wb.Body) for one in made] == [True, False, True]
    assert "is not a person's" in str(made[1])


def test_the_measures_not_given_come_near_those_of_such_people(adult):
    model = load_population_model("ansur2")
    made = person_body(adult, model, sex="male", measures={"stature": 1.87})
    found = measure(made.body)
    assert found["stature"] == pytest.approx(1.87, abs=1e-5)
    assert all(abs(found[name] - made.measures[name]) < 0.02 for name in SIX)


def test_a_scaled_member_is_written_with_its_place_in_the_family_and_read_again(folder, tmp_path):
    out = folder / "short.yaml"
    assert (
        main(["body", "scale", str(folder / "adult.yaml"), "--stature", "1650 mm", "-o", str(out)])
        == 0
    )
    short = wb.load_body(out)
    assert measure(short, ["stature"])["stature"] == pytest.approx(1.65, abs=1e-5)
    assert np.abs(short.basis_at[0]).max() > 0.3
    again = scale(short, measure(short))
    assert np.allclose(again.centre[0], short.centre[0], atol=1e-9)


def test_a_body_of_a_family_is_made_in_the_detail_asked_for(folder):
    out = folder / "coarse.yaml"
    flags = ["--stature", "1700 mm", "--detail", "coarse", "-o", str(out)]
    assert main(["body", "scale", str(folder / "adult.yaml"), *flags]) == 0
    made = wb.load_body(out)
    assert len(made.sphere_names) == 240
    assert measure(made, ["stature"])["stature"] == pytest.approx(1.7, abs=1e-5)


# -------------------------------------------------------------------------------------------------
# bad files


def test_a_basis_in_another_order_of_segments_is_put_in_the_bodys(adult):
    segments = adult.segments[::-1]
    joints = adult.joints[::-1]
    there = in_order(adult.basis, segments, joints)
    back = in_order(there, adult.segments, adult.joints)
    assert np.array_equal(back.details["fine"].centre_mean, adult.basis.details["fine"].centre_mean)
    assert np.array_equal(back.details["fine"].blend_joint, adult.basis.details["fine"].blend_joint)
    assert np.array_equal(there.joint_mean, adult.basis.joint_mean[::-1])


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"format": np.array(2)}, "format 2 is unknown; 1 is what can be read"),
        ({"joint_mean": None}, "array 'joint_mean' is missing"),
        ({"origin_mean": np.zeros((4, 3))}, "origin_mean: numbers of shape (20, 3) are needed"),
        ({"anchors": np.full((2, 13), np.nan)}, "anchors: finite numbers are needed"),
        (
            {"fine_radius_mean": np.array(["a"] * 399)},
            "fine_radius_mean: numbers of shape (399,) are needed",
        ),
        ({"fine_segment": np.full(399, 77)}, "fine_segment: numbers from 0 to 19 are needed"),
        ({"segments": np.array(["A"] * 20)}, "is of other segments or joints than this body"),
        ({"fine_blend_share": np.full(399, 2.0)}, "fine_blend_share: numbers from 0 to 1"),
        ({"fine_direction": np.array(["up"] * 399)}, "no direction 'up'"),
        ({"fine_segment": None, "coarse_segment": None}, "no level of detail"),
        ({"fine_segment": None}, "this body's 399 spheres fit none of these levels"),
    ],
)
def test_a_wrong_basis_is_told_with_file_and_array(folder, tmp_path, arrays, words):
    path = changed(folder, tmp_path / "wrong", **arrays)
    with pytest.raises(wb.InputError) as caught:
        wb.load_body(path)
    assert words in str(caught.value)
    assert "family.npz" in str(caught.value)


def test_a_basis_with_pickles_or_of_another_kind_is_refused(folder, tmp_path):
    path = changed(folder, tmp_path / "wrong", anchors=np.array([{}], dtype=object))
    with pytest.raises(wb.InputError, match="not a NumPy archive without pickles"):
        wb.load_body(path)
    (path.parent / "family.npz").write_bytes(b"no archive")
    with pytest.raises(wb.InputError, match="not a NumPy archive without pickles"):
        wb.load_body(path)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("basis: family.npz", "basis: nothing.npz", "basis: no such file 'nothing.npz'"),
        ("- 0.0\n", "", "13 coefficients are needed for family.npz (got 0)"),
    ],
)
def test_a_wrong_place_in_a_family_is_told_where_it_stands(folder, old, new, words):
    path = folder / "wrong.yaml"
    path.write_text(
        (folder / "adult.yaml")
        .read_text()
        .replace(old, new)
        .replace("basis_at:\n", "basis_at: []\n" if not new else "basis_at:\n")
    )
    with pytest.raises(wb.InputError) as caught:
        wb.load_body(path)
    assert words in str(caught.value)
