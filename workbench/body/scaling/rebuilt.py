"""Build a body from the parameters of its space of shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.body.scaling.manikin import Manikin
from workbench.body.scaling.space import ShapeSpace, volumes
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.settled import settled

__all__ = ["rebuilt"]

_ENCLOSING_STEPS = 6
"""Iterations of the sphere around each segment."""


def rebuilt(space: ShapeSpace, values: Floats, manikin: Manikin) -> Body:
    """Build the body with given parameters: on the floor, with its masses and allowance for flesh.

    Parameters
    ----------
    space, values
        The shapes of a body, and the parameters (K,) of one.
    manikin
        The body with this shape.

    Returns
    -------
    Body
        Masses are proportional to the volumes of the segments.
    """
    body = space.base.body
    shape = manikin.shape
    made = replace(
        body,
        centre=shape.centre[None],
        radius=shape.radius[None],
        joint_in_parent=_on_the_floor(body, manikin)[None],
        joint_in_child=shape.in_child[None],
        mass=body.mass * volumes(body, shape) / np.maximum(space.volume, 1e-12),
        allowance=_flesh(space, manikin),
        basis_at=values[None, : space.family],
    )
    return settled(made, steps=_ENCLOSING_STEPS)


def _on_the_floor(body: Body, manikin: Manikin) -> Floats:
    """(J, 3) [m] joint coordinates in the parents.

    The first joints are raised so that the zero pose stands on the floor.
    """
    in_parent = manikin.shape.in_parent.copy()
    in_parent[body.parent[1:] == 0, 2] -= manikin.lowest()
    return in_parent


def _flesh(space: ShapeSpace, manikin: Manikin) -> Floats:
    """(1, N, N) [m] the allowance for soft flesh.

    It grows by what standing and sitting overlap more than in the unchanged body: a stouter body
    presses more flesh together in postures in which the unchanged one is not in contact.
    """
    body = space.base.body
    more = np.maximum(manikin.overlaps() - space.overlaps, 0.0)
    return np.where(body.adjacent, 0.0, body.allowance + more)
