"""Many different bodies of a family placed, one pose each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.errors import UsageError
from workbench.kernels.forward import Skin, chain_transforms, place_spheres
from workbench.model.arrays import Floats
from workbench.model.blend import blend_point
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.solve.forward import packed_chain, packed_skin

__all__ = ["PeoplePlaced", "place_people"]

_ENDS = ("joint_in_parent", "joint_in_child")


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
    """Place B bodies of a family, with the same segments, joints and spheres by number, a row of poses each: what
    `place` gives for one after the other. UsageError where there are not as many poses as bodies."""
    if len(poses) != len(bodies):
        raise UsageError(f"{len(bodies)} bodies need as many poses, got {len(poses)}")
    first = bodies[0]
    shown = np.ones(len(first.segments), dtype=np.bool_)
    chain, skin = packed_chain(first, poses.reference, shown), packed_skin(first, shown)
    in_parent, in_child = (np.stack([getattr(b, name)[chain.joint] for b in bodies]) for name in _ENDS)
    up = (chain.upward == 1)[:, None]
    came, to = np.where(up, in_child, in_parent), np.where(up, in_parent, in_child)
    parts = _skins(bodies, skin)
    world = np.empty((len(bodies), len(first.segments), 3, 4))
    world[:, poses.reference] = poses.world_from_reference
    centres, local = np.empty((len(bodies), len(first.radius), 3)), np.empty(skin.centre.shape)
    for b in range(len(bodies)):
        one = slice(b, b + 1)
        chain_transforms(poses.rotations[one], chain._replace(at_came=came[b], at_to=to[b]), 0, world[one])
        own = skin._replace(centre=parts[0][b], out=parts[1][b], across=parts[2][b], twist_axis=parts[3][b],
                            twist_share=parts[4][b], blend_share=parts[5][b], blend_point=parts[6][b])  # fmt: skip
        place_spheres(poses.rotations[one], world[one], own, local, centres[one])
    return PeoplePlaced(world, centres, np.stack([body.radius for body in bodies]))


def _skins(bodies: Sequence[Body], skin: Skin) -> tuple[Floats, ...]:
    """What the skins of bodies differ in: centre, out, across (B, 3, S), twist_axis (B, N, 3), twist_share, blend_share
    (B, S), blend_point (B, S, 3)."""
    segment = bodies[0].sphere_segment
    centre, axis, point, share, blend = (
        np.stack([getattr(body, name) for body in bodies])
        for name in ("centre", "twist_axis", "twist_point", "twist_share", "blend_share")
    )
    line = axis[:, segment]
    arm = centre - point[:, segment]
    out = arm - np.einsum("bsi,bsi->bs", arm, line)[..., None] * line
    columns = (np.ascontiguousarray(values.transpose(0, 2, 1)) for values in (centre, out, np.cross(line, out)))
    if not len(skin.blended):  # nothing moves across a joint
        return (*columns, axis, share, blend, np.zeros(centre.shape))
    return (*columns, axis, share, blend, np.stack([blend_point(body) for body in bodies]))
