"""Few spheres that hold every sample of a surface: set cover over candidate spheres.

Required spheres first, then greedily, then without the needless ones, then improved in small
neighbourhoods with a seeded generator: the same input gives the same spheres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.fitting.candidates import Candidates
from workbench.body.kernels.balls import BLOCK, block_bounds, covered_by
from workbench.body.kernels.setcover import greedy_cover, improve_cover, prune_cover, transposed
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Cover", "Targets", "cover", "held_rows", "joined_targets"]

_WORK = 8e8
"""Entries of the cover that all moves of the improvement may look at: about 3 s."""


@dataclass(frozen=True, eq=False)
class Targets:
    """What must be held: points (n, 3) [m], each at most margin (n,) [m] outside a sphere; may
    (n,): the bits of the segments whose spheres count for it."""

    point: Floats
    margin: Floats
    may: Ints

    def __len__(self) -> int:
        return len(self.margin)

    def at(self, index: Ints | Bools) -> Targets:
        """Some of them."""
        return Targets(self.point[index], self.margin[index], self.may[index])


@dataclass(frozen=True, eq=False)
class Cover:
    """Numbers of the chosen candidates, required ones first (k,), and of the targets that no
    candidate holds (b,)."""

    chosen: Ints
    bare: Ints


def joined_targets(parts: list[Targets]) -> Targets:
    """All of several lists, in an order in which near ones are together."""
    point = np.concatenate([p.point for p in parts])
    order = morton_order(point)
    margin = np.concatenate([p.margin for p in parts])
    may = np.concatenate([p.may for p in parts])
    return Targets(point[order], margin[order], may[order])


def held_rows(targets: Targets, candidates: Candidates, radius: Floats) -> tuple[Ints, Ints]:
    """Which targets each candidate holds: start (m + 1,), item; candidate j holds
    item[start[j]:start[j + 1]]."""
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

    The first `required` candidates are taken in any case and stay; `begun` are taken first and may
    go again; `moves` tries of improvement for each sphere (each drops 3 to 12 neighbours and covers
    anew), fewer once `target` spheres are enough.
    """
    start, item = held_rows(targets, candidates, radius)
    times = np.zeros(len(targets), np.int64)
    chosen = np.zeros(len(radius), np.int64)
    fixed = np.zeros(len(radius), np.int64)
    fixed[:required] = 1
    for j in np.union1d(np.arange(required), begun if begun is not None else []).astype(np.int64):
        chosen[j] = 1
        times[item[start[j] : start[j + 1]]] += 1
    greedy_cover(start, item, times, chosen)
    prune_cover(start, item, times, chosen, fixed)
    # a move looks at about 8 rows and all that could take their place: few large rows make dear
    # moves
    moves = min(
        moves * int(chosen.sum()),
        int(_WORK / max(1.0, len(item) * min(1.0, 8 / max(1, chosen.sum())))),
    )
    if moves:
        begin, row = transposed(start, item, len(targets))
        improve_cover(
            start, item, begin, row, times, chosen, fixed, candidates.centre, moves, target, seed
        )
        times[:] = 0
        for j in np.flatnonzero(chosen):
            times[item[start[j] : start[j + 1]]] += 1
        prune_cover(start, item, times, chosen, fixed)
    picked = np.flatnonzero(chosen)
    while target and len(picked) > max(target, required):
        picked = _without_least(start, item, times, picked, required)
    return Cover(picked, np.flatnonzero(times == 0))


def _without_least(start: Ints, item: Ints, times: Ints, picked: Ints, required: int) -> Ints:
    """The chosen rows without the one that alone holds the fewest targets."""
    alone = [np.count_nonzero(times[item[start[j] : start[j + 1]]] == 1) for j in picked]
    least = required + int(np.argmin(alone[required:]))
    j = picked[least]
    times[item[start[j] : start[j + 1]]] -= 1
    return np.delete(picked, least)
