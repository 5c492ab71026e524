"""Spheres for the left half of a symmetric skin, by segment, with the joints and landmarks given;
mirrored to a whole.

The tolerance is finer where the body is: face, hands, feet. Built on workbench.shape: blue-noise
samples, inner balls, set cover, least-squares polish.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from human.skeleton import SEGMENTS
from workbench.body.fitting.candidates import (
    Candidates,
    FitBounds,
    Samples,
    even_samples,
    inner_balls,
    joined_candidates,
)
from workbench.body.fitting.cover import Targets, cover, joined_targets
from workbench.body.fitting.polish import refine_spheres
from workbench.body.fitting.regions import Regions
from workbench.body.surface import Surface

__all__ = ["Given", "Spheres", "fitted", "shares_at"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FLIP = np.array([1.0, -1.0, 1.0])
MOST = 2**62 - 1
# [m], at the level "fine" of a body of 1.70 m
TOLERANCE = {
    "LT": 3.6,
    "CT": 3.3,
    "UT": 3.3,
    "N": 2.8,
    "H": 2.6,
    "LSM": 3.2,
    "LUA": 2.9,
    "LLA": 2.5,
    "LHN": 1.6,
    "LUL": 3.5,
    "LLL": 2.8,
    "LF": 2.3,
}
FACE = 1.6
FINE_PARTS = ("H", "LHN", "LF")
FILLED = 0.009
"""Spacing [m] of the points inside the body that must lie inside a sphere, at the level "fine"."""
OVERLAP = 3e-3
MOST_PIECES = 60
"""Two spheres that overlap by so much [m] hang together; how many may be added to this end."""


@dataclass(frozen=True, eq=False)
class Given:
    """Spheres that stand in any case, left and middle: centre (G, 3), radius (G,), segment (G,),
    joint (G,) or -1, name and direction."""

    centre: Floats
    radius: Floats
    segment: Ints
    joint: Ints
    name: tuple[str, ...]
    direction: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Spheres:
    """Left and middle spheres, the given ones first: centre (S, 3), radius (S,), segment (S,)."""

    centre: Floats
    radius: Floats
    segment: Ints
    given: int

    @property
    def sided(self) -> NDArray[np.bool_]:
        """(S,) True for those that have a twin on the right."""
        return self.centre[:, 1] != 0


def shares_at(surface: Surface, share: Floats, samples: Samples) -> Floats:
    """(n, N) the segments' shares at samples, from those at the vertices."""
    corner = surface.faces[samples.face]
    a, b, c = (surface.vertices[corner[:, k]] for k in range(3))
    whole = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("nc,nc->n", whole, whole), 1e-30)
    u = np.einsum("nc,nc->n", np.cross(c - b, samples.point - b), whole) / square
    v = np.einsum("nc,nc->n", np.cross(a - c, samples.point - c), whole) / square
    weight = np.column_stack([u, v, 1 - u - v])
    result: Floats = np.einsum("nk,nks->ns", weight, share[corner])
    return result


def _tolerance(point: Floats, label: Ints, eye: Floats) -> Floats:
    """(n,) [m] at the finest level."""
    table = np.array([TOLERANCE.get(name, 3.0) for name in SEGMENTS])
    tolerance = table[label]
    face = (
        (label == SEGMENTS.index("H"))
        & (point[:, 0] > eye[0] - 0.045)
        & (point[:, 2] < eye[2] + 0.03)
    )
    tolerance[face] = FACE
    return 1e-3 * tolerance


def fitted(
    surface: Surface, share: Floats, given: Given, *, factor: float, eye: Floats, seed: int = 0
) -> Spheres:
    """Spheres within the tolerances times `factor`. share (P, N) at the vertices of the surface;
    eye (3,): a place."""
    fine = float(np.clip(np.sqrt(factor), 0.8, 1.6))
    wide = even_samples(surface, 0.0038 * fine, seed=seed)
    close = even_samples(surface, 0.0019 * fine, seed=seed + 1)
    samples = [_kept(surface, share, wide, fine=False), _kept(surface, share, close, fine=True)]
    targets = []
    balls = []
    for part in samples:
        weight = shares_at(surface, share, part)
        label = weight.argmax(axis=1)
        tolerance = factor * _tolerance(part.point, label, eye)
        may = ((weight >= 0.3) | (np.arange(len(SEGMENTS)) == label[:, None])) @ (
            1 << np.arange(len(SEGMENTS))
        )
        targets.append(Targets(part.point, 0.97 * tolerance, may.astype(np.int64)))
        slack = np.random.default_rng(seed + 2).random(len(part)) * 0.7 * tolerance
        limits = FitBounds(0.0025, 0.16, 0.0, 0.0)
        bits = (1 << label).astype(np.int64)
        found = inner_balls(surface, part, limits, slack=slack, bits=bits, regions=Regions())
        balls.append(_middled(surface, _of_one_part(surface, share, found)))
    candidates = joined_candidates(
        [Candidates(given.centre, given.radius, np.full(len(given.radius), MOST)), *balls]
    )
    label = np.log2(np.minimum(candidates.bits, 2**40).astype(float)).astype(int)
    label[: len(given.radius)] = given.segment
    outward = (
        0.6
        * factor
        * _tolerance(candidates.centre + [0.03, 0, 0] * (label == 5)[:, None], label, eye)
    )
    radius = np.where(candidates.depth > 0.0018, candidates.depth + outward, -1e9)
    radius[: len(given.radius)] = given.radius
    targets.append(_inner(surface, share, factor))
    found = cover(
        joined_targets(targets), candidates, radius, required=len(given.radius), moves=16, seed=seed
    )
    chosen = found.chosen
    spheres = Spheres(
        candidates.centre[chosen], radius[chosen], label[chosen].astype(np.int64), len(given.radius)
    )
    return _connected(surface, _polished(spheres, samples))


def _connected(surface: Surface, spheres: Spheres) -> Spheres:
    """The spheres with more of them where the body would fall into pieces, so that it is one
    solid.

    A sphere is added in the middle between the two that are nearest to each other, as large as the
    skin lets it and large enough to overlap both.
    """
    for _ in range(MOST_PIECES):
        sided = spheres.sided
        centre = np.concatenate([spheres.centre, spheres.centre[sided] * FLIP])
        radius = np.concatenate([spheres.radius, spheres.radius[sided]])
        owner = np.concatenate([np.arange(len(sided)), np.flatnonzero(sided)])
        gap = np.linalg.norm(centre[:, None] - centre[None], axis=2) - radius[:, None] - radius
        _, piece = connected_components(coo_matrix(gap < -OVERLAP), directed=False)
        lone = np.flatnonzero((piece != np.bincount(piece).argmax()) & (centre[:, 1] >= 0))
        if not len(lone):
            return spheres
        apart = np.where(piece[lone][:, None] == piece[None], np.inf, gap[lone])
        row, other = np.unravel_index(int(apart.argmin()), apart.shape)
        one = int(lone[row])
        along = centre[other] - centre[one]
        far = float(np.linalg.norm(along))
        middle = centre[one] + along * (0.5 + 0.5 * (radius[one] - radius[other]) / far)
        depth = -float(surface.distance(middle[None])[0])
        size = max(0.5 * float(apart.min()) + 2.0 * OVERLAP, min(depth, radius[one]))
        spheres = Spheres(
            np.concatenate([spheres.centre, middle[None]]),
            np.append(spheres.radius, size),
            np.append(spheres.segment, spheres.segment[owner[one]]),
            spheres.given,
        )
    raise ValueError(f"the spheres still fall into pieces after {MOST_PIECES} were added")


def _kept(surface: Surface, share: Floats, samples: Samples, *, fine: bool) -> Samples:
    """The samples of the left half that lie on parts of this fineness."""
    label = shares_at(surface, share, samples).argmax(axis=1)
    wanted = np.isin(label, [SEGMENTS.index(n) for n in FINE_PARTS]) == fine
    return samples.at(np.flatnonzero(wanted & (samples.point[:, 1] >= -1e-4)))


def _of_one_part(surface: Surface, share: Floats, found: Candidates) -> Candidates:
    """Without the balls that also touch the skin of another part: they would bridge an arm pit or a
    groin."""
    _, face, _ = surface.nearest(found.centre)
    mine = np.log2(found.bits.astype(np.float64)).astype(np.int64)
    return found.at(share[surface.faces[face]].mean(axis=1)[np.arange(len(mine)), mine] > 0.25)


def _middled(surface: Surface, found: Candidates) -> Candidates:
    """What lies near the middle plane is moved into it, so that it needs no twin."""
    depth = np.maximum(found.depth, 1e-9)
    near = found.centre[:, 1] < 0.45 * depth
    centre = np.where(near[:, None], found.centre * [1, 0, 1], found.centre)
    return Candidates(centre, np.where(near, -surface.distance(centre), found.depth), found.bits)


def _inner(surface: Surface, share: Floats, factor: float) -> Targets:
    """Points all through the left half that must lie inside some sphere, so that no air is left
    inside the body.

    They stand on a grid that is finer where the body is thin. A sphere of any segment may hold
    them: the limbs stand apart.
    """
    wide = FILLED * float(np.sqrt(factor))
    parts = [
        _filling(surface, share, wide, fine=False),
        _filling(surface, share, 0.35 * wide, fine=True),
    ]
    point = np.concatenate(parts)
    return Targets(point, np.zeros(len(point)), np.full(len(point), MOST))


def _filling(surface: Surface, share: Floats, spacing: float, *, fine: bool) -> Floats:
    """(n, 3) the points of a grid that lie at least half its spacing inside the skin, of the parts
    of this fineness."""
    low = surface.vertices.min(axis=0)
    high = surface.vertices.max(axis=0)
    low[1] = 0.0
    axes = [np.arange(a + 0.5 * spacing, b, spacing) for a, b in zip(low, high, strict=True)]
    axes[1] -= 0.5 * spacing
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    _, face, _ = surface.nearest(grid)
    label = share[surface.faces[face]].mean(axis=1).argmax(axis=1)
    mine = np.isin(label, [SEGMENTS.index(name) for name in FINE_PARTS]) == fine
    grid = grid[mine]
    inside: Floats = grid[surface.distance(grid) < -0.5 * spacing]
    return inside


def _polished(spheres: Spheres, samples: list[Samples]) -> Spheres:
    """Least squares on both halves at once, then exactly symmetric again."""
    point = np.concatenate([s.point for s in samples])
    # fine parts have more samples for their area; each sphere is solved by its own, so that does no
    # harm
    both = np.concatenate([point, point * FLIP])
    sided = spheres.sided
    centre = np.concatenate([spheres.centre, spheres.centre[sided] * FLIP])
    radius = np.concatenate([spheres.radius, spheres.radius[sided]])
    free = np.arange(len(radius)) >= spheres.given
    free[len(spheres.radius) :] = free[: len(spheres.radius)][sided]
    from workbench.geometry.nearest import morton_order

    both = both[morton_order(both)]
    centre, radius = refine_spheres(
        both, centre, radius, free=free, limits=FitBounds(0.002, 0.2, 1, 1), steps=4
    )
    count = len(spheres.radius)
    twin_centre = centre[:count] * [1, 0, 1]
    twin_radius = radius[:count].copy()
    twin_centre[sided] = centre[count:] * FLIP
    twin_radius[sided] = radius[count:]
    centre = 0.5 * (centre[:count] + twin_centre)
    radius = 0.5 * (radius[:count] + twin_radius)
    centre[~sided, 1] = 0.0
    return Spheres(centre, radius, spheres.segment, spheres.given)
