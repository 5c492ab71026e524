"""Grip strength: how hard people close a hand, by norms of age and sex [1]_.

Between two percentiles of the norms the force is straight on a normal scale; below the 5th and above
the 95th the last slope goes on.

References
----------
.. [1] International norms for adult handgrip strength (2025), Journal of Sport and Health Science 14,
   101014.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.files.study.rules import rule_set
from workbench.model.arrays import Floats, for_rows
from workbench.model.rule_set import RuleSet
from workbench.strain.arm_strength import deviations_below

__all__ = ["GripStrength", "grip_strength"]


@dataclass(frozen=True, eq=False)
class GripStrength:
    """The grip strength of P people.

    Parameters
    ----------
    forces
        (P, K) [N] at K percentiles.
    scores
        (K,) the percentiles on a normal scale.
    version, status
        The norms; where its numbers are from, and how sure each is.
    """

    forces: Floats
    scores: Floats
    version: str
    status: str

    def capable(self, force: ArrayLike) -> Floats:
        """(P,) the share of such people that close a hand with a force [N], one or (P,)."""
        from scipy.special import ndtr

        given = for_rows(force, np.float64, (), rows=len(self.forces), what="force")
        k = (given[:, None] >= self.forces[:, 1:-1]).sum(axis=1)
        rows = np.arange(len(k))
        low, high = self.forces[rows, k], self.forces[rows, k + 1]
        rise = (self.scores[k + 1] - self.scores[k]) / (high - low)
        return ndtr(-(self.scores[k] + rise * (given - low)))

    def strength(self, share: float) -> Floats:
        """(P,) [N] what a share of such people closes a hand with at least; never below 0.
        InputError where that is not between 0 and 1."""
        score = -deviations_below(share)
        k = int(np.searchsorted(self.scores[1:-1], score))
        part = (score - self.scores[k]) / (self.scores[k + 1] - self.scores[k])
        force: Floats = self.forces[:, k] + part * (self.forces[:, k + 1] - self.forces[:, k])
        return np.maximum(force, 0.0)


def grip_strength(
    age: ArrayLike, *, male: ArrayLike, rules: RuleSet | str = "strain_grip"
) -> GripStrength:
    """Look up the grip strength of people of an age and sex.

    Parameters
    ----------
    age
        [years], one or (P,), from 20 to 74 in the norms that are there.
    male
        Whether people are men, one truth value or (P,).
    rules
        The norms; a rule set, or the name or path of one.

    Raises
    ------
    InputError
        If an age is out of the table, or a value of the rule set has another shape.

    Examples
    --------
    >>> import workbench as wb
    >>> found = wb.grip_strength(32, male=False)
    >>> found.strength(0.95).round(), found.capable(250.0).round(2)
    (array([192.]), array([0.75]))
    """
    from scipy.special import ndtri

    values = rule_set(rules)
    count = max(np.size(age), np.size(male))
    years = for_rows(age, np.float64, (), rows=count, what="age")
    man = for_rows(male, np.bool_, (), rows=count, what="male")
    ages = values.shaped("ages", None)
    last = 2.0 * ages[-1] - ages[-2]
    out = years[(years < ages[0]) | (years >= last)]
    if len(out):
        raise InputError(
            f"age: the table has {ages[0]:g} to {last - 1:g} years of age, got {out[0]:g}"
        )
    percentiles = values.shaped("percentiles", None)
    row = np.searchsorted(ages, years, side="right") - 1
    tables = [values.shaped(sex, len(ages), len(percentiles)) for sex in ("female", "male")]
    return GripStrength(
        forces=np.where(man[:, None], tables[1][row], tables[0][row]),
        scores=ndtri(percentiles / 100.0),
        version=values.description,
        status=values.status(*values.values),
    )
