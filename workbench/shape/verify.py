"""Does a union of spheres keep to its tolerances everywhere? What does not is handed back, to be covered too.

The surface is proved triangle by triangle, not sampled. What the spheres leave hollow inside is sampled on their own
exposed surface: a place there that is deeper under the surface than the inward tolerance is a void.
"""

from __future__ import annotations

import numpy as np

from workbench.kernels.balls import widest_gap
from workbench.model.arrays import Floats, Ints
from workbench.shape.candidates import Limits
from workbench.shape.fit_quality import exposed_points
from workbench.shape.surface import Surface

__all__ = ["bare_places", "hollow_places"]

FINE = 0.01
"""Share of the tolerance kept back, so that what is proved to within this share holds in full."""


def bare_places(corners: Floats, centre: Floats, radius: Floats, limits: Limits) -> tuple[Floats, Ints]:
    """Points (k, 3) of triangles (T, 3, 3) that are not proved within limits.inward of the union; their triangles."""
    points, gaps = np.empty((len(corners), 3)), np.empty((len(corners), 2))
    widest_gap(corners, centre, radius, (1 - FINE) * limits.inward, FINE * limits.inward, points, gaps)
    # rounding of the last digits is not a fault
    bad = np.flatnonzero(gaps[:, 1] > limits.inward * (1 + 1e-9))
    return points[bad], bad


def hollow_places(surface: Surface, centre: Floats, radius: Floats, limits: Limits, *, count: int) -> tuple[Floats, Ints]:
    """Points (k, 3) on the exposed spheres that lie deeper than limits.inward under the surface; their spheres."""
    exposed, owner = exposed_points(centre, radius, count)
    deep = surface.distance(exposed) < -(1 - 4 * FINE) * limits.inward
    return exposed[deep], owner[deep]
