"""Limits at the 5th and 95th percentile of several measures do not serve 90 %: each leaves out
other people."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.body.people.percentile import percentile_values
from workbench.model.arrays import Bools, Floats
from workbench.model.population import COCKPIT, SEXES, Population, PopulationModel, check_measures


def inside_limits(people: Population, low: Floats, high: Floats) -> Bools:
    """(P,) whether all measures of a person lie within limits [m; kg], inclusive.

    low, high: (M,) for everybody, or (2, M) a row for each of SEXES.
    """
    by_sex = [
        np.broadcast_to(limit, (len(SEXES), len(people.names)))[people.sex] for limit in (low, high)
    ]
    return np.asarray(
        np.all((people.measures >= by_sex[0]) & (people.measures <= by_sex[1]), axis=1)
    )


def inside_own_percentiles(
    people: Population,
    *,
    measures: Sequence[str] = COCKPIT,
    low: float = 5,
    high: float = 95,
    limits: Population | PopulationModel | None = None,
) -> Bools:
    """(P,) whether a person lies between two percentiles [%] of their own sex in all of these
    measures.

    limits: where the percentiles come from; the people themselves where not given.
    """
    source: Population | PopulationModel = people if limits is None else limits
    check_measures(measures, source.names)
    columns = [source.names.index(name) for name in measures]
    edges = np.full((2, len(SEXES), len(columns)), np.nan)
    for code in np.unique(people.sex):
        edges[:, code] = percentile_values(source, SEXES[code], [low, high])[:, columns]
    return inside_limits(people.of(measures), *edges)
