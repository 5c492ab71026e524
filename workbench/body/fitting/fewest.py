"""Compute a lower bound of the number of spheres, to compare a fit with the best possible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_array

from workbench.body.fitting.candidates import Limits
from workbench.body.fitting.cover import held_rows
from workbench.body.fitting.problem import Joints, density, prepared
from workbench.body.fitting.regions import Regions
from workbench.body.surface import Surface
from workbench.errors import InputError

__all__ = ["fewest_spheres"]


def fewest_spheres(
    surface: Surface,
    limits: Limits,
    joints: Joints,
    regions: Regions,
    *,
    targets: int = 2500,
    seed: int = 0,
) -> int:
    """Compute a number of candidate spheres below which no union holds the surface.

    It is the linear relaxation of the set cover: each target is held by shares of spheres that add up
    to 1 or more, joint spheres are whole, and the least sum is rounded up. A sample of the targets
    stands for all, which can only lower the bound.

    Parameters
    ----------
    surface, limits, joints, regions
        As for `fit_regions`.
    targets
        Number of targets, about.
    seed
        0 or more.

    Raises
    ------
    InputError
        If the linear program is not solved.

    References
    ----------
    Huangfu, Q. & Hall, J. A. J. (2018), Parallelizing the dual revised simplex method, Mathematical
    Programming Computation 10, 119-142 (HiGHS).
    """
    spacing, sources = density(surface, limits)
    problem = prepared(
        surface, limits, spacing=spacing, sources=sources, joints=joints, regions=regions, seed=seed
    )
    every = max(1, len(problem.targets) // targets)
    some = problem.targets.at(np.arange(0, len(problem.targets), every))
    # the full tolerance, not the 97 % that the search uses
    some = replace(some, margin=np.where(some.margin > 0, limits.inward, some.margin))
    usable = problem.radius(limits) > 0
    start, item = held_rows(some, problem.candidates.at(usable), problem.radius(limits)[usable])
    held = csr_array((np.ones(len(item)), item, start), shape=(len(start) - 1, len(some))).T.tocsr()
    held = held[np.flatnonzero(np.diff(held.indptr) > 0)]
    return int(np.ceil(_least_sum(held, len(joints.radius)) - 1e-6))


def _least_sum(held: csr_array, required: int) -> float:
    """The least sum of shares x >= 0 with H x >= 1; the first `required` shares are 1 or more."""
    low = np.zeros(held.shape[1])
    low[:required] = 1.0
    found = linprog(  # type: ignore[call-overload]  # sparse is fine
        np.ones(len(low)),
        A_ub=-held,
        b_ub=-np.ones(held.shape[0]),
        bounds=np.column_stack([low, np.full(len(low), np.inf)]),
        method="highs-ipm",
    )
    if not found.success:
        raise InputError(f"the bound of the fewest spheres could not be found ({found.message})")
    return float(found.fun)
