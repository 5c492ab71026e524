"""The parts that are a control's own beside the one that it stands on.

Meshes have a lever as knob, stalk, base and screws. What touches the part of a control, or another
piece of it, and belongs to the same small thing is the control's own. A piece belongs to it that
moves with it, is named like it or like the control, or lies within its part. What two controls
could claim is neither's: a base that their levers stand on. None of it depends on the unit, the
sides or the order of parts.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import takewhile

import numpy as np

from workbench.geometry.polygon import winding_number
from workbench.geometry.surfaces import come_near
from workbench.model.arrays import Floats
from workbench.model.environment import Environment, OwnPiece

__all__ = [
    "GRIPPABLE",
    "TOUCHING",
    "Handle",
    "NearbyParts",
    "OwnPieces",
    "PartMeshes",
    "Touching",
    "grippable",
    "likeness",
    "name_words",
    "own_pieces",
    "part_meshes",
]

GRIPPABLE = 0.6
"""A part that is larger [m] than this and no rod is no handle, knob, wheel or pedal: a control on it
is on a panel, which a hand may not enter wherever it likes."""
TOUCHING = 0.002
"""What is fixed to one another is drawn this far [m] apart at most: a fit, a coat of paint."""
_SMALL = 0.3
"""What a hand moves as one thing is no larger [m] in all, unless its own part is by itself."""


_TWO_ALONE = "both touch nothing else that is small"
_SLENDER = 0.1
"""What is taken for a stalk, an arm or a rail by its shape alone is no wider [m]: a hand closes about
it."""


def grippable(corners: Floats) -> bool:
    """Return whether a hand or a foot may enter a part where it uses a control on it: whether it is
    no panel, but as small as a handle, a wheel or a pedal, or as slender as a rail.

    Parameters
    ----------
    corners
        (T, 3, 3) [m] its triangles.
    """
    size = np.ptp(corners.reshape(-1, 3), axis=0).max()
    return bool(size <= GRIPPABLE) or _slender(corners)


def _slender(corners: Floats) -> bool:
    """Whether a hand could close about a part (T, 3, 3) [m]: along its second axis of inertia, as a
    surface, it is no larger than `_SLENDER`."""
    sides = corners[:, 1:] - corners[:, :1]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    away = corners - corners.mean(axis=1).T @ area / max(area.sum(), 1e-30)
    # of a triangle the integral of x x' is its area / 12 times the sum over its corners and over the
    # sum of its corners
    points = np.concatenate([away, away.sum(axis=1, keepdims=True)], axis=1)
    axes = np.linalg.eigh(np.einsum("t,tki,tkj->ij", area, points, points))[1]
    return bool(np.ptp(corners.reshape(-1, 3) @ axes[:, 1]) <= _SLENDER)


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
class PartMeshes:
    """The K parts of a place as triangles.

    Parameters
    ----------
    names
        Of the parts.
    boxes
        (K, 2, 3) [m] the least and the greatest corner of each part.
    triangles
        Gives the corners (T, 3, 3) [m] of the part of a number.
    """

    names: tuple[str, ...]
    boxes: Floats
    triangles: Callable[[int], Floats]


def part_meshes(environment: Environment) -> PartMeshes:
    """Return the parts of an environment as triangles."""
    boxes = np.empty((len(environment.parts), 2, 3))
    for k in range(len(boxes)):
        polygons = environment.polygons(k)
        first, last = environment.triangle_start[[polygons.start, polygons.stop]]
        corners = environment.vertices[environment.triangles[first:last].ravel()]
        boxes[k] = corners.min(axis=0), corners.max(axis=0)
    return PartMeshes(environment.parts, boxes, environment.triangle_corners)


@dataclass(frozen=True, eq=False)
class Touching:
    """Which parts touch one another, found as it is asked and kept."""

    meshes: PartMeshes
    _known: dict[tuple[int, int], bool] = field(default_factory=dict)
    _corners: dict[int, Floats] = field(default_factory=dict)

    def extent(self, parts: Iterable[int]) -> float:
        """Largest side [m] of the box about parts."""
        boxes = self.meshes.boxes[list(parts)]
        return float((boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)).max())

    def touch(self, one: int, other: int) -> bool:
        """Whether two parts cross, come as near as `TOUCHING`, or one is inside the other."""
        pair = min(one, other), max(one, other)
        if pair not in self._known:
            self._known[pair] = self._touch(*pair)
        return self._known[pair]

    def touched(self, parts: Sequence[int], among: Sequence[int]) -> list[int]:
        """Those of some parts that touch any of others."""
        found = []
        boxes = self.meshes.boxes
        rows = boxes[list(among)]
        for part in parts:
            near = np.all(
                (rows[:, 0] <= boxes[part, 1] + TOUCHING)
                & (rows[:, 1] >= boxes[part, 0] - TOUCHING),
                axis=1,
            )
            if any(self.touch(part, among[k]) for k in np.flatnonzero(near).tolist()):
                found.append(part)
        return found

    def _touch(self, one: int, other: int) -> bool:
        boxes = self.meshes.boxes
        low = np.maximum(boxes[one, 0], boxes[other, 0])
        high = np.minimum(boxes[one, 1], boxes[other, 1])
        if np.any(low > high + TOUCHING):
            return False
        if come_near(self.triangles(one), self.triangles(other), TOUCHING):
            return True
        return self._holds(one, other) or self._holds(other, one)

    def _holds(self, one: int, other: int) -> bool:
        """Whether a part has another, which does not touch it, inside it."""
        corners = self.triangles(one)
        point = self.triangles(other)[0, 0]
        return bool(abs(winding_number(*point, corners, 0, len(corners))) > 0.5)

    def triangles(self, part: int) -> Floats:
        """(T, 3, 3) [m] the corners of a part's triangles."""
        if part not in self._corners:
            self._corners[part] = np.ascontiguousarray(self.meshes.triangles(part))
        return self._corners[part]


@dataclass(frozen=True)
class NearbyParts:
    """What of the parts of a place bears on pieces.

    Parameters
    ----------
    hidden
        Parts that are neither drawn nor checked.
    barred
        Other parts that are no pieces: what people sit on.
    movers
        What moves parts, in words, with the parts.
    """

    hidden: frozenset[str]
    barred: frozenset[str]
    movers: Mapping[str, tuple[str, ...]]

    def mover(self, part: str) -> str:
        """What moves a part, in words: "" for nothing."""
        return " and ".join(words for words, parts in self.movers.items() if part in parts)


def own_pieces(touching: Touching, handles: Sequence[Handle], around: NearbyParts) -> OwnPieces:
    """Find the pieces of handles that no file states.

    Parameters
    ----------
    touching
        The parts.
    handles
        All that controls stand on. A part of one is never a piece of another.
    around
        What else is known of the parts.

    Returns
    -------
    OwnPieces
        The pieces of each handle, the nearest first.
    """
    if all(handle.stated for handle in handles):
        return OwnPieces(tuple(() for _ in handles), ())
    names = touching.meshes.names
    handled = {names[k] for handle in handles for k in handle.parts}
    search = _Search(touching, replace(around, barred=around.barred | handled))
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
    """What the search of pieces knows of a place."""

    touching: Touching
    around: NearbyParts

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parts."""
        return self.touching.meshes.names

    def thing(self, handle: Handle) -> _Thing:
        """A handle with what stands about it; nothing does about a panel."""
        own = self.touching.extent(handle.parts)
        largest = max(_SMALL, own)
        small = self._small(handle, largest) if own <= GRIPPABLE else []
        steps = self._steps(handle, small)
        said = self._said(handle)
        why = {k: words for k in steps if (words := self._why(handle, k, said))}
        if len(steps) == 1 and not why:
            why = {k: _TWO_ALONE for k in steps if self._alone(handle, k, small)}
        return _Thing(handle, steps, why, largest)

    def _small(self, handle: Handle, largest: float) -> list[int]:
        """The parts beside a handle that are no larger with it than that."""
        boxes = self.touching.meshes.boxes
        own = list(handle.parts)
        low = np.minimum(boxes[:, 0], boxes[own, 0].min(axis=0))
        high = np.maximum(boxes[:, 1], boxes[own, 1].max(axis=0))
        small = np.flatnonzero((high - low).max(axis=1) <= largest).tolist()
        return [k for k in small if k not in own and self.names[k] not in self.around.hidden]

    def _steps(self, handle: Handle, small: Iterable[int]) -> dict[int, int]:
        """How many pieces each small part is away, of those that may be pieces and move as the
        handle does."""
        mover = self.around.mover(self.names[handle.parts[0]])
        free = [k for k in small if self.names[k] not in self.around.barred]
        near = [k for k in free if self.around.mover(self.names[k]) == mover]
        steps: dict[int, int] = {}
        ring = list(handle.parts)
        step = 0
        while ring:
            step += 1
            ring = self.touching.touched([k for k in near if k not in steps], ring)
            steps |= dict.fromkeys(ring, step)
        return steps

    def _alone(self, handle: Handle, part: int, small: Iterable[int]) -> bool:
        """Whether a handle and a slender part touch one another and nothing else that is small."""
        both = [*handle.parts, part]
        others = self.touching.touched([k for k in small if k != part], both)
        return not others and _slender(self.touching.triangles(part))

    def _numbered(self, name: str, part: int) -> bool:
        """Whether two names differ in their numbers alone, and all that do are no small thing: the
        pieces of a mesh that was split."""
        words = name_words(name)
        if name_words(self.names[part]) != words:
            return False
        family = [k for k, other in enumerate(self.names) if name_words(other) == words]
        return self.touching.extent(family) > GRIPPABLE

    def _said(self, handle: Handle) -> set[str]:
        """The words in the names of what is too large for a handle and stands about it."""
        boxes = self.touching.meshes.boxes
        own = boxes[list(handle.parts)]
        low = own[:, 0].min(axis=0) - TOUCHING
        high = own[:, 1].max(axis=0) + TOUCHING
        near = np.all((boxes[:, 0] <= high) & (boxes[:, 1] >= low), axis=1)
        large = near & ((boxes[:, 1] - boxes[:, 0]).max(axis=1) > GRIPPABLE)
        return {word for k in np.flatnonzero(large).tolist() for word in name_words(self.names[k])}

    def _why(self, handle: Handle, part: int, said: Container[str]) -> str:
        """What makes a part belong to a handle, in words; "" for nothing.

        said: words that tell nothing here.
        """
        name = self.names[part]
        mover = self.around.mover(name)
        if mover in self.around.movers:
            moved = [self.names.index(one) for one in self.around.movers[mover]]
            if self.touching.extent(moved) <= _SMALL:
                return f"{mover} moves both and nothing else"
        others = [self.names[k] for k in handle.parts if not self._numbered(name, k)]
        if words := likeness(name, [*others, *handle.controls], said):
            return f"it is named like it ({words})"
        boxes = self.touching.meshes.boxes
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
    names = search.names
    rings = [dict.fromkeys(thing.handle.parts, "")]
    taken = set(thing.handle.parts)
    while rings[-1]:
        ring: dict[int, str] = {}
        for k in (k for k in thing.why if k not in taken):
            beside = min((names[p] for p in rings[-1] if search.touching.touch(k, p)), default="")
            others = search.claimants(thing, rivals, k) if beside else []
            if others:
                claimed[names[k]] = _claimed_words(names[k], beside, [thing, *others])
            elif beside:
                ring[k] = beside
        rings.append(ring)
        taken |= set(ring)
    while len(rings) > 1 and search.touching.extent(k for r in rings for k in r) > thing.largest:
        rings.pop()
    return tuple(
        OwnPiece(names[k], ring[k], thing.why[k])
        for ring in rings[1:]
        for k in sorted(ring, key=lambda k: names[k])
    )


def _claimed_words(part: str, beside: str, things: Iterable[_Thing]) -> str:
    controls = sorted({name for thing in things for name in thing.handle.controls})
    listed = f"{', '.join(controls[:-1])} and {controls[-1]}"
    return (
        f"part {part!r} touches {beside!r}, and could be a piece of {listed}: it counts as a piece "
        f"of none (a control's 'part' may list what is its own)"
    )


# Whether two parts are named as pieces of one thing.
#
# A name is divided into words at signs, digits and capitals. Two parts are alike where they share a
# word that tells their thing from others: `PropCap` and `PropLever`, `throttle_knob` and
# `ThrotLever`. Words for kinds and places of parts, and those that programs add, tell nothing:
# `prop_lever` and `mix_lever` are two levers. So do words that the structure around has in its name
# too. But `gear_lever_knob` and `gear_lever_stalk` are pieces of a lever: they begin alike, and go on
# with pieces that many things have.

_SHORTEST = 3
"""Letters of a word that tells one thing from others; `l`, `r`, `up` and `on` do not."""
_ABBREVIATED = 4
"""Letters of a word that another may begin with, and mean the same: `flap` and `flaps`."""


@lru_cache(maxsize=4096)
def name_words(name: str) -> tuple[str, ...]:
    """Return the words of a name in small letters, without its numbers."""
    spaced = []
    for k, letter in enumerate(name):
        before = name[k - 1 : k]
        behind = name[k + 1 : k + 2]
        new_word = letter.isupper() and (
            before.islower() or (before.isupper() and behind.islower())
        )
        spaced.append(f" {letter}" if new_word else letter if letter.isalpha() else " ")
    return tuple("".join(spaced).lower().split())


_PIECES = frozenset(
    name_words("""
    arm axis axle bar base bearing body bolt boot bottom bracket bush cap case casing clamp clip
    collar core cover detent disc disk edge foot frame gaiter gate grip guard guide handle head
    holder housing hub insert joint knob label link mark mount mounting neck needle nut pad pin
    pivot plate pointer rim ring rod root screw shaft shank side skirt sleeve slot socket spacer
    spindle spoke spring stalk stem strip stub surround tip top washer
    """)
)
"""Pieces that many things have."""
_KINDS = frozenset(
    name_words("""
    button control crank dial gauge indicator instrument key lamp led lever light meter pedal pull
    push selector slider switch toggle wheel
    bouton levier manette poignee pedale hebel knopf griff schalter taste palanca boton perilla
    """)
)
"""Kinds of controls and of what stands beside them."""
_PLACES = frozenset(
    name_words("""
    left right front rear fore aft near far centre center middle main upper lower inner outer inside
    outside inboard outboard driver passenger pilot copilot first second one two
    board bulkhead cab cabin chassis cockpit column console dash dashboard desk door facia fascia
    floor fuselage hull interior overhead panel pedestal pillar quadrant roof seat shell structure
    table wall
    assembly box circle component cone copy cube cylinder default geom geometry group instance line
    material mesh model new node obj object part piece plane polygon shape solid sphere surface
    torus
    """)
)
"""Places, structures, and words that programs add."""
_SAY_NOTHING = _PIECES | _KINDS | _PLACES


def likeness(part: str, others: Iterable[str], said: Container[str] = ()) -> str:
    """Return what the name of a part has in common with others of one thing.

    Parameters
    ----------
    part
        A name.
    others
        The names of the thing: of its part, of the controls on it.
    said
        Words that the names of the structure around it have too.

    Returns
    -------
    str
        The words, "" where nothing makes it a piece of that thing.
    """
    words = name_words(part)
    telling = tuple(word for word in words if word not in said)
    for other in others:
        them = name_words(other)
        common = _common_word(telling, them) or _begun_alike(words, them)
        if common:
            return common
    return ""


def _common_word(one: tuple[str, ...], other: tuple[str, ...]) -> str:
    """The first word that tells a thing and is in both names, or begins one in the other."""
    for word in one:
        for like in other:
            short, long = sorted((word, like), key=len)
            if len(short) < _SHORTEST or {word, like} & _SAY_NOTHING:
                continue
            if word == like or (len(short) >= _ABBREVIATED and long.startswith(short)):
                return short
    return ""


def _begun_alike(one: tuple[str, ...], other: tuple[str, ...]) -> str:
    """The words with which two names begin that differ in words for pieces alone."""
    mine = [word for word in one if word not in _PLACES and len(word) > 1]
    theirs = [word for word in other if word not in _PLACES and len(word) > 1]
    alike = takewhile(lambda pair: pair[0] == pair[1], zip(mine, theirs, strict=False))
    same = len(list(alike))
    rest = [*mine[same:], *theirs[same:]]
    return " ".join(mine[:same]) if rest and _PIECES.issuperset(rest) else ""
