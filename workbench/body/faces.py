"""Triangulate flat regions that are given by their outlines, with holes and islands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints

__all__ = ["filled_loops"]


def filled_loops(loops: Sequence[Floats]) -> tuple[Floats, Ints]:
    """Triangulate what lies inside loops. A point is inside if an odd number of loops enclose it.

    Parameters
    ----------
    loops
        Closed curves (K, 2) [m], of any orientation.

    Returns
    -------
    tuple of Floats and Ints
        Corners (V, 2) [m] and anticlockwise triangles (T, 3); both are empty if nothing is inside.

    Raises
    ------
    InputError
        If a loop is not finite.
    """
    import manifold3d

    if not all(np.isfinite(loop).all() for loop in loops):
        raise InputError("faces: loops must be finite")
    region = manifold3d.CrossSection(
        [np.asarray(loop) for loop in loops], manifold3d.FillRule.EvenOdd
    )
    outlines = region.to_polygons()
    if not outlines:
        return np.empty((0, 2)), np.empty((0, 3), dtype=np.int64)
    triangles = np.asarray(manifold3d.triangulate(outlines), dtype=np.int64).reshape(-1, 3)
    return np.concatenate(outlines).astype(np.float64), triangles
