"""Trim the spheres of one level of a known person until the measures are right to a fraction of a
millimetre.

Levels hold the same skin with spheres of different sizes, so the outermost spheres lie some
millimetres apart. The spheres that a measure is taken at move and grow by the least that gives all
measures; where others become the outermost ones, these are next. Joints stay, and so do the soles
under them: the joints' heights are measures.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from human.anchors import Family, heights
from human.known import Known
from human.stretched import Changed
from workbench.body.scaling.manikin import AXES, QUEUE, Length, Manikin
from workbench.body.scaling.measure import lengths

__all__ = ["joined", "skin_with", "trimmed", "with_spheres"]

Floats = NDArray[np.float64]
ROUNDS = 120
LONGEST_STEP = 1.5e-3
"""Greatest change [m] of a sphere in a round."""
OVERLAP = 1e-3
"""Depth [m] by which spheres that hang together overlap."""
HELD = 5.0
"""How much more a joint's height counts than a measure."""
NEAREST = 12
NEAR = 0.008
"""How many spheres a point of the skin goes along with, and how near [m] their surfaces count."""
RADIUS_EASE = 0.03
"""How easily, beside its place, a sphere's radius changes: a radius changes the volume."""
PACE = 0.6
SOFT = 0.25
KEPT = 0.99
MOST = 0.05
"""Share of a step that is taken; how much a miss weighs less than a change of a sphere; the share
of a change that is left after a round; the miss beyond which a measure is left as it is: the
skeleton does not have it."""


def trimmed(family: Family, one: Changed, level: str, known: Known) -> tuple[Floats, Floats]:
    """Centres (S, 3) and radii (S,) of a level with the known measures, in the world of the zero
    pose."""
    first, size = one.spheres[level]
    half = family.level.half
    flip = np.where(family.level.right[:, None], [1.0, -1.0, 1.0], 1.0)
    tied = family.level.joint >= 0
    count = int(half.max()) + 1
    middle = np.bincount(half, minlength=count) == 1
    change = np.zeros(4 * count)
    wanted = {name: value for name, (value, _) in known.measures.items()} | known.heights
    ease = np.tile([1.0, 1.0, 1.0, RADIUS_EASE], count)
    for _ in range(ROUNDS):
        parts = change.reshape(count, 4)
        centre = first + parts[half, :3] * flip
        radius = size + parts[half, 3]
        manikin = family.base.changed(family.shape(centre, radius, one.joint, one.origin))
        found = lengths(manikin, list(known.measures)) | heights(manikin, list(known.heights))
        gaps = {name: wanted[name] - manikin.value(length) for name, length in found.items()}
        asked = [name for name, gap in gaps.items() if abs(gap) < MOST]
        rows = np.array([_row(family, manikin, found[name]) for name in asked])
        # rows (m, S, 4) of all spheres, in the order of the level, become those of the left half
        rows[:, :, :3] *= flip
        rows[:, tied, :3] = 0.0
        own = np.zeros((len(rows), count, 4))
        for m in range(len(rows)):
            np.add.at(own[m], half, rows[m])
        own[:, middle, 1] = 0.0
        firm = np.array([HELD if name in known.heights else 1.0 for name in asked])
        flat = firm[:, None] * own.reshape(len(rows), -1)
        eased = flat * ease
        gap = firm * np.array([gaps[name] for name in asked])
        step = PACE * eased.T @ np.linalg.solve(flat @ eased.T + SOFT**2 * np.eye(len(rows)), gap)
        step *= min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-12))
        # what was changed and is asked for no more goes back, slowly: several spheres take turns
        change = KEPT * change + step
    parts = change.reshape(count, 4)
    return first + parts[half, :3] * flip, size + parts[half, 3]


def joined(centre: Floats, radius: Floats) -> Floats:
    """Radii (S,) with which spheres that came apart hang together again: the two nearest to each
    other grow alike until they overlap."""
    grown = radius.copy()
    gap = np.linalg.norm(centre[:, None] - centre[None], axis=2)
    while True:
        apart = gap - grown[:, None] - grown
        _, piece = connected_components(coo_matrix(apart < -OVERLAP), directed=False)
        lone = np.flatnonzero(piece != np.bincount(piece).argmax())
        if not len(lone):
            return grown
        other = np.where(piece[lone][:, None] == piece[None], np.inf, apart[lone])
        least = other.min()
        rows, columns = np.nonzero(other < least + 1e-6)  # both sides at once
        pair = np.unique(np.concatenate([lone[rows], columns]))
        grown[pair] += 0.5 * (least + OVERLAP) + 1e-5


def _row(family: Family, manikin: Manikin, length: Length) -> Floats:
    """(S, 4) what the centre and radius of each sphere, in the order of the level, add to a
    length."""
    rig = manikin.rig
    row = np.zeros((len(rig.segment), 4))
    for sign, reach in length.terms:
        if reach.sphere < 0:
            continue
        along = AXES[reach.direction] @ rig.turn[QUEUE[reach.posture], reach.sphere]
        row[reach.sphere, :3] += sign * along
        row[reach.sphere, 3] += sign * reach.surface
    ordered = np.zeros_like(row)
    ordered[family.rows] = row
    return ordered


def with_spheres(one: Changed, level: str, spheres: tuple[Floats, Floats]) -> Changed:
    """The person with other spheres at one level."""
    return replace(one, spheres={**one.spheres, level: spheres})


def skin_with(point: Floats, before: tuple[Floats, Floats], after: tuple[Floats, Floats]) -> Floats:
    """Points (P, 3) of a skin that goes along with spheres that were trimmed: each with the mean
    change of those nearest to it, weighted by how near their surface is."""
    gap = np.linalg.norm(point[:, None] - before[0][None], axis=2) - before[1]
    near = np.argsort(np.abs(gap), axis=1)[:, :NEAREST]
    rows = np.arange(len(point))[:, None]
    weight = np.exp(-0.5 * (gap[rows, near] / NEAR) ** 2) + 1e-9
    away = point[:, None] - before[0][near]
    outward = away / np.maximum(np.linalg.norm(away, axis=2), 1e-9)[:, :, None]
    change = after[0][near] - before[0][near]
    change = change + (after[1][near] - before[1][near])[:, :, None] * outward
    moved: Floats = point + (weight[:, :, None] * change).sum(axis=1) / weight.sum(axis=1)[:, None]
    return moved
