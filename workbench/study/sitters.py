"""People in their places: each in the seat where view and pedals are had, then hand by hand, then what they touch.

The order is that of Zehner and Kennedy's cockpit assessments: the lowest seat that still gives the view, the pedals,
each control in its harness zone, then the clearances in the posture with hands and feet on their controls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.accommodation import MET, AccommodationStudy
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Control, Environment
from workbench.model.poses import Poses
from workbench.solve.driving_people import seat_drivers
from workbench.solve.forward import place
from workbench.solve.limbs import FEET, HANDS
from workbench.solve.people_gaps import PeopleGaps, people_gaps
from workbench.solve.posture import Pedals
from workbench.solve.reach_people import reach_people
from workbench.solve.seat_people import SeatedPeople, seat_people
from workbench.solve.seating import seat_planes
from workbench.solve.stops import stops
from workbench.study.drivers import drivers_among, feet_of, package_of
from workbench.study.requirements import Asked
from workbench.study.sitting_gaps import gap_of, gap_words
from workbench.study.views import view_margin, view_words

__all__ = ["MOST_SPARE", "SEAT_BACK", "SEAT_FORWARD", "Sitters", "Tried", "gaps_of", "met_by", "seated", "with_hands",
           "without_seat"]  # fmt: skip

SEAT_BACK, SEAT_FORWARD = "the seat stops too far back", "the seat stops too far forward"
MOST_SPARE = 0.2
"""A control that is reached with this much to spare [m], or more, is told to have this."""
SHORT = 1e-3
"""A foot this near [m] to its pedal is on it."""
TURN_LEVER = 0.2
"""What a radian past a joint's stop counts [m]: about a hand's length."""


@dataclass(frozen=True, eq=False)
class Sitters:
    """B people seated for a study: where the seat is, poses with the hands at rest and with hands on their controls."""

    bodies: Sequence[Body]
    seat: SeatedPeople
    held: Poses


@dataclass(frozen=True, eq=False)
class Tried:
    """What became of B people and R requirements: margin (B, R) [m], words (B, R) of what limits, "" where met, and
    toward (B, R, 3): how the margin of a reach grows as the control moves (unit vector toward the person), NaN of
    others; seat (B, 2) [m]: forward and up."""

    margin: Floats
    words: list[list[str]]
    toward: Floats
    seat: Floats


def met_by(study: AccommodationStudy, asked: Sequence[Asked], bodies: Sequence[Body], rows: Sequence[int]) -> Tried:
    """How B people, these rows of the study's people, come out in all requirements."""
    sitters = with_hands(study, seated(study, bodies, rows))
    margin, toward = np.full((len(bodies), len(asked)), np.nan), np.full((len(bodies), len(asked), 3), np.nan)
    words = [[""] * len(asked) for _ in bodies]
    tried = Tried(margin, words, toward, np.stack([sitters.seat.forward, sitters.seat.up], axis=1))
    _reaches(study, asked, sitters, tried)
    _gaps(study, asked, sitters, tried)
    for r, one in enumerate(asked):
        if one.requirement.check == "vision":
            margin[:, r] = view_margin(study, one.criterion, sitters.seat.eye)
            for b in np.flatnonzero(margin[:, r] < -MET):
                words[b][r] = view_words(study, one.criterion, sitters.seat.eye[b])
        elif one.requirement.check == "seat":
            _seat(sitters, tried, r)
        elif one.requirement.check == "stops":
            _stops(sitters, tried, (r, one.criterion.at_least))
    return tried


def seated(study: AccommodationStudy, bodies: Sequence[Body], rows: Sequence[int]) -> Sitters:
    """B bodies, these rows of the study's people, in the seat, feet on the pedals, arms as in the posture they sit
    like."""
    environment, aims = study.environment, study.aims
    controls = {control.name: control for control in environment.controls}
    at = {limb: controls[name].at for limb, name in aims.controls.items() if limb in FEET}
    pedals = Pedals(at, environment.points[aims.heels][2] if aims.heels else None)
    eye = environment.points[aims.eyes][2] if aims.eyes else None
    assert study.pose is not None
    lap = bodies[0].segment("LT")
    world = place(bodies[0], study.pose).world_from_segment[:, lap]
    poses = Poses(np.repeat(study.pose.rotations, len(bodies), axis=0), lap, np.repeat(world, len(bodies), axis=0))
    seat, driving = environment.seat(study.seat), aims.driving
    if driving is None:
        found = seat_people(bodies, poses, seat, eye=eye, pedals=pedals)
    else:
        found = seat_drivers(
            bodies, poses, seat, drivers=drivers_among(study.people, rows, bodies, driving.age), seed=driving.seed,
            package=package_of(aims, environment), feet=feet_of(aims, environment), eye=eye, numbers=list(rows),
        )  # fmt: skip
    return Sitters(bodies, found, found.poses)


def with_hands(study: AccommodationStudy, sitters: Sitters) -> Sitters:
    """The hands on the controls that they hold, each in the tightest harness zone that will do."""
    controls = {control.name: control for control in study.environment.controls}
    poses = sitters.held
    for limb, name in study.aims.controls.items():
        if limb in HANDS:
            poses = _hand(study, Sitters(sitters.bodies, sitters.seat, poses), (limb, controls[name]))
    return Sitters(sitters.bodies, sitters.seat, poses)


def _hand(study: AccommodationStudy, sitters: Sitters, what: tuple[str, Control]) -> Poses:
    limb, control = what
    rotations = sitters.held.rotations.copy()
    left = np.arange(len(sitters.bodies))
    for zone in range(1, control.zone + 1):
        poses = Poses(sitters.held.rotations[left], sitters.held.reference, sitters.held.world_from_reference[left])
        found = reach_people(
            [sitters.bodies[int(b)] for b in left], poses, [control.at], name=limb, grip=control.grip, zone=zone,
            environment=study.environment, moves=study.environment.seat(study.seat).moves,
            shift=sitters.seat.shift[left], rotations=True,
        )  # fmt: skip
        assert found.rotations is not None
        rotations[left] = found.rotations[:, 0]
        left = left[~found.reached[:, 0]]
        if not len(left):
            break
    return Poses(rotations, sitters.held.reference, sitters.held.world_from_reference)


def without_seat(environment: Environment, seat: str) -> Environment:
    """The environment without the sitters' own seat: a thigh presses the cushion down, it does not stop there."""
    gone = np.isin(environment.parts, environment.seat(seat).moves)
    return replace(environment, hidden=environment.hidden | gone)


def _reaches(study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters, tried: Tried) -> None:
    """Controls with the same grip and zone together: by the limb on their side, by the other where that one misses."""
    groups: dict[tuple[str, int, str], list[int]] = {}
    middle = np.array(study.environment.seat(study.seat).srp)
    leftward = seat_planes(study.environment.seat(study.seat))[2]
    for r, one in enumerate(asked):
        if one.control is None:
            continue
        side = one.criterion.hand or ("left" if (np.array(one.control.at) - middle) @ leftward > 0 else "right")
        groups.setdefault((one.control.grip, one.requirement.zone, side), []).append(r)
    empty = without_seat(study.environment, study.seat)
    for (grip, zone, side), rows in groups.items():
        foot = grip == "foot"
        how = ("ball" if foot else grip, zone, empty if foot else study.environment)
        first, second = ((f"{s} {'foot' if foot else 'hand'}") for s in (side, "left" if side == "right" else "right"))
        _tried(study, asked, (sitters, tried), (first, *how), rows, np.arange(len(sitters.bodies)))
        free = [r for r in rows if asked[r].criterion.hand is None]
        left = np.flatnonzero((tried.margin[:, free] < -MET).any(axis=1)) if free else np.zeros(0, np.int64)
        if len(left):
            _tried(study, asked, (sitters, tried), (second, *how), free, left)


def _tried(
    study: AccommodationStudy, asked: Sequence[Asked], people: tuple[Sitters, Tried],
    how: tuple[str, str, int, Environment], rows: list[int], who: Ints,
) -> None:  # fmt: skip
    """Let some people reach with one limb for some controls; what is better than before counts."""
    (sitters, tried), (limb, grip, zone, environment) = people, how
    poses = sitters.seat.poses
    some = Poses(poses.rotations[who], poses.reference, poses.world_from_reference[who])
    targets = [asked[r].control.at for r in rows]  # type: ignore[union-attr]
    found = reach_people(
        [sitters.bodies[int(b)] for b in who], some, targets, name=limb, grip=grip, zone=zone, environment=environment,
        moves=study.environment.seat(study.seat).moves, shift=sitters.seat.shift[who], spare=MOST_SPARE,
    )  # fmt: skip
    worst = np.maximum(found.miss + found.overlap, 1e-4)
    margin = np.where(found.reached, found.spare, -worst)
    for t, r in enumerate(rows):
        before = tried.margin[who, r]
        better = np.isnan(before) | ((before < -MET) & (margin[:, t] > before))
        tried.margin[who[better], r] = margin[better, t]
        for k in np.flatnonzero(better):
            short = f"{limb}, {found.limit(int(k), t)}" if not found.reached[k, t] else ""
            tried.words[who[k]][r] = short


def _gaps(study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters, tried: Tried) -> None:
    """The clearances and contacts in the posture with hands and feet in their places."""
    rows = [r for r, one in enumerate(asked) if one.requirement.check in ("clearance", "contact")]
    if not rows:
        return
    body = sitters.bodies[0]
    found = gaps_of(study, [asked[r] for r in rows], sitters)
    for q, r in enumerate(rows):
        room = found.room[:, q] - asked[r].criterion.at_least
        tried.margin[:, r] = np.where(np.isfinite(room), room, np.nan)
        for b in np.flatnonzero(room < -MET):
            tried.words[b][r] = gap_words(body, study.environment, (int(found.sphere[b, q]), int(found.polygon[b, q])))


def gaps_of(study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters) -> PeopleGaps:
    """The nearest pairs of these requirements, as the people sit with their hands and feet in place."""
    body, environment = sitters.bodies[0], study.environment
    return people_gaps(
        sitters.bodies, sitters.held, environment, gaps=[gap_of(body, environment, one.criterion) for one in asked],
        moves=environment.seat(study.seat).moves, shift=sitters.seat.shift,
    )  # fmt: skip


def _seat(sitters: Sitters, tried: Tried, r: int) -> None:
    """Pedals missed by so much; else what is left of the seat's travel to its nearer end, fore and aft."""
    seat = sitters.seat
    feet = list(seat.miss)
    miss = np.stack([seat.miss[foot] for foot in feet])
    worst = miss.argmax(axis=0)
    far = miss.max(axis=0)
    tried.margin[:, r] = np.where(far > SHORT, -far, seat.spare_travel[:, :2].min(axis=1))
    for b in np.flatnonzero(far > SHORT):
        foot = feet[int(worst[b])]
        tried.words[b][r] = f"{foot}, {seat.limit[foot][b]}"
    for b in np.flatnonzero((far <= SHORT) & (tried.margin[:, r] < -MET)):
        tried.words[b][r] = SEAT_BACK if seat.spare_travel[b, 1] < 0 else SEAT_FORWARD


def _stops(sitters: Sitters, tried: Tried, what: tuple[int, float]) -> None:
    """The joint nearest to its stop, as an arc at TURN_LEVER."""
    r, at_least = what
    body = sitters.bodies[0]  # stops are those of the family
    found = stops(body, sitters.held)
    joint = found.margin.argmin(axis=1)
    tried.margin[:, r] = TURN_LEVER * (found.margin.min(axis=1) - at_least)
    for b in np.flatnonzero(tried.margin[:, r] < -MET):
        motion = found.motion(int(b), int(joint[b])).replace("_", " ")
        tried.words[b][r] = f"{body.joint_names[joint[b]]} ({motion})"
