"""Clearance from parts and contact with parts.

The margin of a clearance is the distance less what is asked for. The margin of a contact is the
depth that is allowed, and `at_most` more, less the depth.

The bounds of a margin are the margins of larger and of smaller spheres: each grown by as much as
the true surface may lie outside its segment, or shrunk by as much as it may lie inside.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from workbench.body.forward import place
from workbench.contact.clearance_pairs import ClearancePair, clearance_of_pairs
from workbench.contact.collide import allowed_depth
from workbench.contact.kernels.search import Nearest
from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats, pieces
from workbench.model.body import Body, Topology
from workbench.model.contacts import subpart_words
from workbench.model.criterion import Criterion, Reason
from workbench.model.environment import Environment
from workbench.model.motion_case import ContactEvent
from workbench.model.poses import Placed
from workbench.model.result import Finding, MotionFound
from workbench.study.checks.margins import Asked, Bounds, Margins, no_margins
from workbench.study.checks.pairs import NearPairs, pair_findings
from workbench.study.crash.frames import BLOCK
from workbench.study.situation import Situation, moved_by_hands

__all__ = [
    "asked_pair",
    "bounds",
    "clearance_moments",
    "contact_moments",
    "findings",
    "limit_of",
    "margins",
    "meeting_finding",
    "most",
    "nearest_pair",
    "no_contact",
    "spheres_asked",
]

ROUNDING = 1e-9
"""[m] Searches for different spheres may round a distance of the same one differently."""


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What everybody has to spare in clearances and contacts, all in one search."""
    found = no_margins(len(situation), asked)
    body = situation.body
    environment = situation.environment
    near = _nearest(situation, [one.criterion for one in asked])
    found.toward[:] = _toward(situation.placed, near)
    for q, one in enumerate(asked):
        room = near.distance[:, q] - limit_of(one.criterion)
        found.margin[:, q] = np.where(np.isfinite(room), room, np.nan)
        for b in np.flatnonzero(room < -MET):
            pair = int(near.sphere[b, q]), int(near.polygon[b, q])
            found.words[b, q] = _reason(body, environment, *pair)
    return found


def most(situation: Situation, asked: Sequence[Asked]) -> Floats:
    """(B, Q) [m] what everybody has to spare in clearances and contacts at most, wherever the hands
    are: that of the spheres that hands do not move. Infinite where nothing of these is near."""
    limits = np.array([limit_of(one.criterion) for one in asked])
    still = ~moved_by_hands(situation)
    pairs = [asked_pair(situation.body, situation.environment, one.criterion) for one in asked]
    near = _nearest_of(situation, [replace(pair, spheres=pair.spheres & still) for pair in pairs])
    return near.distance - limits + ROUNDING


def bounds(situation: Situation, asked: Sequence[Asked]) -> Bounds:
    """Between what everybody may truly have to spare in clearances and contacts."""
    criteria = [one.criterion for one in asked]
    limits = np.array([limit_of(criterion) for criterion in criteria])
    low, high = _distances(situation, criteria)
    return Bounds(low - limits, high - limits)


def _distances(situation: Situation, criteria: Sequence[Criterion]) -> tuple[Floats, Floats]:
    """(B, Q) [m] the least and the greatest that distances may truly be, NaN where nothing is near
    or the fit error of a segment is not known that the criterion is about."""
    body = situation.body
    error = body.fit_error[situation.placed.person]
    ends = []
    for growth in (error[..., 0], -error[..., 1]):
        distance = _nearest(situation, criteria, np.nan_to_num(growth)).distance.copy()
        for q, criterion in enumerate(criteria):
            spheres = asked_pair(body, situation.environment, criterion).spheres
            about = growth[:, np.unique(body.sphere_segment[spheres])]
            distance[np.isnan(about).any(axis=1), q] = np.nan
        ends.append(np.where(np.isfinite(distance), distance, np.nan))
    return ends[0], ends[1]


def _nearest(
    situation: Situation, criteria: Sequence[Criterion], growth: Floats | None = None
) -> Nearest:
    """(B, Q) what criteria find nearest, the spheres of each segment grown by (B, N) [m]."""
    body = situation.body
    environment = situation.environment
    pairs = [asked_pair(body, environment, criterion) for criterion in criteria]
    return _nearest_of(situation, pairs, growth)


def _nearest_of(
    situation: Situation, pairs: Sequence[ClearancePair], growth: Floats | None = None
) -> Nearest:
    """(B, Q) what is nearest in pairs of spheres and parts."""
    return clearance_of_pairs(
        situation.placed,
        situation.environment,
        pairs=pairs,
        moving_parts=situation.place.moving_parts,
        displacement=situation.displacement,
        growth=growth,
    )


def nearest_pair(situation: Situation, criterion: Criterion) -> Nearest:
    """(B, 1) the spheres and polygons that a criterion finds nearest to each other."""
    return _nearest(situation, [criterion])


def asked_pair(body: Body, environment: Environment, criterion: Criterion) -> ClearancePair:
    """The spheres and parts that a criterion is about; of a contact with the overlap that is
    allowed added back."""
    return _pair(
        body.topology,
        environment.parts,
        criterion.subparts,
        criterion.segments,
        criterion.parts,
        criterion.check == "contact",
    )


@lru_cache(maxsize=128)
def _pair(
    topology: Topology,
    parts: tuple[str, ...],
    subparts: tuple[str, ...],
    segments: tuple[str, ...],
    against: tuple[str, ...],
    allowing: bool,
) -> ClearancePair:
    """The same by names, made once."""
    if subparts:
        spheres = np.isin(topology.subparts, subparts)
    else:
        spheres = np.isin(np.array(topology.segments)[topology.sphere_segment], segments)
    return ClearancePair(spheres, np.isin(parts, against), allowing)


def spheres_asked(situation: Situation, criterion: Criterion) -> Bools:
    """(S,) the spheres that a clearance or a contact is about."""
    return asked_pair(situation.body, situation.environment, criterion).spheres


def limit_of(criterion: Criterion) -> float:
    """The distance [m] that may not be fallen short of."""
    return -criterion.at_most if criterion.check == "contact" else criterion.at_least


def _reason(body: Body, environment: Environment, sphere: int, polygon: int) -> Reason:
    """ "right lower leg (knee cap) at instrument_panel"."""
    segment = body.segment_names[int(body.sphere_segment[sphere])]
    name = subpart_words(body, sphere)
    part = environment.parts[int(environment.polygon_part[polygon])]
    return Reason("near", f"{segment} ({name})" if name else segment, at=part)


def _toward(placed: Placed, found: Nearest) -> Floats:
    """(B, Q, 3) the unit vectors from the nearest spheres to the nearest parts: where a part would
    have to go. NaN where nothing is near, or a centre is inside."""
    people = np.arange(len(placed.centres))[:, None]
    sphere = np.maximum(found.sphere, 0)
    way = found.point - placed.centres[people, sphere]
    far = np.linalg.norm(way, axis=2)
    radius = placed.body.radius[placed.person[:, None], sphere]
    seen = (found.sphere >= 0) & (far > 1e-9) & (found.distance > -radius)
    return np.where(seen[..., None], way / np.maximum(far, 1e-9)[..., None], np.nan)


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """Every pair of a segment and a part, of named spheres the nearest; pairs whose contact is
    allowed by rule have no clearance."""
    if criterion.subparts:
        yield from _subpart_findings(situation, criterion)
        return
    body = situation.body
    environment = situation.environment
    allowed = allowed_depth(body, environment)
    about = np.isin(body.segments, criterion.segments)[:, None]
    keep = about & np.isin(environment.parts, criterion.parts)[None, :]
    if criterion.check == "contact":
        limit = -(allowed + criterion.at_most)
    else:
        keep = keep & (allowed == 0)
        limit = np.full(allowed.shape, criterion.at_least)
    asked = NearPairs(situation.nearest, limit, keep, situation.place.role)
    yield from pair_findings(asked, situation.work.name)


def _subpart_findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    body = situation.body
    environment = situation.environment
    found = nearest_pair(situation, criterion)
    low, high = _distances(situation, [criterion])
    for row in np.flatnonzero(np.isfinite(found.distance[:, 0])).tolist():
        sphere = int(found.sphere[row, 0])
        polygon = int(found.polygon[row, 0])
        segment = body.segment_names[int(body.sphere_segment[sphere])]
        part, number = _plane(environment, polygon)
        distance = float(found.distance[row, 0])
        met = distance >= limit_of(criterion)
        known = distance - low[row, 0] if met else high[row, 0] - distance
        yield Finding(
            case=situation.work.name,
            person=situation.place.role,
            other_person="",
            subject=f"{segment} ({subpart_words(body, sphere)})",
            target=f"{part}, polygon {number}",
            value=distance,
            limit=limit_of(criterion),
            point=tuple(found.point[row, 0].tolist()),
            surface_known_to=float(known),
            sphere=sphere,
            polygon=number,
        )


def _plane(environment: Environment, polygon: int) -> tuple[str, int]:
    """The part of a polygon, and its number in that part."""
    part = int(environment.polygon_part[polygon])
    return environment.parts[part], polygon - int(environment.part_start[part])


def clearance_moments(found: MotionFound, criterion: Criterion) -> list[Finding]:
    """The nearest that segments or named spheres come to parts at the frames of a motion, allowed
    contacts left out."""
    study = found.study
    body = study.body
    environment = study.environment
    pair = asked_pair(body, environment, criterion)
    best: list[Finding] = []
    for frames in pieces(len(study.motion), size=BLOCK):
        placed = place(body, study.motion.rows(frames))
        near = clearance_of_pairs(placed, environment, pairs=[pair])
        frame = int(np.argmin(near.distance[:, 0]))
        least = float(near.distance[frame, 0])
        if not np.isfinite(least) or (best and least >= best[0].value):
            continue
        sphere = int(near.sphere[frame, 0])
        part, number = _plane(environment, int(near.polygon[frame, 0]))
        moment = Finding(
            case=study.case,
            person=study.person,
            other_person="",
            subject=body.segment_names[int(body.sphere_segment[sphere])],
            target=f"{part}, polygon {number}",
            value=least,
            limit=limit_of(criterion),
            point=tuple(near.point[frame, 0].tolist()),
            time=float(study.motion.clock[frames.start + frame]),
            sphere=sphere,
            polygon=number,
        )
        best = [moment]
    return best


def contact_moments(found: MotionFound, criterion: Criterion) -> Iterable[Finding]:
    """The contacts of a motion in continuous time, each at its deepest; of named spheres the
    nearest at the frames."""
    if criterion.subparts:
        return clearance_moments(found, criterion)
    return (
        meeting_finding(found, meeting, criterion.at_most)
        for meeting in found.meetings
        if not meeting.own
        and meeting.segment in criterion.segments
        and meeting.other in criterion.parts
    )


def no_contact(criterion: Criterion) -> str:
    """Why a motion without findings passes."""
    return "" if criterion.subparts else "no contact"


def meeting_finding(found: MotionFound, meeting: ContactEvent, at_most: float) -> Finding:
    """The deepest moment of a contact, against what is allowed and `at_most` [m] more."""
    return Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=meeting.deep,
        target=meeting.other if meeting.own else f"{meeting.other}, polygon {meeting.polygon}",
        value=-meeting.depth,
        limit=-(meeting.allowed + at_most),
        point=meeting.point,
        time=meeting.deepest,
        sphere=meeting.sphere,
        polygon=meeting.polygon,
        other_sphere=meeting.other_sphere,
    )
