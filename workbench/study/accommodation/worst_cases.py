"""The people farthest from being served, posed at what they miss most, whoever comes nearest to that
where all are served, and those nearest to missing what they see, to be looked at."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place as place_body
from workbench.model.accommodation import MET, most_missed
from workbench.model.arrays import Floats, Ints, xyz
from workbench.model.criterion import Finding
from workbench.model.poses import Placed, Poses
from workbench.model.result import Illustration
from workbench.posture.reaching.limbs import Limb, limb, limbs_there
from workbench.posture.reaching.reach import reach
from workbench.study.accommodation.checkpoints import Chunk, PopulationQuestion
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.checks.margins import Asked
from workbench.study.checks.parts import nearest_pair
from workbench.study.checks.reach import limbs_asked
from workbench.study.checks.seat_travel import foot_seated, worse_foot
from workbench.study.checks.table import findings_of
from workbench.study.checks.view import eyes_of
from workbench.study.positions import comfortable_situations, in_positions
from workbench.study.settings import at_setting, renewed
from workbench.study.situation import (
    Occupants,
    Situation,
    with_hands,
    without_seat,
)

__all__ = ["Found", "Places", "beheld_people", "found_situations", "hardest_rows", "shown_people"]


@dataclass(frozen=True, eq=False)
class Places:
    """Where B people were found: positions of the seat and comfortable ones (B, 2) [m], and settings
    (B, A), as of `Chunk`."""

    seat: Floats
    comfortable: Floats
    setting: Floats


Found = tuple[Ints, list[Situation]]
"""Rows of people, and these people in each case."""
MOST = 5
_EVER_SO = ("pedals", "self_contact", "stops")
"""What is tight in everybody, whatever stands around."""


def hardest_rows(margin: Floats, weight: Floats, *, checks: Sequence[str] = ()) -> dict[int, int]:
    """The rows of at most five people with the most negative margin (P, R), each with the requirement
    to look at: first who misses most of what most people, by weight (P,), miss; then worst first, one a
    worst requirement as far as there are: the same trouble five times says less. Those that remain
    fill up.

    Where nobody misses anything it is whoever comes nearest to it, at what is tightest. checks: of the
    requirements, so that this is no foot that is on its pedal, nor, where anything else was asked, a
    fold of the own body."""
    chief = most_missed(margin, weight)
    known = np.nan_to_num(margin, nan=np.inf)
    worst = known.min(axis=1)
    at = known.argmin(axis=1)
    order = [int(row) for row in np.argsort(worst, kind="stable") if worst[row] < -MET]
    if not order and np.isfinite(known).any():
        kind = np.array(checks or [""] * margin.shape[1])
        for some in (_EVER_SO, ("pedals",), ()):
            left = np.where(np.isin(kind, some), np.inf, known)
            if np.isfinite(left).any():
                row, at_most = np.unravel_index(np.argmin(left), left.shape)
                return {int(row): int(at_most)}
    lead = min(order, key=lambda row: (at[row] != chief, known[row, chief]), default=-1)
    first = {int(at[row]): row for row in reversed(order) if row != lead and at[row] != chief}
    chosen = [lead] * bool(order) + sorted(first.values(), key=order.index)[: MOST - 1]
    chosen += [row for row in order if row not in chosen][: MOST - len(chosen)]
    chosen[1:] = sorted(chosen[1:], key=order.index)
    return {row: chief if row == lead else int(at[row]) for row in chosen}


def found_situations(
    question: PopulationQuestion,
    bodies: PopulationBodies,
    people: Ints,
    found: Chunk | Places,
    *,
    first: int = 0,
) -> Iterator[Found]:
    """People (N,) in each case, in the positions of the seat and the settings that their margins are
    of: those of one setting together. first: the number that the first of the people of the question
    has in the population, by which driving postures are drawn."""
    for setting in np.unique(found.setting[people], axis=0):
        rows = people[(found.setting[people] == setting).all(axis=1)]
        place = at_setting(question.place, setting)
        who = Occupants(bodies[rows], question.people, rows, first)
        comfortable = comfortable_situations(place, who)
        stays = np.array_equal(found.seat[rows], found.comfortable[rows])
        if stays and place is question.place:
            yield rows, comfortable
        else:
            yield rows, in_positions(place, who, found.seat[rows], comfortable)


def shown_people(
    question: PopulationQuestion,
    bodies: PopulationBodies,
    found: Chunk | Places,
    rows: Sequence[int],
    *,
    at: Sequence[int],
    first: int = 0,
) -> Iterator[Illustration]:
    """Some people (rows) as found, in their position, each at one requirement (at). first: as of
    `found_situations`."""
    for row, r in zip(rows, at, strict=True):
        one = question.asked[r]
        some = np.array([row])
        _, there = next(found_situations(question, bodies, some, found, first=first))
        situation = there[one.case]
        (again,) = renewed(situation.place, [one])
        look = _look(situation, again)
        environment = situation.environment_moved
        yield Illustration(
            row=first + row,
            requirement=r,
            case=situation.work.name,
            poses=look.poses,
            placed=place_body(situation.body, look.poses),
            environment=environment,
            limb=look.limb,
            target=look.target,
            tip=look.tip,
            finding=look.finding,
        )


def beheld_people(
    question: PopulationQuestion, bodies: PopulationBodies, found: Chunk
) -> Iterator[Illustration]:
    """For each criterion of sight whoever comes nearest to missing one of its requirements, met or
    not; nobody where it applies to nobody."""
    asked = [one.requirement for one in question.asked]
    for name in dict.fromkeys(one.criterion for one in asked if one.of_sight):
        mine = np.array([one.criterion == name for one in asked])
        margin = np.where(mine & ~np.isnan(found.margin), found.margin, np.inf)
        row, r = np.unravel_index(np.argmin(margin), margin.shape)
        if np.isfinite(margin[row, r]):
            yield from shown_people(question, bodies, found, [int(row)], at=[int(r)])


def _measured(situation: Situation, one: Asked) -> Finding | None:
    """What is measured of a requirement of sight: of reading the limit of which the least share is to
    spare, as its margin counts."""
    every = findings_of([situation], one.criterion)
    mine = [finding for finding in every if finding.subject == one.requirement.target] or every
    shares = [(one.unit != "share" and abs(one.limit)) or 1.0 for one in mine]
    spare = [finding.margin / share for finding, share in zip(mine, shares, strict=True)]
    return mine[int(np.argmin(spare))] if mine else None


@dataclass(frozen=True, eq=False)
class _Look:
    """What to look at: one pose of a person; what comes too near or does not get there, "" where
    nothing is to be named; the two points that are to be near or apart; and what is measured of sight."""

    poses: Poses
    limb: str = ""
    target: tuple[float, float, float] | None = None
    tip: tuple[float, float, float] | None = None
    finding: Finding | None = None


def _look(resting: Situation, one: Asked) -> _Look:
    """How a person misses a requirement."""
    check = one.requirement.check
    if check == "reach":
        return _reaching(resting, one)
    situation = with_hands(resting)
    if check in ("clearance", "contact"):
        return _nearest(situation, one)
    if check == "self_contact":
        return _in_oneself(situation, one)
    if check in ("eye_height", "view_over"):
        return _eyes(situation)
    if one.requirement.of_sight:
        found = _measured(situation, one)
        at = None if found is None else found.point
        return _Look(situation.poses, "eyes", at, xyz(eyes_of(situation)[0]), found)
    if check in ("pedals", "preferred_seat"):
        return _foot(situation, worse_foot(situation))
    return _Look(situation.poses)


def _nearest(situation: Situation, one: Asked) -> _Look:
    """The nearest points of a clearance."""
    body = situation.body
    placed = situation.placed
    found = nearest_pair(situation, one.criterion)
    sphere = int(found.sphere[0, 0])
    if sphere < 0:
        return _Look(situation.poses)
    segment = body.segment_names[int(body.sphere_segment[sphere])]
    return _Look(situation.poses, segment, xyz(found.point[0, 0]), xyz(placed.centres[0, sphere]))


def _in_oneself(situation: Situation, one: Asked) -> _Look:
    """The two segments of a body that are deepest in one another, or nearest to that: where the surface
    of the one is that the other meets."""
    worst = min(
        findings_of([situation], one.criterion), key=lambda found: found.margin, default=None
    )
    if worst is None or worst.point is None:
        return _Look(situation.poses)
    segment = situation.body.sphere_segment[worst.sphere]
    return _Look(situation.poses, situation.body.segment_names[int(segment)], worst.point)


def _eyes(situation: Situation) -> _Look:
    """The eyes and the point that they are meant for."""
    if situation.eyes is None or situation.seated is None:
        return _Look(situation.poses)
    point = situation.environment.points[situation.eyes]
    return _Look(situation.poses, "eyes", point, xyz(situation.seated.eye[0]))


def _foot(situation: Situation, foot: str) -> _Look:
    """A foot and its pedal; "" for none."""
    if not foot:
        return _Look(situation.poses)
    name = situation.work.held[foot]
    (control,) = (one for one in situation.environment.controls if one.name == name)
    tip = _tip(situation.placed, limb(situation.body, foot, grip="ball"))
    return _Look(situation.poses, foot, xyz(situation.where([control])[0, 0]), xyz(tip))


def _reaching(situation: Situation, one: Asked) -> _Look:
    """In the attempt, by the limb that comes nearest of those that are asked. The obstacles stand as in the study,
    those that go along with the seat aside by its travel: an environment of its own for each person
    would be indexed anew."""
    assert one.control is not None
    foot = one.control.for_feet
    place = situation.place
    room = without_seat(place) if foot and place.seat is not None else place.environment
    grip, zone = ("ball", 1) if foot else (one.control.grip, one.requirement.zone)
    tries = []
    names = limbs_asked(place, situation.work, one.control, one.criterion.hand)
    names = limbs_there(situation.body, names)
    if foot_seated(situation, one.control, names):
        return _foot(with_hands(situation), names[0])
    for name in names:
        found = reach(
            situation.body,
            situation.taken.poses,
            situation.where([one.control]),
            limb=limb(situation.body, name, grip=grip, zone=zone),
            environment=room,
            moving_parts=place.moving_parts,
            displacement=situation.displacement,
        )
        tries.append((float(found.miss[0, 0] + found.overlap[0, 0]), name, found))
    _, name, best = min(tries, key=lambda entry: entry[:2])
    body = place_body(situation.body, best.poses)
    tip = _tip(body, limb(situation.body, name, grip=grip, zone=zone))
    return _Look(best.poses, name, xyz(best.target[0, 0]), xyz(tip))


def _tip(placed: Placed, chain: Limb) -> Floats:
    """(3,) [m] where the end of a limb is."""
    world = placed.world_from_segment[0, chain.end]
    point: Floats = world[:, :3] @ chain.tip[0] + world[:, 3]
    return point
