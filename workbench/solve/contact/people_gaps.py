"""Clearances of many people at once: how far each stays from what it is asked to stay clear of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.kernels.contact.crews import least_gaps
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.solve.contact.collide import allowed_depth
from workbench.solve.contact.fields import packed_faces, packed_shells
from workbench.solve.threads import in_pieces

__all__ = ["Gap", "PeopleGaps", "people_gaps"]

PIECE = 16
"""People a thread takes at a time."""


@dataclass(frozen=True, eq=False)
class Gap:
    """Something to stay clear of: these spheres (S,) of these parts (K,). touching: overlap that
    the parts allow is taken off, else pairs that may touch are left out."""

    spheres: Bools
    parts: Bools
    touching: bool


@dataclass(frozen=True, eq=False)
class PeopleGaps:
    """B people, Q gaps. room (B, Q) [m]: the signed distance of the nearest pair, plus what it may
    overlap where that is asked for; infinite where nothing is there. sphere, polygon (B, Q): of
    that pair, -1 where none; point (B, Q, 3) [m]: of the polygon, nearest to the sphere's centre,
    NaN where none."""

    room: Floats
    sphere: Ints
    polygon: Ints
    point: Floats


def people_gaps(
    placed: Placed,
    environment: Environment,
    *,
    gaps: Sequence[Gap],
    moves: Sequence[str] = (),
    shift: Floats | None = None,
    threads: int | None = None,
) -> PeopleGaps:
    """The clearances of B placed people.

    moves: parts that have gone along with each person's seat
    by shift (B, 3) [m]. Hidden parts take no part. threads: all cores where None; the answer does
    not depend on it.
    """
    count = len(placed.centres)
    by = np.zeros((count, 3)) if shift is None else np.ascontiguousarray(shift, dtype=np.float64)
    shape = (count, len(gaps))
    out = (
        np.full(shape, np.inf),
        np.full(shape, -1),
        np.full(shape, -1),
        np.full((*shape, 3), np.nan),
    )
    asked = _asked(placed.body, environment, gaps, np.isin(environment.parts, list(moves)))
    index = packed_faces(environment), packed_shells(environment)
    radius = np.ascontiguousarray(placed.body.radius[placed.person])

    def work(begin: int, end: int) -> None:
        least_gaps(placed.centres, radius, by, asked, *index, out, begin, end)

    in_pieces(work, count, PIECE, threads=threads)
    return PeopleGaps(*out)


def _asked(
    body: Body, environment: Environment, gaps: Sequence[Gap], moves: Bools
) -> tuple[Ints, Ints, Ints, Floats]:
    """Spheres in groups (a segment's, as far as they are asked for), and the pairs of a group and a
    part."""
    segment = body.sphere_segment
    allowed = allowed_depth(body, environment)
    rows: list[Ints] = []
    pairs: list[tuple[int, int, int, int]] = []
    depth: list[float] = []
    for q, gap in enumerate(gaps):
        for n in range(len(body.segments)):
            own = np.flatnonzero(gap.spheres & (segment == n))
            if not len(own):
                continue
            for k in np.flatnonzero(gap.parts & ~environment.hidden):
                if gap.touching or allowed[n, k] == 0:
                    pairs.append((q, len(rows), int(k), int(moves[k])))
                    depth.append(float(allowed[n, k]) if gap.touching else 0.0)
            rows.append(own)
    first = np.concatenate([[0], np.cumsum([len(own) for own in rows])]).astype(np.int64)
    flat = np.concatenate([np.zeros(0, np.int64), *rows])
    return (
        flat,
        first,
        np.array(pairs, dtype=np.int64).reshape(-1, 4),
        np.array(depth, dtype=np.float64),
    )
