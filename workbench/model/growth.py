"""Growth: how stature and mass of children are spread at each age."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, frozen
from workbench.model.measures import check_measures
from workbench.model.population import SEXES

__all__ = ["Growth"]


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
        object.__setattr__(self, "age", frozen(self.age, np.float64, (ages,), "growth.age"))
        shape = (len(SEXES), len(self.names), ages, 3)
        object.__setattr__(self, "lms", frozen(self.lms, np.float64, shape, "growth.lms"))
        check_measures(self.names)
        if ages < 2 or not np.all(np.diff(self.age) > 0):
            raise InputError(f"growth {self.name}: two or more rising ages are needed")
        if not np.all(np.isfinite(self.lms)) or not np.all(self.lms[..., 1:] > 0):
            raise InputError(f"growth {self.name}: L must be finite, M and S positive")
