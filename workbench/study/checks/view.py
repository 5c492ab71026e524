"""The view: eyes near enough to the height that they are meant for, or high enough to look down
over what is before them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.errors import InputError
from workbench.model.accommodation import MET
from workbench.model.arrays import Floats
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.result import Finding
from workbench.posture.seating.seating import seat_planes
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation

__all__ = ["THE_EYES", "TOO_HIGH", "TOO_LOW", "eyes_of", "findings", "margins", "skyline"]

TOO_LOW = "eyes too low"
TOO_HIGH = "eyes too high"
THE_EYES = "the eyes"
"""What a finding about a view is about."""
EYES = ("left eye", "right eye")
"""The spheres between whose centres a body looks from."""


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much higher or lower everybody's eyes may be.

    Of heights: the nearer of the least and the greatest height that will do. Of a view over parts:
    how far the eyes are above the line that rises backward from the parts at the angle asked for,
    in the upright plane of the seat.
    """
    found = no_margins(len(situation), asked)
    eye = eyes_of(situation)
    for r, one in enumerate(asked):
        found.margin[:, r] = _margin(situation, one.criterion, eye)
        if one.criterion.check == "view_over":
            found.toward[:, r] = _gives_way(situation, one.criterion)
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            found.words[b, r] = _words(situation, one.criterion, eye[b])
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
    middle: Floats = situation.placed.centres[:, spheres].mean(axis=1)
    return middle


def _margin(situation: Situation, criterion: Criterion, eyes: Floats) -> Floats:
    """(B,) [m] of height to spare of eyes (B, 3)."""
    environment = situation.environment
    if criterion.check == "view_over":
        assert situation.place.seat is not None
        return _over(environment, situation.place.seat, criterion, eyes)
    if situation.eyes is None:
        return np.full(len(eyes), np.nan)
    rise = eyes[:, 2] - environment.points[situation.eyes][2]
    margin: Floats = np.minimum(rise + criterion.below, criterion.above - rise)
    return margin


def _words(situation: Situation, criterion: Criterion, eye: Floats) -> str:
    """What is wrong with an eye (3,) that misses a view."""
    if criterion.check == "view_over" or situation.eyes is None:
        return TOO_LOW
    highest = situation.environment.points[situation.eyes][2] + criterion.above
    return TOO_HIGH if eye[2] > highest else TOO_LOW


def _over(environment: Environment, name: str, criterion: Criterion, eyes: Floats) -> Floats:
    """(B,) [m] how far eyes (B, 3) are above the highest line that starts at an edge before them
    and rises backward: height of the edge + tan(down) * distance."""
    seat = environment.seat(name)
    aside = seat_planes(seat)[2]
    ahead = np.array([aside[1], -aside[0], 0.0])
    edge = skyline(environment, criterion.parts, (np.array(seat.srp), aside))
    distance = edge @ ahead - eyes[:, None] @ ahead
    line = edge[:, 2] + np.tan(criterion.down) * distance
    before = distance > 0
    highest = np.max(np.where(before, line, -np.inf), axis=1, initial=-np.inf)
    margin: Floats = np.where(np.isfinite(highest), eyes[:, 2] - highest, np.nan)
    return margin


def _gives_way(situation: Situation, criterion: Criterion) -> Floats:
    """(3,) by how much the margin of a view over parts grows with a metre that they are moved by: it
    is eye z - edge z - tan(down) * (edge - eye) along the way ahead."""
    assert situation.place.seat is not None
    aside = seat_planes(situation.environment.seat(situation.place.seat))[2]
    slope = float(np.tan(criterion.down))
    return np.array([-slope * aside[1], slope * aside[0], -1.0])


def skyline(
    environment: Environment, parts: tuple[str, ...], plane: tuple[Floats, Floats]
) -> Floats:
    """(M, 3) [m] where the edges of parts cross a plane, given by a point and its normal: the
    corners of its cut."""
    point, normal = plane
    found = [np.zeros((0, 3))]
    for name in parts:
        corner = environment.triangle_corners(environment.part_index(name))
        side = (corner - point) @ normal
        for a, b in ((0, 1), (1, 2), (2, 0)):
            crosses = (side[:, a] <= 0) != (side[:, b] <= 0)
            one = side[crosses, a]
            two = side[crosses, b]
            share = (one / (one - two))[:, None]
            found.append(corner[crosses, a] * (1 - share) + corner[crosses, b] * share)
    return np.concatenate(found)
