"""Edits of who a person is: size and clothes; and the harness zone that reaches are judged in.

A body is made when one of these is asked for the first time, which takes up to a second; then it is
known.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from workbench.body.people.growth_charts import growth_percentile, growth_values
from workbench.body.people.percentile import percentile_rank, percentile_values
from workbench.errors import InputError, one_of
from workbench.files.body.encumbrances import load_encumbrances
from workbench.files.catalogue import names
from workbench.files.study.sizes import ADULTS, CHILDREN, people_of_size, size_of
from workbench.model.body import Body
from workbench.model.person import Encumbrance, Growth, Size
from workbench.model.population import MASS, PopulationModel
from workbench.model.study import PredictedPosture, Role
from workbench.posture.reaching.limbs import ZONES
from workbench.study.bench.edits import LENGTH_STEP, Edit, rounded
from workbench.study.bench.state import Arrangement, Figure, OpenStudy, PersonState, figure_of
from workbench.study.workplaces import drawn_number

__all__ = [
    "SizeWanted",
    "dressed",
    "harnessed",
    "percentile_of",
    "reach_criteria",
    "sized",
    "wearable",
]

MASS_STEP = 0.1
"""[kg]"""
AGE_STEP = 0.1
"""[years]"""


@dataclass(frozen=True)
class SizeWanted:
    """The size that a person is to have.

    Parameters
    ----------
    sex
        "male" or "female"; "" for the body as its file has it.
    measures
        By name [m].
    percentiles
        By name [%] of people of this sex: instead of a measure, and of the mass.
    mass
        [kg], None where it is as people with these measures have it.
    age
        [years] of a child, None for adults.
    """

    sex: str
    measures: Mapping[str, float] = field(default_factory=dict)
    percentiles: Mapping[str, float] = field(default_factory=dict)
    mass: float | None = None
    age: float | None = None


@dataclass(frozen=True)
class _Key:
    """What a figure is made of; equal where the body is the same."""

    sex: str
    measures: tuple[tuple[str, float], ...]
    people: PopulationModel | Growth | None
    age: float | None
    clothes: tuple[Encumbrance, ...]


def sized(opened: OpenStudy, arrangement: Arrangement, person: str, wanted: SizeWanted) -> Edit:
    """Give a person another size, to 0.1 mm, 0.1 kg and 0.1 years.

    Returns
    -------
    Edit
        The words say what is improbable about the size.

    Raises
    ------
    InputError
        If the person is not there, many people take the role, a study's file may not say this size,
        or there is no body of this size.
    """
    row = _single(opened, arrangement, person)
    figure = arrangement.people[row].figure
    size = None if not wanted.sex else _size(opened, row, figure, wanted)
    if size is None and figure.size is not None and _drives(arrangement.people[row]):
        raise InputError(
            f"{person}: it is not stated whether a man or a woman drives: a size is needed"
        )
    return _embodied(opened, arrangement, row, size, figure.clothes)


def _drives(person: PersonState) -> bool:
    """Whether a driver's posture is predicted of a person, and the size alone states the sex."""
    aims = [one.aims.driving for one in person.actions if isinstance(one, PredictedPosture)]
    return any(driving is not None and not driving.sex for driving in aims)


def _single(opened: OpenStudy, arrangement: Arrangement, person: str) -> int:
    """The row of a person; InputError where a population takes the role."""
    row = arrangement.row(person)
    if row == opened.crowd:
        raise InputError(
            f"{person}: a population takes this role, one person after the other; "
            "sizes and clothes of its people are changed in the study's file"
        )
    return row


def _size(opened: OpenStudy, row: int, figure: Figure, wanted: SizeWanted) -> Size:
    """The size that is wanted, as a file may state it."""
    age = None if wanted.age is None else _step(wanted.age, AGE_STEP)
    people = _people(opened, figure, age)
    values = dict(wanted.measures)
    mass = wanted.mass
    for name, percentile in wanted.percentiles.items():
        value = _at_percentile(people, wanted.sex, name, percentile, age)
        if name == MASS:
            mass = value
        else:
            values[name] = value
    sizes = [one.size.measures for one in (figure, opened.figures[row]) if one.size is not None]

    def step(name: str, value: float, step: float) -> float:
        return _step(value, step, [known[name] for known in sizes if name in known])

    return size_of(
        wanted.sex,
        {name: step(name, value, LENGTH_STEP) for name, value in values.items()},
        mass=None if mass is None else step(MASS, mass, MASS_STEP),
        age=age,
        people=people,
    )


def _step(value: float, step: float, before: Sequence[float] = ()) -> float:
    """A value in steps; as it was, now or in the file, where it is within half a step of this. NaN
    stays: it is reported as no person's."""
    for known in before:
        if abs(value - known) <= step / 2:
            return known
    return rounded(value, step) if math.isfinite(value) else value


def _people(opened: OpenStudy, figure: Figure, age: float | None) -> PopulationModel | Growth:
    """Whose other measures are taken: as before where that fits, else those that a file need not
    name."""
    known = figure.size.population if figure.size is not None else None
    if known is not None and isinstance(known, Growth) == (age is not None):
        return known
    source = ADULTS if age is None else CHILDREN
    return _loaded(source, age is None, opened.folder)


@lru_cache(maxsize=8)
def _loaded(source: str, adults: bool, near: Path) -> PopulationModel | Growth:
    """The same object for the same population."""
    return people_of_size(source, None if adults else 1.0, near)[1]


def _at_percentile(
    people: PopulationModel | Growth, sex: str, name: str, percentile: float, age: float | None
) -> float:
    """A measure [m; kg] at a percentile [%] of a sex."""
    if name not in people.names:
        raise InputError(
            f"no percentiles of {name!r} in {people.name}; {one_of(name, people.names)}"
        )
    column = people.names.index(name)
    if isinstance(people, Growth):
        assert age is not None
        return float(growth_values(people, sex, percentile, age=age)[0, column])
    if not 0 < percentile < 100:
        raise InputError(f"a percentile lies between 0 and 100, got {percentile:g}")
    return float(percentile_values(people, sex, percentile)[0, column])


def percentile_of(size: Size, name: str) -> float | None:
    """The percentile [%] of a stated measure among people of this sex (and age); None where the
    population does not know the measure."""
    people = size.population
    if name not in people.names:
        return None
    value = size.measures[name]
    if isinstance(people, Growth):
        assert size.age is not None
        return float(growth_percentile(people, size.sex, name, value, age=size.age))
    return percentile_rank(people, size.sex, name, value)


def dressed(
    opened: OpenStudy, arrangement: Arrangement, person: str, clothes: Sequence[str]
) -> Edit:
    """Put clothes on a person and take others off.

    Parameters
    ----------
    clothes
        All that is worn then, by name, from the inside to the outside.

    Raises
    ------
    InputError
        If the person or a name is not there, many people take the role, or something does not fit
        the body.
    """
    row = _single(opened, arrangement, person)
    figure = arrangement.people[row].figure
    known = {item.name: item for item in (*opened.figures[row].clothes, *figure.clothes)}
    new = [name for name in clothes if name not in known]
    if twice := [name for k, name in enumerate(clothes) if name in clothes[:k]]:
        raise InputError(f"{twice[0]!r} cannot be worn twice")
    found = load_encumbrances(new, opened.study.roles[row].body, near=opened.folder)
    known |= dict(zip(new, found, strict=True))
    items = tuple(known[name] for name in clothes)
    return _embodied(opened, arrangement, row, figure.size, items)


def wearable(body: Body, folder: Path) -> list[str]:
    """The names of the clothes that fit a body, of those that a study in a folder may name."""
    found = []
    for name in names("bodies/encumbrance", near=folder):
        try:
            load_encumbrances([name], body, near=folder)
        except InputError:
            continue  # it fits another kind of body
        found.append(name)
    return found


def _embodied(
    opened: OpenStudy,
    arrangement: Arrangement,
    row: int,
    size: Size | None,
    clothes: tuple[Encumbrance, ...],
) -> Edit:
    """A state in which a person has a size and clothes."""
    person = arrangement.people[row]
    key = _key(size, clothes)
    if key == _key(person.figure.size, person.figure.clothes):
        return Edit(arrangement)
    figure = opened.figures[row]
    if key != _key(figure.size, figure.clothes):
        roles = opened.study.roles
        figure = _figure(roles[row], drawn_number(roles, roles[row]), key)
    after = arrangement.with_person(row, replace(person, figure=figure))
    return Edit(after, "; ".join(figure.notes) or f"{person.role}: {_words(figure)}")


def _key(size: Size | None, clothes: tuple[Encumbrance, ...]) -> _Key:
    if size is None:
        return _Key("", (), None, None, clothes)
    return _Key(size.sex, tuple(size.measures.items()), size.population, size.age, clothes)


@lru_cache(maxsize=64)
def _figure(role: Role, number: int, key: _Key) -> Figure:
    """The same figure for the same size and clothes: a body is made once."""
    size = None
    if key.people is not None:
        size = Size(key.sex, dict(key.measures), key.people, key.age)
    return figure_of(replace(role, size=size, clothes=key.clothes), number)


def _words(figure: Figure) -> str:
    """A size and clothes in words."""
    size = figure.size
    if size is None:
        words = ["as the body's file has it"]
    else:
        kind = {"female": ("a woman", "a girl"), "male": ("a man", "a boy")}[size.sex]
        lead = kind[0] if size.age is None else f"{kind[1]} of {size.age:g} years"
        stature = size.measures.get("stature")
        words = [lead if stature is None else f"{lead}, {1000 * stature:g} mm tall"]
    if figure.clothes:
        words.append("with " + ", ".join(item.name for item in figure.clothes))
    return ", ".join(words)


def reach_criteria(opened: OpenStudy, person: str) -> list[int]:
    """The criteria that ask what a person reaches, by index."""
    criteria = opened.study.criteria
    return [k for k, one in enumerate(criteria) if one.check == "reach" and person in one.people]


def harnessed(opened: OpenStudy, arrangement: Arrangement, person: str, zone: int | None) -> Edit:
    """Judge what a person reaches in one harness zone.

    Parameters
    ----------
    zone
        1, 2 or 3; None for the zone of each control.

    Returns
    -------
    Edit
        The words name others whom the same criteria ask about.

    Raises
    ------
    InputError
        If the person or the zone is not there, or no criterion asks what the person reaches.
    """
    arrangement.row(person)
    if zone is not None and zone not in ZONES:
        raise InputError(f"no zone {zone}; it is 1, 2 or 3")
    rows = reach_criteria(opened, person)
    if not rows:
        raise InputError(f"no criterion asks what {person} reaches, so no zone is asked for")
    zones = tuple(zone if k in rows else old for k, old in enumerate(arrangement.zones))
    if zones == arrangement.zones:
        return Edit(arrangement)
    asked = [name for k in rows for name in opened.study.criteria[k].people]
    others = [name for name in dict.fromkeys(asked) if name != person]
    words = f"the same criteria ask about {', '.join(others)}" if others else ""
    return Edit(replace(arrangement, zones=zones), words)
