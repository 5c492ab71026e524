"""The instrument panel: three facets, what is set into them, and the coaming above. Lengths [mm]."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray
from solids import box, disc, frame, hull, loft, mirrored, place, prism, shell, sweep, union

__all__ = ["panel_parts"]

Floats = NDArray[np.float64]
Parts = dict[str, Manifold]

FOLD_X, FOLD_Y, FOOT_Z = 622.0, 180.0, 575.0  # where the facets meet at their foot
TILT, WRAP = radians(10.0), radians(8.0)  # top away from the pilot; outer facets turned toward him
THICK = 5.0
BEZEL = 42.0


def facet(turn: float, y: float) -> Floats:
    """The placement of a facet: x outward to the left, y up the face, z out of it toward the pilot."""
    u = np.array([-sin(turn), cos(turn), 0.0])
    away = np.array([cos(turn), sin(turn), 0.0])
    v = sin(TILT) * away + [0.0, 0.0, cos(TILT)]
    return frame((FOLD_X, y, FOOT_Z), -u, v)


LEFT, CENTRE, RIGHT = facet(WRAP, FOLD_Y), facet(0.0, 0.0), facet(-WRAP, -FOLD_Y)
# On the left facet x is negative outboard, on the right one positive.


def behind(depth: float) -> Manifold:
    """All that lies at least so far behind the face of one of the facets."""
    slab = box((-1500.0, -900.0, -900.0), (1500.0, 900.0, -depth))
    return union([place(slab, placement) for placement in (LEFT, CENTRE, RIGHT)])


def plate() -> Manifold:
    """The panel without its holes."""
    half = [(0, 852), (120, 850), (260, 845), (380, 834), (470, 818), (516, 802), (534, 784), (540, 620), (530, 592), (505, 575), (118, 575), (104, 540), (0, 540)]
    outline = half + [(-y, z) for y, z in half[-2:0:-1]]
    return (behind(0.0) - behind(THICK)) ^ prism(outline, "x", 300.0, 900.0)
