"""A lower bound of how few spheres can do, so that a fit can say how far from the fewest it is."""

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
    """No union of candidate spheres (those the search chooses from) holds the surface with fewer
    than this.

    The set cover as a linear program: each target held by shares of spheres that add up to 1 or
    more, joint spheres whole; the least sum, rounded up, is a bound for whole spheres too.
    `targets` of the surface stand for all of it, which can only make the bound smaller. Solved by
    HiGHS (Huangfu & Hall 2018, DOI 10.1007/s12532-017-0130-5).
    """
    spacing, sources = density(surface, limits)
    problem = prepared(
        surface, limits, spacing=spacing, sources=sources, joints=joints, regions=regions, seed=seed
    )
    some = problem.targets.at(
        np.arange(0, len(problem.targets), max(1, len(problem.targets) // targets))
    )
    # the full tolerance, not the 97 % that the search keeps in hand
    some = replace(some, margin=np.where(some.margin > 0, limits.inward, some.margin))
    usable = problem.radius(limits) > 0
    start, item = held_rows(some, problem.candidates.at(usable), problem.radius(limits)[usable])
    held = csr_array((np.ones(len(item)), item, start), shape=(len(start) - 1, len(some))).T.tocsr()
    held = held[np.flatnonzero(np.diff(held.indptr) > 0)]
    low = np.zeros(held.shape[1])
    low[: len(joints.radius)] = 1.0
    bounds = np.column_stack([low, np.full(len(low), np.inf)])
    found = linprog(  # type: ignore[call-overload]  # sparse is fine
        np.ones(len(low)),
        A_ub=-held,
        b_ub=-np.ones(held.shape[0]),
        bounds=bounds,
        method="highs-ipm",
    )
    if not found.success:
        raise InputError(f"the bound of the fewest spheres could not be found ({found.message})")
    return int(np.ceil(found.fun - 1e-6))
