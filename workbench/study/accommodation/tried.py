"""What becomes of people in their places: each control, each clearance, the view and the seat, with
a margin.

The margin of a reach is what there is to spare on the way out from the shoulder, or what is
missing; of a clearance, the clearance less what is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.body.forward import place, segment_frames
from workbench.contact.clearance_pairs import clearance_of_pairs
from workbench.model.accommodation import MET, AccommodationStudy
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.reach import reach
from workbench.posture.seating.seating import seat_planes
from workbench.posture.stops import stops
from workbench.study.accommodation.own_contacts import own_margins
from workbench.study.accommodation.requirements import Asked
from workbench.study.accommodation.sitters import (
    SEAT_BACK,
    SEAT_FORWARD,
    Sitters,
    with_hands,
    without_seat,
)
from workbench.study.accommodation.sitting_gaps import gap_toward, gap_words
from workbench.study.accommodation.views import view_margin, view_words
from workbench.study.pairs import pair_of

__all__ = ["MOST_SPARE", "TURN_LEVER", "Tried", "judged", "sitting"]

MOST_SPARE = 0.2
"""A control that is reached with this much to spare [m], or more, is told to have this."""
HELD = ("clearance", "contact", "self_contact", "stops")
"""The checks that are asked with the hands on their controls."""
TURN_LEVER = 0.2
"""What a radian past a joint's stop counts [m]: about a hand's length."""


@dataclass(frozen=True, eq=False)
class Tried:
    """What became of B people and R requirements: margin (B, R) [m], words (B, R) of what limits,
    "" where met, and toward (B, R, 3): the unit vector along which moving the control or part lets
    the margin grow as much, NaN where there is none; seat (B, 2) [m]: forward and up."""

    margin: Floats
    words: NDArray[np.object_]
    toward: Floats
    seat: Floats

    def rows(self, keep: Ints) -> Tried:
        """A copy of what became of the people at indices, in their order."""
        return Tried(self.margin[keep], self.words[keep], self.toward[keep], self.seat[keep])

    def put(self, rows: Ints, other: Tried) -> None:
        """Replace what became of the people at indices."""
        self.margin[rows] = other.margin
        self.words[rows] = other.words
        self.toward[rows] = other.toward
        self.seat[rows] = other.seat


def sitting(study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters) -> Sitters:
    """People who sit, with their hands on their controls where anything that is asked is about
    that."""
    if any(one.requirement.check in HELD for one in asked):
        return with_hands(study, sitters)
    return sitters


def judged(study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters) -> Tried:
    """How people who sit come out in all requirements."""
    people = len(sitters.body)
    margin = np.full((people, len(asked)), np.nan)
    toward = np.full((people, len(asked), 3), np.nan)
    words = np.full(margin.shape, "", dtype=object)
    tried = Tried(margin, words, toward, np.stack([sitters.seat.forward, sitters.seat.up], axis=1))
    _reaches(study, asked, sitters, tried)
    _gaps(study, asked, sitters, tried)
    for r, one in enumerate(asked):
        if one.requirement.check in ("eye_height", "view_over"):
            margin[:, r] = view_margin(study, one.criterion, sitters.seat.eye)
            for b in np.flatnonzero(margin[:, r] < -MET):
                words[b, r] = view_words(study, one.criterion, sitters.seat.eye[b])
        elif one.requirement.check == "pedals":
            _pedals(sitters, tried, (r, one.criterion))
        elif one.requirement.check == "preferred_seat":
            _preferred_seat(sitters, tried, (r, one.criterion))
        elif one.requirement.check == "stops":
            _stops(sitters, tried, (r, one.criterion))
        elif one.requirement.check == "self_contact":
            margin[:, r], words[:, r] = own_margins(sitters.body, sitters.held, one.criterion)
    return tried


def _reaches(
    study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters, tried: Tried
) -> None:
    """Controls with the same grip and zone together: by the limb on their side, by the other where
    that one misses."""
    if all(one.control is None for one in asked):
        return
    groups: dict[tuple[str, int, str], list[int]] = {}
    middle = np.array(study.environment.seat(study.seat).srp)
    leftward = seat_planes(study.environment.seat(study.seat))[2]
    for r, one in enumerate(asked):
        if one.control is None:
            continue
        side = one.criterion.hand or (
            "left" if (np.array(one.control.at) - middle) @ leftward > 0 else "right"
        )
        groups.setdefault((one.control.grip, one.requirement.zone, side), []).append(r)
    empty = without_seat(study.environment, study.seat)
    for (grip, zone, side), rows in groups.items():
        foot = grip == "foot"
        how = ("ball" if foot else grip, zone, empty if foot else study.environment)
        first, second = (
            (f"{s} {'foot' if foot else 'hand'}")
            for s in (side, "left" if side == "right" else "right")
        )
        _tried(study, asked, (sitters, tried), (first, *how), rows, np.arange(len(sitters.body)))
        free = [r for r in rows if asked[r].criterion.hand is None]
        left = (
            np.flatnonzero((tried.margin[:, free] < -MET).any(axis=1))
            if free
            else np.zeros(0, np.int64)
        )
        if len(left):
            _tried(study, asked, (sitters, tried), (second, *how), free, left)


def _tried(
    study: AccommodationStudy,
    asked: Sequence[Asked],
    people: tuple[Sitters, Tried],
    how: tuple[str, str, int, Environment],
    rows: list[int],
    who: Ints,
) -> None:
    """Let some people reach with one limb for some controls; what is better than before counts."""
    (sitters, tried), (name, grip, zone, environment) = people, how
    body = sitters.body
    poses = sitters.seat.poses
    root = _root(body, poses, name)[who]
    some = Poses(poses.rotations[who], poses.reference, poses.world_from_reference[who], None, who)
    targets = [asked[r].control.at for r in rows]  # type: ignore[union-attr]
    found = reach(
        body,
        some,
        targets,
        limb=limb(body, name, grip=grip, zone=zone),
        environment=environment,
        moving_parts=study.environment.seat(study.seat).moves,
        displacement=sitters.seat.shift[who],
        max_extension=MOST_SPARE,
    )
    worst = np.maximum(found.miss + found.overlap, 1e-4)
    margin = np.where(found.reached, found.extension, -worst)
    for t, r in enumerate(rows):
        before = tried.margin[who, r]
        better = np.isnan(before) | ((before < -MET) & (margin[:, t] > before))
        tried.margin[who[better], r] = margin[better, t]
        tried.words[who[better], r] = ""
        for k in np.flatnonzero(better & ~found.reached[:, t]):
            tried.words[who[k], r] = found.limit(int(k), t)
        way = root - asked[r].control.at  # type: ignore[union-attr]
        way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
        tried.toward[who[better], r] = way[better]


def _root(body: Body, poses: Poses, limb: str) -> Floats:
    """(B, 3) [m] the shoulder or hip that a limb begins at, as people sit."""
    joint = body.joint(limb[0].upper() + ("S" if limb.endswith("hand") else "H"))
    world = segment_frames(body, poses, joint + 1)
    below = body.joint_in_child[:, joint]
    at: Floats = np.einsum("bij,bj->bi", world[:, :, :3], below) + world[:, :, 3]
    return at


def _gaps(
    study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters, tried: Tried
) -> None:
    """The clearances and contacts in the posture with hands and feet in their places."""
    rows = [r for r, one in enumerate(asked) if one.requirement.check in ("clearance", "contact")]
    if not rows:
        return
    body = sitters.body
    environment = study.environment
    moves = environment.seat(study.seat).moves
    shift = sitters.seat.shift
    placed = place(body, sitters.held)
    pairs = [pair_of(body, environment, asked[r].criterion) for r in rows]
    found = clearance_of_pairs(
        placed, environment, pairs=pairs, moving_parts=moves, displacement=shift
    )
    toward = gap_toward(placed, found)
    for q, r in enumerate(rows):
        criterion = asked[r].criterion
        contact = criterion.check == "contact"
        allowed = criterion.at_most if contact else -criterion.at_least
        room = found.distance[:, q] + allowed
        tried.margin[:, r] = np.where(np.isfinite(room), room, np.nan)
        tried.toward[:, r] = toward[:, q]
        for b in np.flatnonzero(room < -MET):
            tried.words[b, r] = gap_words(
                body, environment, (int(found.sphere[b, q]), int(found.polygon[b, q]))
            )


def _pedals(sitters: Sitters, tried: Tried, what: tuple[int, Criterion]) -> None:
    """How much farther the worse foot may stay from its pedal."""
    r, criterion = what
    seat = sitters.seat
    feet = list(seat.miss)
    miss = np.stack([seat.miss[foot] for foot in feet])
    worst = miss.argmax(axis=0)
    tried.margin[:, r] = criterion.at_most - miss.max(axis=0)
    for b in np.flatnonzero(tried.margin[:, r] < -MET):
        foot = feet[int(worst[b])]
        tried.words[b, r] = f"{foot}, {seat.limit[foot][b]}"


def _preferred_seat(sitters: Sitters, tried: Tried, what: tuple[int, Criterion]) -> None:
    """What is left of the seat's travel to its nearer end, fore and aft, at the position wanted."""
    r, criterion = what
    spare = sitters.seat.spare_travel[:, :2]
    tried.margin[:, r] = spare.min(axis=1) - criterion.at_least
    for b in np.flatnonzero(tried.margin[:, r] < -MET):
        tried.words[b, r] = SEAT_BACK if spare[b, 1] < spare[b, 0] else SEAT_FORWARD


def _stops(sitters: Sitters, tried: Tried, what: tuple[int, Criterion]) -> None:
    """The joint nearest to its stop, as an arc at TURN_LEVER."""
    r, criterion = what
    body = sitters.body
    found = stops(body, sitters.held)
    asked = np.isin(body.segments[1:], criterion.segments)
    margin = np.where(asked, found.margin, np.inf)
    joint = margin.argmin(axis=1)
    tried.margin[:, r] = TURN_LEVER * (margin.min(axis=1) - criterion.at_least)
    for b in np.flatnonzero(tried.margin[:, r] < -MET):
        motion = found.motion(int(b), int(joint[b])).replace("_", " ")
        tried.words[b, r] = f"{body.joint_names[joint[b]]} ({motion})"
