"""Findings of pairs of segments and parts, or of two segments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats
from workbench.model.contacts import Clearance
from workbench.model.environment import Environment
from workbench.model.result import Finding

__all__ = ["NearPairs", "pair_findings"]


@dataclass(frozen=True, eq=False)
class NearPairs:
    """Clearances of pairs of segments and parts (or segments), and what is asked of them.

    Parameters
    ----------
    near
        Of one pose.
    limit
        (N, K) [m] the distance may not be below it.
    keep
        (N, K) the pairs that are asked about.
    person, other_person
        The roles.
    """

    near: Clearance
    limit: Floats
    keep: Bools
    person: str
    other_person: str = ""


def pair_findings(asked: NearPairs, case: str) -> Iterator[Finding]:
    """The worst finding, the one most in doubt, and every breach."""
    near = asked.near
    distance = near.distance[0]
    wanted = asked.keep & np.isfinite(distance)
    margin = np.where(wanted, distance - asked.limit, np.inf)
    if not np.isfinite(margin).any():
        return
    known = _surface(near)
    least = int(np.argmin(margin))
    in_doubt = int(np.argmin(margin - np.nan_to_num(known[0])))
    breaches = np.flatnonzero(margin.ravel() < 0).tolist()
    for at in dict.fromkeys([least, in_doubt, *breaches]):
        row, column = (int(k) for k in np.unravel_index(at, margin.shape))
        where = (0, row, column)
        polygon, other_sphere = near.met(where)
        yield Finding(
            case=case,
            person=asked.person,
            other_person=asked.other_person,
            subject=near.name(where),
            target=near.other_name(where),
            value=float(distance[row, column]),
            limit=float(asked.limit[row, column]),
            point=tuple(near.point[where].tolist()),
            surface_known_to=float(known[0 if margin[row, column] >= 0 else 1, row, column]),
            sphere=int(near.sphere[where]),
            polygon=polygon,
            other_sphere=other_sphere,
        )


def _surface(near: Clearance) -> Floats:
    """(2, N, K) [m] how far the true surface may lie outside and inside the spheres of each pair,
    NaN where not known; parts of an environment are where they are."""
    own = near.body.fit_error[0].T[:, :, None]
    if isinstance(near.other, Environment):
        return np.broadcast_to(own, (2, *near.distance.shape[1:]))
    return own + near.other.fit_error[0].T[:, None, :]
