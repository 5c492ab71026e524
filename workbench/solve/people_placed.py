"""Many different bodies of a family placed, one pose each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.solve.forward import place

__all__ = ["PeoplePlaced", "place_people"]


class PeoplePlaced(NamedTuple):
    """B placed bodies: world_from_segment (B, N, 3, 4), sphere centres (B, S, 3) and radii (B, S) [m]."""

    world_from_segment: Floats
    centres: Floats
    radius: Floats

    def joint(self, bodies: Sequence[Body], joint: int) -> Floats:
        """(B, 3) [m] where a joint is."""
        inner = np.stack([body.joint_in_child[joint] for body in bodies])
        world = self.world_from_segment[:, joint + 1]
        point: Floats = np.einsum("bij,bj->bi", world[:, :, :3], inner) + world[:, :, 3]
        return point


def place_people(bodies: Sequence[Body], poses: Poses) -> PeoplePlaced:
    """Place B bodies with the same segments, joints and numbers of spheres, a row of poses each. UsageError where there
    are not as many poses as bodies."""
    if len(poses) != len(bodies):
        raise UsageError(f"{len(bodies)} bodies need as many poses, got {len(poses)}")
    rows = []
    for b, body in enumerate(bodies):
        one = slice(b, b + 1)
        rows.append(place(body, Poses(poses.rotations[one], poses.reference, poses.world_from_reference[one])))
    return PeoplePlaced(
        np.concatenate([row.world_from_segment for row in rows]),
        np.concatenate([row.centres for row in rows]),
        np.stack([body.radius for body in bodies]),
    )
