"""Turn a cover of samples into spheres that keep the tolerances everywhere.

The cover is proved on the whole surface and extended where the proof fails. Then the spheres are
refined and proved again; what the refinement breaks is taken back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.body.fitting.candidates import FitBounds, Samples
from workbench.body.fitting.cover import cover
from workbench.body.fitting.polish import polished_parts, union_field, within_bounds
from workbench.body.fitting.problem import Bare, SetCover, refuse_bare, with_more
from workbench.body.kernels.coverage_proof import uncovered_patches
from workbench.body.kernels.poisson_disk import sample_poisson_disk
from workbench.body.kernels.sphere_union import max_distance_bound
from workbench.body.surface import Surface
from workbench.errors import InputError
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "Spheres",
    "deepest_hollow",
    "gap_bound",
    "parts_of",
    "proved_cover",
    "proved_polish",
    "segment_triangles",
    "split_triangles",
    "uncovered_regions",
    "unmatched_regions",
]

Spheres = tuple[Floats, Floats]
"""Centres (m, 3) and radii (m,) [m]."""
_ROUNDS = 40
"""Rounds at most of covering and proving."""
_POLISH_ROUNDS = 30
"""Rounds at most of taking back what refinement broke."""


@dataclass(frozen=True, eq=False)
class Uncovered:
    """What spheres do not hold."""

    bare: Bare
    """Places on the surface."""
    hollow: Floats
    """Places (k, 3) [m] of the union that are too deep inside."""

    def __len__(self) -> int:
        return len(self.bare) + len(self.hollow)


def segment_triangles(problem: SetCover, longest: float) -> list[Floats]:
    """Return the triangles (T, 3, 3) that each segment must hold, no side longer than `longest` [m]."""
    surface = problem.surface
    corners = split_triangles(surface.vertices[surface.faces], longest)
    shared = problem.regions.shared(corners.mean(axis=1))
    return [corners[shared[:, k]] for k in range(problem.regions.count)]


def proved_cover(
    problem: SetCover, limits: FitBounds, triangles: list[Floats], seed: int
) -> tuple[SetCover, Ints]:
    """Cover the targets, prove the tolerance, add what is bare, and repeat until all is proved.

    The first rounds improve the cover, later ones only add to it.

    Parameters
    ----------
    problem, limits
        The problem, and the bounds of the spheres.
    triangles
        Of each segment, see `segment_triangles`.
    seed
        0 or more.

    Returns
    -------
    tuple of Problem and Ints
        The extended problem, and the chosen candidates.

    Raises
    ------
    InputError
        If the tolerance is impossible, or not proved in 40 rounds.
    """
    chosen: Ints | None = None
    for turn in range(_ROUNDS):
        usable = problem.radius(limits) > 0
        problem, chosen = _only(problem, usable, chosen)
        moves = 16 if turn == 0 else 3 if turn < 4 else 0
        found = cover(
            problem.targets,
            problem.candidates,
            problem.radius(limits),
            required=len(problem.joints.radius),
            begun=chosen,
            moves=moves,
            seed=seed + turn,
        )
        if len(found.bare):
            problem = _retried(problem, limits, found.bare)
        chosen = found.chosen
        spheres = problem.candidates.centre[chosen], problem.radius(limits)[chosen]
        uncovered = _uncovered(problem, limits, triangles, spheres, problem.candidates.bits[chosen])
        if not len(uncovered) and not len(found.bare):
            return problem, chosen
        problem = with_more(problem, limits, uncovered.bare, uncovered.hollow)
    raise InputError(
        f"the tolerance could not be proved in {_ROUNDS} rounds; widen it or let smaller spheres in"
    )


def _only(problem: SetCover, usable: Bools, chosen: Ints | None) -> tuple[SetCover, Ints | None]:
    """The problem without the candidates that the limits forbid, and the chosen ones renumbered."""
    if usable.all():
        return problem, chosen
    number = np.cumsum(usable) - 1
    kept = number[chosen[usable[chosen]]] if chosen is not None else None
    return replace(problem, candidates=problem.candidates.at(usable)), kept


def _retried(problem: SetCover, limits: FitBounds, bare: Ints) -> SetCover:
    """The problem with a sphere of its own for each bare target; refused if none is allowed."""
    places = Bare(_foot(problem.surface, problem.targets.point[bare]), problem.targets.may[bare])
    more = with_more(problem, limits, places, np.zeros((0, 3)))
    more = replace(more, targets=problem.targets)
    fresh = cover(problem.targets.at(bare), more.candidates, more.radius(limits))
    if len(fresh.bare):
        refuse_bare(more, limits, bare[fresh.bare])
    return more


def _uncovered(
    problem: SetCover, limits: FitBounds, triangles: list[Floats], spheres: Spheres, bits: Ints
) -> Uncovered:
    """Places on the surface that the spheres of a segment do not hold, and those inside that none holds."""
    places = []
    of = []
    for k, corners in enumerate(triangles):
        mine = bits & (np.int64(1) << k) != 0
        if len(corners) and not mine.any():
            found = corners.mean(axis=1)[:1]
        else:
            found = unmatched_regions(corners, spheres[0][mine], spheres[1][mine], limits.inward)
        places.append(found)
        of.append(np.full(len(found), np.int64(1) << k))
    bare = Bare(_foot(problem.surface, np.concatenate(places)), np.concatenate(of))
    return Uncovered(bare, uncovered_regions(problem.surface, *spheres, limits.inward))


def _foot(surface: Surface, points: Floats) -> Samples:
    """Points (n, 3) at or near the surface as samples, with the normals of their faces."""
    _, face, foot = surface.nearest(points)
    normal = np.empty((len(surface.faces), 3))
    normal[surface.solid.face] = surface.solid.normal[:, 0]
    return Samples(foot, normal[face], face)


def parts_of(problem: SetCover, bits: Ints) -> list[tuple[Bools, Bools]]:
    """Return, for each segment, the samples (n,) that it must hold and its own spheres (m,).

    bits (m,): the segments that each sphere serves.
    """
    shared = problem.regions.shared(problem.samples.point)
    return [(shared[:, k], bits & (np.int64(1) << k) != 0) for k in range(problem.regions.count)]


def proved_polish(
    problem: SetCover, limits: FitBounds, triangles: list[Floats], safe: Spheres, bits: Ints
) -> Spheres:
    """Refine spheres, then take back what breaks the proof.

    A sphere is taken back half way first, then wholly, then together with all spheres near it.

    Parameters
    ----------
    problem, limits, triangles
        As for `proved_cover`.
    safe, bits
        Spheres that are proved, and the bits (m,) of the segments that each serves.
    """
    free = np.arange(len(safe[1])) >= len(problem.joints.radius)
    moved = polished_parts(
        problem.samples.point, safe, free=free, limits=limits, parts=parts_of(problem, bits)
    )
    share = np.ones(len(safe[1]))  # of the way from the safe sphere to the refined one
    for turn in range(_POLISH_ROUNDS):
        mixed = _between(safe, moved, share)
        mixed = within_bounds(problem.surface, mixed, safe, limits)
        mixed[0][~free] = safe[0][~free]
        mixed[1][~free] = safe[1][~free]
        uncovered = _uncovered(problem, limits, triangles, mixed, bits)
        if not len(uncovered):
            return mixed
        wrong = np.concatenate([uncovered.bare.samples.point, uncovered.hollow])
        of = np.concatenate([uncovered.bare.bits, np.full(len(uncovered.hollow), np.int64(-1))])
        margin = limits.inward if turn > 4 else 0.0
        share[_near(wrong, of, safe, bits, margin)] *= 0.5 if turn < 2 else 0.0
        if turn > 4:
            share[_near(wrong, of, mixed, bits, margin)] = 0.0
    return safe


def _between(one: Spheres, other: Spheres, share: Floats) -> Spheres:
    """Spheres at shares (m,) of the way from one to the other."""
    return (
        one[0] + share[:, None] * (other[0] - one[0]),
        one[1] + share * (other[1] - one[1]),
    )


def _near(points: Floats, of: Ints, spheres: Spheres, bits: Ints, margin: float) -> Bools:
    """(m,) True for the spheres that hold a segment's points best, and those within `margin` [m] of them.

    of (k,): the segment of each point (k, 3), as a bit; bits (m,): those of the spheres.
    """
    near = np.zeros(len(spheres[1]), dtype=np.bool_)
    for point, segment in zip(points, of, strict=True):
        gap = np.linalg.norm(point - spheres[0], axis=1) - spheres[1]
        gap[bits & segment == 0] = np.inf
        near[gap.argmin()] = True
        near |= gap < (margin if margin else -np.inf)
    return near


# Prove that a union of spheres keeps its tolerances everywhere, and find where it does not.
#
# The surface is proved triangle by triangle: the field of one sphere is convex, so its greatest value
# on a triangle is at a corner. The exposed surface of the spheres is proved patch by patch: the depth
# under the surface changes by no more than the distance moved. What is not proved is cut into
# quarters, down to 2 % of the tolerance.

_RESERVE = 0.02
"""Share of the tolerance in reserve: what is proved to within this share holds in full."""
_GOLDEN = 0.5 * (1 + np.sqrt(5))


def unmatched_regions(corners: Floats, centre: Floats, radius: Floats, inward: float) -> Floats:
    """Return points (k, 3) of triangles (T, 3, 3) that are not proved to lie within `inward` [m] of the
    union of spheres (m, 3), (m,) [m].
    """
    points = np.empty((len(corners), 3))
    gaps = np.empty((len(corners), 2))
    max_distance_bound(
        corners, centre, radius, (1 - _RESERVE) * inward, _RESERVE * inward, points, gaps
    )
    # rounding of the last digits is not a fault
    bad = points[gaps[:, 1] > inward * (1 + 1e-9)]
    return bad[sample_poisson_disk(bad, 0.5 * inward)] if len(bad) else bad


def uncovered_regions(surface: Surface, centre: Floats, radius: Floats, inward: float) -> Floats:
    """Return points (k, 3) of the exposed spheres that are not proved to lie at most `inward` [m] under
    the surface.
    """
    places = _deep(surface, (centre, radius), inward, _RESERVE * inward, most=64)[0]
    return places[sample_poisson_disk(places, 0.5 * inward)] if len(places) else places


def deepest_hollow(surface: Surface, centre: Floats, radius: Floats, floor: float) -> float:
    """Return a proved upper bound [m], to 2 %, of how deep the union's surface lies under the surface.

    The bound is at least `floor`, and at least 1/500 of the root of the area (0.6 mm of a hand, 2.7 mm
    of a body): a finer proof needs too many patches.
    """
    bound = max(floor, 0.002 * np.sqrt(surface.area))
    for _ in range(60):
        _, upper = _deep(surface, (centre, radius), bound, _RESERVE * bound, most=64)
        if upper <= bound * (1 + 1e-9):
            return float(bound)
        bound = max(1.01 * bound, upper)
    return float(np.inf)


def gap_bound(corners: Floats, centre: Floats, radius: Floats) -> float:
    """Return a proved upper bound [m], to 2 %, of how far triangles (T, 3, 3) lie outside the union."""
    if not len(corners) or not len(radius):
        return float("inf") if len(corners) else 0.0
    middle = corners.mean(axis=1)
    floor = max(float(union_field(middle[morton_order(middle)], centre, radius)[0].max()), 1e-5)
    points = np.empty((len(corners), 3))
    gaps = np.empty((len(corners), 2))
    for _ in range(2):
        max_distance_bound(corners, centre, radius, floor, _RESERVE * floor, points, gaps)
        floor = max(floor, float(gaps[:, 0].max()))
    return float(max(0.0, gaps[:, 1].max()))


def split_triangles(corners: Floats, longest: float) -> Floats:
    """Return triangles (T, 3, 3) halved across their longest side until none is longer than `longest` [m]."""
    done = []
    while len(corners):
        side = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        large = side.max(axis=1) > longest
        done.append(corners[~large])
        turn = (side[large].argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(corners[large], turn[:, :, None], axis=1), 1, 0)
        middle = 0.5 * (a + b)
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        corners = np.stack(halves, axis=1).reshape(-1, 3, 3)
    return np.concatenate(done)


def _deep(
    surface: Surface, spheres: tuple[Floats, Floats], inward: float, fine: float, *, most: int
) -> tuple[Floats, float]:
    """Places (k, 3) on the exposed spheres not proved at most `inward` deep, `most` a sphere, and the deepest [m]."""
    points = np.empty((most * len(spheres[1]), 3))
    depth = np.empty(most * len(spheres[1]))
    found = uncovered_patches(
        *spheres, _icosahedron(), surface.solid, inward, fine, most, points, depth
    )
    return points[:found], float(depth[:found].max(initial=inward))


def _icosahedron() -> Floats:
    """(20, 3, 3) corners of the faces, unit vectors."""
    points = [(0.0, a, b * _GOLDEN) for a in (-1, 1) for b in (-1, 1)]
    ring = np.array([np.roll(p, k) for k in range(3) for p in points]) / np.sqrt(1 + _GOLDEN**2)
    near = ring @ ring.T > 0.4
    triples = [(i, j, k) for i in range(12) for j in range(i) for k in range(j)]
    return ring[
        np.array([(i, j, k) for i, j, k in triples if near[i, j] and near[j, k] and near[i, k]])
    ]
