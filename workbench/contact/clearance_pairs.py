"""Clearance of chosen pairs: how far some spheres of each placed person stay from some parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.contact.batches import least_clearances
from workbench.contact.collide import allowed_depth
from workbench.contact.kernels.clearance import ClearanceTask
from workbench.contact.kernels.search import Nearest
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["ClearancePair", "clearance_of_pairs"]


@dataclass(frozen=True, eq=False)
class ClearancePair:
    """Spheres (S,) and parts (K,) that are to stay clear of each other."""

    spheres: Bools
    parts: Bools
    touching: bool
    """Whether overlap that a part allows is added back; else pairs that may overlap are left out."""


def clearance_of_pairs(
    placed: Placed,
    environment: Environment,
    *,
    pairs: Sequence[ClearancePair],
    moving_parts: Sequence[str] = (),
    displacement: Floats | None = None,
    growth: Floats | None = None,
    threads: int | None = None,
) -> Nearest:
    """Compute the least clearance of each pair, for every pose with its own person.

    Parameters
    ----------
    placed
        P poses of a body with any number of rows.
    environment
        The environment. Hidden parts take no part.
    pairs
        Q pairs of spheres and parts.
    moving_parts
        Names of the parts that move with the seat.
    displacement
        (P, 3) [m] of these parts in each pose; none where None.
    growth
        (P, N) [m] by which the spheres of each segment are larger than the body's, negative where
        they are smaller; none where None.
    threads
        All cores where None. The answer does not depend on it.

    Returns
    -------
    Nearest
        (P, Q) signed distance with the overlap that is allowed added back, and where; those of a
        pose do not depend on the other poses.
    """
    count = len(placed)
    moved = np.zeros((count, 3)) if displacement is None else np.ascontiguousarray(displacement)
    task = _packed(placed.body, environment, pairs, np.isin(environment.parts, list(moving_parts)))
    radius = np.ascontiguousarray(placed.body.radius[placed.person])
    if growth is not None:
        radius = radius + growth[:, placed.body.sphere_segment]
    bodies = placed.centres, radius, moved
    return least_clearances(bodies, task, environment, len(pairs), threads=threads)


def _packed(
    body: Body, environment: Environment, pairs: Sequence[ClearancePair], moves: Bools
) -> ClearanceTask:
    """The pairs as the kernel takes them: the spheres of a segment in a group, against one part."""
    segment = body.sphere_segment
    allowed = allowed_depth(body, environment)
    groups: list[Ints] = []
    rows: list[tuple[int, int, int, int]] = []
    depth: list[float] = []
    for q, pair in enumerate(pairs):
        for n in range(len(body.segments)):
            own = np.flatnonzero(pair.spheres & (segment == n))
            if not len(own):
                continue
            for k in np.flatnonzero(pair.parts & ~environment.hidden):
                if pair.touching or allowed[n, k] == 0:
                    rows.append((q, len(groups), int(k), int(moves[k])))
                    depth.append(float(allowed[n, k]) if pair.touching else 0.0)
            groups.append(own)
    counts = [len(own) for own in groups]
    return ClearanceTask(
        sphere=np.concatenate([np.zeros(0, np.int64), *groups]),
        first=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        row=np.array(rows, dtype=np.int64).reshape(-1, 4),
        allowed=np.array(depth, dtype=np.float64),
    )
