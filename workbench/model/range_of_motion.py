"""Reduce the range of motion of a body's joints: people whose joints turn less than a healthy adult's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.model.body import Body
from workbench.model.posing import motion_of
from workbench.model.stops import StopKind

__all__ = ["reduced"]


def reduced(body: Body, changes: Mapping[tuple[str, str], tuple[float, bool]]) -> Body:
    """Return a body with other joint stops.

    A shoulder, whose stop is a spherical polygon, becomes a cone with the half-angles of its
    motions. Limits that depend on another motion are scaled by a share, and replaced by an angle.

    Parameters
    ----------
    body
        B bodies of one topology.
    changes
        By joint and motion how far it turns [rad], or as a share of what it did where the second is
        True.

    Raises
    ------
    InputError
        If there is no such joint or motion, or it would turn farther than before.
    """
    stops = body.stops
    limits = stops.limits.copy()
    kind = stops.kind.copy()
    couplings = list(stops.couplings)
    for (name, motion), (value, share) in changes.items():
        j = body.joint(name)
        axis, sign = motion_of(body, j, motion)
        side = 0 if sign > 0 else 1
        before = float(limits[j, axis, side])
        limits[j, axis, side] = value * before if share else value
        if limits[j, axis, side] > before + 1e-9:
            raise InputError(
                f"joint {name}: {motion} ends at {np.degrees(before):g} degrees; it can be reduced, "
                f"got {np.degrees(value):g}: a joint that turns farther is another body file's"
            )
        if kind[j] == StopKind.POLYGON:
            kind[j] = StopKind.CONE
        own = [k for k in couplings if (k.joint, k.axis, k.side) == (j, axis, side)]
        couplings = [k for k in couplings if k not in own]
        if share:
            couplings += [replace(k, limit=(value * k.limit[0], value * k.limit[1])) for k in own]
    other = replace(stops, kind=kind, limits=limits, couplings=tuple(couplings))
    return replace(body, topology=replace(body.topology, stops=other))
