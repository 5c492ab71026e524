"""Certainty: between which margins the true ones lie, in the positions that people end up in.

The search of a position looks at the spheres alone. Of the position that it ends with this asks
once more, with spheres as large as the true surface may be and as small. Each person is then
certain to fit, certain not to fit there, or undecided by the body's own fit. Who fits and is
undecided there is tried in other positions, with spheres as large as the true surface may be.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from workbench.model.accommodation import OF_SURFACE, certainly_met, met_of
from workbench.model.arrays import Bools, Ints
from workbench.model.workplace import Workplace
from workbench.study.checks.margins import Asked, Bounds
from workbench.study.checks.table import bounds_of
from workbench.study.positions import (
    FittedBody,
    comfortable_situations,
    fitted_positions,
    lattice,
)
from workbench.study.settings import at_setting, renewed
from workbench.study.situation import Occupants, Situation

__all__ = ["certain_elsewhere", "true_bounds"]


def true_bounds(
    asked: Sequence[Asked],
    places: Sequence[tuple[Ints, Sequence[Situation]]],
    fitted: FittedBody,
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


def certain_elsewhere(
    place: Workplace,
    asked: Sequence[Asked],
    who: Occupants,
    fitted: FittedBody,
    bounds: Bounds,
    *,
    proceed: Callable[[], None] = lambda: None,
) -> Bools:
    """Find who fits for certain in another position than that of the margins.

    People who fit where they are, but not wherever their true surface lies, are tried at the
    setting that they have, all over the travel of the seat, down to `positions.FINEST`.

    Parameters
    ----------
    bounds
        (B, R) as of `true_bounds`.
    proceed
        As of `fitted_positions`.

    Returns
    -------
    Bools
        (B,). Not of those who are certain where they are, nor where the bounds are not known.
    """
    margin = fitted.tried.margin
    known = np.isnan(margin) | np.isfinite(bounds.low)
    undecided = met_of(margin).all(axis=1) & known.all(axis=1)
    undecided &= ~certainly_met(margin, bounds.low).all(axis=1)
    found = np.zeros(len(who), dtype=np.bool_)
    if len(lattice(place.travel)) < 2:
        return found
    for setting in np.unique(fitted.setting[undecided], axis=0):
        rows = np.flatnonzero(undecided & (fitted.setting == setting).all(axis=1))
        there = replace(at_setting(place, setting), adjusts=())
        certain = [replace(one, for_certain=True) for one in renewed(there, asked)]
        some = who.rows(rows)
        no_sets = np.zeros((len(asked), 0), dtype=np.bool_)
        comfortable = comfortable_situations(there, some)
        here = fitted.tried.rows(rows)
        here.margin[:] = bounds.low[rows]
        again = fitted_positions(
            there, certain, no_sets, some, comfortable, here=here, proceed=proceed
        )
        found[rows] = met_of(again.tried.margin).all(axis=1)
    return found
