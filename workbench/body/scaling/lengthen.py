"""A body with other lengths of its segments: each that is named stretched along its own axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.model.body import Body, check_one
from workbench.model.settled import settled

__all__ = ["lengthened"]

_LEAST = 0.4
_MOST = 2.0
"""Factors beyond these are no person's that the body could be stretched to: a unit or a name is
wrong."""


def lengthened(body: Body, factors: Mapping[str, float]) -> Body:
    """The body with each named segment that many times as long: spheres and joints move along z of
    its frame, in which the limbs and the trunk of the paper's body lie.

    Girths and segments that are not named stay as they are; masses of the named go with their
    lengths. The soles of the zero pose stay where they are. InputError for a segment that is not
    there, or a factor below 0.4 or above 2.
    """
    check_one(body)
    along = np.ones(len(body.segments))
    for segment, factor in factors.items():
        if not _LEAST <= factor <= _MOST:
            raise InputError(
                f"segment {segment} of {body.name} would be {factor:.2f} times as long; {_LEAST:g} to "
                f"{_MOST:g} are possible: is the unit right?"
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
    """[m] of the zero pose."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z - body.radius[0]).min())
