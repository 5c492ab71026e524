"""Clearance of chosen pairs: how far some spheres of each placed person stay from some parts, in an
environment as it is and with parts displaced: seats along their rails, a lever.

To displace a part is to make another environment, whose distance index is made anew. Here the
bodies are displaced instead: against the parts of a mover they stand where they would stand in that
mover's own frame. The index of the environment at rest serves every displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.contact.batches import grouped_room, least_clearances, nothing_near
from workbench.contact.collide import allowed_depth, allowed_groups
from workbench.contact.distance_fields import Groups
from workbench.contact.kernels.clearance import ClearanceTask
from workbench.contact.kernels.search import Nearest
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, check_one
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.model.surroundings import Surroundings

__all__ = [
    "ClearancePair",
    "FrameRooms",
    "bodies_displaced",
    "clearance_of_pairs",
    "room_of_segments",
    "rooms_by_mover",
]


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


@dataclass(frozen=True, eq=False)
class _Frame:
    """Groups of parts that move together, the overlap (N, G) [m] that they allow, and which mover
    they are, -1 for those at rest."""

    mover: int
    groups: Groups
    allowed: Floats


@dataclass(frozen=True, eq=False)
class FrameRooms:
    """The room of bodies from the parts of each mover, and from those at rest.

    Parameters
    ----------
    placed, surroundings
        What they are of.
    rooms
        By mover, -1 for the parts at rest; movers without shown parts are left out.
    """

    placed: Placed
    surroundings: Surroundings
    rooms: Mapping[int, Nearest]


def rooms_by_mover(
    placed: Placed, surroundings: Surroundings, before: FrameRooms | None = None
) -> FrameRooms:
    """Compute the room that each segment has beyond the overlap that parts allow, mover by mover.

    Parameters
    ----------
    placed
        P poses of a body of one row.
    surroundings
        The environment. Hidden parts take no part.
    before
        An earlier answer: of the same bodies, what has not been displaced since is not asked again.
    """
    check_one(placed.body)
    environment = surroundings.environment
    known = _still(placed, surroundings, before)
    rooms = {}
    for frame in _frames(placed.body, environment, surroundings.movers):
        shift = surroundings.displacement[frame.mover] if frame.mover >= 0 else np.zeros(3)
        rooms[frame.mover] = known.get(frame.mover) or _room_in_frame(
            bodies_displaced(placed, -shift), environment, frame, shift
        )
    return FrameRooms(placed, surroundings, rooms)


def _still(
    placed: Placed, surroundings: Surroundings, before: FrameRooms | None
) -> dict[int, Nearest]:
    """The rooms of an earlier answer that hold still."""
    if before is None or before.placed is not placed:
        return {}
    old = before.surroundings
    if old.environment is not surroundings.environment or old.movers != surroundings.movers:
        return {}
    same = np.all(old.displacement == surroundings.displacement, axis=1)
    return {mover: room for mover, room in before.rooms.items() if mover < 0 or same[mover]}


def room_of_segments(found: FrameRooms) -> Nearest:
    """Take the least room of each segment from any part.

    Returns
    -------
    Nearest
        (P, N) with the overlap that a part allows added: the same as of the environment whose parts
        are displaced, to rounding.
    """
    return _least(list(found.rooms.values()), found.placed)


def _room_in_frame(view: Placed, environment: Environment, frame: _Frame, shift: Floats) -> Nearest:
    """The room from the parts of one frame, for bodies placed in this frame."""
    found = grouped_room(view, environment, frame.groups, frame.allowed)
    near = Nearest._make(every[:, :, 0] for every in found)
    return near._replace(point=near.point + shift)


def _least(rooms: list[Nearest], placed: Placed) -> Nearest:
    """The least of the rooms in several frames; where nothing is there, infinite ones."""
    shape = (len(placed), len(placed.window))
    if not rooms:
        return nothing_near(shape)
    least = np.argmin([one.distance for one in rooms], axis=0)
    rows, columns = np.indices(shape)
    return Nearest._make(
        np.stack(every)[least, rows, columns] for every in zip(*rooms, strict=True)
    )


def bodies_displaced(placed: Placed, shift: Floats) -> Placed:
    """Bodies displaced by (3,) [m]."""
    if not shift.any():
        return placed
    world = placed.world_from_segment.copy()
    world[..., 3] += shift
    return Placed(placed.body, world, placed.centres + shift, placed.window, placed.person)


@lru_cache(maxsize=16)
def _frames(body: Body, environment: Environment, movers: Groups) -> tuple[_Frame, ...]:
    """The parts by what they move with and by the overlap they allow; movers without shown parts
    are left out."""
    groups, allowed = allowed_groups(body, environment)
    mover = np.full(len(environment.parts), -1)
    for m, parts in enumerate(movers):
        mover[list(parts)] = m
    return tuple(_split(groups, allowed, mover))


def _split(groups: Groups, allowed: Floats, mover: Ints) -> Iterator[_Frame]:
    for m in range(-1, int(mover.max(initial=-1)) + 1):
        own = [tuple(k for k in group if mover[k] == m) for group in groups]
        columns = [g for g, parts in enumerate(own) if parts]
        if columns:
            yield _Frame(m, tuple(own[g] for g in columns), allowed[:, columns])
