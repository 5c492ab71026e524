"""The parts that are a control's own beside the one that it stands on.

Meshes have a lever as knob, stalk, base and screws. What touches the part of a control, or another
piece of it, and belongs to the same small thing is the control's own. A piece belongs to it that
moves with it, is named like it or like the control, or lies within its part. What two controls
could claim is neither's: a base that their levers stand on. None of it depends on the unit, the
sides or the order of parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from workbench.files.part_likeness import likeness
from workbench.geometry.polygon import point_winding
from workbench.geometry.touching import come_near
from workbench.model.arrays import Floats
from workbench.model.environment import Environment, OwnPiece

__all__ = ["GRIPPABLE", "TOUCHING", "Handle", "OwnPieces", "Touching", "own_pieces"]

GRIPPABLE = 0.6
"""A part that is larger [m] than this is no handle, knob, wheel or pedal: a control on it is on a
panel, which a hand may not enter wherever it likes."""
TOUCHING = 0.002
"""What is fixed to one another is drawn this far [m] apart at most: a fit, a coat of paint."""
_SMALL = 0.3
"""What a hand moves as one thing is no larger [m] in all, unless its own part is by itself."""


@dataclass(frozen=True)
class Handle:
    """What controls stand on, as one thing that is gripped.

    Parameters
    ----------
    parts
        Its parts, as indices, the one that the controls stand on first.
    controls
        Their names.
    stated
        Whether the file says which parts these are, so that no other is taken along.
    """

    parts: tuple[int, ...]
    controls: tuple[str, ...]
    stated: bool


@dataclass(frozen=True)
class OwnPieces:
    """The pieces that were found for each handle, and a sentence for each part that is nobody's
    because several could claim it."""

    pieces: tuple[tuple[OwnPiece, ...], ...]
    claimed: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Touching:
    """Which parts of an environment touch one another, found as it is asked."""

    environment: Environment
    _known: dict[tuple[int, int], bool] = field(default_factory=dict)
    _corners: dict[int, Floats] = field(default_factory=dict)

    @cached_property
    def boxes(self) -> Floats:
        """(K, 2, 3) [m] least and greatest corner of each part."""
        environment = self.environment
        found = np.empty((len(environment.parts), 2, 3))
        for k in range(len(found)):
            polygons = environment.polygons(k)
            first, last = environment.triangle_start[[polygons.start, polygons.stop]]
            corners = environment.vertices[environment.triangles[first:last].ravel()]
            found[k] = corners.min(axis=0), corners.max(axis=0)
        return found

    def extent(self, parts: Iterable[int]) -> float:
        """Largest side [m] of the box about parts."""
        boxes = self.boxes[list(parts)]
        return float((boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)).max())

    def touch(self, one: int, other: int) -> bool:
        """Whether two parts cross, come as near as `TOUCHING`, or one is in the other, a solid."""
        pair = min(one, other), max(one, other)
        if pair not in self._known:
            self._known[pair] = self._touch(*pair)
        return self._known[pair]

    def _touch(self, one: int, other: int) -> bool:
        low = np.maximum(self.boxes[one, 0], self.boxes[other, 0])
        high = np.minimum(self.boxes[one, 1], self.boxes[other, 1])
        if np.any(low > high + TOUCHING):
            return False
        if come_near(self._triangles(one), self._triangles(other), TOUCHING):
            return True
        return self._holds(one, other) or self._holds(other, one)

    def _holds(self, one: int, other: int) -> bool:
        """Whether a solid has another part, which does not touch its surface, in it."""
        if not self.environment.solid[one]:
            return False
        corners = self._triangles(one)
        point = self._triangles(other)[0, 0]
        return bool(abs(point_winding(*point, corners, 0, len(corners))) > 0.5)

    def _triangles(self, part: int) -> Floats:
        if part not in self._corners:
            self._corners[part] = self.environment.triangle_corners(part)
        return self._corners[part]


def own_pieces(
    environment: Environment, handles: Sequence[Handle], others: Iterable[str]
) -> OwnPieces:
    """Find the pieces of handles that no file states.

    Parameters
    ----------
    environment
        With its parts, seats and adjustments.
    handles
        All that controls stand on. A part of one is never a piece of another.
    others
        Parts that are no pieces: what people sit on.

    Returns
    -------
    OwnPieces
        The pieces of each handle, the nearest first.
    """
    if all(handle.stated for handle in handles):
        return OwnPieces(tuple(() for _ in handles), ())
    search = _Search(
        touching=Touching(environment),
        barred=frozenset(others) | {environment.parts[k] for h in handles for k in h.parts},
        movers=_movers(environment),
    )
    things = [search.thing(handle) for handle in handles]
    claimed: dict[str, str] = {}
    found = []
    for thing in things:
        rivals = [one for one in things if not set(one.handle.parts) & set(thing.handle.parts)]
        found.append(() if thing.handle.stated else _pieces(search, thing, rivals, claimed))
    given = {piece.part for pieces in found for piece in pieces}
    return OwnPieces(
        tuple(found), tuple(words for part, words in claimed.items() if part not in given)
    )


def _movers(environment: Environment) -> tuple[str, ...]:
    """What moves each part, in words: "" for nothing."""
    found: dict[str, list[str]] = {}
    for seat in environment.seats:
        for part in seat.moves:
            found.setdefault(part, []).append(f"seat {seat.name}")
    for one in environment.adjustments:
        if not one.tilts:
            for part in one.parts:
                found.setdefault(part, []).append(f"adjustment {one.name}")
    return tuple(" and ".join(found.get(name, ())) for name in environment.parts)


@dataclass(frozen=True, eq=False)
class _Thing:
    """A handle, and what stands about it.

    Parameters
    ----------
    handle
        The handle.
    steps
        How many pieces each small part is away from it, over parts that touch one another.
    why
        What makes some of these parts belong to it, in words.
    largest
        How large [m] all of it may be.
    """

    handle: Handle
    steps: Mapping[int, int]
    why: Mapping[int, str]
    largest: float


@dataclass(frozen=True, eq=False)
class _Search:
    """What the search of pieces knows of an environment.

    Parameters
    ----------
    touching
        Which parts touch.
    barred
        Parts that are nobody's pieces.
    movers
        What moves each part.
    """

    touching: Touching
    barred: frozenset[str]
    movers: tuple[str, ...]

    @property
    def environment(self) -> Environment:
        return self.touching.environment

    def thing(self, handle: Handle) -> _Thing:
        """A handle with what stands about it; nothing does about a panel."""
        own = self.touching.extent(handle.parts)
        largest = max(_SMALL, own)
        steps = self._steps(handle, largest) if own <= GRIPPABLE else {}
        why = {k: words for k in steps if (words := self._why(handle, k))}
        return _Thing(handle, steps, why, largest)

    def _steps(self, handle: Handle, largest: float) -> dict[int, int]:
        near = self._near(handle, largest)
        steps = dict.fromkeys(handle.parts, 0)
        ring = list(handle.parts)
        while ring:
            outside = [k for k in near if k not in steps]
            next_ring = [k for k in outside if any(self.touching.touch(k, one) for one in ring)]
            steps |= dict.fromkeys(next_ring, steps[ring[0]] + 1)
            ring = next_ring
        return {k: step for k, step in steps.items() if step}

    def _near(self, handle: Handle, largest: float) -> list[int]:
        """The parts that may be pieces: with the handle they are no larger than that, and they
        move as it does."""
        boxes = self.touching.boxes
        own = list(handle.parts)
        low = np.minimum(boxes[:, 0], boxes[own, 0].min(axis=0))
        high = np.maximum(boxes[:, 1], boxes[own, 1].max(axis=0))
        small = (high - low).max(axis=1) <= largest
        shown = np.flatnonzero(small & ~self.environment.hidden).tolist()
        mover = self.movers[own[0]]
        names = self.environment.parts
        return [k for k in shown if names[k] not in self.barred and self.movers[k] == mover]

    def _why(self, handle: Handle, part: int) -> str:
        """What makes a part belong to a handle, in words; "" for nothing."""
        mover = self.movers[part]
        for one in self.environment.adjustments:
            moved = [self.environment.part(name) for name in one.parts]
            if mover == f"adjustment {one.name}" and self.touching.extent(moved) <= _SMALL:
                return f"{mover} moves both and nothing else"
        names = [self.environment.parts[k] for k in handle.parts]
        if word := likeness(self.environment.parts[part], [*names, *handle.controls]):
            return f"it is named like it ({word})"
        boxes = self.touching.boxes
        inside = any(
            np.all(boxes[part, 0] >= boxes[k, 0] - TOUCHING)
            and np.all(boxes[part, 1] <= boxes[k, 1] + TOUCHING)
            for k in handle.parts
        )
        return "it lies within it" if inside else ""

    def claimants(self, thing: _Thing, rivals: Iterable[_Thing], part: int) -> list[_Thing]:
        """The other things that a part could belong to as well: those that have a reason of their
        own and are as near, and those that may stand on it as this one does.

        What carries several handles is larger than each of them.
        """
        mine = thing.steps[part]
        size = self.touching.extent([part])
        return [
            one
            for one in rivals
            if one.steps.get(part, mine + 1) <= mine
            and (part in one.why or mine > 1 or self.touching.extent(one.handle.parts) < size)
        ]


def _pieces(
    search: _Search, thing: _Thing, rivals: Sequence[_Thing], claimed: dict[str, str]
) -> tuple[OwnPiece, ...]:
    """The pieces of a thing, ring about ring; claimed: what is nobody's is told there."""
    names = search.environment.parts
    rings: list[dict[int, str]] = [dict.fromkeys(thing.handle.parts, "")]
    taken = set(thing.handle.parts)
    while rings[-1]:
        ring: dict[int, str] = {}
        for k in (k for k in thing.why if k not in taken):
            beside = min((names[p] for p in rings[-1] if search.touching.touch(k, p)), default="")
            others = search.claimants(thing, rivals, k) if beside else []
            if others:
                claimed[names[k]] = _claimed_words(names[k], beside, [thing, *others])
            elif beside:
                ring[k] = f"it touches {beside}, and {thing.why[k]}"
        rings.append(ring)
        taken |= set(ring)
    while len(rings) > 1 and search.touching.extent(k for r in rings for k in r) > thing.largest:
        rings.pop()
    return tuple(
        OwnPiece(names[k], ring[k])
        for ring in rings[1:]
        for k in sorted(ring, key=lambda k: names[k])
    )


def _claimed_words(part: str, beside: str, things: Iterable[_Thing]) -> str:
    controls = sorted({name for thing in things for name in thing.handle.controls})
    listed = f"{', '.join(controls[:-1])} and {controls[-1]}"
    return (
        f"part {part!r} touches {beside!r}, and could be a piece of {listed}: it counts as a piece "
        f"of none (a control's `part` may list what is its own)"
    )
