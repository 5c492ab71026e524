"""Excursion: how far the surface of segments gets along a direction from an origin.

The margin is the distance that is allowed, less the greatest (c - origin) . direction + r over the
spheres.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.body.forward import place
from workbench.model.accommodation import MET
from workbench.model.arrays import Floats, Ints
from workbench.model.contacts import subpart_words
from workbench.model.criterion import Criterion, Reason
from workbench.model.environment import Environment
from workbench.model.result import Finding, MotionFound
from workbench.study.checks.margins import Asked, Bounds, Margins, no_bounds, no_margins
from workbench.study.situation import Situation

__all__ = ["bounds", "findings", "margins", "moments"]


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much farther everybody may get."""
    found = no_margins(len(situation), asked)
    body = situation.body
    for r, one in enumerate(asked):
        ahead, spheres = _ahead(situation, one.criterion)
        found.margin[:, r] = one.criterion.at_most - ahead.max(axis=1)
        farthest = spheres[ahead.argmax(axis=1)]
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            name = body.segment_names[int(body.sphere_segment[farthest[b]])]
            found.words[b, r] = Reason("segment", name)
    return found


def bounds(situation: Situation, asked: Sequence[Asked]) -> Bounds:
    """Between how much farther everybody may truly get."""
    found = no_bounds(len(situation), asked)
    for r, one in enumerate(asked):
        far, near = _farthest(situation, one.criterion)
        found.low[:, r] = one.criterion.at_most - far
        found.high[:, r] = one.criterion.at_most - near
    return found


def _farthest(situation: Situation, criterion: Criterion) -> tuple[Floats, Floats]:
    """(B,) [m] how far the true surface may get at most, and at least; NaN where not known."""
    body = situation.body
    ahead, spheres = _ahead(situation, criterion)
    error = body.fit_error[situation.placed.person][:, body.sphere_segment[spheres]]
    return (ahead + error[..., 0]).max(axis=1), (ahead - error[..., 1]).max(axis=1)


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """The farthest of the segments."""
    body = situation.body
    ahead, spheres = _ahead(situation, criterion)
    farthest = int(ahead[0].argmax())
    value = float(ahead[0, farthest])
    far, near = (float(end[0]) for end in _farthest(situation, criterion))
    yield Finding(
        case=situation.work.name,
        person=situation.place.role,
        other_person="",
        subject=body.segment_names[int(body.sphere_segment[spheres[farthest]])],
        target=_origin_words(criterion, situation.environment),
        value=-value,
        limit=-criterion.at_most,
        point=_foremost(
            situation.placed.centres[0, spheres[farthest]],
            float(body.radius[0, spheres[farthest]]),
            criterion,
        ),
        surface_known_to=far - value if value <= criterion.at_most else value - near,
        sphere=int(spheres[farthest]),
    )


_WAYS = {
    (1.0, 0.0, 0.0): "ahead of",
    (-1.0, 0.0, 0.0): "behind",
    (0.0, 1.0, 0.0): "to the left of",
    (0.0, -1.0, 0.0): "to the right of",
    (0.0, 0.0, 1.0): "above",
    (0.0, 0.0, -1.0): "below",
}


def _origin_words(criterion: Criterion, environment: Environment) -> str:
    """ "ahead of the reference point of seat left", "above the point x 0, y 280, z 280 mm"."""
    way = _WAYS.get(criterion.direction, "")
    if not way:
        ahead = ", ".join(f"{value + 0.0:.3g}" for value in criterion.direction)
        way = f"along ({ahead}) from"
    for seat in environment.seats:
        if np.allclose(seat.srp, criterion.origin, rtol=0.0, atol=1e-6):
            return f"{way} the reference point of seat {seat.name}"
    x, y, z = (f"{1000.0 * value + 0.0:g}" for value in criterion.origin)
    return f"{way} the point x {x}, y {y}, z {z} mm"


def _foremost(centre: Floats, radius: float, criterion: Criterion) -> tuple[float, float, float]:
    """The point [m] of a sphere's surface that is farthest along the direction. centre: (3,)."""
    x, y, z = (centre + radius * np.array(criterion.direction)).tolist()
    return x, y, z


def _ahead(situation: Situation, criterion: Criterion) -> tuple[Floats, Ints]:
    """(B, S) [m] how far the surfaces of spheres get, and which spheres (S,) these are."""
    body = situation.body
    rows = [n for n, name in enumerate(body.segments) if name in criterion.segments]
    about = np.flatnonzero(np.isin(body.sphere_segment, rows))
    gap = situation.placed.centres[:, about] - np.array(criterion.origin)
    return gap @ np.array(criterion.direction) + body.radius[:, about], about


def moments(found: MotionFound, criterion: Criterion) -> Iterator[Finding]:
    """The farthest moment of a motion."""
    body = found.study.body
    farthest = found.excursions[criterion.name]
    segment = body.segment_names[int(body.sphere_segment[farthest.sphere])]
    name = subpart_words(body, farthest.sphere)
    frame = slice(farthest.frame, farthest.frame + 1)
    centre = place(body, found.study.motion.rows(frame)).centres[0, farthest.sphere]
    yield Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=f"{segment}, {name}" if name else segment,
        target=_origin_words(criterion, found.study.environment),
        value=-farthest.value,
        limit=-criterion.at_most,
        point=_foremost(centre, float(body.radius[0, farthest.sphere]), criterion),
        time=float(found.study.motion.clock[farthest.frame]),
        sphere=farthest.sphere,
    )
