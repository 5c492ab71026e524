"""Poses to answers in one step, for batches so large that the placed bodies need never be seen."""

from __future__ import annotations

import numpy as np

from workbench.body.forward import packed_chain, packed_skin, place
from workbench.contact.collide import allowed_groups, collides
from workbench.contact.crowd import crowd_of
from workbench.contact.fields import field_of, packed_faces, packed_shells
from workbench.contact.gpu import on_cpu, posed_collides_on_device
from workbench.model.arrays import Bools
from workbench.model.body import Body
from workbench.model.contacts import TANGENT_TOLERANCE
from workbench.model.environment import Environment
from workbench.model.poses import Poses

__all__ = ["posed_collides"]

MEMORY = 256 << 20
"""Bytes that the bodies placed at a time may take on the processor; a batch that takes more goes in
pieces."""


def posed_collides(
    body: Body,
    poses: Poses,
    environment: Environment,
    *,
    tolerance: float = TANGENT_TOLERANCE,
    device: str = "cpu",
) -> Bools:
    """(P,) as `collides` of the poses placed, without ever holding more than MEMORY bytes of placed
    bodies.

    On a device the poses are placed there, so that of 10^6 poses only the rotations and one
    transform each have to be moved to it. device: as in `collides`.
    """
    count = len(poses)
    world = poses.world_from_reference
    if on_cpu(device):
        size = _at_a_time(body)
        pieces = [slice(begin, begin + size) for begin in range(0, count, size)]
        placed = (
            place(body, Poses(poses.rotations[some], poses.reference, world[some]))
            for some in pieces
        )
        hits = [collides(piece, environment, tolerance=tolerance) for piece in placed]
        return np.concatenate([np.zeros(0, dtype=np.bool_), *hits])
    groups, allowed = allowed_groups(body, environment)
    one = place(body, Poses(poses.rotations[:1], poses.reference, world[:1]))
    index = (
        crowd_of(one),
        packed_faces(environment),
        packed_shells(environment),
        field_of(environment, groups),
    )
    walk = packed_chain(body, poses.reference, one.window), packed_skin(body, one.window)
    return posed_collides_on_device(
        (poses.rotations, world, poses.reference), walk, index, allowed + tolerance
    )


def _at_a_time(body: Body) -> int:
    """How many poses of a body MEMORY holds: 12 numbers a segment and 3 a sphere; at least one."""
    return max(1, MEMORY // (8 * (12 * len(body.segments) + 3 * len(body.sphere_names))))
