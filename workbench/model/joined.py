"""Two environments as one: belts and airbags set into a cockpit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Ints
from workbench.model.environment import Environment

__all__ = ["joined"]


_STACKED = (
    "vertices",
    "normal",
    "offset",
    "circle_centre",
    "circle_radius",
    "solid",
    "hidden",
    "see_through",
)
"""Arrays of an environment whose rows follow one another."""


def joined(environment: Environment, more: Environment) -> Environment:
    """The environment with the parts of another behind its own; seats, points and controls are its
    own.

    InputError where a part's name is in both.
    """
    twice = sorted(set(environment.parts) & set(more.parts))
    if twice:
        raise InputError(f"a part {twice[0]!r} is in environment {environment.name} already")
    behind = len(environment.parts)
    allowances = tuple(replace(rule, part=rule.part + behind) for rule in more.allowances)
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(environment, name), getattr(more, name)]) for name in _STACKED
    }
    for name in ("edges", "triangles"):
        behind_them = getattr(more, name) + len(environment.vertices)
        arrays[name] = np.concatenate([getattr(environment, name), behind_them])
    for name in ("part_start", "edge_start", "triangle_start"):
        arrays[name] = _continued(getattr(environment, name), getattr(more, name))
    return replace(
        environment,
        parts=(*environment.parts, *more.parts),
        allowances=(*environment.allowances, *allowances),
        quality=(*environment.quality, *more.quality),
        warnings=(*environment.warnings, *more.warnings),
        **arrays,
    )


def _continued(start: Ints, more: Ints) -> Ints:
    """Starts of groups, then those of others behind them."""
    return np.concatenate([start, more[1:] + start[-1]])
