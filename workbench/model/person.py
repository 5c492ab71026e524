"""One person: the size of somebody, and a body in its poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.model.body import Body
from workbench.model.growth import Growth
from workbench.model.population import PopulationModel
from workbench.model.poses import Poses

__all__ = ["Person", "Size"]


@dataclass(frozen=True, eq=False)
class Size:
    """A person's measures [m; mass in kg], and the population whose people the other measures are
    taken from, or the growth charts and the age [years] of a child."""

    sex: str
    measures: Mapping[str, float]
    population: PopulationModel | Growth
    age: float | None = None


@dataclass(frozen=True, eq=False)
class Person:
    """One body in P poses in the world."""

    name: str
    body: Body
    poses: Poses
