"""One person of a population as a body: the given measures exactly, the others as people with these
have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from workbench.body.people.conditional import (
    Scores,
    conditional_distribution,
    mahalanobis_distance,
    scores_of,
)
from workbench.body.people.growth_charts import growth_percentile, growth_values
from workbench.body.people.percentile import percentile_values
from workbench.body.scaling.measure import MEASURES, measure
from workbench.body.scaling.scale import morph_to, scale
from workbench.body.scaling.seated import seated
from workbench.body.wear import wear
from workbench.errors import InputError, one_of
from workbench.model.arguments import short_repr
from workbench.model.body import Body
from workbench.model.driving import Driver, DrivingAims
from workbench.model.person import Growth, Size
from workbench.model.population import (
    GIRTHS,
    SEXES,
    WORDS,
    Population,
    PopulationModel,
    check_plausible,
)
from workbench.model.study import Role
from workbench.model.units import plain

__all__ = ["RARE", "SizedBody", "drivers_among", "person_body", "role_body"]

Measures = Mapping[str, float]

RARE = 4.0
"""A measure this many standard deviations from what the others make likely is no slip of the tape:
it is reported."""
FAR = 0.1
"""The least percentile of the growth charts that is taken for a child's; the curves say nothing
farther out."""
APART = ("overhead_fingertip_reach_sitting", *GIRTHS)
"""Measures that a body is not drawn near to, because typical bodies differ in them from the survey
by definition: a shoulder does not rise as in a person who stretches, and a tape runs around spheres,
which lie some millimetres under the skin."""


@dataclass(frozen=True, eq=False)
class SizedBody:
    """A body, all measures expected of the person [m; kg], and in words what is improbable about
    the given ones."""

    body: Body
    measures: Mapping[str, float]
    warnings: tuple[str, ...]

    __repr__ = short_repr


def person_body(
    body: Body,
    people: PopulationModel | Growth,
    *,
    sex: str,
    measures: Measures,
    age: float | None = None,
    detail: str | None = None,
) -> SizedBody:
    """Scale a body to a person with these measures [m; mass in kg].

    Measures that are not given are drawn near to their conditional mean in a population; of a child
    of an age [years] the growth charts give stature and mass, and the body's own family the rest.
    The masses add up to the given or expected mass. detail: of the body's family. InputError for
    unknown or contradicting measures.
    """
    for name in measures:
        if name not in MEASURES and name != "mass":
            raise InputError(
                f"no measure {name!r}; {one_of(name, [*MEASURES, 'mass'], words=WORDS)}"
            )
    check_plausible(measures)
    if isinstance(people, Growth):
        return _child(body, detail, people, sex, age, measures)
    if age is not None:
        raise InputError(f"an age goes with growth charts, not with the population {people.name}")
    scores = scores_of(people, sex)
    known = {name: value for name, value in measures.items() if name in scores.names}
    expected = (
        conditional_distribution(scores, known)
        if known
        else conditional_distribution(scores, {"stature": _median(people, sex)})
    )
    values = dict(zip(expected.names, expected.values[0].tolist(), strict=True))
    return _made(body, detail, measures, values, _improbable(scores, known))


def _made(
    body: Body,
    detail: str | None,
    measures: Measures,
    values: Measures,
    notes: tuple[str, ...],
) -> SizedBody:
    """A body at a level of detail with the given measures exactly and the expected ones near."""
    exact = {name: value for name, value in measures.items() if name != "mass"}
    near = {name: value for name, value in values.items() if name in MEASURES and name not in APART}
    try:
        made = scale(body, exact, others=near, detail=detail)
    except InputError:
        # what is given comes first; where even that cannot be had, this says so
        made = scale(body, exact, detail=detail)
        notes += (
            "the measures that are not given could not be drawn near to those of such people",
        )
    mass = measures.get("mass", values.get("mass", float(made.mass[0].sum())))
    made = replace(made, mass=made.mass * (mass / made.mass.sum()))
    return SizedBody(made, {**values, **measures}, notes)


def _child(
    body: Body,
    detail: str | None,
    growth: Growth,
    sex: str,
    age: float | None,
    measures: Measures,
) -> SizedBody:
    """A child: stature and mass that are not given stand at the same percentile of its age as the
    one that is, at the median where neither is."""
    if age is None:
        raise InputError(f"{growth.name} are growth charts: they need an age in years")
    known = [name for name in growth.names if name in measures]
    percentile = 50.0
    notes: tuple[str, ...] = ()
    if known:
        percentile = float(growth_percentile(growth, sex, known[0], measures[known[0]], age=age))
        if not FAR <= percentile <= 100 - FAR:
            unit, factor = ("kg", 1.0) if known[0] == "mass" else ("mm", 1000.0)
            end = f"below the {FAR:g}th" if percentile < FAR else f"above the {100 - FAR:g}th"
            notes = (
                f"{plain(known[0])} {factor * measures[known[0]]:.0f} {unit} is {end} percentile at {age:g} "
                f"years; there may be no such child",
            )
        percentile = min(max(percentile, FAR), 100 - FAR)
    row = growth_values(growth, sex, percentile, age=age)[0]
    expected = dict(zip(growth.names, row.tolist(), strict=True))
    lengths = set(measures) - {"mass"}
    given = measures if lengths else {"stature": expected["stature"], **measures}
    return _made(body, detail, given, expected, notes)


def _sized_body(body: Body, size: Size | None, detail: str | None) -> tuple[Body, tuple[str, ...]]:
    """A body at a level of detail, to a size where there is one, and what is improbable about
    it."""
    if size is None:
        return morph_to(body, detail), ()
    made = person_body(
        body,
        size.population,
        sex=size.sex,
        measures=size.measures,
        age=size.age,
        detail=detail,
    )
    return made.body, made.warnings


def role_body(role: Role) -> tuple[Body, tuple[str, ...]]:
    """The body of the one person who takes a role, at its size, seated where it has a seat, and
    dressed; and what is improbable about the size."""
    body, notes = _sized_body(role.body, role.size, role.detail)
    if role.seat is not None:
        body = seated(body)
    return wear(body, role.clothes), tuple(f"{role.name}: {note}" for note in notes)


def _median(model: PopulationModel, sex: str) -> float:
    column = model.names.index("stature")
    return float(percentile_values(model, sex, [50.0])[0, column])


def _improbable(scores: Scores, known: Mapping[str, float]) -> tuple[str, ...]:
    if not known:
        return ()
    found = mahalanobis_distance(scores, known)
    name, surprise = found.worst()
    if abs(surprise) < RARE:
        return ()
    shown = f"{known[name]:.0f} kg" if name == "mass" else f"{1000 * known[name]:.0f} mm"
    against = (
        "the value expected from the other measures"
        if len(known) > 1
        else "the mean of the population"
    )
    return (
        f"{plain(name)} {shown} is {abs(surprise):.1f} standard deviations from {against}; "
        f"there may be no such person",
    )


NEEDED = ("stature", "sitting_height")
"""The measures that are taken from the body of somebody who does not state them."""


def drivers_among(
    people: Population, rows: Sequence[int], body: Body, aims: DrivingAims
) -> list[Driver]:
    """The drivers that some people are.

    Parameters
    ----------
    people, rows
        A population, and B of its people.
    body
        B rows, from which measures and masses are taken that the population does not state.
    aims
        Says the age, and the sex where it is not that of the person.

    Raises
    ------
    InputError
        For somebody who is no driver.
    """
    found = []
    for k, row in enumerate(rows):
        values = dict(zip(people.names, people.measures[row].tolist(), strict=True))
        if "mass" not in values:
            values["mass"] = float(body.mass[k].sum())
        missing = [name for name in NEEDED if name not in values]
        values |= measure(body[k], missing) if missing else {}
        sex = aims.sex or SEXES[int(people.sex[row])]
        stature, mass = values["stature"], values["mass"]
        try:
            found.append(
                _driver(sex, stature, values["sitting_height"], mass / stature**2, aims.age)
            )
        except InputError as error:
            raise InputError(
                [f"{people.called(row)}: {problem}" for problem in error.problems]
            ) from None
    return found


@lru_cache(maxsize=1 << 14)
def _driver(
    sex: str, stature: float, sitting_height: float, mass_index: float, age: float
) -> Driver:
    return Driver(sex, stature, sitting_height, mass_index, age)
