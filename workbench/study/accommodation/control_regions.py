"""Find where a control may be so that a share of a population reaches it.

Places are a lattice about the one that the control has. Everybody is asked everything that the study
asks, as by a run, and sits or stands where that finds him. Who may step within an area asks for each
place from a lattice of the area too, from wherever he is in no part with more than he is there.

1. Places inside solid parts are left out, but for the part that the control is on; who sits before
   a place with the backrest between, or has a leg or the trunk there, does not reach it.
2. Everybody is asked about every place without obstacles (see `reach_map`).
3. Where enough people reach it so, they are asked again with obstacles: all parts but those that go
   along with the control. Who finds no way about them from the posture that reaches without them
   counts as missing it, so the share is no less than what is said.
4. Where no place will do, the lattice is made twice as large and twice as coarse, until it is as
   large as the reach of arms. About the nearest place that will do it is made finer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, fields, replace
from itertools import product

import numpy as np

from workbench.body.forward import place as place_body
from workbench.body.scaling.scale import morph_to
from workbench.contact.collide import contacts
from workbench.errors import InputError, UsageError, one_of
from workbench.geometry.polygon import winding_number
from workbench.model.accommodation import SHARE_TOLERANCE, met_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.control_region import ControlRegion
from workbench.model.environment import Control, Environment
from workbench.model.joint_angles import join_poses
from workbench.model.poses import Poses
from workbench.model.study import Study
from workbench.model.surroundings import moved_along, parts_along
from workbench.model.workplace import Workplace
from workbench.posture.reaching.limbs import FEET, HANDS, limbs_there
from workbench.posture.seating.seating import leftward, seat_planes
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.checkpoints import (
    Chunk,
    PopulationQuestion,
    joined_chunks,
    result_chunks,
)
from workbench.study.accommodation.gains import ARMS
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.accommodation.shares import share_single
from workbench.study.accommodation.worst_cases import found_situations
from workbench.study.checks.reach import limbs_asked
from workbench.study.executors import Shared, completed
from workbench.study.passes import ASKING, BODIES, Passes
from workbench.study.people import Present
from workbench.study.reach_map import COARSE, ReachObstacles, farthest_point_order, who_reaches
from workbench.study.situation import without_parts

__all__ = ["MOST_WITHIN", "SPACING", "WITHIN", "check_region", "control_region"]

WITHIN = 0.3
SPACING = 0.04
"""How far [m] from today's place others are looked at at first, and how far these are apart."""
MOST_WITHIN = 1.2
"""How far [m] they are looked at at last."""
MOST_PLACES = 60_000
"""Places of a lattice at most."""
FINER = 4
"""How many times finer the lattice is about the nearest place that will do."""
TOGETHER = 8
"""People who are one piece of work."""
FIRST = 4
"""The part of the people, the smallest, who are asked first: one in so many."""
LEGS = ("LUL", "LLL", "LF", "RUL", "RLL", "RF")
"""Segments of the limbs that reach."""
STEP = 0.2
"""How far [m] the places of an area to stand in are apart at most; its ends are among them."""
HIDING = 0.05
"""[m] How much wider and higher than the backrest what it hides is."""

Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class _Asked:
    """How a control is asked for: by which limbs, in which harness zone, past which obstacles."""

    control: Control
    hand: str
    zone: int
    environment: Environment
    moving_parts: tuple[str, ...]

    @property
    def limbs(self) -> tuple[str, ...]:
        """The limbs that may reach it."""
        both = FEET if self.control.for_feet else HANDS
        return tuple(limb for limb in both if self.hand in ("either", limb.split()[0]))

    @property
    def grip(self) -> str:
        """What of the limb gets there."""
        return "ball" if self.control.for_feet else self.control.grip


@dataclass(frozen=True, eq=False)
class _Sitting:
    """B people where they sit, or stand in one place of their area: rows of a body and of poses, how
    far (B, 3) [m] the seat of each is from where it is at rest, how far (B, 2) [m] each has stepped,
    and (B,) who may be there."""

    body: Body
    poses: Poses
    shift: Floats
    stepped: Floats
    there: Bools

    def __len__(self) -> int:
        return len(self.body)

    def rows(self, some: Ints) -> _Sitting:
        """People at indices."""
        return _Sitting(
            self.body[some],
            self.poses.rows(some),
            self.shift[some],
            self.stepped[some],
            self.there[some],
        )


@dataclass(frozen=True, eq=False)
class _Places:
    """Places (M, 3) [m], the order in which they are asked about, (B, M) who is known to miss which
    of them, and (M,) of which the share is wanted however small it is. coarse: as of `who_reaches`."""

    points: Floats
    order: tuple[Ints, Floats]
    hopeless: Bools
    whole: Bools
    coarse: float

    def of(self, people: Ints) -> _Places:
        """The same for people at indices."""
        return replace(self, hopeless=self.hopeless[people])


@dataclass(frozen=True, eq=False)
class _Found:
    """What is known of M places: as of `ControlRegion`."""

    offset: Floats
    free: Floats
    share: Floats
    inside: Ints
    behind: Bools

    def enough(self, wanted: float) -> Bools:
        """(M,) where the wanted share reaches it clear of obstacles."""
        return np.asarray(np.nan_to_num(self.share, nan=-1.0) >= wanted - SHARE_TOLERANCE)


@dataclass(frozen=True, eq=False)
class _Search:
    """What is looked for, and where people are."""

    place: Workplace
    asked: _Asked
    sitting: _Sitting
    stepped: tuple[_Sitting, ...]
    """Elsewhere in the area that they may step in."""
    order: Ints
    """(B,) the numbers of the people, the smallest first."""
    weight: Floats
    wanted: float
    say: Say
    executor: Executor | None


def control_region(
    study: Study,
    control: str,
    *,
    share: float = 0.95,
    within: float = WITHIN,
    spacing: float = SPACING,
    beside: Present | None = None,
    say: Say = lambda text: None,
    executor: Executor | None = None,
) -> ControlRegion:
    """Find the places about a control's own at which a share of a study's population reaches it.

    Parameters
    ----------
    study
        With a population in one of its roles.
    control
        The name of the control.
    share
        Above 0, up to 1.
    within, spacing
        [m] how far from its place others are looked at, and how far they are apart. Both are
        doubled while no place is found.
    beside
        Those who are there too.
    say
        Called with words on how far it is.
    executor
        Does the work: processes of this machine if None.

    Returns
    -------
    ControlRegion

    Raises
    ------
    InputError
        Where the study has no population, or no such control.
    UsageError
        For numbers that are out of range.
    """
    check_region(study, control, share=share, within=within, spacing=spacing)
    question = population_question(study, beside)
    asked, case = _as_asked(question, control)
    role = study.crowd
    assert role is not None
    passes = Passes(say, [BODIES, ASKING])
    bodies = fit_population(
        morph_to(role.body, role.detail),
        question.people,
        role.clothes,
        sits=role.seat is not None,
        executor=executor,
        progress=passes.begin(BODIES, "fitting bodies"),
    )
    asking = passes.begin(ASKING, "asking everybody")
    chunks = result_chunks(question, bodies, keep=None, tell=asking, executor=executor)
    answer = joined_chunks(chunks)
    sitting = _sitting(question, bodies, answer, case)
    search = _Search(
        place=question.place,
        asked=asked,
        sitting=sitting,
        stepped=tuple(_stepped(question.place, sitting)),
        order=_by_stature(question),
        weight=question.people.weight,
        wanted=share,
        say=say,
        executor=executor,
    )
    found = _places(search, _lattice(within, spacing))
    while not found.enough(share).any() and 2 * within <= MOST_WITHIN + 1e-9:
        within *= 2
        spacing *= 2
        found = _places(search, _lattice(within, spacing))
    if not found.enough(share).any():
        found = _places(search, found.offset, whole=True)
    found = _refined(search, found, spacing)
    mine = [r for r, one in enumerate(question.asked) if one.control == asked.control]
    single = share_single(met_of(answer.margin), search.weight)
    one = search.sitting.rows(search.order[[len(search.order) // 2]])
    environment = question.place.environment
    return ControlRegion(
        control=asked.control,
        hand=asked.hand,
        zone=asked.zone,
        people=len(search.sitting),
        wanted=share,
        spacing=spacing,
        within=within,
        axes=_axes(question.place),
        offset=found.offset,
        free=found.free,
        share=found.share,
        inside=found.inside,
        behind=found.behind,
        solids=_solids(asked.environment),
        placed=place_body(one.body, one.poses),
        environment=moved_along(environment, question.place.moving_parts, one.shift[0]),
        standing=question.place.stand is not None,
        steps=bool(search.stepped),
        together=float(single[mine[0]]) if mine else math.nan,
    )


def check_region(
    study: Study, control: str, *, share: float, within: float, spacing: float
) -> None:
    """Raise what `control_region` does for a study, a control or numbers that it cannot answer."""
    if study.crowd is None:
        raise InputError(
            f"{study.name}: the share of a population is asked for; give a role a 'population'"
        )
    controls = [one.name for one in study.environment.controls]
    if control not in controls:
        raise InputError(
            f"{study.name}: environment {study.environment.name} has no control {control!r}; "
            f"{one_of(control, controls)}"
        )
    if not 0 < share <= 1:
        raise UsageError(f"share: expected above 0, up to 100 %, got {100 * share:g} %")
    if not 0 < spacing <= within <= MOST_WITHIN:
        raise UsageError(
            f"within and spacing: expected 0 < spacing <= within <= {1000 * MOST_WITHIN:g} mm, got "
            f"{1000 * within:g} and {1000 * spacing:g} mm"
        )
    if (2 * within / spacing) ** 3 > MOST_PLACES:
        least = 2 * within / MOST_PLACES ** (1 / 3)
        raise UsageError(
            f"spacing: {1000 * spacing:g} mm makes too many places within {1000 * within:g} mm; "
            f"{1000 * least:.1f} mm is possible"
        )


def _as_asked(question: PopulationQuestion, name: str) -> tuple[_Asked, int]:
    """How the first criterion asks for a control, and in which case; in its own zone, in
    the first case, where none does."""
    place = question.place
    control = next(one for one in place.environment.controls if one.name == name)
    one = next(
        (one for one in question.asked if one.control is not None and one.control.name == name),
        None,
    )
    gone = parts_along(place.environment, (name,))
    if control.for_feet:
        gone = (*gone, *place.moving_parts)  # the thighs press the cushion down
    case = 0 if one is None else one.case
    hand = None if one is None else one.criterion.hand
    sides = [limb.split()[0] for limb in limbs_asked(place, place.cases[case], control, hand)]
    asked = _Asked(
        control=control,
        hand="either" if len(sides) > 1 else sides[0],
        zone=control.zone if one is None else one.requirement.zone,
        environment=without_parts(place.environment, gone),
        moving_parts=place.moving_parts,
    )
    return asked, case


def _sitting(
    question: PopulationQuestion, bodies: PopulationBodies, found: Chunk, case: int
) -> _Sitting:
    """Everybody in a case where they do everything that is asked."""
    everybody = np.arange(len(bodies))
    groups = list(found_situations(question, bodies, everybody, found))
    back = np.argsort(np.concatenate([rows for rows, _ in groups]))
    there = [situations[case] for _, situations in groups]
    poses = join_poses([one.taken.poses for one in there]).rows(back)
    shift = np.concatenate([one.displacement for one in there])[back]
    stepped = np.concatenate([one.taken.stepped for one in there])[back]
    present = np.ones(len(bodies), dtype=np.bool_)
    return _Sitting(bodies[everybody], poses, shift, stepped, present)


def _stepped(place: Workplace, standing: _Sitting) -> Iterator[_Sitting]:
    """The same people at the other places of the area that they may step in."""
    if place.stand is None or not place.stand.steps:
        return
    before = _depths(standing, place.environment)
    ways = []
    for low, high in (place.stand.forward, place.stand.left):
        ways.append(np.linspace(low, high, 1 + math.ceil((high - low) / STEP - 1e-9)))
    for at in product(*ways):
        world = standing.poses.world_from_reference.copy()
        world[:, :, 3] += (np.array(at) - standing.stepped) @ _axes(place)[:2]
        there = replace(standing, poses=replace(standing.poses, world_from_reference=world))
        deeper = _depths(there, place.environment) > np.maximum(before, 0.0)
        yield replace(there, there=np.logical_not(deeper.any(axis=1)))


def _depths(people: _Sitting, environment: Environment) -> Floats:
    """(B, K) [m] how much deeper than is allowed people are in parts."""
    met = contacts(place_body(people.body, people.poses), environment)
    excess = np.zeros((len(people), len(environment.parts)))
    np.maximum.at(excess, (met.pose, met.part), met.excess)
    return excess


def _by_stature(question: PopulationQuestion) -> Ints:
    """(B,) the numbers of the people, the smallest first; as they are where that is not known."""
    people = question.people
    if "stature" not in people.names:
        return np.arange(len(people))
    return np.argsort(people.column("stature"), kind="stable")


def _places(
    search: _Search, offset: Floats, *, whole: bool = False, coarse: float = COARSE
) -> _Found:
    """Who reaches a control at places (M, 3) [m] from its own. whole: the share is wanted of all of
    them, else of today's and of those that enough people reach."""
    points = np.array(search.asked.control.at) + offset @ _axes(search.place)
    inside = _inside(search.asked, points)
    hidden = _behind_backrest(search.place, search.sitting.shift, points)
    behind = np.asarray(hidden.all(axis=0))
    hidden |= inside >= 0
    kept = np.asarray((np.linalg.norm(offset, axis=1) < 1e-9) | whole)
    places = _Places(points, farthest_point_order(points), hidden, kept, coarse)
    free = _reached(search, places, obstacles=False)
    share = search.weight @ free / search.weight.sum()
    clear = np.full(len(points), np.nan)
    some = np.flatnonzero((share >= search.wanted - SHARE_TOLERANCE) | kept)
    if len(some):
        order = farthest_point_order(points[some])
        places = _Places(points[some], order, ~free[:, some], kept[some], coarse)
        reached = _reached(search, places, obstacles=True)
        clear[some] = search.weight @ reached / search.weight.sum()
    return _Found(offset, share, clear, inside, behind)


def _refined(search: _Search, found: _Found, spacing: float) -> _Found:
    """With places of a finer lattice about the nearest one that will do, if these are nearer."""
    enough = np.flatnonzero(found.enough(search.wanted))
    if not len(enough):
        return found
    far = np.linalg.norm(found.offset[enough], axis=1)
    nearest = enough[np.argmin(far)]
    around = _lattice(spacing, spacing / FINER)
    some = found.offset[nearest] + around[np.linalg.norm(around, axis=1) > 0]
    some = some[np.linalg.norm(some, axis=1) < far.min() - 1e-9]
    if not len(some):
        return found
    more = _places(search, some, coarse=0.0)
    return _Found(
        *(
            np.concatenate([getattr(one, field.name) for one in (found, more)])
            for field in fields(_Found)
        )
    )


def _axes(place: Workplace) -> Floats:
    """(3, 3) unit vectors forward, to the left and up, as people face."""
    left = leftward(place)
    return np.array([[left[1], -left[0], 0.0], left, [0.0, 0.0, 1.0]])


def _lattice(within: float, spacing: float) -> Floats:
    """(M, 3) [m] a cubic lattice in a ball about 0, which is one of its places."""
    count = int(within / spacing + 1e-9)
    steps = np.arange(-count, count + 1) * spacing
    cube = np.array(list(product(steps, steps, steps)))
    ball: Floats = cube[np.linalg.norm(cube, axis=1) <= within + 1e-9]
    return ball


def _solids(environment: Environment) -> tuple[str, ...]:
    """The names of solid parts."""
    rows = np.flatnonzero(environment.solid & ~environment.hidden).tolist()
    return tuple(environment.parts[row] for row in rows)


def _inside(asked: _Asked, points: Floats) -> Ints:
    """(M,) the number of the solid part that each point is inside of, -1 of none. The part that the
    control is on is none: a point on its surface would be."""
    environment = asked.environment
    found = np.full(len(points), -1)
    for number, name in enumerate(_solids(environment)):
        if name in asked.control.own_parts:
            continue
        corners = environment.triangle_corners(environment.part_index(name))
        low = corners.min(axis=(0, 1))
        high = corners.max(axis=(0, 1))
        near = (points >= low).all(axis=1) & (points <= high).all(axis=1) & (found < 0)
        for k in np.flatnonzero(near).tolist():
            if abs(winding_number(*points[k].tolist(), corners, 0, len(corners))) > 0.5:
                found[k] = number
    return found


def _behind_backrest(place: Workplace, shift: Floats, points: Floats) -> Bools:
    """(B, M) whether points are behind the backrest of people whose seats are displaced by shift
    (B, 3): behind its plane, and no wider and higher than it is."""
    seat = place.own_seat
    hidden = np.zeros((len(shift), len(points)), dtype=np.bool_)
    if seat is None or not seat.back.part:
        return hidden
    _, ahead, left = seat_planes(seat)
    up = np.cross(ahead, left)
    environment = place.environment
    corners = environment.triangle_corners(environment.part_index(seat.back.part)).reshape(-1, 3)
    wide = np.abs((corners - seat.srp) @ left).max() + HIDING
    high = ((corners - seat.srp) @ up).max() + HIDING
    for person, by in enumerate(shift):
        away = points - np.array(seat.srp) - by
        across = np.abs(away @ left) <= wide
        hidden[person] = (away @ ahead < 0) & across & (away @ up <= high)
    return hidden


def _in_own_body(sitting: _Sitting, asked: _Asked, points: Floats) -> Bools:
    """(B, M) whether points are inside people who would reach for them: their spheres as they sit,
    without the limbs that reach."""
    body = sitting.body
    limbs = LEGS if asked.control.for_feet else ARMS
    still = [k for k, name in enumerate(body.segments) if name not in limbs]
    spheres = np.flatnonzero(np.isin(body.sphere_segment, still))
    centres = place_body(body, sitting.poses).centres[:, spheres]
    found = np.zeros((len(sitting), len(points)), dtype=np.bool_)
    for person, centre in enumerate(centres):
        away = np.sum((points[:, None] - centre) ** 2, axis=2)
        found[person] = (away < body.radius[person, spheres] ** 2).any(axis=1)
    return found


def _reached(search: _Search, places: _Places, *, obstacles: bool) -> Bools:
    """(B, M) who reaches which places, of those that are not known to be missed.

    The smallest people are asked first. Places that too many of them miss are asked of nobody else:
    the others count as reaching them.
    """
    first, others = np.split(search.order, [max(1, len(search.sitting) // FIRST)])
    reached = np.ones(places.hopeless.shape, dtype=np.bool_)
    reached[first] = _reached_in_parts(search, places.of(first), first, obstacles)
    if not len(others):
        return reached
    lost = search.weight @ ~reached / search.weight.sum()
    done = (lost > 1.0 - search.wanted + SHARE_TOLERANCE) & ~places.whole
    left = replace(places, hopeless=places.hopeless | done)
    reached[others] = _reached_in_parts(search, left.of(others), others, obstacles) | done
    return reached


def _reached_in_parts(search: _Search, places: _Places, rows: Ints, obstacles: bool) -> Bools:
    """(P, M) which places some people (P,) reach, worked on by all processes."""
    parts = np.array_split(np.arange(len(rows)), max(1, -(-len(rows) // TOGETHER)))
    shared = Shared(search.asked)
    reached = np.zeros(places.hopeless.shape, dtype=np.bool_)
    jobs = completed(
        _reached_by_some,
        range(len(parts)),
        lambda n: (
            shared,
            [one.rows(rows[parts[n]]) for one in (search.sitting, *search.stepped)],
            places.of(parts[n]),
            obstacles,
        ),
        executor=search.executor,
    )
    how = " past obstacles" if obstacles else ""
    with closing(jobs):
        for done, (number, found) in enumerate(jobs, 1):
            reached[parts[number]] = found
            share = 100 * done // len(parts)
            search.say(f"{len(places.points):,} places, {len(rows)} people{how}: {share} %")
    return reached


def _reached_by_some(
    asked: Shared[_Asked], everywhere: Sequence[_Sitting], places: _Places, obstacles: bool
) -> Bools:
    """(B, M) which places some people reach with any of the limbs that may, from anywhere that they
    may be."""
    reached = np.zeros(places.hopeless.shape, dtype=np.bool_)
    for sitting in everywhere:
        left = np.flatnonzero(~(reached | places.hopeless).all(axis=0))
        if not len(left):
            break
        hopeless = places.hopeless | ~sitting.there[:, None]
        hopeless[:, left] |= _in_own_body(sitting, asked.value, places.points[left])
        reached = _reached_from(asked.value, sitting, places, hopeless, reached, obstacles)
    return reached


def _reached_from(
    asked: _Asked,
    sitting: _Sitting,
    places: _Places,
    hopeless: Bools,
    reached: Bools,
    obstacles: bool,
) -> Bools:
    """(B, M) which places people reach, those that they reach from elsewhere among them."""
    around = ReachObstacles(asked.environment, asked.moving_parts, sitting.shift)
    for name in limbs_there(sitting.body, asked.limbs):
        reached = who_reaches(
            sitting.body,
            sitting.poses,
            places.points,
            name,
            grip=asked.grip,
            zone=asked.zone,
            settled=reached,
            hopeless=hopeless,
            obstacles=around if obstacles else None,
            order=places.order,
            coarse=places.coarse,
        )
    return reached
