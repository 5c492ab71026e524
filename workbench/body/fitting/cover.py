"""Choose few spheres that hold every sample of a surface: a set cover of candidates.

1. Take the required spheres.
2. Take greedily the candidate that holds the most open targets.
3. Remove chosen spheres that hold no target alone.
4. Improve the choice in small neighbourhoods, with a seeded generator.

The same input gives the same spheres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.fitting.candidates import Candidates
from workbench.body.kernels.setcover import greedy_cover, improve_cover, prune_cover, transposed
from workbench.body.kernels.sphere_union import BLOCK, block_bounds, covered_by
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Cover", "Targets", "cover", "held_rows", "joined_targets"]

_WORK = 8e8
"""Entries of the cover that all moves of the improvement may read, about 3 s."""


@dataclass(frozen=True, eq=False)
class Targets:
    """Points that must be held."""

    point: Floats
    """(n, 3) [m]."""
    margin: Floats
    """(n,) distance [m] up to which a point may lie outside a sphere."""
    may: Ints
    """(n,) bits of the segments whose spheres count."""

    def __len__(self) -> int:
        return len(self.margin)

    def at(self, index: Ints | Bools) -> Targets:
        """Return some of the targets."""
        return Targets(self.point[index], self.margin[index], self.may[index])


@dataclass(frozen=True, eq=False)
class Cover:
    """A choice of candidates."""

    chosen: Ints
    """(k,) chosen candidates, required ones first."""
    bare: Ints
    """(b,) targets that no candidate holds."""


def joined_targets(parts: list[Targets]) -> Targets:
    """Concatenate lists of targets, in an order in which near ones are together."""
    point = np.concatenate([p.point for p in parts])
    order = morton_order(point)
    margin = np.concatenate([p.margin for p in parts])
    may = np.concatenate([p.may for p in parts])
    return Targets(point[order], margin[order], may[order])


def held_rows(targets: Targets, candidates: Candidates, radius: Floats) -> tuple[Ints, Ints]:
    """Find the targets that each of m candidates holds.

    Returns
    -------
    tuple of Ints
        start (m + 1,) and item: candidate j holds item[start[j]:start[j + 1]].
    """
    start, item = covered_by(
        targets.point,
        targets.margin,
        targets.may,
        block_bounds(targets.point, BLOCK),
        block_bounds(targets.point, BLOCK * BLOCK),
        candidates.centre,
        radius,
        candidates.bits,
    )
    return start, item


def cover(
    targets: Targets,
    candidates: Candidates,
    radius: Floats,
    *,
    required: int = 0,
    begun: Ints | None = None,
    moves: int = 0,
    target: int = 0,
    seed: int = 0,
) -> Cover:
    """Choose few candidates that hold all targets.

    Parameters
    ----------
    targets, candidates, radius
        The targets, and m candidates with their radii (m,) [m].
    required
        Number of candidates, the first ones, that are chosen in any case.
    begun
        Candidates that are taken first, and may be removed again.
    moves
        Tries of improvement for each chosen sphere. A try removes 3 to 12 neighbours and covers
        anew what they held.
    target
        Number of spheres that is enough: improvement ends, and spheres with the least loss are
        removed down to it. 0 for none.
    seed
        Of the improvement.
    """
    start, item = held_rows(targets, candidates, radius)
    times = np.zeros(len(targets), np.int64)
    chosen = np.zeros(len(radius), np.int64)
    fixed = np.zeros(len(radius), np.int64)
    fixed[:required] = 1
    first = np.union1d(np.arange(required), begun if begun is not None else []).astype(np.int64)
    chosen[first] = 1
    _count_held(start, item, first, times)
    greedy_cover(start, item, times, chosen)
    prune_cover(start, item, times, chosen, fixed)
    moves = _affordable_moves(moves, int(chosen.sum()), len(item))
    if moves:
        begin, row = transposed(start, item, len(targets))
        improve_cover(
            start, item, begin, row, times, chosen, fixed, candidates.centre, moves, target, seed
        )
        times[:] = 0
        _count_held(start, item, np.flatnonzero(chosen), times)
        prune_cover(start, item, times, chosen, fixed)
    picked = np.flatnonzero(chosen)
    while target and len(picked) > max(target, required):
        picked = _without_least(start, item, times, picked, required)
    return Cover(picked, np.flatnonzero(times == 0))


def _count_held(start: Ints, item: Ints, rows: Ints, times: Ints) -> None:
    """Add to times (n,) how many of the rows hold each item."""
    for j in rows:
        times[item[start[j] : start[j + 1]]] += 1


def _affordable_moves(per_sphere: int, spheres: int, entries: int) -> int:
    """Number of moves in all; few large rows make expensive moves.

    A move reads about 8 rows and all that could take their place.
    """
    share = min(1.0, 8 / max(1, spheres))
    return min(per_sphere * spheres, int(_WORK / max(1.0, entries * share)))


def _without_least(start: Ints, item: Ints, times: Ints, picked: Ints, required: int) -> Ints:
    """The chosen rows without the one that alone holds the fewest targets."""
    alone = [np.count_nonzero(times[item[start[j] : start[j + 1]]] == 1) for j in picked]
    least = required + int(np.argmin(alone[required:]))
    j = picked[least]
    times[item[start[j] : start[j + 1]]] -= 1
    return np.delete(picked, least)
