"""Change the lengths of a body's segments, each along its own axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.model.body import Body, check_one
from workbench.model.settled import settled

__all__ = ["lengthened"]

_MIN_FACTOR = 0.4
_MAX_FACTOR = 2.0
"""Factors that people have. One beyond them comes from a wrong unit or name."""


def lengthened(body: Body, factors: Mapping[str, float]) -> Body:
    """Multiply the lengths of segments by factors.

    Spheres and joints move along z of the segment's frame, in which the limbs and the trunk of the
    paper's body lie. Girths stay as they are, and masses are proportional to lengths. The soles of the
    zero pose stay at their height.

    Parameters
    ----------
    body
        One body.
    factors
        Factors by segment, 0.4 to 2.

    Raises
    ------
    InputError
        If there is no such segment, or a factor is out of its range.
    """
    check_one(body)
    along = np.ones(len(body.segments))
    for segment, factor in factors.items():
        if not _MIN_FACTOR <= factor <= _MAX_FACTOR:
            raise InputError(
                f"segment {segment} of {body.name} would be {factor:.2f} times as long; {_MIN_FACTOR:g} to "
                f"{_MAX_FACTOR:g} are possible: is the unit right?"
            )
        along[body.segment(segment)] = factor
    size = np.stack([np.ones_like(along), np.ones_like(along), along], axis=1)
    parent = body.parent[1:]
    in_parent = body.joint_in_parent * size[parent]
    made = replace(
        body,
        topology=replace(body.topology, basis=None),
        centre=body.centre * size[body.sphere_segment],
        joint_in_parent=in_parent,
        joint_in_child=body.joint_in_child * size[1:],
        mass=body.mass * along,
        basis_at=np.zeros((1, 0)),
    )
    standing = in_parent.copy()
    standing[0, parent == 0, 2] += _lowest(body) - _lowest(made)
    return settled(replace(made, joint_in_parent=standing))


def _lowest(body: Body) -> float:
    """Height [m] of the lowest surface in the zero pose."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z - body.radius[0]).min())
