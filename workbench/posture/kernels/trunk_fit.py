"""Tilts of a trunk in side view that come nearest to wanted angles, the line from hip to eye held.

It is a bounded least-squares problem: six angles, in units of their scatter, follow five joint
angles. Gauss-Newton steps solve it ([1]_ chapter 10); the bounds of each step are found by an active
set ([1]_ chapter 16). The line from hip to eye is one more angle with a scatter next to nothing.

References
----------
.. [1] J. Nocedal and S. J. Wright (2006), Numerical Optimization, 2nd edition, Springer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inner, njit
from workbench.posture.kernels.cholesky import LEAST_PIVOT, factorise, substitute

__all__ = ["trunk_turns"]

Floats = NDArray[np.float64]

LINE_SCATTER = 1e-4
"""Scatter [rad] of the line from hip to eye: its error stays below a millionth."""
MOST_ITERATIONS = 60
"""Gauss-Newton steps at most."""
SETTLED = 1e-10
"""Largest change [rad] of an angle in a step at which the steps end."""
MOST_STEP = 0.4
"""Largest change [rad] of an angle in one step."""
MOST_SETS = 20
"""Active sets that are tried for one step at most."""
PAST_BOUND = 1e-12
"""Excess [rad] over a bound that is rounding."""
PULL_INWARD = 1e-9
"""Force of a bound that is rounding."""
TRUNK_LINKS = 6
TRUNK_ANGLES = 5
"""Links: pelvis, abdomen, thorax, two of the neck, and the head, which does not turn against the
neck's second. Angles: the tilt of the pelvis, and the turns of four joints."""


class _Workspace(NamedTuple):
    """Working arrays of one trunk at a time."""

    vectors: Floats
    """(6, 2) [m] the links as they stand: forward, up."""
    residual: Floats
    """(6,) angles less those wanted, in units of their scatter."""
    jacobian: Floats
    """(6, 5) derivatives of the residuals [1/rad]."""
    scatter: Floats
    """(6,) [rad] of hip to eye, pelvis, abdomen, thorax, neck and head."""
    hessian: Floats
    """(5, 5) Gauss-Newton matrix."""
    descent: Floats
    """(5,) negative gradient."""
    matrix: Floats
    """(5, 5) the matrix that is factorised, in place."""
    right: Floats
    """(5,) its right side."""
    held: NDArray[np.int64]
    """(5,) -1 or 1 for an angle that is held at its lower or upper bound, else 0."""
    step: Floats
    """(5,) [rad] the step."""


@inner
def _place_links(links, turns, vectors):  # type: ignore[no-untyped-def]
    """Turn the links (6, 2) [m]: the pelvis leans forward by its angle, each joint turns back."""
    tilt = 0.0
    for m in range(TRUNK_LINKS):
        if m < TRUNK_ANGLES:
            tilt = turns[0] if m == 0 else tilt - turns[m]
        c = math.cos(tilt)
        s = math.sin(tilt)
        vectors[m, 0] = links[m, 0] * c - links[m, 1] * s
        vectors[m, 1] = links[m, 0] * s + links[m, 1] * c


@inner
def _fill_sum(vectors, first, last, row, residual, jacobian):  # type: ignore[no-untyped-def]
    """Fill the row of an angle from upright of the sum of the links first..last - 1."""
    # With the sum S of links x the angle is atan2(-Sx, Sz). A link that turns by dα moves it by
    # (x . S) / |S|^2 dα, its share along S.
    x = 0.0
    z = 0.0
    for m in range(first, last):
        x = x + vectors[m, 0]
        z = z + vectors[m, 1]
    residual[row] = math.atan2(-x, z)
    for m in range(first, last):
        share = (vectors[m, 0] * x + vectors[m, 1] * z) / (x * x + z * z)
        for k in range(min(m, TRUNK_ANGLES - 1) + 1):
            jacobian[row, k] += share if k == 0 else -share


@inner
def _fill_residuals(links, turns, wanted, workspace):  # type: ignore[no-untyped-def]
    """Fill residuals and Jacobian: hip to eye, pelvis, abdomen, thorax, neck and head."""
    vectors = workspace.vectors
    residual = workspace.residual
    jacobian = workspace.jacobian
    _place_links(links, turns, vectors)
    jacobian[:] = 0.0
    for m in range(3):
        residual[m + 1] = math.atan2(-vectors[m, 0], vectors[m, 1])
        for k in range(m + 1):
            jacobian[m + 1, k] = 1.0 if k == 0 else -1.0
    residual[5] = math.atan2(vectors[5, 1], vectors[5, 0])
    for k in range(TRUNK_ANGLES):
        jacobian[5, k] = 1.0 if k == 0 else -1.0
    _fill_sum(vectors, 0, TRUNK_LINKS, 0, residual, jacobian)
    _fill_sum(vectors, 3, 5, 4, residual, jacobian)
    for r in range(6):
        gap = (residual[r] - wanted[r] + math.pi) % (2.0 * math.pi) - math.pi
        residual[r] = gap / workspace.scatter[r]
        for k in range(TRUNK_ANGLES):
            jacobian[r, k] /= workspace.scatter[r]


@inner
def _fill_normal_equations(workspace):  # type: ignore[no-untyped-def]
    """Fill H = J' J and the negative gradient -J' r."""
    for i in range(TRUNK_ANGLES):
        workspace.descent[i] = 0.0
        for j in range(TRUNK_ANGLES):
            workspace.hessian[i, j] = 0.0
        for r in range(6):
            workspace.descent[i] -= workspace.jacobian[r, i] * workspace.residual[r]
            for j in range(TRUNK_ANGLES):
                workspace.hessian[i, j] += workspace.jacobian[r, i] * workspace.jacobian[r, j]


@inner
def _solve_free(workspace):  # type: ignore[no-untyped-def]
    """Solve for the free angles of the step; the held ones stand in it: their rows are x = step."""
    matrix = workspace.matrix
    right = workspace.right
    held = workspace.held
    for i in range(TRUNK_ANGLES):
        right[i] = workspace.step[i] if held[i] != 0 else workspace.descent[i]
        for j in range(TRUNK_ANGLES):
            matrix[i, j] = workspace.hessian[i, j]
            if held[i] != 0 or held[j] != 0:
                matrix[i, j] = 1.0 if i == j else 0.0
                if held[i] == 0:
                    right[i] -= workspace.hessian[i, j] * workspace.step[j]
    factorise(matrix, LEAST_PIVOT)
    substitute(matrix, right, workspace.step)


@inner
def _hold_worst(turns, bounds, held, step):  # type: ignore[no-untyped-def]
    """Hold the free angle that goes farthest past a bound at that bound; False if none does."""
    worst = -1
    beyond = PAST_BOUND
    for i in range(TRUNK_ANGLES):
        past = max(bounds[i, 0] - turns[i] - step[i], turns[i] + step[i] - bounds[i, 1])
        if held[i] == 0 and past > beyond:
            worst = i
            beyond = past
    if worst < 0:
        return False
    held[worst] = -1 if turns[worst] + step[worst] < bounds[worst, 0] else 1
    step[worst] = bounds[worst, 0 if held[worst] < 0 else 1] - turns[worst]
    return True


@inner
def _release_loosest(workspace):  # type: ignore[no-untyped-def]
    """Release the held angle that is pulled inward most; False if none is."""
    held = workspace.held
    loose = -1
    pull = PULL_INWARD
    for i in range(TRUNK_ANGLES):
        force = workspace.descent[i]
        for j in range(TRUNK_ANGLES):
            force -= workspace.hessian[i, j] * workspace.step[j]
        if held[i] != 0 and -held[i] * force > pull:
            loose = i
            pull = -held[i] * force
    if loose < 0:
        return False
    held[loose] = 0
    return True


@inner
def _bounded_step(turns, bounds, workspace):  # type: ignore[no-untyped-def]
    """Solve for the Gauss-Newton step within the bounds (5, 2) [rad]."""
    _fill_normal_equations(workspace)
    workspace.held[:] = 0
    for _ in range(MOST_SETS):
        _solve_free(workspace)
        if _hold_worst(turns, bounds, workspace.held, workspace.step):
            continue
        if not _release_loosest(workspace):
            return


@inner
def _fit_trunk(links, wanted, spread, bounds, turns, workspace):  # type: ignore[no-untyped-def]
    """Fit one trunk; arguments as rows of those of `trunk_turns`."""
    workspace.scatter[0] = LINE_SCATTER
    for k in range(TRUNK_ANGLES):
        workspace.scatter[1 + k] = spread[k]
    for _ in range(MOST_ITERATIONS):
        _fill_residuals(links, turns, wanted, workspace)
        _bounded_step(turns, bounds, workspace)
        largest = 0.0
        for k in range(TRUNK_ANGLES):
            largest = max(largest, abs(workspace.step[k]))
        share = min(1.0, MOST_STEP / max(largest, 1e-300))
        for k in range(TRUNK_ANGLES):
            turns[k] += share * workspace.step[k]
        if largest < SETTLED:
            return


@njit(cache=True, nogil=True)
def trunk_turns(links, wanted, spread, bounds, turns):  # type: ignore[no-untyped-def]
    """Fit the turns of P trunks to wanted angles.

    Parameters
    ----------
    links : (P, 6, 2)
        Links [m], forward and up, of the upright trunk: pelvis, abdomen, thorax, neck, neck, head.
    wanted : (P, 6)
        Angles [rad]: hip to eye (held), pelvis, abdomen, thorax and neck from upright, and head.
    spread : (P, 5)
        Scatter [rad] of the last five.
    bounds : (P, 5, 2)
        Least and greatest turn [rad].
    turns : (P, 5)
        Tilt of the pelvis and turns of the four joints [rad]: a start in, the answer out.
    """
    workspace = _Workspace(
        np.zeros((TRUNK_LINKS, 2)),
        np.zeros(6),
        np.zeros((6, TRUNK_ANGLES)),
        np.zeros(6),
        np.zeros((TRUNK_ANGLES, TRUNK_ANGLES)),
        np.zeros(TRUNK_ANGLES),
        np.zeros((TRUNK_ANGLES, TRUNK_ANGLES)),
        np.zeros(TRUNK_ANGLES),
        np.zeros(TRUNK_ANGLES, np.int64),
        np.zeros(TRUNK_ANGLES),
    )
    for p in range(len(turns)):
        _fit_trunk(links[p], wanted[p], spread[p], bounds[p], turns[p], workspace)
