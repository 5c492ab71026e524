"""Sitters: the seat where view and pedals are had, one function for one and for many."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.accommodations import smaller_study
from tests.crowds import crowd_of
from tests.seat_oracle import seat_slowly
from workbench import seat as sit
from workbench.model.environment import Rest, Seat
from workbench.model.joint_angles import attitude_matrix
from workbench.posture.seating.posture import Pedals, positions
from workbench.posture.seating.seating import seat_planes

TRAINER = Pedals({"left foot": (0.93, 0.365, 0.144), "right foot": (0.93, 0.195, 0.144)}, floor=0.0)
EYE = 1.053
FEET = tuple(TRAINER.at)
SOME = st.lists(st.sampled_from(FEET), unique=True, max_size=2).map(tuple)
WAY = st.floats(-0.15, 0.15)
MEASURES = (
    {"stature": 1.52},
    {"stature": 1.60, "thumb_tip_reach": 0.70},
    {"stature": 1.75},
    {"stature": 1.88, "thumb_tip_reach": 0.86},
)


@pytest.fixture(scope="module")
def seat():
    return wb.load_environment("trainer").seat("left")


@pytest.fixture(scope="module")
def people(bubbleman):
    return wb.stack_bodies([wb.scale(bubbleman, measures) for measures in MEASURES])


@pytest.fixture(scope="module")
def crowd(bubbleman):
    sizes = np.random.default_rng(5).normal([1.69, 0.89], [0.09, 0.035], (24, 2))
    return wb.stack_bodies(
        [wb.scale(bubbleman, {"stature": float(s), "sitting_height": float(h)}) for s, h in sizes]
    )


def poses_of(people):
    return wb.join_poses([wb.pose(body, {}, reference="LT") for body in people])


def row(poses, b):
    return wb.Poses(
        poses.rotations[b : b + 1], poses.reference, poses.world_from_reference[b : b + 1]
    )


def missed(found):
    return sum(np.where(miss > 1e-3, miss, 0.0) for miss in found.miss.values())


def test_everybody_sits_as_trying_all_places_slowly_finds(people, seat):
    poses = poses_of(people)
    found = sit(people, poses, seat, eye=EYE, pedals=TRAINER)
    for b, body in enumerate(people):
        one = seat_slowly(body, row(poses, b), seat, eye=EYE, pedals=TRAINER)
        assert found.forward[b] == pytest.approx(one["forward"], abs=1e-9)
        assert found.up[b] == pytest.approx(one["up"], abs=2e-4)
        np.testing.assert_allclose(found.eye[b], one["eye"], atol=3e-4)
        assert found.discomfort[b] == pytest.approx(one["discomfort"], abs=0.03)
        assert found.pressed[b] == pytest.approx(max(one["pressed"], 0.0), abs=3e-4)
        for foot in TRAINER.at:
            assert found.miss[foot][b] == pytest.approx(one["miss"][foot], abs=1e-4)
            assert found.limit[foot][b].text == one["limit"][foot]
    np.testing.assert_allclose(found.spare_travel[:, 0] + found.spare_travel[:, 1], 0.18, atol=1e-9)
    np.testing.assert_allclose(found.eye_off, found.eye[:, 2] - EYE, atol=1e-9)
    np.testing.assert_allclose(found.shift[:, 0], found.forward, atol=1e-12)


LOW_CAR = Seat(
    "car",
    (-0.06, 0.35, 0.157),
    0.42,
    0.24,
    0.0,
    Rest("pan", ("LT",), 0.02),
    Rest("back", ("LT",), 0.015),
    (-0.04, 0.2),
    (-0.015, 0.045),
    (),
)
CAR = Pedals({"left foot": (0.93, 0.46, 0.13), "right foot": (0.96, 0.22, 0.183)}, floor=0.0)
CASES = {
    "trainer": (None, EYE, TRAINER),
    "trainer without a view": (None, None, TRAINER),
    "trainer without a floor": (None, EYE, Pedals(TRAINER.at)),
    "trainer with far pedals": (
        None,
        EYE,
        Pedals({n: (x + 0.12, y, z) for n, (x, y, z) in TRAINER.at.items()}, 0.0),
    ),
    "trainer with one pedal": (None, EYE, Pedals({"right foot": TRAINER.at["right foot"]}, 0.0)),
    "car": (LOW_CAR, 0.88, CAR),
}


@pytest.mark.parametrize("name", CASES)
def test_downhill_comes_to_the_place_that_trying_all_comes_to(crowd, seat, name):
    own, eye, pedals = CASES[name]
    poses = poses_of(crowd)
    quick, slow = (
        sit(crowd, poses, own or seat, eye=eye, pedals=pedals, every=every)
        for every in (False, True)
    )
    same = np.isclose(quick.forward, slow.forward)
    # where discomforts are the same to a thousandth, either will do
    np.testing.assert_allclose(missed(quick)[~same], missed(slow)[~same], atol=2e-4)
    np.testing.assert_allclose(quick.discomfort[~same], slow.discomfort[~same], atol=5e-3)
    assert same.mean() > 0.9
    assert np.all(slow.tried == len(positions((own or seat).travel_forward)))
    if "far" not in name:
        assert quick.tried.mean() < 0.5 * slow.tried.mean()


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("study", "drivers"), [("trainer_accommodation", ""), ("car_driver", "driver")]
)
def test_drawn_people_sit_where_trying_all_places_puts_them(tmp_path, study, drivers):
    """Downhill and everywhere: the same place for each of 40 people drawn from ANSUR II, in their
    own bodies."""
    path = smaller_study(study, tmp_path, people=40)
    if drivers:  # the same people without a driver's posture
        text = path.read_text().replace("{driver: {wheel:", "{predicted: {wheel:")
        path.write_text(re.sub(r"wheel: \w+, h_point: \w+, seed: \d+, ", "", text))
    plan = crowd_of(path)
    work = plan.question.place.cases[0]
    bodies = plan.bodies[:]
    controls = {control.name: control.at for control in plan.environment.controls}
    pedals = Pedals(
        {
            foot: controls[name]
            for foot, name in work.aims.controls.items()
            if foot.endswith("foot")
        },
        plan.environment.points[work.aims.heels][2],
    )
    poses = wb.Poses(
        np.repeat(work.pose.rotations, len(bodies), axis=0),
        work.pose.reference,
        np.repeat(work.pose.world_from_reference, len(bodies), axis=0),
    )
    own = plan.seat
    eye = plan.environment.points[work.aims.eyes][2]
    quick, slow = (
        sit(bodies, poses, own, eye=eye, pedals=pedals, every=every) for every in (False, True)
    )
    np.testing.assert_allclose(quick.forward, slow.forward, atol=1e-9)


FIELDS = ("forward", "up", "shift", "eye", "eye_off", "spare_travel", "discomfort", "tried")


def test_no_answer_depends_on_threads_nor_on_who_else_is_seated(crowd, seat):
    poses = poses_of(crowd)
    one, two = (
        sit(crowd, poses, seat, eye=EYE, pedals=TRAINER, threads=threads) for threads in (1, 2)
    )
    for name in ("forward", "up", "eye", "discomfort"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    order = np.arange(len(crowd))
    for rows in ([0], [7], [23], order[::-1]):
        who = np.array(rows)
        some = sit(crowd[who], poses.rows(who), seat, eye=EYE, pedals=TRAINER)
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(some, name), getattr(one, name)[who], name)
        for name in ("rotations", "world_from_reference"):
            np.testing.assert_array_equal(
                getattr(some.poses, name), getattr(one.poses, name)[who], name
            )
        for foot in TRAINER.at:
            np.testing.assert_array_equal(some.miss[foot], one.miss[foot][who])
            assert some.limit[foot] == tuple(one.limit[foot][k] for k in who)


@pytest.mark.parametrize(
    "left", [(0.95, 0.12, 0.15), (0.93, 0.085, 0.144), (1.1, 0.1, 0.2), (0.8, 0.2, 0.1)]
)
def test_mirrored_pedals_give_the_mirrored_sitter(bubbleman, seat, left):
    side = seat.srp[1]
    right = (0.90, -0.06, 0.13)
    poses = wb.pose(bubbleman, {}, reference="LT")
    found = []
    for one, other, sign in ((left, right, 1), (right, left, -1)):
        at = {"left foot": one, "right foot": other}
        pedals = Pedals({name: (x, side + sign * y, z) for name, (x, y, z) in at.items()}, 0.0)
        found.append(sit(bubbleman, poses, seat, eye=EYE, pedals=pedals))
    one, two = found
    assert one.forward == two.forward
    np.testing.assert_allclose(
        one.poses.world_from_reference, two.poses.world_from_reference, atol=1e-7
    )
    np.testing.assert_allclose(one.discomfort, two.discomfort, atol=1e-4)
    np.testing.assert_allclose(one.miss["left foot"], two.miss["right foot"], atol=1e-6)


@settings(max_examples=12, deadline=None)
@given(st.tuples(*[st.integers(0, 9)] * 4), st.floats(-0.05, 0.15))
def test_more_travel_never_misses_more(crowd_and_seat, ends, farther):
    crowd, seat = crowd_and_seat
    rear, more_rear, front, more_front = (0.01 * end for end in ends)
    pedals = Pedals({n: (x + farther, y, z) for n, (x, y, z) in TRAINER.at.items()}, 0.0)
    less = replace(seat, travel_forward=(-rear, front))
    more = replace(seat, travel_forward=(-rear - more_rear, front + more_front))
    short, long = (sit(crowd, poses_of(crowd), one, eye=EYE, pedals=pedals) for one in (less, more))
    assert np.all(missed(long) <= missed(short) + 2e-4)


@pytest.fixture(scope="module")
def crowd_and_seat(crowd, seat):
    return crowd[:6], seat


def test_longer_legs_on_the_same_trunk_sit_no_farther_forward(bubbleman, seat):
    legs = [
        wb.scale(bubbleman, {"stature": 0.90 + leg, "sitting_height": 0.90})
        for leg in (0.72, 0.78, 0.84, 0.90)
    ]
    legs = wb.stack_bodies(legs)
    found = sit(legs, poses_of(legs), seat, eye=EYE, pedals=TRAINER)
    assert np.all(np.diff(found.forward) <= 1e-9) and found.forward[0] > found.forward[-1]


def test_the_seat_is_the_lowest_that_brings_the_eyes_to_their_height(crowd, seat):
    found = sit(crowd, poses_of(crowd), seat, eye=EYE, pedals=TRAINER)
    low, high = seat.travel_up
    inside = (found.up > low + 1e-9) & (found.up < high - 1e-9)
    assert np.all(np.abs(found.eye_off[inside]) < 1e-6)
    assert np.all(found.eye_off[found.up <= low + 1e-9] >= -1e-6)
    assert np.all(found.eye_off[found.up >= high - 1e-9] <= 1e-6)
    assert inside.any() and not inside.all()


def test_hips_rest_as_deep_in_cushion_and_back_as_the_seat_says(people, seat):
    found = sit(people, poses_of(people), seat, eye=EYE, pedals=TRAINER)
    for b, body in enumerate(people):
        placed = wb.place(body, row(found.poses, b))
        point = np.array(seat.srp) + found.shift[b]
        for way, rest in zip(seat_planes(seat)[:2], (seat.cushion, seat.back), strict=True):
            on = np.isin(body.sphere_segment, [body.segment(name) for name in rest.segments])
            assert np.min(
                (placed.centres[0, on] - point) @ way - body.radius[0, on]
            ) == pytest.approx(-rest.depth, abs=1e-5)


def test_no_stop_of_a_sitters_legs_is_breached(people, seat):
    found = sit(people, poses_of(people), seat, eye=EYE, pedals=TRAINER)
    for b, body in enumerate(people):
        legs = [body.joint(name) for name in ("LH", "LK", "LA", "RH", "RK", "RA")]
        assert wb.stops(body, row(found.poses, b)).margin[0, legs].min() > -1e-3


def test_a_seat_without_travel_stays_and_says_by_how_much_pedals_are_missed(people, seat):
    fixed = replace(seat, travel_forward=(0.0, 0.0), travel_up=(0.0, 0.0))
    far = Pedals({"right foot": (1.9, 0.195, 0.144)}, 0.0)
    found = sit(people, poses_of(people), fixed, eye=EYE, pedals=far)
    assert np.all(found.forward == 0) and np.all(found.up == 0) and np.all(found.tried == 1)
    assert np.all(found.miss["right foot"] > 0.5)
    assert {one.text for one in found.limit["right foot"]} <= {
        "length of the limb",
        "right ankle (plantarflexion)",
    }


def test_pedals_beyond_everybody_bring_the_seat_to_its_front_end(people, seat):
    far = Pedals({n: (1.9, y, z) for n, (_, y, z) in TRAINER.at.items()}, 0.0)
    found = sit(people, poses_of(people), seat, eye=EYE, pedals=far)
    assert np.all(found.forward == 0.09)


def test_a_seat_that_stands_ahead_of_its_rest_goes_no_farther_back(people, seat):
    ahead = replace(seat, travel_forward=(0.03, 0.06))
    assert positions(ahead.travel_forward) == pytest.approx([0.03, 0.04, 0.05, 0.06])
    found = sit(people, poses_of(people), ahead, eye=EYE, pedals=TRAINER)
    assert np.all((found.forward >= 0.03) & (found.forward <= 0.06))
    assert np.all(sit(people, poses_of(people), ahead, eye=EYE, pedals=Pedals({})).forward == 0.03)


def test_who_has_no_pedals_sits_where_the_seat_stands(people, seat):
    found = sit(people, poses_of(people), seat, eye=None, pedals=Pedals({}))
    assert np.all(found.forward == 0) and np.all(found.up == 0) and not found.miss
    placed = wb.place(people[2], row(found.poses, 2))
    on = np.isin(people[2].sphere_segment, [people[2].segment("LT")])
    low = np.min(
        (placed.centres[0, on] - seat.srp) @ seat_planes(seat)[0] - people[2].radius[0, on]
    )
    assert low == pytest.approx(-seat.cushion.depth, abs=1e-9)


@pytest.mark.parametrize(
    ("yaw", "offset"), [(np.pi / 2, (0, 0, 0)), (0.6458, (10, -10, 0)), (0.0, (-7.3, 41, 1.1))]
)
def test_a_seat_that_stands_and_faces_elsewhere_is_sat_in_alike_to_the_bit(
    crowd, seat, yaw, offset
):
    poses = poses_of(crowd)
    turn, offset = attitude_matrix(yaw=yaw), np.array(offset)

    def there(point):
        return tuple(turn @ point + offset)

    elsewhere = replace(seat, srp=there(seat.srp), yaw=yaw)
    # a pedal beyond all, too: how near a foot comes to it is where searches end at a tolerance
    for ahead in (0.0, 0.3):
        at = {name: (x + ahead, y, z) for name, (x, y, z) in TRAINER.at.items()}
        pedals = Pedals({name: there(point) for name, point in at.items()}, offset[2])
        one = sit(crowd, poses, seat, eye=EYE, pedals=Pedals(at, 0.0))
        two = sit(crowd, poses, elsewhere, eye=EYE + offset[2], pedals=pedals)
        assert np.array_equal(one.poses.rotations, two.poses.rotations)
        assert np.array_equal(one.forward, two.forward)
        assert np.array_equal(one.discomfort, two.discomfort)
        assert np.abs(one.eye @ turn.T + offset - two.eye).max() < 1e-12


@settings(max_examples=8, deadline=None)
@given(along=SOME, forward=WAY, up=WAY)
def test_a_pedal_that_goes_along_is_one_that_stands_there(people, seat, along, forward, up):
    shift = np.array([forward, 0.0, up])
    held = np.repeat([[forward, up]], len(people), axis=0)
    there = {foot: tuple(np.add(at, shift * (foot in along))) for foot, at in TRAINER.at.items()}
    poses = poses_of(people)
    moved = sit(people, poses, seat, pedals=Pedals(TRAINER.at, along=along), held=held)
    stated = sit(people, poses, seat, pedals=Pedals(there), held=held)
    # what is farther than the leg ends at a tolerance of the search
    assert np.abs(moved.poses.rotations - stated.poses.rotations).max() < 2e-3
    for foot in FEET:
        assert np.abs(moved.miss[foot] - stated.miss[foot]).max() < 1e-5


@settings(max_examples=4, deadline=None)
@given(forward=WAY, up=WAY)
def test_seat_and_footplates_moved_together_carry_the_posture_along(people, seat, forward, up):
    plates = Pedals(TRAINER.at, 0.0, along=FEET)
    held = np.repeat([[forward, up]], len(people), axis=0)
    rest, moved = (
        sit(people, poses_of(people), seat, pedals=plates, held=at) for at in (0 * held, held)
    )
    assert np.abs(moved.poses.rotations - rest.poses.rotations).max() < 1e-5
    way = moved.poses.world_from_reference[:, :, 3] - rest.poses.world_from_reference[:, :, 3]
    assert np.abs(way - [forward, 0.0, up]).max() < 1e-6


def test_a_seat_with_footplates_stays_where_it_stands(people, seat):
    found = sit(people, poses_of(people), seat, pedals=Pedals(TRAINER.at, 0.0, along=FEET))
    assert (found.forward == 0.0).all()


def test_what_cannot_be_seated_is_refused(people, seat):
    poses = poses_of(people)
    with pytest.raises(wb.UsageError, match="poses: expected 2 rows for 2 bodies"):
        sit(people[:2], poses, seat, eye=None, pedals=Pedals({}))
    dog = wb.load_body("dog")
    with pytest.raises(wb.InputError, match="no spheres in"):
        sit(dog, wb.pose(dog, {}), seat, eye=None, pedals=Pedals({}))
    with pytest.raises(wb.InputError, match="no limb 'third foot'"):
        sit(people, poses, seat, eye=None, pedals=Pedals({"third foot": (1, 0, 0)}))
