"""One person of a population as a body: the given measures exactly, the others as people with these have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.body import Body
from workbench.model.measures import MEASURES as PLAUSIBLE
from workbench.model.population import PopulationModel
from workbench.model.study import Study
from workbench.people.conditional import condition, improbability
from workbench.people.percentile import percentile_values
from workbench.people.scores import Scores, scores_of
from workbench.shape.measure import MEASURES
from workbench.shape.scale import scale

__all__ = ["RARE", "SizedBody", "person_body", "sized"]

RARE = 4.0
"""A measure this many standard deviations from what the others make likely is no slip of the tape: it is told."""
# measures whose figures and definition on the sphere body are known not to agree (see shape.measure)
APART = ("functional_leg_length", "hip_breadth_sitting", "cervicale_height", "cervicale_height_sitting")


@dataclass(frozen=True, eq=False)
class SizedBody:
    """A body, all measures expected of the person [m; kg], and in words what is improbable about the given ones."""

    body: Body
    measures: Mapping[str, float]
    warnings: tuple[str, ...]


def person_body(body: Body, model: PopulationModel, *, sex: str, measures: Mapping[str, float]) -> SizedBody:
    """Scale a body to a person with these measures [m; mass in kg].

    Measures that are not given are drawn near to their conditional mean in the population; the masses add up to the
    given or expected mass. InputError for unknown or contradicting measures.
    """
    scores = scores_of(model, sex)
    for name in measures:
        if name not in MEASURES and name != "mass":
            raise InputError(f"no measure {name!r}; {one_of(name, [*MEASURES, 'mass'])}")
    known = {name: value for name, value in measures.items() if name in scores.names}
    expected = condition(scores, known) if known else condition(scores, {"stature": _median(model, sex)})
    values = dict(zip(expected.names, expected.values[0].tolist(), strict=True))
    exact = {name: value for name, value in measures.items() if name != "mass"}
    near = {name: value for name, value in values.items() if name in MEASURES and name not in APART}
    _plausible(measures)
    told = _improbable(scores, known)
    try:
        made = scale(body, exact, others=near)
    except InputError:
        made = scale(body, exact)  # what is given comes first; where even that cannot be had, this says so
        told += ("the measures that are not given could not be drawn near to those of such people",)
    mass = measures.get("mass", values.get("mass", float(made.mass.sum())))
    made = replace(made, mass=made.mass * (mass / made.mass.sum()))
    return SizedBody(made, values | dict(measures), told)


def sized(study: Study) -> tuple[Study, list[str]]:
    """The study with every person's body at its size, and what is improbable about the sizes, person by person."""
    people, told = [], []
    for person in study.people:
        if person.size is None:
            people.append(person)
            continue
        size = person.size
        made = person_body(person.body, size.population, sex=size.sex, measures=size.measures)
        people.append(replace(person, body=made.body))
        told += [f"{person.name}: {warning}" for warning in made.warnings]
    return replace(study, people=tuple(people)), told


def _median(model: PopulationModel, sex: str) -> float:
    column = model.names.index("stature")
    return float(percentile_values(model, sex, [50.0])[0, column])


def _improbable(scores: Scores, known: Mapping[str, float]) -> tuple[str, ...]:
    if not known:
        return ()
    found = improbability(scores, known)
    name, surprise = found.worst()
    if abs(surprise) < RARE:
        return ()
    shown = f"{known[name]:.0f} kg" if name == "mass" else f"{1000 * known[name]:.0f} mm"
    against = "what the other measures make likely" if len(known) > 1 else "the middle of the population"
    return (f"{name} {shown} is {abs(surprise):.1f} standard deviations from {against}; "
            f"there may be no such person",)  # fmt: skip


def _plausible(measures: Mapping[str, float]) -> None:
    """InputError for a measure that nobody has: most likely a wrong unit."""
    faults = []
    for name, value in measures.items():
        low, high = PLAUSIBLE.get(name, (0.0, np.inf))
        if not low <= value <= high:
            unit, factor = ("kg", 1.0) if name == "mass" else ("mm", 1000.0)
            faults.append(f"{name} {factor * value:g} {unit} is not a person's ({factor * low:g} to {factor * high:g} "
                          f"{unit} is): a wrong unit?")  # fmt: skip
    if faults:
        raise InputError(faults)
