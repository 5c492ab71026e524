"""Drivers of a study: what is known of each person that the posture at the wheel depends on, and
the car's package."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from workbench.body.scaling.measure import measure
from workbench.errors import InputError
from workbench.model.body import Body
from workbench.model.driving import Driver, DrivingAims, Package
from workbench.model.environment import Environment
from workbench.model.population import SEXES, Population
from workbench.model.posture_study import Aims, Person

__all__ = ["driver_of", "drivers_among", "feet_of", "package_of"]

NEEDED = ("stature", "sitting_height", "mass")


def package_of(aims: Aims, environment: Environment) -> Package:
    """The package a driver sits in: the heel's point, the accelerator, the wheel's centre, the
    seat's hip point."""
    assert aims.driving is not None and aims.heels is not None
    controls = {control.name: control for control in environment.controls}
    points = environment.points
    ball = controls[aims.controls["right foot"]].at
    return Package(
        points[aims.heels], ball, points[aims.driving.wheel], points[aims.driving.h_point]
    )


def feet_of(aims: Aims, environment: Environment) -> dict[str, tuple[float, float, float]]:
    """Where the balls of the feet go [m], by "left foot" and "right foot"."""
    controls = {control.name: control for control in environment.controls}
    return {
        limb: controls[held].at for limb, held in aims.controls.items() if limb.endswith("foot")
    }


def driver_of(person: Person, aims: DrivingAims) -> Driver:
    """The driver that a person of a study is. Measures that the person's size does not give are
    taken from the body as it is dressed. InputError for somebody who is no driver."""
    size = person.size
    given: Mapping[str, float] = size.measures if size is not None else {}
    taken = measure(person.body, [name for name in NEEDED[:2] if name not in given])
    mass = given.get("mass", float(person.body.mass[0].sum()))
    sex = aims.sex or (size.sex if size is not None else "")
    return _driver(sex, {**taken, **given, "mass": mass}, aims.age)


def drivers_among(people: Population, rows: Sequence[int], body: Body, age: float) -> list[Driver]:
    """The drivers that some people (rows) of a population are; what the population does not tell is
    taken from their rows of a body. InputError for somebody who is no driver."""
    found = []
    for row, one in zip(rows, body, strict=True):
        values = dict(zip(people.names, people.measures[row].tolist(), strict=True))
        if "mass" not in values:
            values["mass"] = float(one.mass[0].sum())
        missing = [name for name in NEEDED[:2] if name not in values]
        values |= measure(one, missing) if missing else {}
        try:
            found.append(_driver(SEXES[int(people.sex[row])], values, age))
        except InputError as error:
            label = people.labels[row] if people.labels else f"person {row + 1}"
            raise InputError([f"{label}: {problem}" for problem in error.problems]) from None
    return found


def _driver(sex: str, values: Mapping[str, float], age: float) -> Driver:
    return Driver(
        sex,
        values["stature"],
        values["sitting_height"],
        values["mass"] / values["stature"] ** 2,
        age,
    )
