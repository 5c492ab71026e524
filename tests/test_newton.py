"""The equations of a Newton step: their matrix is the second derivative of what they stand for; and
the solver of linear systems."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench import limb
from workbench.posture.kernels.chain_kinematics import forward_kinematics, new_state
from workbench.posture.kernels.cholesky import LEAST_PIVOT, factorise, substitute
from workbench.posture.kernels.inequality_constraints import ContactPlanes, constraint_slacks
from workbench.posture.kernels.newton_step import HOLD, INSIDE, new_work, normal_equations
from workbench.posture.reaching.packing import packed_links

STEP = 1e-4
PLANE = ContactPlanes(
    np.array([3]), np.array([[0.01, 0.02, -0.2]]), np.array([[0.6, 0.0, 0.8]]), np.array([0.1])
)
GOAL = np.array([[0.5, 0.1, 0.2, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.2, 0.2, 0.2]])


class Arm:
    """A right arm at angles (n,), with one plane."""

    def __init__(self, body, zone):
        self.link = packed_links(body, limb(body, "right hand", zone=zone))
        count = len(self.link.rows) + 1
        joints = len(self.link.axes)
        self.free = len(self.link.mode)
        self.state, self.work = (
            new_state(joints, self.free, count),
            new_work(joints, self.free, count),
        )
        self.base = np.eye(3, 4)[None].copy()
        self.where = np.random.default_rng(zone).uniform(-0.5, 0.9, self.free)

    def at(self, angles):
        self.state.angles[self.link.free_joint, self.link.free_axis] = angles
        forward_kinematics(self.link, 0, self.base, 0, self.state)
        constraint_slacks(self.link, PLANE, (0, 1), self.state)
        return self.state

    def second(self, value):
        """Second derivatives (n, n) of value(state) by central differences."""
        step = STEP * np.eye(self.free)
        found = np.zeros((self.free, self.free))
        for i, j in np.ndindex(self.free, self.free):
            corners = [
                value(self.at(self.where + a * step[i] + b * step[j])) * a * b
                for a in (1, -1)
                for b in (1, -1)
            ]
            found[i, j] = sum(corners) / (4 * STEP**2)
        self.at(self.where)
        return found

    def matrix(self):
        """The matrix of the equations, whole."""
        normal_equations(self.link, GOAL, 0, self.state, self.work, 0.0, 0.0, True)
        lower = np.tril(self.work.matrix)
        return lower + np.tril(lower, -1).T


@pytest.mark.parametrize("zone", [2, 3])
@pytest.mark.parametrize("part", [slice(0, 3), slice(3, 6)], ids=["tip", "direction"])
def test_the_tips_and_the_directions_curvature_is_that_of_differences(bubbleman, zone, part):
    arm = Arm(bubbleman, zone)
    force = np.zeros(6)
    force[part] = [0.3, -0.8, 0.5]
    expected = arm.second(lambda state: state.at @ force)
    arm.state.room[:] = 9.0
    arm.work.bend[:] = force
    np.testing.assert_allclose(-arm.matrix(), expected, atol=1e-6)
    assert np.abs(expected).max() > 0.3


@pytest.mark.parametrize("zone", [2, 3])
def test_a_planes_curvature_is_that_of_differences(bubbleman, zone):
    arm = Arm(bubbleman, zone)
    row = len(arm.link.rows)
    expected = arm.second(lambda state: state.room[row])
    arm.state.room[:] = 9.0
    arm.state.room[row] = INSIDE
    arm.work.press[row] = 2.0
    np.testing.assert_allclose(-arm.matrix(), 2.0 * expected, atol=1e-5)
    assert np.abs(expected).max() > 0.1


def test_a_cones_curvature_is_that_of_differences_along_its_surface(bubbleman):
    arm = Arm(bubbleman, 2)
    row = next(r for r, (k, axis, _) in enumerate(arm.link.rows) if axis == 3 and k == 0)
    angles = [int(arm.link.free_of[0, axis]) for axis in range(2)]
    room = arm.at(arm.where).room[row]
    arm.where[angles] *= _onto_cone(arm, row, angles, room)
    expected = arm.second(lambda state: state.room[row])[np.ix_(angles, angles)]
    slope = arm.state.slope_of_room[row, angles]
    along = np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
    assert abs(arm.state.room[row]) < 1e-9
    arm.state.room[:] = 9.0
    arm.work.press[row] = 1.0
    arm.state.room[row] = INSIDE
    found = -arm.matrix()[np.ix_(angles, angles)]
    assert along @ found @ along == pytest.approx(along @ expected @ along, abs=1e-5)
    assert 1e3 * abs(along @ found @ along) < HOLD


def _onto_cone(arm, row, angles, room):
    """By what two angles are to be multiplied to lie on the cone: bisection."""
    low = 0.0
    high = 20.0
    start = arm.where.copy()
    for _ in range(80):
        middle = 0.5 * (low + high)
        trial = start.copy()
        trial[angles] *= middle
        low, high = (middle, high) if arm.at(trial).room[row] > 0 else (low, middle)
    return low


@given(st.integers(1, 12), st.integers(0, 1000))
def test_a_positive_definite_system_is_solved_in_place_from_its_lower_triangle(size, seed):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(size, size))
    matrix = half @ half.T + np.eye(size)
    right = rng.normal(size=size)
    expected = np.linalg.solve(matrix, right)
    matrix[np.triu_indices(size, 1)] = np.nan
    assert factorise(matrix, LEAST_PIVOT)
    substitute(matrix, right, right)
    np.testing.assert_allclose(right, expected, rtol=1e-9, atol=1e-12)


def test_a_system_that_is_not_positive_definite_is_said_to_be_none():
    assert not factorise(np.array([[1.0, 0.0], [2.0, 1.0]]), LEAST_PIVOT)  # 1 - 2 x 2 = -3
    assert not factorise(np.zeros((1, 1)), LEAST_PIVOT)
