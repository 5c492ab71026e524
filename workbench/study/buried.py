"""Controls that nobody can get at: those inside solid parts."""

from __future__ import annotations

import numpy as np

from workbench.geometry.polygon import point_winding
from workbench.model.environment import Environment

__all__ = ["buried_controls"]


def buried_controls(environment: Environment) -> list[str]:
    """In words, the controls whose point is inside a solid part that is not their own."""
    solids = np.flatnonzero(environment.solid & ~environment.hidden).tolist()
    shells = {environment.parts[k]: environment.triangle_corners(k) for k in solids}
    notes = []
    for control in environment.controls:
        for name, corners in shells.items():
            if name in control.own_parts:
                continue
            if abs(point_winding(*control.at, corners, 0, len(corners))) > 0.5:
                notes.append(
                    f"control {control.name!r} is inside the solid part {name!r}: "
                    f"a hand gets there as deep as the part allows; check where it is"
                )
    return notes
