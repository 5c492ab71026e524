"""Move parts of an environment, such as a seat along its rails."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.model.environment import Environment

__all__ = ["moved"]


def moved(environment: Environment, parts: Iterable[str], shift: ArrayLike) -> Environment:
    """Displace parts of an environment.

    Seats, points and controls stay where they are: they are positions at rest.

    Parameters
    ----------
    environment
        The environment.
    parts
        Names of the parts that move.
    shift
        (3,) [m].

    Raises
    ------
    InputError
        If a part is unknown.
    UsageError
        If the displacement is not three finite numbers.
    """
    by = np.asarray(shift, dtype=np.float64)
    if by.shape != (3,) or not np.all(np.isfinite(by)):
        raise UsageError(f"a shift is three finite numbers [m], got {shift!r}")
    chosen = np.zeros(len(environment.parts), dtype=np.bool_)
    chosen[[environment.part(name) for name in parts]] = True
    if not chosen.any() or not by.any():
        return environment
    polygon = chosen[environment.polygon_part]
    triangle = np.repeat(polygon, np.diff(environment.triangle_start))
    vertex = np.zeros(len(environment.vertices), dtype=np.bool_)
    vertex[environment.triangles[triangle].ravel()] = True
    return replace(
        environment,
        vertices=environment.vertices + np.where(vertex[:, None], by, 0.0),
        offset=environment.offset + np.where(polygon, environment.normal @ by, 0.0),
        circle_centre=environment.circle_centre + np.where(polygon[:, None], by, 0.0),
    )
