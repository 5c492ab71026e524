"""A body from the knobs of its space of shapes: on the floor, with its masses, twist lines and soft
flesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.body.scaling.manikin import Manikin
from workbench.body.scaling.space import ShapeSpace, volumes
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.settled import settled

__all__ = ["rebuilt"]

ENCLOSING_STEPS = 6


def rebuilt(space: ShapeSpace, values: Floats, manikin: Manikin) -> Body:
    """The body with these knobs (K,), of which the manikin is. Masses go with the volume of each
    segment."""
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
    return settled(made, steps=ENCLOSING_STEPS)


def _on_the_floor(body: Body, manikin: Manikin) -> Floats:
    """Joint coordinates in the parents, the first joints raised so that the zero pose stands on the
    floor."""
    in_parent = manikin.shape.in_parent.copy()
    in_parent[body.parent[1:] == 0, 2] -= manikin.lowest()
    return in_parent


def _flesh(space: ShapeSpace, manikin: Manikin) -> Floats:
    """(1, N, N) [m] the allowance for soft flesh: grown by what standing and sitting overlap more than
    they did.

    A stouter body presses more flesh together in the very postures in which the first one was not
    in contact.
    """
    body = space.base.body
    more = np.maximum(manikin.overlaps() - space.overlaps, 0.0)
    return np.where(body.adjacent, 0.0, body.allowance + more)
