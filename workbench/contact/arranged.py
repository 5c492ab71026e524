"""Clearance in an environment some of whose parts are displaced: seats along their rails, a lever.

To displace a part is to make another environment, whose distance index is made anew. Here the
bodies are displaced instead: against the parts of a mover they stand where they would stand in that
mover's own frame. The index of the environment at rest serves every displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.contact.batches import grouped_room
from workbench.contact.collide import allowed_groups
from workbench.contact.fields import Groups
from workbench.model.arrays import Floats, Ints, frozen
from workbench.model.body import Body, check_one
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = [
    "Arranged",
    "FrameRooms",
    "SegmentRoom",
    "bodies_displaced",
    "room_of_segments",
    "rooms_by_mover",
]


@dataclass(frozen=True, eq=False)
class Arranged:
    """An environment with groups of parts displaced.

    Parameters
    ----------
    environment
        With all parts at rest.
    movers
        M groups of parts, by index, that move together; no part is in two of them.
    displacement
        (M, 3) [m] of each.
    """

    environment: Environment
    movers: Groups
    displacement: Floats

    def __post_init__(self) -> None:
        given = frozen(
            self.displacement, np.float64, (len(self.movers), 3), "arranged.displacement"
        )
        object.__setattr__(self, "displacement", given)

    @property
    def by_part(self) -> Floats:
        """(K, 3) [m] the displacement of each part."""
        found = np.zeros((len(self.environment.parts), 3))
        for parts, shift in zip(self.movers, self.displacement, strict=True):
            found[list(parts)] = shift
        return found


@dataclass(frozen=True, eq=False)
class SegmentRoom:
    """What comes nearest to each of the N segments of P poses.

    Parameters
    ----------
    room
        (P, N) [m] the least signed distance, with the overlap that a part allows added; infinite
        where nothing is near.
    sphere, polygon
        (P, N) which are nearest, -1 where there are none.
    point
        (P, N, 3) [m] the polygon's nearest point, NaN where there is none.
    """

    room: Floats
    sphere: Ints
    polygon: Ints
    point: Floats


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
    placed, arranged
        What they are of.
    rooms
        By mover, -1 for the parts at rest; movers without shown parts are left out.
    """

    placed: Placed
    arranged: Arranged
    rooms: Mapping[int, SegmentRoom]


def rooms_by_mover(
    placed: Placed, arranged: Arranged, before: FrameRooms | None = None
) -> FrameRooms:
    """Compute the room that each segment has beyond the overlap that parts allow, mover by mover.

    Parameters
    ----------
    placed
        P poses of a body of one row.
    arranged
        The environment. Hidden parts take no part.
    before
        An earlier answer: of the same bodies, what has not been displaced since is not asked again.
    """
    check_one(placed.body)
    environment = arranged.environment
    known = _still(placed, arranged, before)
    rooms = {}
    for frame in _frames(placed.body, environment, arranged.movers):
        shift = arranged.displacement[frame.mover] if frame.mover >= 0 else np.zeros(3)
        rooms[frame.mover] = known.get(frame.mover) or _room_in_frame(
            bodies_displaced(placed, -shift), environment, frame, shift
        )
    return FrameRooms(placed, arranged, rooms)


def _still(placed: Placed, arranged: Arranged, before: FrameRooms | None) -> dict[int, SegmentRoom]:
    """The rooms of an earlier answer that hold still."""
    if before is None or before.placed is not placed:
        return {}
    old = before.arranged
    if old.environment is not arranged.environment or old.movers != arranged.movers:
        return {}
    same = np.all(old.displacement == arranged.displacement, axis=1)
    return {mover: room for mover, room in before.rooms.items() if mover < 0 or same[mover]}


def room_of_segments(found: FrameRooms) -> SegmentRoom:
    """Take the least room of each segment from any part.

    Returns
    -------
    SegmentRoom
        The same as of the environment whose parts are displaced, to rounding.
    """
    return _least(list(found.rooms.values()), found.placed)


def _room_in_frame(
    view: Placed, environment: Environment, frame: _Frame, shift: Floats
) -> SegmentRoom:
    """The room from the parts of one frame, for bodies placed in this frame."""
    found = grouped_room(view, environment, frame.groups, frame.allowed)
    return SegmentRoom(
        found.distance[:, :, 0],
        found.sphere[:, :, 0],
        found.polygon[:, :, 0],
        found.point[:, :, 0] + shift,
    )


def _least(rooms: list[SegmentRoom], placed: Placed) -> SegmentRoom:
    """The least of the rooms in several frames; where nothing is there, infinite ones."""
    shape = (len(placed), len(placed.window))
    if not rooms:
        none = np.full(shape, -1)
        return SegmentRoom(np.full(shape, np.inf), none, none, np.full((*shape, 3), np.nan))
    least = np.argmin([one.room for one in rooms], axis=0)
    rows, columns = np.indices(shape)

    def chosen(name: str) -> Floats:
        every = np.stack([getattr(one, name) for one in rooms])
        picked: Floats = every[least, rows, columns]
        return picked

    return SegmentRoom(
        chosen("room"), chosen("sphere").astype(int), chosen("polygon").astype(int), chosen("point")
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
