"""What is known of each person that a driving posture depends on."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from workbench.body.scaling.measure import measure
from workbench.errors import InputError
from workbench.model.body import Body
from workbench.model.driving import Driver, DrivingAims
from workbench.model.population import SEXES, Population

__all__ = ["drivers_among"]

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
