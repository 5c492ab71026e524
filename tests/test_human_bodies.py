"""The human family: its files are bodies of people, adult and child, with anatomy, masses and
landmarks in place."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import yaml

import workbench as wb
from tests.conftest import ROOT
from workbench import load_population_model, measure
from workbench.body.fitting.polish import union_field
from workbench.body.people.percentile import percentile_values
from workbench.body.scaling.measure import MEASURES
from workbench.body.scaling.morph import morph
from workbench.geometry.nearest import morton_order

NAMES = ("adult_male", "adult_female", "child_6", "child_3")
ADULTS = {"adult_male": 0, "adult_female": 1}
SEATED = {f"{side}{joint}": {"flexion": 90.0} for side in "LR" for joint in "HKE"}
LANDMARKS = {
    "LH": (914, 859),
    "LK": (491, 465),
    "LA": (73, 63),
    "LS": (1439 - 38, 1332 - 38),
    "LE": (1439 - 335 + 8, 1332 - 311 + 7),
    "LW": (1439 - 335 - 267, 1332 - 311 - 240.5),
}
"""Heights [mm], man and woman."""
# de Leva 1996, table 4; shoulder masses from the upper trunk, a fifth of head and neck the neck
SHARES = {
    "LT": (0.1117, 0.1247),
    "CT": (0.1633, 0.1465),
    "UT": (0.133, 0.1279),
    "LSM": (0.0133, 0.0133),
    "N": (0.0139, 0.0134),
    "H": (0.0555, 0.0534),
    "LUA": (0.0271, 0.0255),
    "LLA": (0.0162, 0.0138),
    "LHN": (0.0061, 0.0056),
    "LUL": (0.1416, 0.1478),
    "LLL": (0.0433, 0.0481),
    "LF": (0.0137, 0.0129),
}


@cache
def loaded(name):
    return wb.load_body(name)


@cache
def measured(name):
    return measure(loaded(name))


def world(body):
    """Sphere centres (S, 3) and joints (J, 3) in the zero pose."""
    placed = wb.place(body, wb.pose(body, {}))
    frames = placed.world_from_segment[0][1:]
    return placed.centres[0], np.einsum(
        "jik,jk->ji", frames[:, :, :3], body.joint_in_child[0]
    ) + frames[:, :, 3]


def sole(body):
    """Height [m] of the lowest point in the zero pose."""
    return float((world(body)[0][:, 2] - body.radius[0]).min())


@cache
def volumes(name):
    """(N,) [m3] of each segment: points belong to the segment whose sphere they are deepest in; 9
    mm grid."""
    body = loaded(name)
    centre = world(body)[0]
    step = 0.009 * np.ptp(world(body)[0][:, 2]) / 1.7
    reach = body.radius[0, :, None]
    low = (centre - reach).min(axis=0)
    high = (centre + reach).max(axis=0)
    axes = [np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[morton_order(grid)]
    field, ball = union_field(grid, centre, body.radius[0])
    owner = body.sphere_segment[ball[field < 0]]
    return np.bincount(owner, minlength=len(body.segments)) * step**3


@pytest.mark.parametrize("name", NAMES)
def test_every_measure_can_be_taken(name):
    assert set(measured(name)) == set(MEASURES)
    assert all(0.03 < value < 2.3 for value in measured(name).values())


@pytest.mark.parametrize("level", ["medium", "fine"])
@pytest.mark.parametrize("name", ADULTS)
def test_adults_measure_what_the_median_of_the_survey_does(name, level):
    k = ADULTS[name]
    model = load_population_model("ansur2")
    median = percentile_values(model, ("male", "female")[k], [50.0])[0]
    body = loaded(name)
    found = measure(morph(body, body.basis_at[0], level))
    off = {
        key: 1000 * (found[key] - value)
        for key, value in zip(model.names, median.tolist(), strict=True)
        if key in found and "circumference" not in key
    }
    assert len(off) >= 38
    beyond = {key: d for key, d in off.items() if abs(d) > 5}
    assert not beyond
    assert np.mean(np.abs(list(off.values()))) <= 1


@pytest.mark.parametrize("name", ADULTS)
def test_joints_are_where_the_surveys_landmarks_have_them(name):
    """Medians of ANSUR II: knee and ankle at the lateral epicondyle and malleolus, the hip joint at
    the trochanterion and 15 mm over it, the wrist at the stylion, the elbow some 8 mm over the
    radiale, the shoulder joint 35 to 40 mm under the acromion."""
    body = loaded(name)
    height = dict(zip(body.joints, 1000 * (world(body)[1][:, 2] - sole(body)), strict=True))
    for joint, row in LANDMARKS.items():
        assert height[joint] == pytest.approx(row[ADULTS[name]], abs=5), joint


@pytest.mark.parametrize("name", ADULTS)
def test_thighs_and_shanks_are_as_long_as_peoples(name):
    """Shares of stature between joint centres: AnyBody's AMMR, de Leva 1996."""
    body = loaded(name)
    joints = world(body)[1]
    hip, knee, ankle = (joints[body.joint(n)] for n in ("LH", "LK", "LA"))
    stature = measured(name)["stature"]
    assert 0.2405 <= np.linalg.norm(hip - knee) / stature <= 0.2425
    assert 0.24 <= np.linalg.norm(knee - ankle) / stature <= 0.249


@pytest.mark.parametrize("name", ADULTS)
def test_the_knee_cap_is_in_front_of_its_joint_and_the_joint_deep_in_the_knee(name):
    body = loaded(name)
    centre, joints = world(body)
    knee = joints[body.joint("LK")]
    part = body.spheres(body.segment("LLL"))
    cap = next(
        centre[s] for s in range(*part.indices(len(centre))) if body.sphere_names[s] == "knee cap"
    )
    assert abs(cap[2] - knee[2]) < 0.010
    assert 0.015 < cap[0] - knee[0] < 0.05
    depth, _ = union_field(knee[None], centre, body.radius[0])
    assert depth[0] < -0.03


def test_an_average_mans_hips_are_170_to_180_mm_apart():
    body = loaded("adult_male")
    joints = world(body)[1]
    apart = np.linalg.norm(joints[body.joint("LH")] - joints[body.joint("RH")])
    assert 0.170 <= apart <= 0.180


@pytest.mark.parametrize("name", ADULTS)
def test_volume_times_density_is_the_mass_of_the_whole_and_near_the_table_for_segments(name):
    body = loaded(name)
    k = ADULTS[name]
    density = dict(zip(body.segments, body.basis.density, strict=True))
    found = dict(zip(body.segments, volumes(name), strict=True))
    off = {
        n: found[n] * density[n] / (row[k] * body.mass[0].sum()) - 1 for n, row in SHARES.items()
    }
    assert 985 <= body.mass[0].sum() / sum(found.values()) <= 1065
    assert abs(sum(found[n] * density[n] for n in body.segments) / body.mass[0].sum() - 1) < 0.04
    assert max(map(abs, off.values())) < 0.15, off


def test_bubbleman_is_too_slim_for_his_mass_by_the_volume_that_is_stated():
    density = loaded("bubbleman").mass[0].sum() / volumes("bubbleman").sum()
    assert density == pytest.approx(1170, abs=10)


@pytest.mark.parametrize(
    ("name", "kilograms"),
    [("adult_male", 84.6), ("adult_female", 66.8), ("child_6", 23.4), ("child_3", 15.5)],
)
def test_bodies_weigh_what_they_should(name, kilograms):
    assert loaded(name).mass.sum() == pytest.approx(kilograms, rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_left_is_the_mirror_image_of_right(name):
    body = loaded(name)
    centre, joints = world(body)
    rows = np.column_stack([centre, body.radius[0]])
    for twin in (rows, np.column_stack([joints, np.zeros(len(joints))])):
        image = twin * [1, -1, 1, 1]
        gap = np.abs(image[:, None] - twin[None]).max(axis=2).min(axis=1)
        assert gap.max() < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_subparts_of_bubbleman_and_more_are_named(name):
    body = loaded(name)
    first = loaded("bubbleman")

    def named(b):
        return {
            (b.segments[s], n) for s, n in zip(b.sphere_segment, b.sphere_names, strict=True) if n
        }

    assert named(first) <= named(body)
    assert {("LLL", "calf"), ("N", "nape")} <= named(body)


@pytest.mark.parametrize("name", NAMES)
def test_nobody_touches_himself_standing_or_sitting(name):
    body = loaded(name)
    poses = wb.join_poses([wb.pose(body, {}), wb.pose(body, SEATED)])
    contacts = wb.self_contacts(wb.place(body, poses))
    assert not [
        d for d, a in zip(contacts.distance, contacts.allowed, strict=True) if -d > a + 1e-9
    ]


def test_a_child_is_no_shrunken_adult():
    head = {name: measured(name)["head_length"] / measured(name)["stature"] for name in NAMES}
    sitting = {name: measured(name)["sitting_height"] / measured(name)["stature"] for name in NAMES}
    assert head["child_3"] > head["child_6"] > 1.25 * head["adult_male"]
    # NHTSA, Hybrid III: 546 of 945 mm, 635 of 1143 mm; men 918 of 1755 mm
    assert sitting["child_3"] == pytest.approx(0.578, abs=0.008)
    assert sitting["child_6"] == pytest.approx(0.556, abs=0.008)


@pytest.mark.parametrize("name", NAMES)
def test_fit_errors_are_told_for_every_segment(name):
    body = loaded(name)
    assert np.all(np.isfinite(body.fit_error[0, 1:]))
    assert np.all((body.fit_error[0, 1:] > 0) & (body.fit_error[0, 1:] < 0.05))


@pytest.mark.parametrize("name", NAMES)
def test_the_family_gives_the_body_of_the_file(name):
    body = loaded(name)
    again = morph(body, body.basis_at[0], "medium")
    assert np.abs(world(again)[0] - world(body)[0]).max() < 5e-5
    assert np.abs(again.radius[0] - body.radius[0]).max() < 1e-5


@pytest.mark.parametrize(
    ("level", "low", "high"), [("coarse", 240, 300), ("medium", 380, 420), ("fine", 900, 1000)]
)
def test_there_are_three_levels_of_detail(level, low, high):
    body = loaded("adult_female")
    assert low <= len(body.basis.detail(level).names) <= high
    other = morph(body, body.basis_at[0], level)
    stature, sitting = (1000 * measure(other)[key] for key in ("stature", "sitting_height"))
    assert stature == pytest.approx(1626, abs=12)
    assert sitting == pytest.approx(857, abs=15)


def test_the_basis_is_small_and_scaled_to_unit_variance():
    path = ROOT / "bodies" / "human_basis.npz"
    assert path.stat().st_size < 3e6
    basis = loaded("adult_male").basis
    assert set(basis.anchor_names) == set(NAMES)
    assert np.abs(basis.anchors).max() < 5
    for spread in basis.anchor_spread:
        assert np.linalg.eigvalsh(spread).min() > 0


def test_bodies_say_where_they_come_from():
    for name in NAMES:
        text = (ROOT / "bodies" / f"{name}.yaml").read_text(encoding="utf-8")
        assert "MakeHuman" in text.split("segments:")[0]
        assert yaml.safe_load(text)["licence"] == "CC0-1.0"
