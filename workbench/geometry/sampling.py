"""Places spread evenly over a triangle, always the same ones."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["even_places"]

_STEPS = 0.7548776662466927, 0.5698402909980532
"""1 / p and 1 / p^2 of the plastic number p: steps of the R2 sequence (Roberts 2018)."""


def even_places(count: int, first: float = 0.5) -> tuple[Floats, Floats]:
    """Spread places over a triangle by the R2 sequence, folded into it.

    Parameters
    ----------
    count
        Of places.
    first
        Both shares of the first place, 0 to 1: 1/3 is the centroid.

    Returns
    -------
    tuple[Floats, Floats]
        (count,) the shares u and v of the two sides from the first corner: a + u (b - a) + v (c - a).
    """
    number = np.arange(count)
    u, v = ((first + number * step) % 1.0 for step in _STEPS)
    over = u + v > 1.0
    return np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
