"""The spheres and parts that a criterion is about."""

from __future__ import annotations

import numpy as np

from workbench.contact.clearance_pairs import ClearancePair
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment

__all__ = ["pair_of"]


def pair_of(body: Body, environment: Environment, criterion: Criterion) -> ClearancePair:
    """Find the spheres and parts that a clearance or contact criterion is about.

    Parameters
    ----------
    body
        Any of the bodies; only its names are read.

    Returns
    -------
    ClearancePair
        For `contact` with the overlap that is allowed added back.
    """
    if criterion.subparts:
        spheres = np.isin(body.subparts, criterion.subparts)
    else:
        spheres = np.isin(np.array(body.segments)[body.sphere_segment], criterion.segments)
    parts = np.isin(environment.parts, criterion.parts)
    return ClearancePair(spheres, parts, criterion.check == "contact")
