"""Move parts of an environment, such as a seat along its rails."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.model.adjusting import move_parts
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
    return move_parts(environment, parts, None, by)
