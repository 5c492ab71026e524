"""The population of an open study: who fits, reaches and clears.

People are settled as a run of the study does it: each in the position of the seat, and in the
setting, that suits best. That takes seconds, so while something is dragged they are followed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.body.scaling.scale import morph_to
from workbench.model.accommodation import met_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.population import Population
from workbench.model.poses import Poses
from workbench.model.surroundings import control_moves, part_moves
from workbench.model.workplace import Workplace
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.checkpoints import PopulationQuestion
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    arranged_study,
)
from workbench.study.checks.margins import Asked
from workbench.study.checks.reach import ReachMemory
from workbench.study.passes import BODIES, Passes
from workbench.study.people import present_people
from workbench.study.positions import (
    Before,
    FittedBody,
    comfortable_situations,
    fitted_positions,
    found_places,
)
from workbench.study.settings import nominal_setting
from workbench.study.situation import (
    Occupants,
    Situation,
)
from workbench.study.workplaces import population_of

__all__ = [
    "AT_HAND",
    "BenchPopulation",
    "HandsPlaced",
    "Moved",
    "Posed",
    "Settled",
    "Trail",
    "crowd_question",
    "held_controls",
    "in_columns",
    "met_all",
    "moved_since",
    "open_crowd",
    "same_columns",
    "settled",
]

AT_HAND = 256
"""People who are followed while something is dragged."""
Places = tuple[tuple[Ints, list[Situation]], ...]


@dataclass(frozen=True, eq=False)
class BenchPopulation:
    """The people of an open study.

    Parameters
    ----------
    row
        The index of their role.
    people, bodies
        All of them, and their bodies.
    order
        (P,) the rows of all people: those at hand first, spread evenly over them.
    """

    row: int
    people: Population
    bodies: PopulationBodies
    order: Ints

    @property
    def at_hand(self) -> int:
        """How many are followed."""
        return min(len(self.order), AT_HAND)

    def occupants(self, rows: Ints) -> Occupants:
        """Some people with their bodies."""
        return Occupants(self.bodies[rows], self.people, rows)


@dataclass(frozen=True, eq=False)
class Posed:
    """People where they sit in a state, and their margins (B, R) [m] there, NaN where a requirement
    does not apply or is not known; waiting (B, R): those that wait for a hand to be searched for."""

    content: tuple[object, ...]
    situations: Sequence[Situation]
    margin: Floats
    waiting: Bools


@dataclass(frozen=True, eq=False)
class HandsPlaced:
    """People with their hands on their controls; `about` says in which case and where these are."""

    about: tuple[object, ...]
    situation: Situation


@dataclass(eq=False)
class Trail:
    """What was found of people while they were followed, so that it serves the next step.

    Parameters
    ----------
    hands
        With their hands on their controls, while some parts are no obstacles.
    reaches
        What all of them reached where they sat last.
    posed
        Where they sat last while the seat was dragged.
    """

    hands: HandsPlaced | None = None
    reaches: ReachMemory = field(default_factory=dict)
    posed: Posed | None = None


@dataclass(frozen=True, eq=False)
class Settled:
    """People as a run of a state finds them.

    Parameters
    ----------
    arrangement, question
        The state, and what is asked of everybody in it.
    rows
        (B,) of the people in their population.
    who
        The people; None of those who are not followed.
    comfortable
        (B,) their postures in each case, in the comfortable position and with the hands at rest.
    fitted
        In the positions that suit them best, with their margins there.
    places
        The people in those positions, case by case: by setting, with their indices.
    trail
        What was found of them last while they were followed.
    """

    arrangement: Arrangement
    question: PopulationQuestion
    rows: Ints
    who: Occupants | None
    comfortable: tuple[Poses, ...]
    fitted: FittedBody
    places: Places
    trail: Trail = field(default_factory=Trail)

    @property
    def margin(self) -> Floats:
        """(B, R) [m]."""
        return self.fitted.tried.margin


def open_crowd(
    opened: OpenStudy, say: Callable[[str], None] = lambda text: None
) -> BenchPopulation | None:
    """Make the bodies of an open study's population, or read them from the cache.

    Parameters
    ----------
    say
        Called with words on how far that is.

    Returns
    -------
    Crowd or None
        None where no population takes a role.

    Raises
    ------
    InputError
        If there is no body for somebody's measures.
    """
    if opened.crowd is None:
        return None
    row = opened.crowd
    role = opened.study.roles[row]
    people = population_of(replace(role, population=opened.population))
    body = morph_to(role.body, role.detail)
    fitting = Passes(say, [BODIES]).begin(BODIES, "fitting bodies")
    with ThreadPoolExecutor(1) as pool:  # no forks: other threads of this process are at work
        bodies = fit_population(
            body, people, role.clothes, sits=role.seat is not None, executor=pool, progress=fitting
        )
    count = len(people)
    first = np.unique(np.linspace(0, count - 1, min(count, AT_HAND)).round().astype(np.int64))
    rest = np.setdiff1d(np.arange(count), first)
    return BenchPopulation(row, people, bodies, np.concatenate([first, rest]))


def crowd_question(
    opened: OpenStudy, crowd: BenchPopulation, arrangement: Arrangement
) -> PopulationQuestion:
    """What a run of a state asks of everybody, without the sets that only a report shows.

    Raises
    ------
    InputError
        Where no criterion asks for anything.
    """
    study = arranged_study(opened, arrangement)
    roles = list(study.roles)
    roles[crowd.row] = replace(roles[crowd.row], population=crowd.people)
    study = replace(study, roles=tuple(roles))
    beside = present_people(study) if len(roles) > 1 else None
    question = population_question(study, beside)
    none = np.zeros((len(question.asked), 0), dtype=np.bool_)
    return replace(question, members=none, bounded=False)


def settled(
    crowd: BenchPopulation,
    question: PopulationQuestion,
    arrangement: Arrangement,
    rows: Ints,
    before: Settled | None = None,
    *,
    proceed: Callable[[], None] = lambda: None,
) -> Settled:
    """Put people where a run puts them, and measure what they have to spare.

    Parameters
    ----------
    rows
        (B,) of the people.
    before
        The same people in another state: of who met everything in the comfortable position, only
        what has changed since is asked. What they reached goes along.
    proceed
        As of `fitted_positions`.
    """
    place = question.place
    who = crowd.occupants(rows)
    situations = comfortable_situations(place, who)
    known = None if before is None else _before(before, question, arrangement)
    fitted = fitted_positions(
        place, question.asked, question.members, who, situations, known, proceed=proceed
    )
    places = found_places(place, who, situations, fitted)
    comfortable = tuple(situation.taken.poses for situation in situations)
    found = Settled(arrangement, question, rows, who, comfortable, fitted, tuple(places))
    return found if before is None else replace(found, trail=Trail(reaches=before.trail.reaches))


def _before(
    before: Settled, question: PopulationQuestion, arrangement: Arrangement
) -> Before | None:
    """How people came out in another state, where only the reaches of some controls can differ."""
    old = before.arrangement
    if old.people != arrangement.people or old.zones != arrangement.zones:
        return None
    if len(arrangement.people) > 1:
        return None
    moved = moved_since(before, arrangement)
    if moved.parts or moved.controls & held_controls(question.place):
        return None
    same = same_columns(before.question.asked, question.asked)
    borne = [
        r
        for r, one in enumerate(question.asked)
        if same[r] < 0 or one.requirement.target in moved.controls
    ]
    fitted = before.fitted
    there = (fitted.tried.seat == fitted.comfortable).all(axis=1)
    there &= (fitted.setting == nominal_setting(before.question.place)).all(axis=1)
    fits = met_of(before.margin).all(axis=1) & there
    return Before(
        margin=in_columns(before.margin, same),
        seat=fitted.tried.seat,
        nominal=there,
        fits=fits,
        known=np.zeros_like(fits),
        again=np.zeros((len(fits), 0, fitted.setting.shape[1] + 2)),
        travel=np.zeros((2, 2)),
        borne=tuple(borne),
    )


def same_columns(old: Sequence[Asked], new: Sequence[Asked]) -> Ints:
    """(R,) the number among some requirements of each of others, -1 of those that are not there."""

    def about(one: Asked) -> tuple[object, ...]:
        control = one.control.name if one.control is not None else ""
        return one.criterion.name, one.requirement.name, control, one.case

    at = {about(one): r for r, one in enumerate(old)}
    found = np.array([at.get(about(one), -1) for one in new], dtype=np.int64)
    for r in np.flatnonzero(found >= 0).tolist():
        limits = [
            (one.criterion.at_least, one.criterion.at_most) for one in (old[found[r]], new[r])
        ]
        if limits[0] != limits[1]:
            found[r] = -1
    return found


def in_columns(values: Floats, columns: Ints) -> Floats:
    """(B, R) the columns of values (B, Q) in another order, NaN for those numbered -1."""
    return np.where(columns >= 0, values[:, columns], np.nan)


@dataclass(frozen=True)
class Moved:
    """The parts, by index, and the controls that stand elsewhere than in another state."""

    parts: frozenset[int]
    controls: frozenset[str]


def moved_since(before: Settled, arrangement: Arrangement) -> Moved:
    """What stands elsewhere in a state than people were settled in."""
    environment = before.question.place.environment
    old = before.arrangement.moves
    parts = part_moves(environment, arrangement.moves) != part_moves(environment, old)
    controls = control_moves(environment, arrangement.moves) != control_moves(environment, old)
    rows = np.flatnonzero(controls.any(axis=1))
    return Moved(
        frozenset(np.flatnonzero(parts.any(axis=1)).tolist()),
        frozenset(environment.controls[k].name for k in rows),
    )


def held_controls(place: Workplace) -> frozenset[str]:
    """The controls that hands and feet hold in some case."""
    return frozenset(name for case in place.cases for name in case.held.values())


def met_all(margin: Floats, columns: Bools | None = None) -> Bools:
    """(B,) who meets all requirements, or all of some (R,)."""
    some = margin if columns is None else margin[:, columns]
    return np.asarray(met_of(some).all(axis=1), dtype=np.bool_)
