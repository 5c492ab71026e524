"""What may hide something from eyes: parts of an environment, the own body, other people."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Bools, Floats, Ints, freeze_fields, read_only
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.sight.eyes import Eyes, eyes_of, head_of
from workbench.sight.kernels.segments import Blockers, enclosing

__all__ = ["Scenery", "check_eye", "check_eyes", "enclosing_items", "items_around", "scenery_of"]

_WORN = re.compile(r"^.*\(([^()]*?)(?: \d+)?\)$")
"""The name of a sphere that is worn ends with the thing, perhaps with a number: "heel (boots 2)"."""


@dataclass(frozen=True, eq=False)
class Scenery:
    """What may stand before B pairs of eyes: N items made of T triangles and S spheres.

    Items are all parts of the environment, in its order, then segments of the own body and things on
    its head, then segments of other people. Hidden parts have no triangles.

    Parameters
    ----------
    names
        Of the N items.
    triangles
        (T, 3, 3) [m] corners, grouped by item.
    item
        (T,) the item of each triangle.
    see_through, solid
        (N,) items that one looks through, and closed parts that no eye can be in.
    centre, radius
        (B, S, 3) and (B, S) [m] of spheres; NaN where a sphere is not there. B = 1 where all eyes
        have the same scenery.
    sphere_item
        (S,) the item of each sphere.
    moving
        (N,) items that are displaced.
    displacement
        (B, 3) [m] of these.
    ball, item_ball
        (T, 4) and (N, 7) centre and radius [m] of a sphere about each triangle, and about all of an
        item, of which half the size of its box follows; made from the triangles.
    on_head
        (S,) spheres worn on the head of who looks; empty where there are none.
    """

    names: tuple[str, ...]
    triangles: Floats
    item: Ints
    see_through: Bools
    solid: Bools
    centre: Floats
    radius: Floats
    sphere_item: Ints
    moving: Bools
    displacement: Floats
    ball: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    item_ball: Floats = field(default_factory=lambda: np.zeros((0, 7)))
    on_head: Bools = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    def __post_init__(self) -> None:
        n = len(self.names)
        b, s = np.shape(self.radius)
        arrays = {
            "triangles": (np.float64, (None, 3, 3)),
            "item": (np.int64, (len(self.triangles),)),
            "see_through": (np.bool_, (n,)),
            "solid": (np.bool_, (n,)),
            "centre": (np.float64, (b, s, 3)),
            "radius": (np.float64, (b, s)),
            "sphere_item": (np.int64, (s,)),
            "moving": (np.bool_, (n,)),
            "displacement": (np.float64, (b, 3)),
            "ball": (np.float64, (len(self.triangles), 4)),
            "item_ball": (np.float64, (n, 7)),
        }
        if len(self.item_ball) != n:
            for name, balls in zip(
                ("ball", "item_ball"), _balls(self.triangles, self.start), strict=True
            ):
                object.__setattr__(self, name, balls)
        freeze_fields(self, arrays, "scenery")

    def __len__(self) -> int:
        return len(self.radius)

    @property
    def start(self) -> Ints:
        """(N + 1,) where the triangles of each item begin."""
        return np.searchsorted(self.item, np.arange(len(self.names) + 1))

    def blockers(self, blocks: Bools) -> Blockers:
        """Return it as the kernels take it; blocks (N,): the items whose triangles count."""
        return Blockers(
            self.triangles,
            self.start,
            self.ball,
            self.item_ball,
            blocks,
            self.moving,
            self.displacement,
            self.centre,
            self.radius,
            self.sphere_item,
        )

    def of_row(self, row: int) -> Scenery:
        """Return the scenery of one row of eyes; UsageError where there is no such row."""
        one = slice(0, 1) if len(self) == 1 else slice(row, row + 1)
        if not 0 <= one.start < len(self):
            raise UsageError(f"scenery: expected a row of 0 to {len(self) - 1}, got {row}")
        return replace(
            self,
            centre=self.centre[one],
            radius=self.radius[one],
            displacement=self.displacement[one],
        )

    def head_turned(self, eyes: Eyes, looks: Eyes) -> Scenery:
        """Return it with what is worn on the head turned about the neck as the head is, from eyes at
        rest to those of a gaze, B each."""
        if not self.on_head.any():
            return self
        turn = np.einsum("bki,bkj->bij", looks.axes, eyes.axes)
        pivot = eyes.pivot[:, None]
        worn = np.einsum("bij,bsj->bsi", turn, self.centre[:, self.on_head] - pivot)
        centre = self.centre.copy()
        centre[:, self.on_head] = pivot + worn
        return replace(self, centre=centre)


def _balls(triangles: Floats, start: Ints) -> tuple[Floats, Floats]:
    """Spheres (T, 4) [m] about triangles (T, 3, 3), and spheres and half boxes (K, 7) about groups of
    them that begin at start (K + 1,); zeros where a group has none."""
    corners = [np.ascontiguousarray(triangles[:, k]) for k in range(3)]
    low = np.minimum(np.minimum(*corners[:2]), corners[2])
    high = np.maximum(np.maximum(*corners[:2]), corners[2])
    own = (low + high) / 2.0
    each = np.concatenate([own, _farthest(corners, own)], axis=1)
    count = np.diff(start)
    some = np.flatnonzero(count)
    balls = np.zeros((len(count), 7))
    if len(some):
        least = np.minimum.reduceat(low, start[some])
        most = np.maximum.reduceat(high, start[some])
        balls[some, :3] = (least + most) / 2.0
        away = _farthest(corners, np.repeat(balls[:, :3], count, axis=0))
        balls[some, 3:4] = np.maximum.reduceat(away, start[some])
        balls[some, 4:] = (most - least) / 2.0
    return each, balls


def _farthest(corners: Sequence[Floats], middle: Floats) -> Floats:
    """(T, 1) [m] from middles (T, 3) to the farthest of three corners (T, 3)."""
    square = [np.einsum("ti,ti->t", out, out) for out in (one - middle for one in corners)]
    return np.asarray(np.sqrt(np.maximum(np.maximum(*square[:2]), square[2])))[:, None]


def scenery_of(
    environment: Environment | None,
    placed: Placed | None = None,
    others: Mapping[str, Placed] | None = None,
    *,
    moving: tuple[str, ...] = (),
    displacement: Floats | None = None,
    without: Bools | None = None,
) -> Scenery:
    """Collect what may hide something from the eyes of B people.

    The own head never hides: spheres of the segment that has the eyes are left out. What is worn on
    it, as a helmet, hides with all spheres that no eye is in; it is an item of its own, "own helmet".

    Parameters
    ----------
    environment
        Its parts; those that are hidden neither hide nor are seen.
    placed
        (B,) the people who look; their segments are "own left hand" and so on.
    others
        Other people by name, in one pose or in B; their segments are "co-pilot's left hand".
    moving, displacement
        Names of the parts that go along with each person's seat, and by how much, (B, 3) [m].
    without
        (S,) spheres of the own body that hide nothing; none if None.

    Raises
    ------
    InputError
        If the own body has no eyes.
    UsageError
        If numbers of poses differ.
    """
    people = [] if placed is None else [_own(placed, without)]
    people += [_spheres_of(other, f"{name}'s") for name, other in (others or {}).items()]
    if displacement is not None:
        displacement = read_only(displacement, np.float64, (None, 3), "scenery: displacement")
    rows = max([1 if displacement is None else len(displacement), *map(len, people)])
    for one in people:
        if len(one) not in (1, rows):
            raise UsageError(f"scenery: expected 1 or {rows} poses, got {len(one)}")
    names = () if environment is None else tuple(environment.parts)
    count = len(names)
    centre = [np.zeros((rows, 0, 3))]
    radius = [np.zeros((rows, 0))]
    sphere_item = [np.zeros(0, dtype=np.int64)]
    for one in people:
        centre.append(np.broadcast_to(one.centre, (rows, *one.centre.shape[1:])))
        radius.append(np.broadcast_to(one.radius, (rows, *one.radius.shape[1:])))
        sphere_item.append(one.item + len(names))
        names += one.names
    flags = np.zeros((3, len(names)), dtype=np.bool_)
    if environment is not None:
        flags[0, :count] = environment.see_through
        flags[1, :count] = environment.solid & ~environment.hidden
        flags[2, [environment.part_index(name) for name in moving]] = True
    shown = _shown_triangles(environment)
    item_ball = np.zeros((len(names), 7))
    item_ball[:count] = shown.item_ball
    return Scenery(
        names,
        shown.corners,
        shown.item,
        flags[0],
        flags[1],
        np.concatenate(centre, axis=1),
        np.concatenate(radius, axis=1),
        np.concatenate(sphere_item),
        flags[2],
        np.broadcast_to(np.zeros(3) if displacement is None else displacement, (rows, 3)),
        shown.ball,
        item_ball,
        np.concatenate([np.zeros(0, dtype=np.bool_), *(one.on_head for one in people)]),
    )


class _Shown(NamedTuple):
    """Corners (T, 3, 3) [m] of the triangles of the K parts that are not hidden, the part (T,) of
    each, and the spheres (T, 4), (K, 7) [m] about triangles and parts."""

    corners: Floats
    item: Ints
    ball: Floats
    item_ball: Floats


@lru_cache(maxsize=8)
def _shown_triangles(environment: Environment | None) -> _Shown:
    """What an environment shows: once for all who look, since only what moves depends on them."""
    if environment is None:
        none = np.zeros(0, dtype=np.int64)
        return _Shown(np.zeros((0, 3, 3)), none, np.zeros((0, 4)), np.zeros((0, 7)))
    counts = np.diff(environment.triangle_start[environment.part_start])
    part = np.repeat(np.arange(len(counts)), counts)
    shown = ~environment.hidden[part]
    corners = environment.vertices[environment.triangles[shown]]
    item = part[shown]
    start = np.searchsorted(item, np.arange(len(environment.parts) + 1))
    return _Shown(corners, item, *_balls(corners, start))


@dataclass(frozen=True, eq=False)
class _Spheres:
    """Items made of spheres, as in `Scenery`."""

    names: tuple[str, ...]
    centre: Floats
    radius: Floats
    item: Ints
    on_head: Bools

    def __len__(self) -> int:
        return len(self.radius)


def _spheres_of(placed: Placed, whose: str) -> _Spheres:
    """The segments of people, named as theirs."""
    body = placed.body
    names = tuple(f"{whose} {name}" for name in body.segment_names)
    radius = np.where(np.isfinite(placed.centres[:, :, 0]), body.radius[placed.person], np.nan)
    none = np.zeros(len(body.sphere_segment), dtype=np.bool_)
    return _Spheres(names, placed.centres, radius, body.sphere_segment, none)


def _own(placed: Placed, without: Bools | None) -> _Spheres:
    """The segments of who looks, without the head; and what is worn on it. without (S,): see
    `scenery_of`."""
    body = placed.body
    found = _spheres_of(placed, "own")
    on_head = body.sphere_segment == head_of(body)
    worn = np.array([_WORN.search(name) is not None for name in body.sphere_names], dtype=np.bool_)
    names = list(found.names)
    item = found.item.copy()
    for s in np.flatnonzero(on_head & worn).tolist():
        name = "own " + _WORN.sub(r"\1", body.sphere_names[s])
        names += [] if name in names else [name]
        item[s] = names.index(name)
    eyes = eyes_of(placed)
    holds = np.zeros(found.radius.shape, dtype=np.bool_)
    for eye in (eyes.left, eyes.right):
        holds |= np.linalg.norm(found.centre - eye[:, None], axis=2) <= found.radius
    radius = np.where(holds & on_head, np.nan, found.radius)
    kept = ~on_head | worn
    if without is not None:
        kept &= ~without
    return _Spheres(
        tuple(names), found.centre[:, kept], radius[:, kept], item[kept], (on_head & worn)[kept]
    )


def enclosing_items(scenery: Scenery, eye: Floats) -> Ints:
    """Return the item that each eye is in, -1 for none: a solid part, or a sphere.

    Parameters
    ----------
    scenery
        Of B rows, or of one for all.
    eye
        (B, 3) [m].

    Returns
    -------
    Ints
        (B,).

    Raises
    ------
    InputError, UsageError
        As `check_eyes`.
    """
    return items_around(scenery, check_eyes(scenery, eye))


def items_around(scenery: Scenery, eyes: Floats) -> Ints:
    """As `enclosing_items` of eyes (E, 3) of the rows of the scenery, once or, all after each other,
    several times."""
    found = np.full(len(eyes), -1)
    enclosing(eyes, scenery.blockers(scenery.solid), found)
    return found


def check_eyes(scenery: Scenery, eye: Floats) -> Floats:
    """Return eyes (B, 3) [m] as the kernels take them.

    InputError where one is not finite; UsageError where the scenery is neither of B rows nor of one.
    """
    points = np.ascontiguousarray(eye, dtype=np.float64)
    if not np.isfinite(points).all():
        raise InputError("eyes: their place is not finite; is the head outside the logical window?")
    if len(scenery) not in (1, len(points)):
        raise UsageError(
            f"eyes: expected {len(scenery)}, a row of the scenery each, got {len(points)}"
        )
    return points


def check_eye(scenery: Scenery, eye: Floats, *, row: int = 0) -> None:
    """Raise InputError if an eye (3,) [m] is not finite, or inside a solid part or a sphere."""
    found = int(enclosing_items(scenery.of_row(row), np.asarray(eye)[None])[0])
    if found >= 0:
        place = ", ".join(f"{1e3 * value:.0f}" for value in np.asarray(eye).tolist())
        raise InputError(
            f"eyes: the eye at ({place}) mm is inside {scenery.names[found]!r}, so it sees nothing; "
            "move the eye or the part, or hide the part; a shell that is a surface only is told by "
            "'solid: false'"
        )
