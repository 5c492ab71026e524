"""Controls that nobody can get at: those inside solid parts."""

from __future__ import annotations

import numpy as np

from workbench.geometry.polygon import point_winding
from workbench.model.environment import Environment

__all__ = ["buried_controls"]


def buried_controls(environment: Environment) -> list[str]:
    """In words, the controls whose point is inside a solid part that is not their own."""
    corners = environment.vertices[environment.triangles]
    notes = []
    for control in environment.controls:
        for k in np.flatnonzero(environment.solid & ~environment.hidden):
            if environment.parts[k] == control.part:
                continue
            first, last = (
                int(environment.triangle_start[environment.part_start[k + i]]) for i in (0, 1)
            )
            if abs(point_winding(*control.at, corners, first, last)) > 0.5:
                notes.append(
                    f"control {control.name!r} is inside the solid part {environment.parts[k]!r}: "
                    f"a hand gets there as deep as the part allows; check where it is"
                )
    return notes
