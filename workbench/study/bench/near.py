"""What is near to what: of each segment the part that is nearest, of each body itself, of people each
other, with the overlap that is allowed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.contact.collide import allowed_depth
from workbench.contact.kernels.search import Nearest
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.contacts import Clearance, subpart_words
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment

__all__ = [
    "MOST_NEAR",
    "NearPair",
    "Someone",
    "Tolerances",
    "own_pair",
    "part_pairs",
    "people_pair",
]

MOST_NEAR = 14
"""Pairs that are listed."""


@dataclass(frozen=True)
class NearPair:
    """Two things that are near each other, or overlap.

    Parameters
    ----------
    distance
        [m] negative where they overlap.
    allowed
        [m] the overlap that is allowed.
    person, subject
        The role and its side in words.
    other_person, target
        The other side; the role is "" of a part.
    point
        (3,) [m] on the other side.
    segment, other_segment
        The segments of both sides by name; the other is "" of a part.
    """

    distance: float
    allowed: float
    person: str
    subject: str
    other_person: str
    target: str
    point: tuple[float, float, float]
    segment: str
    other_segment: str = ""

    @property
    def room(self) -> float:
        """[m] what is left before the overlap is deeper than allowed: negative is a fault."""
        return self.distance + self.allowed


@dataclass(frozen=True, eq=False)
class Someone:
    """A person whose surroundings are looked at: the role and the body, of one row."""

    role: str
    body: Body


@dataclass(frozen=True)
class Tolerances:
    """What the criteria of a case let overlap beyond what parts and flesh allow: `at_most` of a
    `contact`, and `at_least` below 0 of `between_people`."""

    criteria: Sequence[Criterion] = ()
    case: str = ""

    def of_part(self, someone: Someone, segment: int, part: str) -> float:
        """[m] of a segment of somebody and a part: that of the strictest criterion."""
        mnemonic = someone.body.segments[segment]
        return min(
            (
                one.at_most
                for one in self._asked("contact", someone.role)
                if mnemonic in one.segments and not one.subparts and part in one.parts
            ),
            default=0.0,
        )

    def between(self, one: Someone, other: Someone) -> float:
        """[m] of two people: that of the strictest criterion."""
        asked = [
            *self._asked("between_people", one.role),
            *self._asked("between_people", other.role),
        ]
        return max(0.0, min((-each.at_least for each in asked), default=0.0))

    def _asked(self, check: str, role: str) -> Iterator[Criterion]:
        for one in self.criteria:
            if one.check == check and role in one.people and one.asks(self.case):
                yield one


def part_pairs(
    someone: Someone,
    environment: Environment,
    near: Nearest,
    *,
    row: int = 0,
    tolerances: Tolerances | None = None,
    most: int = MOST_NEAR,
) -> Iterator[NearPair]:
    """The pairs of the segments that have the least room, each with the part that is nearest.

    Parameters
    ----------
    near
        What comes nearest to each segment, pose by pose.
    row
        The pose.
    """
    body = someone.body
    room = near.distance[row]
    depth = allowed_depth(body, environment)
    extra = tolerances or Tolerances()
    for n in np.argsort(room, kind="stable")[:most].tolist():
        if not np.isfinite(room[n]):
            return
        polygon = int(near.polygon[row, n])
        part = int(np.searchsorted(environment.part_start, polygon, side="right")) - 1
        name = environment.parts[part]
        yield NearPair(
            distance=float(room[n] - depth[n, part]),
            allowed=float(depth[n, part]) + extra.of_part(someone, n, name),
            person=someone.role,
            subject=_sphere_words(body, int(near.sphere[row, n])),
            other_person="",
            target=name,
            point=_point(near.point[row, n]),
            segment=body.segment_names[n],
        )


def own_pair(someone: Someone, own: Clearance, *, row: int = 0) -> Iterator[NearPair]:
    """The two segments of one body that have the least room; nothing where there are none."""
    body = someone.body
    room = own.distance[row] + body.allowance[0]
    room = np.where(np.isfinite(room), room, np.inf)
    n, m = (int(k) for k in np.unravel_index(int(room.argmin()), room.shape))
    if np.isfinite(room[n, m]):
        yield NearPair(
            distance=float(own.distance[row, n, m]),
            allowed=float(body.allowance[0, n, m]),
            person=someone.role,
            subject=_sphere_words(body, int(own.sphere[row, n, m])),
            other_person=someone.role,
            target=_sphere_words(body, int(own.target[row, n, m])),
            point=_point(own.point[row, n, m]),
            segment=body.segment_names[n],
            other_segment=body.segment_names[m],
        )


def people_pair(
    one: Someone,
    other: Someone,
    near: Clearance,
    *,
    row: int = 0,
    tolerances: Tolerances | None = None,
) -> NearPair:
    """The nearest segments of two people."""
    distance = np.where(np.isnan(near.distance[row]), np.inf, near.distance[row])
    n, m = (int(k) for k in np.unravel_index(int(distance.argmin()), distance.shape))
    return NearPair(
        distance=float(distance[n, m]),
        allowed=(tolerances or Tolerances()).between(one, other),
        person=one.role,
        subject=near.name((row, n, m)),
        other_person=other.role,
        target=near.other_name((row, n, m)),
        point=_point(near.point[row, n, m]),
        segment=one.body.segment_names[n],
        other_segment=other.body.segment_names[m],
    )


def _sphere_words(body: Body, sphere: int) -> str:
    name = subpart_words(body, sphere)
    at = int(np.searchsorted(body.start, sphere, side="right")) - 1
    segment = body.segment_names[at]
    return f"{segment}, {name}" if name else segment


def _point(values: Floats) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
