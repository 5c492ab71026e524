"""Lifting: the revised NIOSH lifting equation, for one task and for several [1]_.

The recommended weight limit is a constant times six factors from 0 to 1:

    RWL = LC * HM * VM * DM * AM * FM * CM

of horizontal and vertical place of the hands, travel, asymmetry, frequency and coupling. The index
is the load over that limit. The rule set is the form: metric and inch form round their constants
differently and are not the same, so none of their numbers are mixed.

References
----------
.. [1] T. R. Waters, V. Putz-Anderson and A. Garg (1994, revised 2021), Applications manual for the
   revised NIOSH lifting equation, DHHS (NIOSH) 94-110.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.files.study.rules import rule_set
from workbench.model.arguments import check_fields, given_words
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.poses import Placed
from workbench.model.rule_set import RuleSet
from workbench.strain.working_angles import check_segments, joint_points

__all__ = ["GripPlace", "Lifting", "Lifts", "grip_place", "lifting"]

COUPLINGS = ("good", "fair", "poor")
_ARRAYS = ("load", "horizontal", "vertical", "travel", "asymmetry", "per_minute")
_SEATED = "it holds for people who stand and lift with both hands, and for up to 8 hours a day"
_ON = 1e-9
"""A place or a frequency that is beyond an end by this share is at it."""


@dataclass(frozen=True, eq=False)
class Lifts:
    """Tasks of lifting, in arrays whose last axis is the tasks of one job.

    Parameters
    ----------
    load
        (..., T) [kg].
    horizontal, vertical
        (..., T) [m] the middle of the grips from the middle of the ankles, and above the floor.
    travel
        (..., T) [m] the way up or down.
    asymmetry
        (..., T) [rad] between the direction of the load and straight ahead of the feet.
    per_minute
        (..., T) lifts a minute.
    hours
        How long the work lasts [h], 8 at most.
    stance, hands
        The equation holds for "standing" and 2 alone.
    coupling
        (..., T) "good", "fair" or "poor", or one for all.
    """

    load: ArrayLike
    horizontal: ArrayLike
    vertical: ArrayLike
    travel: ArrayLike
    asymmetry: ArrayLike
    per_minute: ArrayLike
    hours: float
    stance: Literal["standing", "sitting", "kneeling"]
    hands: int
    coupling: str | tuple[str, ...] = "good"

    def __post_init__(self) -> None:
        check_fields(self)
        if self.stance != "standing" or self.hands != 2:
            raise InputError(
                f"lifting: the equation is not for a person who is {self.stance} and uses "
                f"{self.hands} hands; {_SEATED}. Ask for static loads or strength instead"
            )
        if not 0.0 < self.hours <= 8.0 * (1.0 + _ON):
            raise InputError(f"lifting: expected more than 0 and up to 8 hours, got {self.hours:g}")
        couplings = (self.coupling,) if isinstance(self.coupling, str) else tuple(self.coupling)
        if not couplings or not set(couplings) <= set(COUPLINGS):
            expected = (
                f"lifts.coupling: expected one of {', '.join(COUPLINGS)} for all or each task"
            )
            raise InputError(f"{expected}, got {given_words(self.coupling)}")
        for name, value in _tasks(self).items():
            if np.any(value < 0.0):
                raise InputError(
                    f"lifts.{name}: expected numbers of 0 or more, got {value.min():g}"
                )


@dataclass(frozen=True, eq=False)
class Lifting:
    """What the lifting equation says of T tasks of a job, or of several jobs.

    Parameters
    ----------
    factors
        (..., T) from 0 to 1 by name: horizontal, vertical, travel, asymmetry, frequency, coupling.
    limit
        (..., T) [kg] the recommended weight limit of each task alone.
    index
        (..., T) the load over that limit; infinite where the limit is 0.
    composite
        (...) the composite index of all tasks of a job.
    version, status
        The form of the equation; where its numbers are from, and how sure each is.
    assumed
        What was not stated, in words.
    """

    factors: dict[str, Floats]
    limit: Floats
    index: Floats
    composite: Floats
    version: str
    status: str
    assumed: tuple[str, ...] = ("recovery: rest as long as the duration asks for (assumed)",)


@dataclass(frozen=True, eq=False)
class GripPlace:
    """Where the hands of P people are, for the lifting equation; see `Lifts`: (P,) each."""

    horizontal: Floats
    vertical: Floats
    asymmetry: Floats


def lifting(lifts: Lifts, *, rules: RuleSet | str = "strain_niosh_metric") -> Lifting:
    """Compute the recommended weight limit and the lifting index of tasks.

    Parameters
    ----------
    lifts
        The tasks; the last axis is the tasks of one job. Judge the end of a lift as a task of its
        own where the load must be placed with care.
    rules
        The form of the equation; "strain_niosh_metric", "strain_niosh_inch", a rule set or a path.

    Raises
    ------
    InputError
        If a value of the rule set has another shape.

    References
    ----------
    .. [1] DHHS (NIOSH) 94-110, section 2 (one task) and 3.2 (several tasks).

    Examples
    --------
    >>> import numpy as np
    >>> import workbench as wb
    >>> one = wb.Lifts(load=12, horizontal=0.4, vertical=0.3, travel=0.8,
    ...     asymmetry=np.radians(45), per_minute=3, hours=1.5, stance="standing", hands=2,
    ...     coupling="fair")
    >>> found = wb.lifting(one)
    >>> found.limit.round(3), found.index.round(2)
    (array([7.]), array([1.71]))
    """
    values = rule_set(rules)
    tasks = _tasks(lifts)
    rate = tasks["per_minute"] / 60.0
    low = tasks["vertical"] < values.number("v_low") * (1.0 - _ON)
    row = _duration(lifts.hours, values)
    factors = {
        "horizontal": _horizontal(tasks["horizontal"], values),
        "vertical": _vertical(tasks["vertical"], values),
        "travel": _travel(tasks["travel"], values),
        "asymmetry": _asymmetry(tasks["asymmetry"], values),
        "frequency": _frequency(rate, low, row, values),
        "coupling": _coupling(tasks["coupling"].astype(np.int64), low, values),
    }
    product = np.prod([factors[name] for name in factors if name != "frequency"], axis=0)
    unhurried = values.number("load_constant") * product
    limit = unhurried * factors["frequency"]
    index = _over(tasks["load"], limit)
    # falling by the index of each task alone: CLI = STLI_1 + sum of FILI_n (1 / FM(F_1 + ... + F_n)
    # - 1 / FM(F_1 + ... + F_(n - 1))), FILI being the index at FM = 1
    order = np.argsort(-index, axis=-1, kind="stable")
    rates: Floats = np.take_along_axis(rate, order, axis=-1)
    lower: Bools = np.take_along_axis(low, order, axis=-1)
    slow: Floats = np.take_along_axis(_over(tasks["load"], unhurried), order, axis=-1)
    up_to = np.cumsum(rates, axis=-1)
    after = _inverse(_frequency(up_to, lower, row, values))
    before = _inverse(_frequency(up_to - rates, lower, row, values))
    more = after - np.where(np.isfinite(before), before, 0.0)
    counts = (slow > 0.0) & np.isfinite(slow)
    added = np.multiply(slow, more, out=np.zeros_like(slow), where=counts)
    return Lifting(
        factors=factors,
        limit=limit,
        index=index,
        composite=index.max(axis=-1) + added[..., 1:].sum(axis=-1),
        version=values.description,
        status=values.status(*values.values),
    )


def grip_place(placed: Placed, *, floor: float = 0.0) -> GripPlace:
    """Measure where the hands of people are, for the lifting equation.

    The grip of a hand is the centre of gravity of the hand, near its knuckles. Straight ahead is
    where the feet point together.

    Parameters
    ----------
    placed
        P postures in the world, z upward.
    floor
        Height [m] of the floor.

    Raises
    ------
    InputError
        If the body lacks hands or feet, or they are outside the logical window.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> both = {joint: {"flexion": 60} for joint in ("LS", "RS")}
    >>> found = wb.grip_place(wb.place(body, wb.pose(body, both)))
    >>> found.horizontal.round(2), found.vertical.round(2), found.asymmetry.round(2)
    (array([0.52]), array([1.1]), array([0.]))
    """
    check_segments(placed, ("LHN", "RHN", "LF", "RF"), "lifts")
    body = placed.body
    world = placed.world_from_segment
    hands = world[..., 3][:, [body.segment("LHN"), body.segment("RHN")]].mean(axis=1)
    ankles = joint_points(placed, [body.joint("LA"), body.joint("RA")]).mean(axis=1)
    ahead = world[..., :2, 0][:, [body.segment("LF"), body.segment("RF")]].sum(axis=1)
    way = (hands - ankles)[:, :2]
    cross = ahead[:, 0] * way[:, 1] - ahead[:, 1] * way[:, 0]
    return GripPlace(
        horizontal=np.linalg.norm(way, axis=1),
        vertical=hands[:, 2] - floor,
        asymmetry=np.abs(np.arctan2(cross, np.sum(ahead * way, axis=1))),
    )


def _tasks(lifts: Lifts) -> dict[str, Floats]:
    """The arrays of tasks, of one shape (..., T), with the couplings by their number."""
    given = lifts.coupling
    couplings = (given,) if isinstance(given, str) else given
    index = [float(COUPLINGS.index(name)) for name in couplings]
    values = {name: np.asarray(getattr(lifts, name), dtype=np.float64) for name in _ARRAYS}
    values["coupling"] = np.array(index if len(index) > 1 else index[0])
    try:
        shaped = np.broadcast_arrays(*values.values())
    except ValueError:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in values.items())
        raise InputError(f"lifts: expected arrays of one shape, got {shapes}") from None
    return {name: np.atleast_1d(value) for name, value in zip(values, shaped, strict=True)}


def _over(load: Floats, limit: Floats) -> Floats:
    """Load over limit; infinite for a load whose limit is 0."""
    endless = np.where(load > 0.0, np.inf, 0.0)
    return np.divide(load, limit, out=endless, where=limit > 0.0)


def _horizontal(h: Floats, rules: RuleSet) -> Floats:
    """HM = h_least / h, 1 nearer than h_least, 0 beyond h_most."""
    least = rules.number("h_least")
    return np.where(h > rules.number("h_most") * (1.0 + _ON), 0.0, least / np.maximum(h, least))


def _vertical(v: Floats, rules: RuleSet) -> Floats:
    """VM = 1 - slope |v - v_best|, 0 above v_most."""
    factor = 1.0 - rules.number("v_slope") * np.abs(v - rules.number("v_best"))
    return np.where(v > rules.number("v_most") * (1.0 + _ON), 0.0, np.maximum(factor, 0.0))


def _travel(d: Floats, rules: RuleSet) -> Floats:
    """DM = share + constant / d, 1 up to d_least, 0 beyond d_most."""
    least = rules.number("d_least")
    factor = rules.number("d_share") + rules.number("d_constant") / np.maximum(d, least)
    near = np.where(d <= least * (1.0 + _ON), 1.0, np.minimum(factor, 1.0))
    return np.where(d > rules.number("d_most") * (1.0 + _ON), 0.0, near)


def _asymmetry(a: Floats, rules: RuleSet) -> Floats:
    """AM = 1 - slope a, 0 beyond a_most."""
    factor = np.maximum(1.0 - rules.number("a_slope") * a, 0.0)
    return np.where(a > rules.number("a_most") * (1.0 + _ON), 0.0, factor)


def _coupling(coupling: Ints, low: Bools, rules: RuleSet) -> Floats:
    """CM of the coupling, for low grips (True) and high ones."""
    lower = rules.shaped("coupling_low", len(COUPLINGS))[coupling]
    return np.where(low, lower, rules.shaped("coupling_high", len(COUPLINGS))[coupling])


def _duration(hours: float, rules: RuleSet) -> int:
    """The row of the first duration that is no shorter."""
    durations = rules.shaped("durations", None)
    row = int(np.searchsorted(durations * (1.0 + _ON), 3600.0 * hours, side="left"))
    if row == len(durations):
        raise InputError(f"rule set {rules.name}: durations end before {hours:g} hours")
    return row


def _frequency(rate: Floats, low: Bools, row: int, rules: RuleSet) -> Floats:
    """FM of rates [1/s], straight between those of the table; 0 above the last one that is allowed,
    which is another for low grips (True)."""
    table = rules.shaped("frequencies", None)
    factors = rules.shaped("frequency_factor", None, len(table))[row]
    last = table[np.flatnonzero(factors)[-1]]
    most = np.where(low, min(rules.shaped("low_most", None)[row], last), last)
    return np.where(rate > most * (1.0 + _ON), 0.0, np.interp(rate, table, factors))


def _inverse(factor: Floats) -> Floats:
    """1 / FM, infinite where it is 0."""
    return np.divide(1.0, factor, out=np.full_like(factor, np.inf), where=factor > 0.0)
