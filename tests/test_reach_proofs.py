"""Reaches that are kept for certain: the hand, turned about the target by anything there is, enters
a part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench import limb, reach
from workbench.files.meshes.parts import RawPart
from workbench.model.environment import Allowance
from workbench.model.quaternions import matrices
from workbench.model.reach import DOUBTS

LEGS = {"LH": {"flexion": 80}, "RH": {"flexion": 80}, "LK": {"flexion": 70}, "RK": {"flexion": 70}}
PROVED = DOUBTS.index("kept for certain")
TURNS = 3000
"""Random turns of the hand about each target."""
MIDDLE = np.array([0.45, -0.15, 0.75])
"""[m] Where targets are, in front of a seated man."""


@pytest.fixture(scope="module")
def seated(bubbleman):
    return wb.pose(bubbleman, LEGS, reference="LT", position=(0.1, 0.0, 0.4))


def _hand(body, arm, target, rng):
    """Centres (n, S, 3) of the hand's solid spheres with the tip on a target, turned at random, and
    their radii (S,). Those that go with the forearm in part are left out."""
    counts = arm.solid[0] & (body.sphere_segment == arm.end) & (body.blend_share[0] == 0)
    turns = rng.normal(size=(TURNS, 4))
    frames = matrices(turns / np.linalg.norm(turns, axis=1, keepdims=True))
    arms = body.centre[0, counts] - arm.tip[0]
    return target + np.einsum("nij,sj->nsi", frames, arms), body.radius[0, counts]


def _box_distance(points, box):
    """Signed distance [m] of points to a box (2, 3), in closed form."""
    out = np.maximum(box[0] - points, points - box[1])
    beyond = np.linalg.norm(np.maximum(out, 0.0), axis=-1)
    return beyond + np.minimum(out.max(axis=-1), 0.0)


def _excess(centres, radius, boxes, allowed):
    """(n,) [m] the deepest that the spheres enter boxes beyond what is allowed: of all surfaces, and
    of the box that a centre is deepest in."""
    distance = np.stack([_box_distance(centres, box) for box in boxes])
    surface = (radius - np.abs(distance) - allowed[:, None, None]).max(axis=0)
    deepest = distance.argmin(axis=0)
    depth = -distance.min(axis=0)
    inside = np.where(depth > 0, depth + radius - allowed[deepest], -np.inf)
    return np.maximum(surface, inside).max(axis=1)


def _made(rng, target):
    """A large box about a target and two small ones near it: corners (3, 2, 3) and allowances (3,)
    [m], and the environment of them."""
    half = rng.uniform([[0.05], [0.005], [0.005]], [[0.2], [0.06], [0.06]], (3, 3))
    half[0, rng.integers(3)] = rng.uniform(0.02, 0.15)
    middle = target + rng.uniform(-1, 1, (3, 3)) * np.array([0.4 * half[0], half[0], half[0]])
    boxes = np.stack([middle - half, middle + half], axis=1)
    allowed = rng.uniform(0.0, [0.01, 0.06, 0.03])
    made = environment_of(*(box_part(f"box {k}", *box) for k, box in enumerate(boxes)))
    rules = tuple(Allowance(k, ("RHN", "LHN"), depth) for k, depth in enumerate(allowed.tolist()))
    return boxes, allowed, replace(made, allowances=rules)


@pytest.mark.parametrize("cases", [12, pytest.param(600, marks=pytest.mark.nightly)])
def test_however_the_hand_is_turned_it_enters_what_keeps_it_for_certain(bubbleman, seated, cases):
    rng = np.random.default_rng(cases)
    proved = 0
    for _ in range(cases):
        grip = rng.choice(["grasp", "pinch", "push"], p=[0.6, 0.2, 0.2])
        target = MIDDLE + rng.uniform(-0.1, 0.1, 3)
        boxes, allowed, made = _made(rng, target)
        arm = limb(bubbleman, "right hand", grip=str(grip), zone=1)
        found = reach(bubbleman, seated, [target], limb=arm, environment=made)
        if found.doubt[0, 0] == PROVED:
            proved += 1
            assert _excess(*_hand(bubbleman, arm, target, rng), boxes, allowed).min() > 0
    assert proved >= cases / 4


@pytest.mark.parametrize(("depth", "proved"), [(0.02, False), (0.06, True)])
def test_a_target_counts_as_too_deep_beyond_what_the_hand_may_enter(
    bubbleman, seated, depth, proved
):
    # the palm's surface is grasped with: its spheres touch the target, and may go 30 mm in
    box = environment_of(box_part("box", MIDDLE - [depth, 1, 1], MIDDLE + 1.0))
    rules = (Allowance(0, ("RHN",), 0.03),)
    arm = limb(bubbleman, "right hand", grip="grasp", zone=3)
    found = reach(bubbleman, seated, [MIDDLE], limb=arm, environment=replace(box, allowances=rules))
    assert (found.doubt[0, 0] == PROVED) == proved


def _slot(gap):
    """Two walls of one sheet each, open all round, `gap` [m] apart about the middle."""
    walls = []
    for name, side in (("left wall", 0.5), ("right wall", -0.5)):
        y = MIDDLE[1] + side * gap
        corners = MIDDLE + 0.4 * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1.0]])
        corners[:, 1] = y
        walls.append(RawPart(name, corners, np.array([[0, 1, 2], [0, 2, 3]])))
    return environment_of(*walls, solid=False)


@pytest.mark.parametrize(("gap", "proved"), [(0.03, True), (0.3, False)])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_hand_between_walls_nearer_than_it_is_thick_is_kept_for_certain(
    bubbleman, seated, gap, proved, side
):
    arm = limb(bubbleman, f"{side} hand", grip="grasp", zone=2)
    found = reach(bubbleman, seated, [MIDDLE], limb=arm, environment=_slot(gap))
    assert (found.doubt[0, 0] == PROVED) == proved
    centres, radius = _hand(bubbleman, arm, MIDDLE, np.random.default_rng(1))
    inside = np.abs(np.abs(centres[..., 1] - MIDDLE[1]) - gap / 2) - radius
    assert (inside.min(axis=1).max() < 0) == proved  # the best of all turns still enters a wall


def test_what_is_proved_of_a_hand_does_not_depend_on_where_its_person_sits(bubbleman, seated):
    arm = limb(bubbleman, "right hand", grip="grasp", zone=1)
    doubts = []
    for ahead in (-0.05, 0.0, 0.04):
        world = seated.world_from_reference.copy()
        world[:, 0, 3] += ahead
        there = wb.Poses(seated.rotations, seated.reference, world)
        found = reach(bubbleman, there, [MIDDLE], limb=arm, environment=_slot(0.03))
        doubts.append(int(found.doubt[0, 0]))
    assert doubts == [PROVED] * 3
