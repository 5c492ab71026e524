"""Contacts: one row for each touching or near pair, named on both sides. Clearance: the nearest
pairs. Episodes: the spells in which something touched during a motion."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from workbench.errors import UsageError
from workbench.model.arguments import check_index, chosen_rows, given_words
from workbench.model.arrays import Bools, Floats, Ints, read_only
from workbench.model.body import DIRECTIONS, Body
from workbench.model.environment import Environment

__all__ = ["TANGENT_TOLERANCE", "Clearance", "Contacts", "Episodes", "subpart_words"]

TANGENT_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Contacts:
    """C contacts of a body with an environment or with a body (perhaps itself).

    pose, sphere (C,): the body's; part, polygon (C,): the environment's, -1 against a body;
    other_sphere (C,): -1 against an environment; distance (C,) [m]: signed, negative overlapping;
    point (C, 3) [m]: on the other's surface; normal (C, 3): unit, the way the body would be pushed
    out; facing, other_facing (C,): index into DIRECTIONS of the side that is touched (-1: none);
    allowed (C,) [m]: overlap that is no fault here.
    """

    body: Body
    other: Body | Environment
    pose: Ints
    sphere: Ints
    part: Ints
    polygon: Ints
    other_sphere: Ints
    distance: Floats
    point: Floats
    normal: Floats
    facing: Ints
    other_facing: Ints
    allowed: Floats

    def __repr__(self) -> str:
        return f"Contacts({len(self)} of {self.body!r} with {self.other!r})"

    def __post_init__(self) -> None:
        count = len(self.distance)
        for name in ("pose", "sphere", "part", "polygon", "other_sphere", "facing", "other_facing"):
            object.__setattr__(
                self, name, read_only(getattr(self, name), np.int64, (count,), f"contacts.{name}")
            )
        for name in ("distance", "allowed"):
            object.__setattr__(
                self, name, read_only(getattr(self, name), np.float64, (count,), f"contacts.{name}")
            )
        for name in ("point", "normal"):
            shape = (count, 3)
            object.__setattr__(
                self, name, read_only(getattr(self, name), np.float64, shape, f"contacts.{name}")
            )

    def __len__(self) -> int:
        return len(self.distance)

    @property
    def segment(self) -> Ints:
        """(C,) the body's segment."""
        return self.body.sphere_segment[self.sphere]

    @property
    def other_segment(self) -> Ints:
        """(C,) the other body's segment, -1 against an environment."""
        if isinstance(self.other, Environment):
            return np.full(len(self), -1)
        return self.other.sphere_segment[self.other_sphere]

    @property
    def excess(self) -> Floats:
        """(C,) overlap beyond what is allowed [m]; positive is a fault."""
        return -self.distance - self.allowed

    def rows(self, keep: Bools | Ints) -> Contacts:
        """The contacts at a mask or at indices."""
        names = (
            "pose",
            "sphere",
            "part",
            "polygon",
            "other_sphere",
            "distance",
            "point",
            "normal",
            "facing",
            "other_facing",
            "allowed",
        )
        rows = chosen_rows("keep", keep, len(self))
        return Contacts(
            self.body, self.other, **{name: getattr(self, name)[rows] for name in names}
        )

    def deepest(self) -> Contacts:
        """One contact for each pose, segment and part (or other segment): the one with the greatest
        excess."""
        other = self.part if isinstance(self.other, Environment) else self.other_segment
        order = np.lexsort(
            (
                self.other_sphere,
                self.polygon,
                self.sphere,
                -self.excess,
                other,
                self.segment,
                self.pose,
            )
        )
        key = np.stack([self.pose, self.segment, other], axis=1)[order]
        first = np.ones(len(self), dtype=np.bool_)
        first[1:] = np.any(key[1:] != key[:-1], axis=1)
        return self.rows(order[first])

    def name(self, row: int) -> str:
        """The body's side in words: "right hand, thumb tip (front)"."""
        row = check_index("row", row, len(self))
        return _side(self.body, int(self.sphere[row]), int(self.facing[row]))

    def other_name(self, row: int) -> str:
        """The other side in words: "instrument_panel, polygon 117", or as `name` for a body."""
        row = check_index("row", row, len(self))
        if isinstance(self.other, Environment):
            part = int(self.part[row])
            return f"{self.other.parts[part]}, polygon {int(self.polygon[row] - self.other.part_start[part])}"
        return _side(self.other, int(self.other_sphere[row]), int(self.other_facing[row]))


def subpart_words(body: Body, sphere: int) -> str:
    """What a sphere is called within its segment: "thumb tip", "" where it has no name.

    Of what is worn, whose spheres are called "heel (boots)" and "heel (boots 3)": "heel in boots".
    """
    name = body.sphere_names[sphere]
    worn = _WORN.fullmatch(name)
    return f"{worn[1]} in {worn[2]}".strip() if worn else name


_WORN = re.compile(r"(.*?) ?\((.+?)(?: \d+)?\)")
"""The name of a sphere of what is worn: that of the sphere below, the thing, a number."""


def _side(body: Body, sphere: int, facing: int) -> str:
    words = body.segment_names[int(body.sphere_segment[sphere])]
    if body.sphere_names[sphere]:
        words += f", {subpart_words(body, sphere)}"
    return f"{words} ({DIRECTIONS[facing]})" if facing >= 0 else words


@dataclass(frozen=True, eq=False, repr=False)
class Clearance:
    """The nearest pair of every pose, segment and other (K parts of an environment, or segments of
    a body).

    distance (P, N, K) [m]: signed; infinite where there is nothing to measure, NaN outside the
    logical window. sphere (P, N, K): the body's sphere, -1 where none; target (P, N, K): polygon,
    or the other body's sphere; point (P, N, K, 3) [m]: nearest point of the other's surface; facing
    (P, N, K): the side of the body's sphere that is nearest, index into DIRECTIONS.
    """

    body: Body
    other: Body | Environment
    distance: Floats
    sphere: Ints
    target: Ints
    point: Floats
    facing: Ints

    def __repr__(self) -> str:
        poses, segments, others = self.distance.shape
        least = np.nanmin(self.distance, initial=np.inf)
        return (
            f"Clearance({self.body!r} from {self.other!r}: {poses} poses, {segments} segments, "
            f"{others} others, least {1e3 * least:.1f} mm)"
        )

    def _checked(self, where: tuple[int, int, int]) -> tuple[int, int, int]:
        """The indices of a pose, a segment and another; UsageError for what is none."""
        if not isinstance(where, (tuple, list)) or len(where) != 3:
            raise UsageError(
                f"where: expected the indices (pose, segment, other), got {given_words(where)}"
            )
        names = ("where: pose", "where: segment", "where: other")
        shape = self.distance.shape
        p, n, k = (check_index(*each) for each in zip(names, where, shape, strict=True))
        return p, n, k

    def met(self, where: tuple[int, int, int]) -> tuple[int, int]:
        """What is nearest to the body's sphere at (pose, segment, other), -1 where it is not of that
        kind: the polygon of the part, by its number in the part, and the other limb's sphere."""
        where = self._checked(where)
        target = int(self.target[where])
        if isinstance(self.other, Environment):
            return target - int(self.other.part_start[where[2]]), -1
        return -1, target

    def name(self, where: tuple[int, int, int]) -> str:
        """The body's side in words at (pose, segment, other)."""
        where = self._checked(where)
        return _side(self.body, int(self.sphere[where]), int(self.facing[where]))

    def other_name(self, where: tuple[int, int, int]) -> str:
        """The other side in words: part and polygon, or segment and sphere."""
        where = self._checked(where)
        polygon, sphere = self.met(where)
        if isinstance(self.other, Environment):
            return f"{self.other.parts[where[2]]}, polygon {polygon}"
        return _side(self.other, sphere, -1)


@dataclass(frozen=True, eq=False, repr=False)
class Episodes:
    """E episodes of contact of a moving body with an environment or with a body (perhaps itself),
    sorted by sphere or segment, by part or the other's sphere or segment, and by time.

    enter, deepest, leave (E,) [s]: when it began, was deepest and ended; distance (E,) [m]: the
    signed distance when deepest, negative overlapping; allowed (E,) [m]: overlap that is no fault
    here. segment (E,); sphere (E,): the one that was deepest; part (E,): the environment's, -1
    against a body; other_segment, other_sphere (E,): -1 against an environment. frame (E,): the
    motion's last frame at or before the deepest. span: first and last time [s].
    """

    body: Body
    other: Body | Environment
    span: tuple[float, float]
    enter: Floats
    deepest: Floats
    leave: Floats
    distance: Floats
    allowed: Floats
    segment: Ints
    sphere: Ints
    part: Ints
    other_segment: Ints
    other_sphere: Ints
    frame: Ints

    def __repr__(self) -> str:
        return f"Episodes({len(self)} of {self.body!r} with {self.other!r})"

    def __post_init__(self) -> None:
        count = len(self.enter)
        for name in ("enter", "deepest", "leave", "distance", "allowed"):
            object.__setattr__(
                self, name, read_only(getattr(self, name), float, (count,), f"episodes.{name}")
            )
        for name in ("segment", "sphere", "part", "other_segment", "other_sphere", "frame"):
            object.__setattr__(
                self, name, read_only(getattr(self, name), int, (count,), f"episodes.{name}")
            )

    def __len__(self) -> int:
        return len(self.enter)

    @property
    def cut_short(self) -> tuple[Bools, Bools]:
        """Two masks (E,): in contact already when the motion began, and still when it ended."""
        return self.enter <= self.span[0], self.leave >= self.span[1]

    def rows(self, keep: Bools | Ints) -> Episodes:
        """The episodes at a mask or at indices."""
        names = (
            "enter",
            "deepest",
            "leave",
            "distance",
            "allowed",
            "segment",
            "sphere",
            "part",
            "other_segment",
            "other_sphere",
            "frame",
        )
        rows = chosen_rows("keep", keep, len(self))
        return Episodes(
            self.body, self.other, self.span, **{name: getattr(self, name)[rows] for name in names}
        )
