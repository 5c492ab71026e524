"""Environments with parts and controls elsewhere, as a call in Python says it: names to
displacements."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from workbench.errors import InputError, UsageError, one_of
from workbench.files.names import matching
from workbench.files.schema import plausible, to_metres
from workbench.files.study.doubts import far_words
from workbench.files.study.moves import riding_words
from workbench.model.arguments import caller_level, given_words
from workbench.model.environment import Environment
from workbench.model.moves import Move, displaced

__all__ = ["moved_environment", "moved_kind"]


def moved_environment(environment: Environment, displacements: Mapping[str, Any]) -> Environment:
    """Displace what is named. See `Environment.moved`."""
    moves = []
    taken: dict[str, str] = {}
    for name, by in displacements.items():
        kind = moved_kind(environment, name)
        names = matching([name], environment.parts) if kind == "parts" else (name,)
        if riding := riding_words(environment, names):
            raise InputError(f"environment {environment.name}: {riding}")
        for one in names:
            before = taken.setdefault(f"{kind} {one}", name)
            if before != name:
                raise InputError(f"displacements: {one!r} is moved by {before!r} and by {name!r}")
        shift = _shift(name, by)
        controls = names if kind == "controls" else ()
        moves.append(Move(names if kind == "parts" else (), controls, shift))
    for doubt in far_words("displacements", [move.by for move in moves], environment):
        warnings.warn(doubt, stacklevel=caller_level())
    return displaced(environment, moves)


def moved_kind(environment: Environment, name: object) -> str:
    """Whether a name means "parts", by a pattern too, or else "controls".

    Raises
    ------
    InputError
        If it means neither.
    """
    if isinstance(name, str) and matching([name], environment.parts):
        return "parts"
    controls = [control.name for control in environment.controls]
    if name in controls:
        return "controls"
    valid = one_of(str(name), [*environment.parts, *controls])
    raise InputError(f"environment {environment.name} has no part and no control {name!r}; {valid}")


def _shift(name: str, by: Any) -> tuple[float, float, float]:
    """A displacement [m] of three lengths."""
    row = by.tolist() if isinstance(by, np.ndarray) else by
    is_row = isinstance(row, (list, tuple)) and len(row) == 3
    if is_row and not any(isinstance(v, bool) for v in row):
        try:
            x, y, z = (plausible(to_metres(v) if isinstance(v, str) else v + 0.0) for v in row)
        except (ValueError, TypeError):
            pass
        else:
            if all(map(math.isfinite, (x, y, z))):
                return float(x), float(y), float(z)
    raise UsageError(
        f"displacements[{name!r}]: expected three lengths x, y, z ([m], or texts such as '20 mm'), "
        f"got {given_words(by)}"
    )
