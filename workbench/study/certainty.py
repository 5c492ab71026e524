"""Certainty: between which margins the true ones lie, in the positions that people end up in.

The search of a position looks at the spheres alone. Of the position that it ends with this asks
once more, with spheres as large as the true surface may be and as small. Each person is then
certain to fit, certain not to fit there, or undecided by the body's own fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.model.accommodation import OF_SURFACE
from workbench.model.arrays import Ints
from workbench.study.checks.margins import Asked, Bounds
from workbench.study.checks.table import bounds_of
from workbench.study.positions import Fitted
from workbench.study.situation import Situation

__all__ = ["true_bounds"]


def true_bounds(
    asked: Sequence[Asked],
    places: Sequence[tuple[Ints, Sequence[Situation]]],
    fitted: Fitted,
) -> Bounds:
    """Bound the true margins of people in the positions that suit them best.

    Parameters
    ----------
    places
        The people there, as of `found_places`.
    fitted
        The positions, with the margins of the R requirements there.

    Returns
    -------
    Bounds
        (B, R). A requirement that does not depend on the surface has its margin as both bounds.
    """
    margin = fitted.tried.margin
    found = Bounds(margin.copy(), margin.copy())
    checks = [one.requirement.check for one in asked]
    columns = np.flatnonzero(np.isin(checks, OF_SURFACE))
    if not len(columns):
        return found
    some = [asked[r] for r in columns.tolist()]
    for rows, there in places:
        found.put(rows, columns, bounds_of(there, some))
    return found
