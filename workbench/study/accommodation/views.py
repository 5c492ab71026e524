"""Vision: eyes near enough to the height they are meant for, or high enough to look down over what
is before them."""

from __future__ import annotations

import numpy as np

from workbench.model.accommodation import AccommodationStudy
from workbench.model.arrays import Floats
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.posture.seating.seating import seat_planes

__all__ = ["TOO_HIGH", "TOO_LOW", "margin_of_view", "skyline", "view_margin", "view_words"]

TOO_LOW = "eyes too low"
TOO_HIGH = "eyes too high"


def view_margin(study: AccommodationStudy, criterion: Criterion, eyes: Floats) -> Floats:
    """(B,) [m] of height to spare of eyes (B, 3).

    Of heights: the nearer of the least and the greatest height that will do. Of a view over parts:
    how far the eyes are above the line that rises backward from the parts at the angle asked for,
    in the upright plane of the seat.
    """
    return margin_of_view(study.environment, (study.seat, study.aims.eyes), criterion, eyes)


def margin_of_view(
    environment: Environment,
    who: tuple[str, str | None],
    criterion: Criterion,
    eyes: Floats,
) -> Floats:
    """The same for whoever sits in a seat, with the point that the eyes are meant for."""
    seat, point = who
    if criterion.check == "view_over":
        return _over(environment, seat, criterion, eyes)
    assert point is not None
    rise = eyes[:, 2] - environment.points[point][2]
    margin: Floats = np.minimum(rise + criterion.below, criterion.above - rise)
    return margin


def view_words(study: AccommodationStudy, criterion: Criterion, eye: Floats) -> str:
    """In words, what is wrong with an eye (3,) that misses a view."""
    if criterion.check == "view_over" or study.aims.eyes is None:
        return TOO_LOW
    return (
        TOO_HIGH
        if eye[2] > study.environment.points[study.aims.eyes][2] + criterion.above
        else TOO_LOW
    )


def _over(environment: Environment, name: str, criterion: Criterion, eyes: Floats) -> Floats:
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


def skyline(
    environment: Environment, parts: tuple[str, ...], plane: tuple[Floats, Floats]
) -> Floats:
    """(M, 3) [m] where the edges of parts cross a plane, given by a point and its normal: the
    corners of its cut."""
    point, normal = plane
    found = [np.zeros((0, 3))]
    for name in parts:
        polygons = environment.polygons(environment.part(name))
        first, last = environment.triangle_start[[polygons.start, polygons.stop]]
        corner = environment.vertices[environment.triangles[first:last]]
        side = (corner - point) @ normal
        for a, b in ((0, 1), (1, 2), (2, 0)):
            crosses = (side[:, a] <= 0) != (side[:, b] <= 0)
            one = side[crosses, a]
            two = side[crosses, b]
            share = (one / (one - two))[:, None]
            found.append(corner[crosses, a] * (1 - share) + corner[crosses, b] * share)
    return np.concatenate(found)
