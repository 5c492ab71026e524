"""Static loads against a two-link arm by hand, the slope of potential energy, and MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from workbench.errors import InputError
from workbench.posture.balance import hull_margins, support_polygon

G = 9.80665
FEET = ("LF", "RF")


@pytest.fixture(scope="module")
def man():
    return wb.load_body("bubbleman")


def random_poses(body, count, seed, spread=0.8):
    """Poses whose joints are turned at random."""
    rng = np.random.default_rng(seed)
    vectors = rng.uniform(-spread, spread, (count, len(body.joints), 3))
    half = 0.5 * np.linalg.norm(vectors, axis=2, keepdims=True)
    rotations = np.concatenate([np.cos(half), np.sin(half) / half * vectors / 2.0], axis=2)
    place = np.broadcast_to(wb.pose(body, {}).world_from_reference, (count, 3, 4))
    return wb.Poses(rotations, 0, place)


def leaning(body, count, seed):
    """People who stand on flat feet and bend their trunk and raise their arms at random."""
    rng = np.random.default_rng(seed)
    rows = []
    for bend, side, left, right in rng.uniform((-60, -50, 0, 0), (90, 50, 120, 120), (count, 4)):
        angles = {"W": {"flexion": bend, "bend_left": side}}
        angles |= {"LS": {"flexion": left}, "RS": {"flexion": right}}
        rows.append(wb.pose(body, angles))
    return wb.place(body, wb.join_poses(rows))


def test_a_planar_arm_of_two_links_by_hand(one_arm):
    # level arm of 2, 1 and 0.5 kg whose centres are 150, 400 and 600 mm from the shoulder, the elbow
    # 300 mm from it: 9.80665 * (2 * 0.15 + 1 * 0.4 + 0.5 * 0.6) = 9.80665 Nm there
    level = wb.place(one_arm, wb.pose(one_arm, {"SHOULDER": {"flexion": 90}}))
    shoulder = level.world_from_segment[0, 0, :, 3] + one_arm.joint_in_parent[0, 0]
    arms = np.linalg.norm(level.world_from_segment[0, 1:, :, 3] - shoulder, axis=1)
    found = wb.static_load(level, None)
    by_hand = G * float(one_arm.mass[0, 1:] @ arms)
    assert np.linalg.norm(found.moment[0, 0]) == pytest.approx(by_hand)
    assert found.about_axes[0, 0, 0] == pytest.approx(by_hand)  # the flexors hold it
    elbow = G * float(one_arm.mass[0, 2:] @ (arms[1:] - 0.3))
    assert found.about_axes[0, 1, 0] == pytest.approx(elbow)
    bent = wb.pose(one_arm, {"SHOULDER": {"flexion": 90}, "ELBOW": {"flexion": 90}})
    upright = wb.static_load(wb.place(one_arm, bent), None)  # forearm and hand above the elbow
    assert upright.about_axes[0, 1, 0] == pytest.approx(0.0, abs=1e-9)
    assert upright.about_axes[0, 0, 0] == pytest.approx(G * (2 * arms[0] + 1.5 * 0.3))


def potential(body, poses, held, hand_force):
    """(P,) [J] of weight, of what is held, and of a force on the right hand."""
    placed = wb.place(body, poses)
    mass = body.mass[0].copy()
    mass[body.segment("LHN")] += held
    at = placed.world_from_segment[..., 3]
    hand = at[:, body.segment("RHN")]
    return G * at[..., 2] @ mass - hand @ hand_force


def test_moments_are_the_slopes_of_potential_energy_at_every_joint(man):
    step, force = 1e-5, np.array([30.0, -20.0, 50.0])
    poses = random_poses(man, 5, seed=1)
    placed = wb.place(man, poses)
    found = wb.static_load(placed, None, pushes=[wb.Push("RHN", force)], held={"LHN": 3.0})
    rng = np.random.default_rng(2)
    for j in range(len(man.joints)):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        energies = []
        for way in (step, -step):
            turn = np.array([np.cos(way / 2), *(np.sin(way / 2) * axis)])
            rotations = poses.rotations.copy()
            rotations[:, j] = product(rotations[:, j], turn)
            energies.append(potential(man, replace(poses, rotations=rotations), 3.0, force))
        slope = (energies[0] - energies[1]) / (2 * step)
        world = placed.world_from_segment[:, j + 1, :, :3] @ axis
        np.testing.assert_allclose(np.sum(found.moment[:, j] * world, axis=1), slope, atol=2e-5)


def product(a, b):
    """Quaternions (P, 4) times one (4,), by the table of i, j and k."""
    w, x, y, z = a.T
    p, q, r, s = b
    return np.stack(
        [
            w * p - x * q - y * r - z * s,
            w * q + x * p + y * s - z * r,
            w * r - x * s + y * p + z * q,
            w * s + x * r - y * q + z * p,
        ],
        axis=1,
    )


@pytest.mark.parametrize(
    ("joint", "motion", "axis"),
    [("RS", "flexion", 0), ("LE", "flexion", 0), ("LS", "abduction", 1), ("RK", "flexion", 0)],
)
def test_moments_about_the_axes_of_a_joint_are_slopes_by_its_named_angle(man, joint, motion, axis):
    lower, upper = (wb.pose(man, {joint: {motion: 50 + step}}) for step in (-1e-4, 1e-4))
    rise = potential(man, upper, 0, np.zeros(3)) - potential(man, lower, 0, np.zeros(3))
    slope = rise / np.radians(2e-4)
    found = wb.static_load(wb.place(man, wb.pose(man, {joint: {motion: 50}})), None)
    assert found.about_axes[0, man.joint(joint), axis] == pytest.approx(slope[0], abs=1e-5)


def test_supports_balance_weight_and_pushes_in_force_and_moment(man):
    placed = leaning(man, 40, seed=3)
    feet = wb.supports_of(placed, FEET)
    push = wb.Push("RHN", (-20.0, 5.0, -30.0))
    found = wb.static_load(placed, feet, pushes=[push], held={"H": 1.5})
    assert found.balanced.all() and np.all(found.left_over == 0.0)
    weight = G * (man.mass[0].sum() + 1.5)
    np.testing.assert_allclose(found.reaction.sum(axis=1), [[20, -5, weight + 30]] * 40, atol=1e-6)
    hand = placed.world_from_segment[:, man.segment("RHN"), :, 3]
    turns = np.cross(feet.points, found.reaction).sum(axis=1) + np.cross(hand, push.force)
    turns += np.cross(found.centre, [0.0, 0.0, -weight])
    np.testing.assert_allclose(turns, 0.0, atol=1e-6)
    # what is balanced as a whole needs no moment where the stage holds the body
    np.testing.assert_allclose(found.moment[:, man.joint("PV")], 0.0, atol=1e-6)


def test_a_posture_that_is_out_of_balance_would_have_to_be_pulled_and_no_other(man):
    placed = leaning(man, 120, seed=4)
    found = wb.static_load(placed, wb.supports_of(placed, FEET))
    assert 20 < found.pulls.sum() < 100
    assert np.array_equal(found.pulls, found.margin < 0.0)
    up = found.reaction[..., 2][~found.pulls]
    assert up.min() >= -1e-6
    np.testing.assert_allclose(found.margin, wb.balance(placed).margin, atol=1e-12)


def test_the_centre_of_pressure_moves_back_by_the_moment_of_a_forward_push(man):
    placed = wb.place(man, wb.pose(man, {}))
    feet = wb.supports_of(placed, FEET)
    at = (0.4, 0.0, 1.2 + feet.points[0, :, 2].min())
    push = wb.Push("RHN", (-100.0, 0.0, 0.0), at)  # who pushes forward feels it backward
    found = wb.static_load(placed, feet, pushes=[push])
    back = 100.0 * 1.2 / (G * man.mass[0].sum())
    assert found.pressure[0, 0] == pytest.approx(found.centre[0, 0] - back)
    assert found.margin[0] < 0.0 and found.pulls[0]
    down = wb.static_load(placed, feet, pushes=[wb.Push("RHN", (0.0, 0.0, 1e4))])
    assert np.isnan(down.pressure).all() and np.isnan(down.margin[0])  # lifted off the floor


def test_a_seat_takes_the_load_off_the_legs(man):
    sits = {joint: {"flexion": 90} for joint in ("LH", "RH", "LK", "RK")}
    sitting = wb.place(man, wb.pose(man, sits))
    seat = wb.supports_of(sitting, ("LT", "LUL", "RUL"))
    found = wb.static_load(sitting, seat)
    assert found.balanced.all() and not found.pulls.any()
    # the legs below the knees hang straight down: no moment but that of their own slight offset
    assert abs(found.about_axes[0, man.joint("LK"), 0]) < 2.0
    both = seat + wb.supports_of(sitting, FEET)
    shared = wb.static_load(sitting, both)
    assert shared.reaction.shape[1] == len(both.segment) and shared.balanced.all()
    np.testing.assert_allclose(shared.reaction.sum(axis=1), found.reaction.sum(axis=1), atol=1e-6)


def test_mirrored_postures_have_mirrored_loads(man):
    one, other = (
        wb.place(man, wb.pose(man, {"W": {bend: 20}, arm: {"abduction": 60}}))
        for bend, arm in (("bend_left", "LS"), ("bend_right", "RS"))
    )
    loads = [wb.static_load(placed, wb.supports_of(placed, FEET)) for placed in (one, other)]
    for left, right in (("LS", "RS"), ("LH", "RH"), ("RE", "LE"), ("W", "W")):
        seen = loads[0].moment[0, man.joint(left)]
        np.testing.assert_allclose(
            seen * [-1, 1, -1], loads[1].moment[0, man.joint(right)], atol=1e-6
        )


def test_a_batch_has_the_loads_of_its_rows(man):
    placed = leaning(man, 6, seed=5)
    together = wb.static_load(placed, wb.supports_of(placed, FEET))
    for row in range(6):
        alone = placed.of_person(0, np.array([row]))
        found = wb.static_load(alone, wb.supports_of(alone, FEET))
        np.testing.assert_allclose(found.moment[0], together.moment[row], atol=1e-9)
        assert found.margin[0] == pytest.approx(together.margin[row])


COORDINATES = st.tuples(st.integers(-4, 4), st.integers(-4, 4))


@settings(max_examples=30, deadline=None)
@given(
    points=st.lists(COORDINATES, min_size=1, max_size=9),
    others=st.lists(COORDINATES, min_size=1, max_size=9),
    at=COORDINATES,
)
def test_the_margin_in_a_hull_is_that_of_its_edges_one_by_one(points, others, at):
    width = max(len(points), len(others))
    rows = [np.array(some + [(9, 9)] * (width - len(some)), float) for some in (points, others)]
    bears = np.array([np.arange(width) < len(some) for some in (points, others)])
    found = hull_margins(np.array(rows), bears, np.array([at, at], float))
    for row, some in enumerate((points, others)):
        assert found[row] == pytest.approx(slow_margin(np.array(some, float), np.array(at, float)))


def slow_margin(points, at):
    """The margin by walking the edges of the support polygon."""
    corners = support_polygon(points)
    inside, nearest = len(corners) > 2, np.inf
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        edge, arm = b - a, at - a
        share = np.clip(arm @ edge / max(edge @ edge, 1e-18), 0, 1)
        nearest = min(nearest, np.linalg.norm(arm - share * edge))
        inside = inside and edge[0] * arm[1] - edge[1] * arm[0] >= 0
    return nearest if inside else -nearest


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"held": {"RHN": -1.0}}, "held: RHN: expected 0 kg or more, got -1"),
        ({"held": {"TOOL": 1.0}}, "no segment 'TOOL'"),
        ({"pushes": [wb.Push("RHN", (1.0, 2.0))]}, "push on RHN: force: expected an array"),
    ],
)
def test_wrong_loads_are_refused(man, given, message):
    with pytest.raises(InputError, match=message):
        wb.static_load(wb.place(man, wb.pose(man, {})), None, **given)


def test_wrong_supports_are_refused(man):
    stood = wb.place(man, wb.pose(man, {}))
    with pytest.raises(InputError, match="the segments STG have no spheres"):
        wb.supports_of(stood, ["STG"])
    with pytest.raises(InputError, match="expected a direction toward the surface"):
        wb.supports_of(stood, FEET, toward=(0, 0, 0))
    arm = wb.place(man, wb.pose(man, {}), window=["RHN"])
    with pytest.raises(InputError, match="outside the logical window: LF, RF"):
        wb.supports_of(arm, FEET)
    with pytest.raises(InputError, match="static loads need all segments"):
        wb.static_load(arm, None)
    with pytest.raises(InputError, match="expected those of 6 postures, got 1"):
        wb.static_load(leaning(man, 6, seed=5), wb.supports_of(stood, FEET))


def mujoco_text(body):
    """The body as MuJoCo takes it: each segment's frame at its joint, ball joints, the pelvis free."""

    def nested(n):
        at = np.zeros(3) if n == 1 else body.joint_in_parent[0, n - 1]
        if n > 1 and body.parent[n] > 1:
            at = at - body.joint_in_child[0, body.parent[n] - 1]
        own = np.zeros(3) if n == 1 else -body.joint_in_child[0, n - 1]
        kind = "free" if n == 1 else "ball"
        inner = "".join(nested(c) for c in range(len(body.segments)) if body.parent[c] == n)
        numbers = [" ".join(f"{x:.17g}" for x in v) for v in (at, own)]
        mass = f'mass="{body.mass[0, n]:.17g}" diaginertia="0.01 0.01 0.01"'
        return (
            f'<body name="{body.segments[n]}" pos="{numbers[0]}"><joint type="{kind}"/>'
            f'<inertial pos="{numbers[1]}" {mass}/>{inner}</body>'
        )

    head = f'<option gravity="0 0 -{G}"/><compiler angle="radian"/>'
    return f"<mujoco>{head}<worldbody>{nested(1)}</worldbody></mujoco>"


@pytest.mark.nightly
def test_moments_are_those_of_mujocos_inverse_dynamics(man):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(mujoco_text(man))
    data = mujoco.MjData(model)
    poses = random_poses(man, 20, seed=6)
    placed = wb.place(man, poses)
    found = wb.static_load(placed, None)
    numbers = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, s) for s in man.segments[2:]]
    for row in range(len(poses)):
        place = placed.world_from_segment[row, 1]
        data.qpos[:3] = place[:, 3]
        mujoco.mju_mat2Quat(data.qpos[3:7], np.ascontiguousarray(place[:, :3]).ravel())
        for n, number in enumerate(numbers, start=2):
            start = model.jnt_qposadr[model.body_jntadr[number]]
            data.qpos[start : start + 4] = poses.rotations[row, n - 1]
        data.qvel[:], data.qacc[:] = 0.0, 0.0
        mujoco.mj_inverse(model, data)
        for n, number in enumerate(numbers, start=2):
            start = model.jnt_dofadr[model.body_jntadr[number]]
            own = placed.world_from_segment[row, n, :, :3].T @ found.moment[row, n - 1]
            np.testing.assert_allclose(data.qfrc_inverse[start : start + 3], own, atol=1e-6)
