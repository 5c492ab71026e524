"""The view: eyes near enough to the height that they are meant for, or high enough to look down
over what is before them.

Straight ahead is an upright plane: the middle plane of the seat, or of the head of who has none. What
crosses it before the eyes is the skyline. Eyes look over an edge at an angle below level if they are
above the line that rises from it to them at that angle,

    eye - edge >= tan(angle) * distance,

so that a view over parts is told as a height to spare, and a view over the nose as the angle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.geometry.clipping import plane_intersections
from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.criterion import Criterion, Reason
from workbench.model.environment import Environment
from workbench.model.result import Finding
from workbench.model.units import UNITS
from workbench.posture.seating.seating import seat_planes
from workbench.sight.eyes import eyes_of as sight_of
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation

__all__ = [
    "THE_EYES",
    "TOO_HIGH",
    "TOO_LOW",
    "eyes_of",
    "findings",
    "margins",
    "nose_findings",
    "nose_margins",
]

TOO_LOW = Reason("words", "eyes too low")
TOO_HIGH = Reason("words", "eyes too high")
THE_EYES = "the eyes"
"""What a finding about a view is about."""
EYES = ("left eye", "right eye")
"""The spheres between whose centres a body looks from."""
_NEAR = 1e-6
"""[m] Within so little of the line asked for a slope is that of the angle."""
_TOUCH = 1e-6
"""[rad] Pieces of a skyline that are no farther apart than this touch."""


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much higher or lower everybody's eyes may be.

    Of heights: the nearer of the least and the greatest height that will do. Of a view over parts:
    how far the eyes are above the line that rises backward from the parts at the angle asked for.
    """
    found = no_margins(len(situation), asked)
    eye = eyes_of(situation)
    for r, one in enumerate(asked):
        found.margin[:, r] = _margin(situation, one.criterion, eye)
        if one.criterion.check == "view_over":
            found.toward[:, r] = _gives_way(situation, one.criterion)
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            found.words[b, r] = _reason(situation, one.criterion, eye[b])
    return found


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """The height of the eyes, against their point or the line over parts."""
    point = situation.eyes
    if criterion.check == "eye_height" and point is None:
        return
    margin = float(_margin(situation, criterion, eyes_of(situation))[0])
    target = str(point) if criterion.check == "eye_height" else ", ".join(criterion.parts)
    if np.isfinite(margin):
        yield Finding(
            case=situation.work.name,
            person=situation.place.role,
            other_person="",
            subject=THE_EYES,
            target=target,
            value=margin,
            limit=0.0,
            about=situation.eyes or "" if criterion.check == "eye_height" else "",
        )


def nose_margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much farther down than asked everybody sees straight ahead, until a part stands there."""
    found = no_margins(len(situation), asked)
    for r, one in enumerate(asked):
        nose = _over_nose(situation, one.criterion)
        found.margin[:, r] = UNITS["rad"].counted(nose.down - one.criterion.down)
        found.toward[:, r] = nose.gives_way
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            found.words[b, r] = Reason("part", situation.environment.parts[nose.part[b]])
    return found


def nose_findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """How far down the person sees straight ahead, and which part stands there."""
    nose = _over_nose(situation, criterion)
    down = float(nose.down[0])
    if np.isfinite(down):
        part = int(nose.part[0])
        x, y, z = nose.edge[0].tolist()
        yield Finding(
            case=situation.work.name,
            person=situation.place.role,
            other_person="",
            subject=THE_EYES,
            target=situation.environment.parts[part] if part >= 0 else "",
            value=down,
            limit=criterion.down,
            point=(x, y, z) if part >= 0 else None,
            unit="rad",
        )


def eyes_of(situation: Situation) -> Floats:
    """Find the middle between everybody's eyes: (B, 3) [m] in the world.

    Raises
    ------
    InputError
        If the body has no spheres of the eyes.
    """
    body = situation.body
    if not all(name in body.sphere_names for name in EYES):
        raise InputError(f"body {body.name} has no spheres {EYES[0]!r} and {EYES[1]!r}")
    if situation.seated is not None:
        return situation.seated.eye
    spheres = [body.sphere_names.index(name) for name in EYES]
    return situation.placed.centres[:, spheres].mean(axis=1)


def _margin(situation: Situation, criterion: Criterion, eyes: Floats) -> Floats:
    """(B,) [m] of height to spare of eyes (B, 3)."""
    environment = situation.environment
    if criterion.check == "view_over":
        return _over(situation, criterion, eyes)
    if situation.eyes is None:
        return np.full(len(eyes), np.nan)
    rise = eyes[:, 2] - environment.points[situation.eyes][2]
    return np.minimum(rise + criterion.below, criterion.above - rise)


def _reason(situation: Situation, criterion: Criterion, eye: Floats) -> Reason:
    """What is wrong with an eye (3,) that misses a view."""
    if criterion.check == "view_over" or situation.eyes is None:
        return TOO_LOW
    highest = situation.environment.points[situation.eyes][2] + criterion.above
    return TOO_HIGH if eye[2] > highest else TOO_LOW


def _over(situation: Situation, criterion: Criterion, eyes: Floats) -> Floats:
    """(B,) [m] how far eyes (B, 3) are above the highest line that starts at an edge before them
    and rises backward: height of the edge + tan(down) * distance."""
    line = _skyline(situation, criterion.parts, eyes)
    above = np.max(line.rise + np.tan(criterion.down) * line.ahead, axis=2)
    highest = np.max(above, axis=1, where=line.before, initial=-np.inf)
    return np.where(np.isfinite(highest), -highest, np.nan)


def _gives_way(situation: Situation, criterion: Criterion) -> Floats:
    """(3,) by how much the margin of a view over parts grows with a metre that they are moved by: it
    is eye z - edge z - tan(down) * (edge - eye) along the way ahead."""
    assert situation.place.seat is not None
    aside = seat_planes(situation.environment.seat(situation.place.seat))[2]
    slope = float(np.tan(criterion.down))
    return np.array([-slope * aside[1], slope * aside[0], -1.0])


@dataclass(frozen=True, eq=False)
class _Nose:
    """How B people look over what is before them.

    down: (B,) [rad] below level, NaN where the parts asked about are not before them. part: (B,) the
    part that stands there, -1 for none. edge: (B, 3) [m] where, NaN for none. gives_way: (B, 3) by
    how much the margin grows with a metre that the part is moved by.
    """

    down: Floats
    part: Ints
    edge: Floats
    gives_way: Floats


def _over_nose(situation: Situation, criterion: Criterion) -> _Nose:
    """How far down people see straight ahead.

    Of parts that are named the highest counts. Else every opaque part does that hides anything from
    level downward: the angles that each piece of the skyline hides are united, and of those that reach
    below level the highest end counts.
    """
    eyes = eyes_of(situation)
    rows = np.arange(len(eyes))
    line = _skyline(situation, criterion.parts or _opaque(situation.environment), eyes)
    nothing = np.nan if criterion.parts else np.pi / 2
    if not line.before.any():
        none = np.full((len(eyes), 3), np.nan)
        return _Nose(np.full(len(eyes), nothing), np.full(len(eyes), -1), none, none)
    angle = np.where(line.before[:, :, None], np.arctan2(line.rise, line.ahead), -np.inf)
    top = angle.max(axis=2)
    if not criterion.parts:
        top = np.where(_from_level(angle), top, -np.inf)
    piece = top.argmax(axis=1)
    end = angle[rows, piece].argmax(axis=1)
    there = np.isfinite(top[rows, piece])
    ahead, rise = line.ahead[rows, piece, end], line.rise[rows, piece, end]
    up = np.array([0.0, 0.0, 1.0])
    edge = eyes + line.out[rows, piece, end]
    # the height to spare, -rise - tan(down) ahead, is linear in the place of the edge and 0 where the
    # angle to spare is: by their ratio a move lets somebody meet it exactly where it truly does
    height = -rise - np.tan(criterion.down) * ahead
    near = np.abs(height) < _NEAR
    ratio = np.where(near, ahead / (ahead**2 + rise**2), 0.0)
    ratio[~near] = (-top[rows, piece] - criterion.down)[~near] / height[~near]
    slope = ratio[:, None] * (-np.tan(criterion.down) * line.way - up)
    return _Nose(
        np.where(there, -top[rows, piece], nothing),
        np.where(there, line.part[rows, piece], -1),
        np.where(there[:, None], edge, np.nan),
        np.where(there[:, None], UNITS["rad"].counts * slope, np.nan),
    )


def _from_level(angle: Floats) -> Bools:
    """(B, N) which pieces of a skyline hide what is below level, or hang together with such.

    angle: (B, N, 2) [rad] the ends of the pieces, minus infinity of those that are not there.
    """
    low, high = angle.min(axis=2), angle.max(axis=2)
    low = np.where(np.isfinite(high), low, np.inf)
    order = np.argsort(low, axis=1)
    low = np.take_along_axis(low, order, axis=1)
    reach = np.maximum.accumulate(np.take_along_axis(high, order, axis=1), axis=1)
    # a gap above level before a piece, or before one under it, lets one look between them
    gap = np.hstack([np.zeros((len(low), 1), dtype=np.bool_), low[:, 1:] > reach[:, :-1] + _TOUCH])
    free = (low >= 0.0) & gap
    free[:, 0] |= low[:, 0] >= 0.0
    below = ~np.logical_or.accumulate(free, axis=1)
    found = np.zeros_like(below)
    np.put_along_axis(found, order, below, axis=1)
    return found


def _opaque(environment: Environment) -> tuple[str, ...]:
    """The parts that one does not see through."""
    shown = ~(environment.hidden | environment.see_through)
    return tuple(environment.parts[k] for k in np.flatnonzero(shown).tolist())


@dataclass(frozen=True, eq=False)
class _Skyline:
    """N pieces of parts that cross the upright plane straight ahead of each of B people.

    out: (B, N, 2, 3) [m] the ends of each piece from the eyes; what is behind these is cut off. way:
    (B, 3) the unit vectors ahead. before: (B, N) whether anything of a piece is before the eyes. part:
    (B, N) of each piece.
    """

    out: Floats
    way: Floats
    before: Bools
    part: Ints

    @property
    def ahead(self) -> Floats:
        """(B, N, 2) [m] the ends of the pieces along the way ahead."""
        return np.asarray(np.einsum("bnek,bk->bne", self.out, self.way))

    @property
    def rise(self) -> Floats:
        """(B, N, 2) [m] how far the ends are above the eyes."""
        return self.out[..., 2]


def _skyline(situation: Situation, parts: tuple[str, ...], eyes: Floats) -> _Skyline:
    """Cut parts with the upright planes straight ahead of people with eyes (B, 3)."""
    environment = situation.environment
    if situation.place.seat is not None:
        seat = environment.seat(situation.place.seat)
        aside = seat_planes(seat)[2][None]
        cuts = [_cut(environment, parts, np.array(seat.srp), aside[0])]
    else:
        aside = sight_of(situation.placed).axes[:, 1] * np.array([1.0, 1.0, 0.0])
        aside = aside / np.linalg.norm(aside, axis=1)[:, None]
        cuts = [_cut(environment, parts, *one) for one in zip(eyes, aside, strict=True)]
    most = max(len(part) for _, part in cuts)
    ends = np.full((len(cuts), most, 2, 3), np.nan)
    part = np.full((len(cuts), most), -1)
    for row, (points, owner) in enumerate(cuts):
        ends[row, : len(owner)] = points
        part[row, : len(owner)] = owner
    part = np.repeat(part, len(eyes) // len(cuts), axis=0)
    moving = [environment.part_index(name) for name in situation.place.moving_parts]
    goes = np.isin(part, moving)[:, :, None, None] * situation.displacement[:, None, None, :]
    out = ends + goes - eyes[:, None, None, :]
    way = np.stack([aside[:, 1], -aside[:, 0], np.zeros(len(aside))], axis=1)
    way = np.repeat(way, len(eyes) // len(cuts), axis=0)
    ahead = np.einsum("bnek,bk->bne", out, way)
    behind = ~(ahead > 0.0)
    span = np.where(behind & (ahead[..., ::-1] > 0.0), ahead - ahead[..., ::-1], 1.0)
    share = np.where(behind, ahead / span, 0.0)[..., None]
    return _Skyline(out + share * (out[..., ::-1, :] - out), way, ~behind.all(axis=2), part)


def _cut(
    environment: Environment, parts: tuple[str, ...], point: Floats, normal: Floats
) -> tuple[Floats, Ints]:
    """(N, 2, 3) [m] the pieces in which triangles of parts cross a plane, and (N,) their parts."""
    which = [environment.part_index(name) for name in parts]
    corners = [environment.triangle_corners(k) for k in which]
    owner = np.repeat(np.array(which, dtype=np.int64), [len(one) for one in corners])
    lines, triangle = plane_intersections(
        np.concatenate([np.zeros((0, 3, 3)), *corners]), normal, float(normal @ point)
    )
    return lines, owner[triangle]
