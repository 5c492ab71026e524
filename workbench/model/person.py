"""One person: the size of somebody, how children grow, what is worn, and a body in its poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, read_only
from workbench.model.body import Body
from workbench.model.population import SEXES, PopulationModel, check_measures
from workbench.model.poses import Poses

__all__ = ["Encumbrance", "Growth", "Layer", "Person", "Size"]


@dataclass(frozen=True, eq=False, repr=False)
class Growth:
    """LMS curves of M measures at A ages, for both SEXES.

    names (M): the measures; age (A,) [months]: rising; lms (2, M, A, 3): power L, median M [m; kg
    for mass] and coefficient of variation S of Cole & Green 1992: value = M (1 + L S z)^(1/L) at
    the standard normal score z.
    """

    name: str
    source: str
    names: tuple[str, ...]
    age: Floats
    lms: Floats

    def __repr__(self) -> str:
        return f"Growth({self.name}: {', '.join(self.names)}, {self.age[0] / 12:.1f} to {self.age[-1] / 12:.1f} years)"

    def __post_init__(self) -> None:
        ages = len(self.age)
        object.__setattr__(self, "age", read_only(self.age, np.float64, (ages,), "growth.age"))
        shape = (len(SEXES), len(self.names), ages, 3)
        object.__setattr__(self, "lms", read_only(self.lms, np.float64, shape, "growth.lms"))
        check_measures(self.names)
        if ages < 2 or not np.all(np.diff(self.age) > 0):
            raise InputError(f"growth {self.name}: two or more rising ages are needed")
        if not np.all(np.isfinite(self.lms)) or not np.all(self.lms[..., 1:] > 0):
            raise InputError(f"growth {self.name}: L must be finite, M and S positive")


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


@dataclass(frozen=True)
class Layer:
    """Copies of some spheres of a body, grown and shifted.

    segments: mnemonics; subparts: only spheres of these names, all where empty; beyond: only
    spheres whose middles lie at least so far [m] along a direction of the segment from a landmark
    (direction, subpart, distance), all that hold; thickness [m]: added to the radii; shift (3,)
    [m]: in the segment's frame (x front, y left, z top).
    """

    segments: tuple[str, ...]
    subparts: tuple[str, ...]
    beyond: tuple[tuple[str, str, float], ...]
    thickness: float
    shift: tuple[float, float, float]


@dataclass(frozen=True)
class Encumbrance:
    """Something worn: its layers, and what it weighs [kg] on each segment.

    without: segments whose own spheres and mass are gone: a limb that is missing, or in whose place
    the layers are (a prosthesis).
    """

    name: str
    description: str
    source: str
    layers: tuple[Layer, ...]
    mass: tuple[tuple[str, float], ...]
    without: tuple[str, ...] = ()
