"""The search of the judge: random restarts of Levenberg's and Marquardt's method over the turns of
a limb, with the distance of the tip, the breaches of stops and the depths in obstacles as
residuals.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from tests.judge_field import Field, sphere_contacts
from tests.judge_limb import (
    Chain,
    Skin,
    State,
    breaches,
    move,
    sphere_centre,
    sphere_slope,
    tip,
    tip_slope,
)

OFF = 3e-4
"""How far [m] spheres are kept off."""
SPARE = 2e-4
"""How far [rad] joints are kept from their stops."""
TIP = 5e-5
"""How near [m] the tip comes."""
RADIAN = 0.3
"""What a radian past a stop counts [m]."""
MOST = 400
"""Most contacts."""
STEPS = 60
DRAWS = 30
"""Postures drawn for each restart, of which the one with the nearest tip is taken."""
LONGEST = 0.35
"""Longest step [rad]."""
POOL = 12
"""How many of the best failures are kept to begin near them again."""
PATIENCE = 14
"""Steps without a fall of the least sum by a twentieth after which an attempt ends."""


class Scene(NamedTuple):
    """One limb of one person among parts that stand still and parts that have been displaced."""

    chain: Chain
    skin: Skin
    still: Field
    moving: Field
    shift: np.ndarray
    """(3,) how far the moving parts are displaced [m]."""
    low: np.ndarray
    """(D,) [rad]"""
    high: np.ndarray


class Desk(NamedTuple):
    """Room to work in."""

    state: State
    depth: np.ndarray
    """(MOST,) [m] depth of each contact beyond what is allowed and OFF."""
    out: np.ndarray
    """(MOST, 3) its way out."""
    sphere: np.ndarray
    """(MOST,) its sphere."""
    breach: np.ndarray
    """(B,) [rad]"""
    slopes: np.ndarray
    """(B, D)"""
    slope: np.ndarray
    """(D, 3)"""
    matrix: np.ndarray
    """(D, D)"""
    gradient: np.ndarray
    """(D,)"""
    count: np.ndarray
    """(2,) of contacts and breaches."""
    factor: np.ndarray
    """(D, D)"""
    row: np.ndarray
    """(D,)"""
    spot: np.ndarray
    """(2, 3)"""
    few_depth: np.ndarray
    """(FEW,) as `depth`, of one sphere."""
    few_out: np.ndarray
    """(FEW, 3)"""
    parts: np.ndarray
    """(2, n) solid parts about a sphere."""


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def find_contacts(scene, desk, shrunk):
    """Write the contacts of the limb, its spheres shrunk by a share of their radii; return the sum
    of squares of their depths."""
    skin = scene.skin
    at = desk.spot[0]
    away = desk.spot[1]
    depth = desk.few_depth
    out = desk.few_out
    parts = desk.parts
    count = 0
    total = 0.0
    for s in range(len(skin.radius)):
        sphere_centre(skin, desk.state, s, at)
        radius = skin.radius[s] * (1.0 - shrunk)
        allowed = skin.allowed[s]
        few = sphere_contacts(scene.still, at, radius, allowed, OFF, depth, out, 0, parts)
        for i in range(3):
            away[i] = at[i] - scene.shift[i]
        few = sphere_contacts(scene.moving, away, radius, allowed, OFF, depth, out, few, parts)
        for c in range(few):
            past = depth[c] + OFF
            total += past * past
            if count < MOST:
                desk.depth[count] = past
                for i in range(3):
                    desk.out[count, i] = out[c, i]
                desk.sphere[count] = s
                count += 1
    desk.count[0] = count
    return total


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def evaluate(scene, turns, target, shrunk, desk, gap):
    """Bring the limb to turns; write the gap (3,) from the target to the tip, the contacts and the
    breaches; return the sum of squares. No contacts where shrunk is above 1."""
    move(scene.chain, turns, desk.state)
    tip(scene.chain, desk.state, gap)
    total = 0.0
    for i in range(3):
        gap[i] -= target[i]
        total += gap[i] * gap[i]
    count = breaches(scene.chain, desk.state, SPARE, desk.breach, desk.slopes)
    desk.count[1] = count
    for b in range(count):
        total += (RADIAN * desk.breach[b]) ** 2
    desk.count[0] = 0
    if shrunk <= 1.0:
        total += find_contacts(scene, desk, shrunk)
    return total


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def is_way(desk, gap):
    """Whether what was evaluated reaches, keeps the stops and enters nothing."""
    if gap[0] ** 2 + gap[1] ** 2 + gap[2] ** 2 > TIP * TIP:
        return False
    for b in range(desk.count[1]):
        if desk.breach[b] > SPARE:
            return False
    deepest = 0.0
    for c in range(desk.count[0]):
        deepest = max(deepest, desk.depth[c])
    return deepest <= OFF


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _add_row(desk, row, left, size):
    for i in range(size):
        desk.gradient[i] += row[i] * left
        for j in range(i + 1):
            desk.matrix[i, j] += row[i] * row[j]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def normal_equations(scene, desk, gap):
    """Write J'J (its lower half) and J'r of what was evaluated."""
    size = len(scene.chain.owner)
    row = desk.row
    at = desk.spot[0]
    for i in range(size):
        desk.gradient[i] = 0.0
        for j in range(size):
            desk.matrix[i, j] = 0.0
    tip(scene.chain, desk.state, at)
    tip_slope(scene.chain, desk.state, at, desk.slope)
    for i in range(3):
        _add_row(desk, desk.slope[:, i], gap[i], size)
    for b in range(desk.count[1]):
        for d in range(size):
            row[d] = RADIAN * desk.slopes[b, d]
        _add_row(desk, row, RADIAN * desk.breach[b], size)
    last = -1
    for c in range(desk.count[0]):
        s = desk.sphere[c]
        if s != last:
            sphere_centre(scene.skin, desk.state, s, at)
            sphere_slope(scene.chain, scene.skin, desk.state, s, at, desk.slope)
            last = s
        out = desk.out[c]
        for d in range(size):
            row[d] = -(
                desk.slope[d, 0] * out[0] + desk.slope[d, 1] * out[1] + desk.slope[d, 2] * out[2]
            )
        _add_row(desk, row, desk.depth[c], size)


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def solve_step(desk, damping, step):
    """Write the damped step by Cholesky's method; return whether there is one."""
    size = len(step)
    low = desk.factor
    for i in range(size):
        for j in range(i + 1):
            total = desk.matrix[i, j]
            if i == j:
                total += damping
            for k in range(j):
                total -= low[i, k] * low[j, k]
            if i == j:
                if total <= 0.0:
                    return False
                low[i, i] = np.sqrt(total)
            else:
                low[i, j] = total / low[j, j]
    for i in range(size):
        total = -desk.gradient[i]
        for k in range(i):
            total -= low[i, k] * step[k]
        step[i] = total / low[i, i]
    for i in range(size - 1, -1, -1):
        total = step[i]
        for k in range(i + 1, size):
            total -= low[k, i] * step[k]
        step[i] = total / low[i, i]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def descend(scene, turns, target, shrunk, steps, desk):
    """Move turns downhill from where they are; return the last sum of squares, -1 where they are a
    way."""
    size = len(turns)
    gap = np.empty(3)
    step = np.empty(size)
    trial = np.empty(size)
    total = evaluate(scene, turns, target, shrunk, desk, gap)
    damping = 1e-3
    mark = total
    idle = 0
    for _ in range(steps):
        if shrunk == 0.0 and is_way(desk, gap):
            return -1.0
        if total < 1e-10:
            return total
        normal_equations(scene, desk, gap)
        accepted = False
        for _ in range(6):
            if not solve_step(desk, damping, step):
                damping *= 4.0
                continue
            longest = np.abs(step).max()
            scale = min(1.0, LONGEST / max(longest, 1e-12))
            for d in range(size):
                trial[d] = min(scene.high[d], max(scene.low[d], turns[d] + scale * step[d]))
            found = evaluate(scene, trial, target, shrunk, desk, gap)
            if found < total:
                accepted = True
                break
            damping *= 6.0
            if longest < 1e-6:
                break
        if not accepted:
            return total
        turns[:] = trial
        total = found
        damping = max(1e-6, damping * 0.3)
        idle += 1
        if total < 0.95 * mark:
            mark = total
            idle = 0
        elif idle > PATIENCE:
            return total
    if shrunk == 0.0 and is_way(desk, gap):
        return -1.0
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _drawn(scene, target, draws, desk, turns):
    """Draw postures and keep that with the nearest tip."""
    best = np.inf
    at = np.empty(3)
    trial = np.empty(len(turns))
    for _ in range(draws):
        for d in range(len(turns)):
            trial[d] = np.random.uniform(scene.low[d], scene.high[d])
        move(scene.chain, trial, desk.state)
        tip(scene.chain, desk.state, at)
        gap = 0.0
        for i in range(3):
            gap += (at[i] - target[i]) ** 2
        if gap < best:
            best = gap
            turns[:] = trial


@njit(cache=True, nogil=True, error_model="numpy")
def _attempt(scene, target, i, desk, pool, sums, turns):
    """The i-th attempt: straight; the tip first; spheres that grow; near one of the best
    failures."""
    how = i % 4
    if how == 3 and i > 12 and sums[0] < np.inf:
        known = 0
        while known < POOL and sums[known] < np.inf:
            known += 1
        start = pool[np.random.randint(known)]
        spread = 0.1 + 0.7 * np.random.random()
        for d in range(len(turns)):
            value = start[d] + spread * np.random.normal()
            turns[d] = min(scene.high[d], max(scene.low[d], value))
    else:
        draws = 1 + np.random.randint(DRAWS)
        _drawn(scene, target, draws, desk, turns)
    if how == 1 or how == 3:
        descend(scene, turns, target, 2.0, 25, desk)
    if how == 2:
        descend(scene, turns, target, 2.0, 15, desk)
        for k in range(4):
            descend(scene, turns, target, 0.8 - 0.2 * k, 8, desk)
    return descend(scene, turns, target, 0.0, STEPS, desk)


@njit(cache=True, nogil=True, error_model="numpy")
def search(scene, target, seed, first, last, desk, pool, sums, turns):
    """Attempts first..last, each with a seed of its own, until one finds a way.

    Parameters
    ----------
    pool, sums
        (POOL, D) and (POOL,) the best failures and their sums of squares, infinite where there is
        none; kept from call to call.
    turns
        (D,) filled with the way, or the best failure.

    Returns
    -------
    int
        The number of the attempt, -1 where none found a way.
    """
    for i in range(first, last):
        np.random.seed(seed + 7919 * i)
        found = _attempt(scene, target, i, desk, pool, sums, turns)
        if found < 0.0:
            return i
        if found < sums[POOL - 1]:
            place = POOL - 1
            while place > 0 and sums[place - 1] > found:
                sums[place] = sums[place - 1]
                pool[place] = pool[place - 1]
                place -= 1
            sums[place] = found
            pool[place] = turns
    turns[:] = pool[0]
    return -1
