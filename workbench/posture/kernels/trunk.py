"""The tilts of a trunk in side view that come nearest to wanted angles, the line from hip to eye
held.

Five angles in units of their scatter, least squares by Gauss and Newton's steps within the bounds
of the joints; each step's bounds by an active set (Nocedal & Wright 2006, Numerical Optimization,
chapters 10 and 16). The line is one more angle with a scatter next to nothing.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit

__all__ = ["trunk_turns"]

LINE = 1e-4
"""Scatter [rad] of the line from hip to eye: its error stays below a millionth."""
STEPS = 60
SETTLED = 1e-10
MOST_STEP = 0.4


@njit(cache=True, error_model="numpy", _nrt=False)
def _residuals(links, turns, wanted, spread, off, slope):  # type: ignore[no-untyped-def]
    """Fill off (6,) and slope (6, 5): how far hip to eye, pelvis, abdomen, thorax, neck and head
    are from what is wanted, in units of spread, and how that changes with the turns (5,) of the
    lower torso and the four joints."""
    tilt = 0.0
    for r in range(6):
        off[r] = 0.0
        for k in range(5):
            slope[r, k] = 0.0
    whole_x = 0.0
    whole_z = 0.0
    neck_x = 0.0
    neck_z = 0.0
    for m in range(6):
        if m < 5:
            tilt = turns[0] if m == 0 else tilt - turns[m]
        c = math.cos(tilt)
        s = math.sin(tilt)
        x = links[m, 0] * c - links[m, 1] * s
        z = links[m, 0] * s + links[m, 1] * c
        whole_x = whole_x + x
        whole_z = whole_z + z
        if m in (3, 4):
            neck_x = neck_x + x
            neck_z = neck_z + z
        if m in (0, 1, 2, 5):
            off[m + 1 if m < 3 else 5] = math.atan2(-x, z) if m < 3 else math.atan2(z, x)
        for k in range(min(m, 4) + 1):
            sign = 1.0 if k == 0 else -1.0
            if m < 3:
                slope[m + 1, k] = sign
            elif m == 5:
                slope[5, k] = sign
    off[0], off[4] = math.atan2(-whole_x, whole_z), math.atan2(-neck_x, neck_z)
    tilt = 0.0  # a link that turns moves the direction of a sum by its share along that
    for m in range(6):
        if m < 5:
            tilt = turns[0] if m == 0 else tilt - turns[m]
        c = math.cos(tilt)
        s = math.sin(tilt)
        x = links[m, 0] * c - links[m, 1] * s
        z = links[m, 0] * s + links[m, 1] * c
        along = (x * whole_x + z * whole_z) / (whole_x * whole_x + whole_z * whole_z)
        bent = (x * neck_x + z * neck_z) / (neck_x * neck_x + neck_z * neck_z)
        for k in range(min(m, 4) + 1):
            sign = 1.0 if k == 0 else -1.0
            slope[0, k] += sign * along
            if m in (3, 4):
                slope[4, k] += sign * bent
    for r in range(6):
        gap = (off[r] - wanted[r] + math.pi) % (2.0 * math.pi) - math.pi
        off[r] = gap / spread[r]
        for k in range(5):
            slope[r, k] /= spread[r]


@njit(cache=True, error_model="numpy", _nrt=False)
def _solve(matrix, right, fixed, step):  # type: ignore[no-untyped-def]
    """Solve for the free of five unknowns by elimination, the matrix being positive; the fixed ones
    stand in step."""
    for i in range(5):
        for j in range(5):
            if fixed[j] != 0 and fixed[i] == 0:
                right[i] -= matrix[i, j] * step[j]
    for i in range(5):
        if fixed[i] != 0:
            continue
        for r in range(i + 1, 5):
            if fixed[r] == 0:
                share = matrix[r, i] / matrix[i, i]
                right[r] -= share * right[i]
                for j in range(5):
                    if fixed[j] == 0:
                        matrix[r, j] -= share * matrix[i, j]
    for i in range(4, -1, -1):
        if fixed[i] == 0:
            value = right[i]
            for j in range(i + 1, 5):
                if fixed[j] == 0:
                    value -= matrix[i, j] * step[j]
            step[i] = value / matrix[i, i]


@njit(cache=True)
def _step(off, slope, turns, bounds, fixed, step):  # type: ignore[no-untyped-def]
    """The step of least squares within the bounds: what goes beyond is held there, what is pulled
    inward let go."""
    whole = np.zeros((5, 5))
    side = np.zeros(5)
    matrix = np.zeros((5, 5))
    right = np.zeros(5)
    for i in range(5):
        fixed[i] = 0
        for r in range(6):
            side[i] -= slope[r, i] * off[r]
            for j in range(5):
                whole[i, j] += slope[r, i] * slope[r, j]
    for _ in range(20):
        for i in range(5):
            right[i] = side[i]
            for j in range(5):
                matrix[i, j] = whole[i, j]
        _solve(matrix, right, fixed, step)
        worst = -1
        beyond = 1e-12
        for i in range(5):
            past = max(bounds[i, 0] - turns[i] - step[i], turns[i] + step[i] - bounds[i, 1])
            if fixed[i] == 0 and past > beyond:
                worst = i
                beyond = past
        if worst >= 0:
            fixed[worst] = -1 if turns[worst] + step[worst] < bounds[worst, 0] else 1
            step[worst] = bounds[worst, 0 if fixed[worst] < 0 else 1] - turns[worst]
            continue
        loose = -1
        pull = 1e-9
        for i in range(5):
            force = side[i]
            for j in range(5):
                force -= whole[i, j] * step[j]
            if fixed[i] != 0 and -fixed[i] * force > pull:
                loose = i
                pull = -fixed[i] * force
        if loose < 0:
            return
        fixed[loose] = 0


@njit(cache=True, nogil=True)
def trunk_turns(links, wanted, spread, bounds, turns):  # type: ignore[no-untyped-def]
    """Bring the turns (P, 5) [rad] of P trunks, a start in and the answer out, to where the angles
    are nearest to those wanted (P, 6): hip to eye (held), pelvis, abdomen, thorax, neck, head;
    spread (P, 5) of the last five.

    links (P, 6, 2) [m]: forward and up, upright; bounds (P, 5, 2) [rad].
    """
    off = np.zeros(6)
    slope = np.zeros((6, 5))
    fixed = np.zeros(5, np.int64)
    step = np.zeros(5)
    scale = np.zeros(6)
    for p in range(len(turns)):
        scale[0] = LINE
        for k in range(5):
            scale[1 + k] = spread[p, k]
        for _ in range(STEPS):
            _residuals(links[p], turns[p], wanted[p], scale, off, slope)
            _step(off, slope, turns[p], bounds[p], fixed, step)
            largest = 0.0
            for k in range(5):
                largest = max(largest, abs(step[k]))
            share = min(1.0, MOST_STEP / max(largest, 1e-300))
            for k in range(5):
                turns[p, k] += share * step[k]
            if largest < SETTLED:
                break
