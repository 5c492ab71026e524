"""A study that is open for changes, and what its people do in it.

An `Arrangement` is the whole state: who sits where and in which posture, case by case. It is frozen
and shares with others what is the same in both, so that a history of states is a list of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.study.settings import SeatedRole, adjusts_of
from workbench.model.accommodation import MapTask
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment, Seat
from workbench.model.joint_angles import angles_of
from workbench.model.person import Encumbrance, Size
from workbench.model.population import Population
from workbench.model.poses import Poses
from workbench.model.study import Action, Case, PeopleDrawn, PredictedPosture, Role, Study
from workbench.model.surroundings import Move, Surroundings, adjusted, displaced, part_moves
from workbench.study.situation import Occupants
from workbench.study.workplaces import drawn_number, occupant

__all__ = [
    "Arrangement",
    "Figure",
    "OpenStudy",
    "PersonState",
    "Settings",
    "arranged_environment",
    "arranged_parts",
    "arranged_study",
    "environment_at",
    "figure_of",
    "given_angles",
    "open_study",
]


Settings = tuple[tuple[str, float], ...]
"""Where adjustments are set [m or rad], by name."""


@dataclass(frozen=True, eq=False)
class Figure:
    """A person's size and clothes, and the body that they come to.

    Parameters
    ----------
    size, clothes
        None and () for the body as its file has it.
    who
        The person, with the body at its size and dressed.
    notes
        What is improbable about the size.
    """

    size: Size | None
    clothes: tuple[Encumbrance, ...]
    who: Occupants
    notes: tuple[str, ...] = ()

    @property
    def body(self) -> Body:
        """One row."""
        return self.who.body


@dataclass(frozen=True, eq=False)
class PersonState:
    """How large a person is, where the seat stands, and what the person does.

    Parameters
    ----------
    role
        The name of the role.
    figure
        The size and clothes.
    free
        Whether the seat goes where the person wants it; then `forward` and `up` mean nothing.
    forward, up
        [m] the position of the seat.
    actions
        What is done in each case that is a posture.
    """

    role: str
    figure: Figure
    free: bool
    forward: float
    up: float
    actions: tuple[Action, ...]

    def doing(self, case: int, action: Action) -> PersonState:
        """The same with another action in a case."""
        actions = list(self.actions)
        actions[case] = action
        return replace(self, actions=tuple(actions))


@dataclass(frozen=True, eq=False, repr=False)
class Arrangement:
    """The state of an open study.

    Parameters
    ----------
    people
        In the order of the roles.
    case
        The index of the case that is looked at, among those that are postures.
    moves
        The parts and controls that stand elsewhere than the environment's file has them.
    zones
        The harness zone that each criterion asks for, None for that of each control.
    added
        The criteria that were added to those of the file.
    settings
        The adjustments that are set, by name and in their order, each with where [m or rad].
    """

    people: tuple[PersonState, ...]
    case: int = 0
    moves: tuple[Move, ...] = ()
    zones: tuple[int | None, ...] = ()
    added: tuple[Criterion, ...] = ()
    settings: Settings = ()

    def __repr__(self) -> str:
        return f"Arrangement({', '.join(one.role for one in self.people)}; case {self.case})"

    @property
    def content(self) -> tuple[object, ...]:
        """What is saved of it: two states with the same content are the same study."""
        return self.people, self.moves, self.zones, self.added, self.settings

    def row(self, role: str) -> int:
        """The index of a role; InputError with those that there are."""
        names = [person.role for person in self.people]
        if role not in names:
            raise InputError(f"nobody is called {role!r}; valid: {', '.join(names)}")
        return names.index(role)

    def body(self, row: int) -> Body:
        """The body of a person, at its size and dressed."""
        return self.people[row].figure.body

    @property
    def occupants(self) -> dict[str, tuple[Occupants, list[str]]]:
        """Who takes each role, and what is improbable about the size."""
        return {one.role: (one.figure.who, list(one.figure.notes)) for one in self.people}

    def with_person(self, row: int, person: PersonState) -> Arrangement:
        """The same with one person changed."""
        people = list(self.people)
        people[row] = person
        return replace(self, people=tuple(people))


@dataclass(frozen=True, eq=False, repr=False)
class OpenStudy:
    """A study that is open for changes.

    Parameters
    ----------
    study
        With one person in each role, without motions; without roles where every case is a motion.
    figures
        The size and clothes of each role as the file has them.
    case_rows
        The number of each case in the file.
    notes
        What is shown otherwise than the study says.
    crowd, population
        The index of the role that a population takes, and the population; None where none does.
    shown_size
        Of a role that several sizes take one at a time, the name of the one that is shown.
    maps
        The reach maps that are asked of the population.
    moving
        The study with its cases that are motions alone; None where it has none.
    """

    study: Study
    figures: tuple[Figure, ...]
    case_rows: tuple[int, ...]
    notes: tuple[str, ...]
    crowd: int | None = None
    population: Population | PeopleDrawn | None = None
    shown_size: Mapping[str, str] = field(default_factory=dict)
    moving: Study | None = None
    maps: tuple[MapTask, ...] = ()

    def __repr__(self) -> str:
        return f"OpenStudy({self.study.name})"

    @property
    def cases(self) -> tuple[str, ...]:
        """The names of the cases that are postures."""
        return tuple(case.name for case in self.study.cases)

    @cached_property
    def start(self) -> Arrangement:
        """The arrangement as the study's file has it."""
        people = (
            PersonState(
                role=role.name,
                figure=self.figures[row],
                free=role.free,
                forward=role.forward,
                up=role.up,
                actions=tuple(case.actions[row] for case in self.study.cases),
            )
            for row, role in enumerate(self.study.roles)
        )
        zones = tuple(criterion.zone for criterion in self.study.criteria)
        settings = tuple(sorted(self.study.settings.items()))
        return Arrangement(tuple(people), moves=self.study.moved, zones=zones, settings=settings)

    @property
    def folder(self) -> Path:
        """Where the study's file is: names are looked for from there."""
        return self.study.inputs["study"].parent

    def seat(self, row: int) -> Seat | None:
        """The seat of a role with its travel, None for people without one."""
        name = self.study.roles[row].seat
        return None if name is None else self.study.environment.seat(name)

    @cached_property
    def movers(self) -> tuple[tuple[int, ...], ...]:
        """The parts that move with the seat of each role, by index."""
        environment = self.study.environment
        found = []
        for row in range(len(self.study.roles)):
            seat = self.seat(row)
            names = () if seat is None else seat.moves
            found.append(tuple(environment.part_index(name) for name in names))
        return tuple(found)


def open_study(study: Study, size: str = "", *, figures: Sequence[Figure] = ()) -> OpenStudy:
    """Open a study for changes.

    Parameters
    ----------
    study
        As `load_study` returns it.
    size
        Of a role that several sizes take one at a time, the one that is shown; the first if "".
    figures
        Of the roles, whose bodies are made already; their sizes and clothes are the study's.

    Raises
    ------
    InputError
        If the study has no such size.
    """
    notes: list[str] = []
    whole = _one_size(study, size, notes)
    moving = replace(whole, cases=whole.motions, compare=None) if whole.motions else None
    roles = tuple(_one_person(role, notes) for role in whole.roles) if whole.postures else ()
    single = replace(
        whole,
        roles=roles,
        cases=whole.postures,
        reach_envelopes=(),
        reach_maps=(),
        compare=None,
    )
    made = figures or tuple(figure_of(role, drawn_number(roles, role)) for role in roles)
    dressed = zip(made, roles, strict=True)
    sizes = {role.name: size or next(iter(role.sizes)) for role in study.roles if role.sizes}
    case_rows = tuple(row for row, case in enumerate(study.cases) if not case.moves)
    crowd = next((k for k, role in enumerate(study.roles) if role.population is not None), None)
    people = None if crowd is None else study.roles[crowd].population
    return OpenStudy(
        single,
        tuple(replace(one, size=role.size, clothes=role.clothes) for one, role in dressed),
        case_rows,
        tuple(notes),
        crowd,
        people,
        sizes,
        moving,
        () if crowd is None else tuple(task for task in study.reach_maps if not task.sees),
    )


def figure_of(role: Role, number: int) -> Figure:
    """Make the body of the one person who takes a role.

    Parameters
    ----------
    number
        By which a driver's posture is drawn, see `drawn_number`.

    Raises
    ------
    InputError
        If there is no body of this size, or it cannot wear the clothes.
    """
    who, notes = occupant(role, number)
    return Figure(role.size, role.clothes, who, tuple(notes))


def _one_size(study: Study, size: str, notes: list[str]) -> Study:
    """A study with one of the sizes that take a role one at a time."""
    sizes = dict(study.by_size())
    if size and size not in sizes:
        valid = ", ".join(name for name in sizes if name) or "none"
        raise InputError(f"no size {size!r}; valid: {valid}")
    chosen = size or next(iter(sizes))
    if len(sizes) > 1:
        notes.append(f"one of {len(sizes)} sizes is shown: {chosen}")
    return sizes[chosen]


def _one_person(role: Role, notes: list[str]) -> Role:
    """A role with one person in it: of a population the body as its file has it."""
    if role.population is None:
        return role
    notes.append(
        f"{role.name}: one person is shown, {role.body.name} as its file has it; "
        "the whole population is asked beside"
    )
    return replace(role, population=None)


def arranged_study(opened: OpenStudy, arrangement: Arrangement) -> Study:
    """Build the study that an arrangement is: what its file says once it is saved."""
    study = opened.study
    if arrangement.content == opened.start.content:
        return study
    roles = tuple(
        replace(
            role,
            free=person.free,
            forward=person.forward,
            up=person.up,
            size=person.figure.size,
            clothes=person.figure.clothes,
        )
        for role, person in zip(study.roles, arrangement.people, strict=True)
    )
    criteria = tuple(
        criterion if criterion.zone == zone else replace(criterion, zone=zone)
        for criterion, zone in zip(study.criteria, arrangement.zones, strict=True)
    )
    cases = tuple(
        Case(case.name, tuple(person.actions[number] for person in arrangement.people))
        for number, case in enumerate(study.cases)
    )
    environment = arranged_environment(opened, arrangement)
    settings = dict(arrangement.settings)
    adjusts = adjusts_of(_sitters(opened, arrangement), environment, settings)
    roles = tuple(replace(role, adjusts=adjusts.get(role.name, ())) for role in roles)
    return replace(
        study,
        roles=roles,
        cases=cases,
        criteria=(*criteria, *arrangement.added),
        environment=environment,
        settings=settings,
        moved=arrangement.moves,
    )


def _sitters(opened: OpenStudy, arrangement: Arrangement) -> list[SeatedRole]:
    """Who acts on controls from a seat, in the order in which the seats are taken."""
    found = []
    order = sorted(range(len(arrangement.people)), key=lambda row: row == opened.crowd)
    for row in order:
        person = arrangement.people[row]
        aims = [one.aims for one in person.actions if isinstance(one, PredictedPosture)]
        seat = opened.study.roles[row].seat
        if seat is not None and aims:
            driver = any(one.driving is not None for one in aims)
            found.append(SeatedRole(person.role, seat, person.free, driver))
    return found


def arranged_environment(opened: OpenStudy, arrangement: Arrangement) -> Environment:
    """Build the environment with parts, controls and adjustments where a state has them, and the
    seats at rest.

    It is indexed anew where parts have moved: `arranged_parts` is not.
    """
    settled = environment_at(opened, arrangement.settings)
    return _environment(settled, arrangement.moves, opened.study.moved)


@lru_cache(maxsize=4)
def _environment(
    environment: Environment, moves: tuple[Move, ...], before: tuple[Move, ...]
) -> Environment:
    """The same object for the same moves, so that its index is made once."""
    return displaced(environment, moves, before)


def environment_at(opened: OpenStudy, settings: Settings) -> Environment:
    """Build the environment as opened with adjustments set elsewhere; the same object where they
    are set so already."""
    return _adjusted(opened.study.environment, settings)


@lru_cache(maxsize=8)
def _adjusted(environment: Environment, settings: Settings) -> Environment:
    """The same object for the same settings, so that its index is made once."""
    return adjusted(environment, dict(settings))


def arranged_parts(
    opened: OpenStudy, moves: tuple[Move, ...], shifts: Floats, settings: Settings = ()
) -> Surroundings:
    """Build the environment as opened with parts displaced, which needs no other index.

    Parameters
    ----------
    moves
        Of a state.
    shifts
        (R, 3) [m] of the seats, role by role.
    settings
        Adjustments that are set elsewhere than as opened: with others it is indexed anew.
    """
    environment = environment_at(opened, settings)
    by = part_moves(environment, moves) - part_moves(environment, opened.study.moved)
    ways = np.unique(by[by.any(axis=1)], axis=0)
    groups = tuple(tuple(np.flatnonzero((by == way).all(axis=1)).tolist()) for way in ways)
    return Surroundings(environment, (*opened.movers, *groups), np.concatenate([shifts, ways]))


def given_angles(body: Body, poses: Poses) -> Floats:
    """(J, 3) [rad] the joint angles of one pose."""
    return angles_of(body, poses)[0]
