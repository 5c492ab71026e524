"""The statistical driving posture: its angles by hand, and bodies brought to them."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

import workbench as wb
from tests.conftest import ROOT
from tests.pedal_plane import heel_from_ball, pedal_plane_angle
from tests.side_view import side_view
from workbench import Driver, Package, driving_angles, driving_posture, measure, seat_curve
from workbench.body.wear import wear
from workbench.files.body.encumbrances import load_encumbrance
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.driving import ANGLES
from workbench.model.environment import Rest, Seat
from workbench.posture.seating.driving import spine_of, spine_tilts
from workbench.posture.seating.driving_angles import drawn_angles, h_point_offset

SMALL = Driver("female", 1.525, 0.803, 51.3 / 1.525**2)
MEDIAN = Driver("male", 1.755, 0.918, 27.47)
LARGE = Driver("male", 1.870, 0.977, 31.66)
REST = Rest("pan", ("LT",), 0.02)
SEAT = Seat("driver", (0.0, 0.35, 0.15), 0.4, 0.25, 0.0, REST, REST, (-0.2, 0.4), (-0.02, 0.05), ())


def package(h30=0.27, l6=None):
    """A car with its seating reference point at the origin, the wheel at the distance the angles
    are centred on."""
    ball = float(seat_curve(h30))
    slope = float(pedal_plane_angle(h30))
    wheel = ball - (0.7 - 0.55556 * h30 if l6 is None else l6)
    heel = (ball - float(heel_from_ball(h30)), 0.22, 0.0)
    return Package(heel, (ball, 0.22, 0.203 * np.sin(slope)), (wheel, 0.35, 0.65), (0.0, 0.35, h30))


@pytest.fixture(scope="module")
def man():
    body = wb.load_body("adult_male")
    at = measure(body, ["stature", "sitting_height"])
    driver = Driver(
        "male", at["stature"], at["sitting_height"], body.mass[0].sum() / at["stature"] ** 2
    )
    poses = posture_pose(body, load_postures(posture_path("adult_male"), body)[0], "driving")
    return body, poses, driver


def driven(man, seat=SEAT, **more):
    body, poses, driver = man
    car = package()
    feet = {"right foot": car.ball, "left foot": (car.ball[0] - 0.03, 0.5, 0.13)}
    return driving_posture(body, poses, seat, drivers=[driver], package=car, feet=feet, **more)


@pytest.mark.parametrize(
    ("driver", "hip_to_eye", "pelvis", "thigh", "knee"),
    [
        (SMALL, 5.04, 51.61, 14.06, 122.63),
        (MEDIAN, 5.91, 45.12, 17.96, 119.79),
        (LARGE, 5.86, 43.94, 19.52, 115.79),
    ],
)
def test_three_drivers_have_the_published_codes_angles(driver, hip_to_eye, pelvis, thigh, knee):
    mean = dict(zip(ANGLES, np.degrees(driving_angles(driver, package()).mean), strict=True))
    found = [mean[name] for name in ("hip to eye", "pelvis", "thigh", "knee")]
    assert found == pytest.approx([hip_to_eye, pelvis, thigh, knee], abs=0.02)


def test_a_higher_seat_brings_the_knees_down_by_26_degrees_a_metre():
    low, high = (np.degrees(driving_angles(SMALL, package(h30)).mean[6]) for h30 in (0.2, 0.4))
    assert high - low == pytest.approx(-0.0262 * 200)


def test_the_wheel_farther_aft_counts_by_what_it_is_beyond_the_usual():
    near, far = (
        np.degrees(driving_angles(MEDIAN, package(0.27, l6)).mean[7]) for l6 in (0.50, 0.60)
    )
    assert far - near == pytest.approx(0.0933 * 100)


def test_drawn_angles_scatter_by_the_published_residuals():
    angles = driving_angles(MEDIAN, package())
    rows = drawn_angles(angles.mean, angles.spread, 5, range(2000))
    assert np.degrees(rows.std(axis=0)) == pytest.approx(
        [3.3, 5.0, 6.5, 4.3, 11.4, 13.2, 4.4, 8.9], rel=0.06
    )
    assert rows.mean(axis=0) == pytest.approx(angles.mean, abs=0.02)


def test_the_same_seed_and_person_draw_the_same_posture():
    angles = driving_angles(MEDIAN, package())
    one, same, other = drawn_angles(angles.mean, angles.spread, 5, (3, 3, 4))
    assert np.array_equal(one, same) and not np.allclose(one, other)


def test_the_hip_point_is_aft_of_the_hips_by_the_flesh_between():
    aft, above = h_point_offset(MEDIAN)
    assert (1e3 * aft, 1e3 * above) == pytest.approx(
        (0.4691 * 27.47 + 6.7786, 0.2921 * 27.47 - 7.5027)
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"sex": "other"}, "male or female"),
        ({"age": 9.0}, "16 to 100 years old, got 9"),
        ({"stature": 17.5}, "17500 mm tall"),
        ({"sitting_height": 0.3}, "300 mm sitting"),
        ({"mass_index": 4.0}, "12 to 70"),
    ],
)
def test_an_impossible_driver_is_refused(change, words):
    with pytest.raises(wb.InputError, match=words):
        Driver(
            **({"sex": "male", "stature": 1.7, "sitting_height": 0.9, "mass_index": 25.0} | change)
        )


def test_a_seat_as_high_as_a_lorrys_is_refused():
    with pytest.raises(wb.InputError, match="100 to 500 mm above the heel"):
        driving_angles(MEDIAN, Package((0.8, 0, 0), (0.9, 0, 0.2), (0.4, 0, 0.7), (0, 0, 0.6)))


@lru_cache
def man_spine():
    return spine_of(wb.load_body("adult_male"))


@given(st.lists(st.floats(-1.5, 1.5), min_size=8, max_size=8))
def test_the_trunk_keeps_to_its_stops_and_to_the_line_from_hip_to_eye(scores):
    spine = man_spine()
    mean = driving_angles(MEDIAN, package())
    angles = type(mean)(mean.mean + mean.spread * np.array(scores), mean.spread)
    tilts = spine_tilts(spine, angles.mean[None], angles.spread[None])[0]
    turns = tilts[:-1] - tilts[1:]
    assert np.all((turns >= spine.flexion[:, 0] - 1e-9) & (turns <= spine.flexion[:, 1] + 1e-9))
    c = np.cos(np.append(tilts, tilts[-1]))
    s = np.sin(np.append(tilts, tilts[-1]))
    x, z = spine.links[0].T
    eye = np.sum([x * c - z * s, x * s + z * c], axis=1)
    assert np.arctan2(-eye[0], eye[1]) == pytest.approx(angles.mean[0], abs=2e-4)


def slow_tilts(spine, angles):
    """The same least squares by a general optimiser with numeric slopes."""
    wanted = angles.mean[[5, 4, 3, 2, 1]]
    spread = angles.spread[[5, 4, 3, 2, 1]]

    def off(turn):
        tilt = np.append(turn[0] - np.append(0, np.cumsum(turn[1:])), 0)
        tilt[5] = tilt[4]
        x, z = spine.links[0].T
        link = np.stack([x * np.cos(tilt) - z * np.sin(tilt), x * np.sin(tilt) + z * np.cos(tilt)])
        aft = [link.sum(axis=1), link[:, 0], link[:, 1], link[:, 2], link[:, 3] + link[:, 4]]
        found = [*(np.arctan2(-v[0], v[1]) for v in aft), np.arctan2(link[1, 5], link[0, 5])]
        return np.subtract(found, [angles.mean[0], *wanted])

    bounds = [(-1.0, 2.0), *spine.flexion.tolist()]
    found = minimize(
        lambda t: np.sum((off(t)[1:] / spread) ** 2),
        np.clip([0.7, 0, 0, 0, 0], *np.transpose(bounds)),
        bounds=bounds,
        constraints={"type": "eq", "fun": lambda t: off(t)[0]},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 300},
    )
    return found.x[0] - np.append(0, np.cumsum(found.x[1:]))


def test_tilts_are_those_of_a_general_optimiser():
    mean = driving_angles(MEDIAN, package())
    spine = man_spine()
    drawn = drawn_angles(mean.mean, mean.spread, 2, range(6))
    six = replace(spine, links=np.repeat(spine.links, 6, axis=0))
    found = spine_tilts(six, drawn, np.tile(mean.spread, (6, 1)))
    for row, wanted in zip(found, drawn, strict=True):
        angles = replace(mean, mean=wanted)
        assert np.degrees(row) == pytest.approx(np.degrees(slow_tilts(spine, angles)), abs=0.02)


def test_a_trunk_asked_for_its_own_angles_gets_them_back(man):
    body, _, _ = man
    spine = spine_of(body)
    angles = driving_angles(MEDIAN, package())
    upright = side_view(wb.place(body, wb.pose(body, {}, reference="LT")))[0]
    # one rigid tilt of all five moves every angle by as much; the head's is told from the
    # horizontal
    wanted = upright + np.radians(10.0)
    wanted[6:] = angles.mean[6:]
    found = spine_tilts(spine, wanted[None], angles.spread[None])[0]
    assert np.degrees(found) == pytest.approx([10.0] * 5, abs=0.05)


def test_the_median_man_sits_as_the_angles_say_within_seven_degrees(man):
    found = driven(man)
    angles = side_view(wb.place(man[0], found.poses))
    residual = dict(zip(ANGLES, np.degrees(angles[0] - found.expected[0]), strict=True))
    assert max(abs(v) for v in residual.values()) < 7
    assert residual["hip to eye"] == pytest.approx(0, abs=0.02)


def test_both_feet_are_where_they_are_to_be_and_no_stop_is_breached(man):
    found = driven(man)
    assert max(miss[0] for miss in found.miss.values()) < 1e-4
    assert wb.stops(man[0], found.poses).margin.min() > -1e-3


def foot_and_calf(body, placed):
    """(2, B) [rad] of left and right foot: the angle of its sole to the calf, and its pitch."""
    found = []
    for side in "LR":
        first = int(body.start[body.segment(f"{side}F")])
        heel, ball = (
            placed.centres[:, row] - [[0, 0, 1]] * body.radius[:, [row]]
            for row in (body.sphere_names.index(name, first) for name in ("heel", "ball of foot"))
        )
        # soles are flat in the bodies' zero pose, so the direction from heel to ball of its frame
        foot = placed.world_from_segment[:, body.segment(f"{side}F"), :, :3]
        own = (foot.transpose(0, 2, 1) @ (ball - heel)[..., None])[..., 0]
        sole = (foot @ (own * [1.0, 1.0, 0.0])[..., None])[..., 0]
        calf = body.segment(f"{side}LL")
        knee, ankle = (
            body.joint_in_child[:, body.joint(f"{side}K")],
            body.joint_in_parent[:, body.joint(f"{side}A")],
        )
        up = placed.world_from_segment[:, calf, :, :3] @ (knee - ankle)[..., None]
        way = up[..., 0] / np.linalg.norm(up[..., 0], axis=1, keepdims=True)
        toe = sole / np.linalg.norm(sole, axis=1, keepdims=True)
        found.append([np.arccos(np.sum(way * toe, axis=1)), np.arcsin(toe[:, 2])])
    return np.array(found).transpose(1, 0, 2)


def test_the_ankle_on_the_accelerator_is_comfortable(man):
    angle, _ = np.degrees(foot_and_calf(man[0], wb.place(man[0], driven(man).poses)))
    assert 85 < angle[1, 0] < 110


def test_the_seat_is_where_thigh_knee_and_ankle_come_nearest_to_what_is_expected(man):
    body = man[0]
    found = driven(man)
    expected = driving_angles(man[2], package())

    def cost(forward):
        poses = driven(man, positions=np.array([[forward, found.up[0]]])).poses
        placed = wb.place(body, poses)
        off = (side_view(placed)[0] - expected.mean)[[6, 7]] / expected.spread[[6, 7]]
        ankle, _ = np.degrees(foot_and_calf(body, placed))
        return np.sum(off**2) + ((ankle[1, 0] - 97.5) / 10) ** 2

    least = cost(found.forward[0])
    assert least < min(cost(found.forward[0] + way) for way in (-0.03, -0.015, 0.015, 0.03))


def test_the_ball_stays_on_the_accelerator_and_its_heel_is_lifted_by_25_millimetres_at_most(man):
    body = man[0]
    car = package()
    placed = wb.place(body, driven(man).poses)
    first = int(body.start[body.segment("RF")])
    rows = {name: body.sphere_names.index(name, first) for name in ("heel", "ball of foot")}
    heel, ball = (placed.centres[0, row] for row in rows.values())
    assert -0.003 < heel[2] - body.radius[0][rows["heel"]] < 0.025 + 0.010  # and its round turns
    plane = np.subtract(car.ball, car.heel)
    normal = np.array([-plane[2], 0.0, plane[0]]) / np.hypot(plane[0], plane[2])
    assert (ball - car.heel) @ normal == pytest.approx(
        body.radius[0][rows["ball of foot"]], abs=0.004
    )
    slope = np.arctan2(plane[2], plane[0])
    _, pitch = foot_and_calf(body, placed)
    assert slope - np.radians(15) < pitch[1, 0] < slope + 1e-6


def test_the_seat_goes_no_farther_than_its_travel_and_says_where_it_wanted_to_be(man):
    free = driven(man)
    short = Seat(**{**SEAT.__dict__, "travel_forward": (-0.02, free.forward[0] - 0.03)})
    held = driven(man, short)
    assert held.forward == pytest.approx(free.forward - 0.03)
    assert held.wanted == pytest.approx(free.wanted)


def test_the_seat_is_lifted_only_as_far_as_the_view_asks(man):
    low = driven(man, eye=0.1)
    assert low.up == SEAT.travel_up[0]
    lifted = driven(man, eye=float(low.eye[0, 2]) + 0.03)
    assert low.up < lifted.up < SEAT.travel_up[1]
    assert lifted.eye[0, 2] == pytest.approx(low.eye[0, 2] + 0.03, abs=2e-3)
    high = driven(man, eye=2.0)
    assert high.up == SEAT.travel_up[1]


def turned_about(point, yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    x, y, z = point
    return c * x - s * y, s * x + c * y, z


@pytest.mark.parametrize("yaw", [0.5 * np.pi, -2.2])
def test_in_a_car_that_is_turned_the_driver_sits_as_before_to_the_bit(man, yaw):
    body, poses, driver = man
    car = package()
    feet = {"right foot": car.ball, "left foot": (car.ball[0] - 0.03, 0.5, 0.13)}
    names = ("heel", "ball", "wheel", "h_point")
    found = driving_posture(
        body,
        poses,
        Seat(**{**SEAT.__dict__, "yaw": yaw, "srp": turned_about(SEAT.srp, yaw)}),
        drivers=[driver],
        package=Package(*(turned_about(getattr(car, name), yaw) for name in names)),
        feet={foot: turned_about(at, yaw) for foot, at in feet.items()},
    )
    before = driven(man)
    assert np.array_equal(found.poses.rotations, before.poses.rotations)
    for name in ("shift", "eye", "hips", "h_point"):
        expected = turned_about(getattr(before, name)[0], yaw)
        assert getattr(found, name)[0] == pytest.approx(expected, abs=1e-9), name


def test_the_foot_on_the_accelerator_drives_be_it_the_left_one(man):
    body, poses, driver = man
    car = package()
    beside = (car.ball[0] - 0.03, 2 * 0.35 - 0.5, 0.13)
    mirrored = Package(
        (car.heel[0], 0.48, car.heel[2]), (car.ball[0], 0.48, car.ball[2]), car.wheel, car.h_point
    )
    found = driving_posture(
        body,
        poses,
        SEAT,
        drivers=[driver],
        package=mirrored,
        feet={"left foot": mirrored.ball, "right foot": beside},
    )
    right = driven(man)
    # the median man's two sides are alike to a tenth of a millimetre
    assert found.forward == pytest.approx(right.forward, abs=2e-3)
    assert found.miss["left foot"] == pytest.approx(right.miss["right foot"], abs=1e-3)


def test_a_dog_does_not_drive():
    with pytest.raises(wb.InputError, match="no joint"):
        spine_of(wb.load_body("dog"))


def test_shoes_move_the_driver_back_by_about_their_soles(man):
    body, poses, driver = man
    shod = wear(body, [load_encumbrance("shoes")])
    bare = driven(man)
    dressed = driven((shod, poses, driver))
    assert 0.015 < bare.forward - dressed.forward < 0.05
    lowest = wb.place(shod, dressed.poses, window=["RF"])
    rows = shod.spheres(shod.segment("RF"))
    # the heel is lifted by 25 mm at most, and the sole's edge turns with it
    assert -0.003 < np.min(lowest.centres[0, rows, 2] - shod.radius[0, rows]) < 0.035


SEATED = ("forward", "up", "shift", "eye", "eye_off", "spare_travel", "wanted", "hips", "h_point")


def test_many_drivers_sit_as_each_of_them_does_alone(man):
    body, poses, driver = man
    car = package()
    feet = {"right foot": car.ball, "left foot": (car.ball[0] - 0.03, 0.5, 0.13)}
    sizes = (1.62, 1.86, 1.75, 1.70)
    bodies = wb.stack_bodies([wb.scale(body, {"stature": stature}) for stature in sizes])
    rows = wb.join_poses([poses] * 4)

    def asked(who):
        return driving_posture(
            bodies[who],
            rows.rows(who),
            SEAT,
            drivers=[replace(driver, stature=sizes[k]) for k in who],
            package=car,
            feet=feet,
            eye=0.95,
            seed=3,
            numbers=[7 + int(k) for k in who],
        )

    together = asked(np.arange(4))
    assert len(set(together.forward)) == 4
    for who in ([2], [3, 0], [1]):
        some = asked(np.array(who))
        np.testing.assert_array_equal(some.poses.rotations, together.poses.rotations[who])
        for name in SEATED:
            np.testing.assert_array_equal(getattr(some, name), getattr(together, name)[who])
        for foot in feet:
            np.testing.assert_array_equal(some.miss[foot], together.miss[foot][who])


def test_as_many_drivers_as_poses_are_needed(man):
    with pytest.raises(
        wb.UsageError, match="drivers, numbers: expected 1 of each for 1 poses, got 0 and 1"
    ):
        driving_posture(man[0], man[1], SEAT, drivers=[], package=package(), feet={})


def test_the_code_in_the_docs_runs_and_gives_people_their_angles():
    text = (ROOT / "docs" / "driving.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) == 1
    names = {}
    exec(blocks[0], names)
    assert names["mean"][0] == pytest.approx(0.32 + 0.214 * 25)
    assert names["spread"].shape == (8,)
