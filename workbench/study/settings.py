"""The settings of the adjustments that a role may make, and its workplace in each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Adjustment
from workbench.model.surroundings import adjusted
from workbench.model.units import plain
from workbench.model.workplace import Workplace
from workbench.posture.seating.posture import DECIMALS
from workbench.study.checks.margins import Asked

__all__ = [
    "adjustments_of",
    "at_setting",
    "nominal_setting",
    "renewed",
    "setting_axes",
    "setting_text",
    "settings_of",
]

SLIDE_SPACING = 0.03
"""Distance [m] between the settings of a slide that are tried, at most."""
TURN_SPACING = np.radians(5.0)
"""Angle [rad] between the settings of a turn that are tried, at most."""
MOST_SETTINGS = 81
"""Settings that are tried in combination; where there would be more, each adjustment is tried at its
nominal setting and its ends."""


def adjustments_of(place: Workplace) -> tuple[Adjustment, ...]:
    """The A adjustments that the role may make."""
    return tuple(place.environment.adjustment(name) for name in place.adjusts)


def setting_text(one: Adjustment, value: float) -> str:
    """An adjustment and where it is set [m or rad]: "wheel telescope at −20 mm"."""
    amount = value / one.shown_unit
    words = f"{amount:+.1f} degrees" if one.turns else f"{amount:+.0f} mm"
    return f"{plain(one.name)} at {words.replace('-', '−')}"


def nominal_setting(place: Workplace) -> Floats:
    """(A,) [m or rad] the setting in which a role finds its workplace."""
    return np.array([one.at for one in adjustments_of(place)], dtype=np.float64)


def setting_axes(place: Workplace) -> list[Floats]:
    """Of each adjustment the settings that are tried, rising: the nominal one, the ends of its
    travel, and what lies between."""
    adjustments = adjustments_of(place)
    axes = [_axis(one, fine=True) for one in adjustments]
    if np.prod([len(axis) for axis in axes]) > MOST_SETTINGS:
        axes = [_axis(one, fine=False) for one in adjustments]
    return axes


def _axis(one: Adjustment, *, fine: bool) -> Floats:
    """The settings of one adjustment. fine: with those between nominal setting and ends."""
    spacing = TURN_SPACING if one.turns else SLIDE_SPACING
    sides = []
    for end in one.travel:
        count = int(np.ceil(abs(end - one.at) / spacing - 1e-9)) if fine else int(end != one.at)
        sides.append(np.linspace(one.at, end, count + 1))
    return np.concatenate([sides[0][:0:-1], sides[1]])


def settings_of(place: Workplace) -> Floats:
    """(S, A) [m or rad] the other settings than the nominal one, nearest to it first: by the sum of
    the squares of the shares of the travels that they take."""
    adjustments = adjustments_of(place)
    if not adjustments:
        return np.zeros((0, 0))
    nominal = nominal_setting(place)
    every = np.array(list(product(*setting_axes(place))))
    size = np.array([one.travel[1] - one.travel[0] for one in adjustments])
    way = np.linalg.norm((every - nominal) / size, axis=1)
    order = np.argsort(np.round(way, DECIMALS), kind="stable")
    return every[order[way[order] > 0]]


def at_setting(place: Workplace, setting: Sequence[float] | Floats) -> Workplace:
    """The workplace with the adjustments that the role may make set (A,) [m or rad]."""
    return _at_setting(place, tuple(float(value) for value in setting))


@lru_cache(maxsize=32)
def _at_setting(place: Workplace, setting: tuple[float, ...]) -> Workplace:
    """The workplace in a setting, once for each, so that it is indexed once."""
    wanted = dict(zip(place.adjusts, setting, strict=True))
    environment = adjusted(place.environment, wanted)
    return place if environment is place.environment else replace(place, environment=environment)


def renewed(place: Workplace, asked: Sequence[Asked]) -> tuple[Asked, ...]:
    """Requirements with their controls where the environment of a workplace has them."""
    controls = {control.name: control for control in place.environment.controls}
    return tuple(
        one if one.control is None else replace(one, control=controls[one.control.name])
        for one in asked
    )
