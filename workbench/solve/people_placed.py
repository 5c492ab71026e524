"""Many different bodies of a family placed, one pose each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.errors import UsageError
from workbench.kernels.contact.crews import place_crew
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.solve.family import family_of
from workbench.solve.forward import packed_chain, packed_skin
from workbench.solve.threads import in_pieces

__all__ = ["PeoplePlaced", "place_people"]

PIECE = 64
"""People a thread takes at a time."""


class PeoplePlaced(NamedTuple):
    """B placed bodies: world_from_segment (B, N, 3, 4), sphere centres (B, S, 3) and radii (B, S)
    [m]."""

    world_from_segment: Floats
    centres: Floats
    radius: Floats


def place_people(
    bodies: Sequence[Body], poses: Poses, *, threads: int | None = None
) -> PeoplePlaced:
    """Place B bodies of a family, with the same segments, joints and spheres by number, a row of
    poses each: what `place` gives for one after the other. UsageError where there are not as many
    poses as bodies."""
    if len(poses) != len(bodies):
        raise UsageError(f"{len(bodies)} bodies need as many poses, got {len(poses)}")
    family = family_of(tuple(bodies))
    first = bodies[0]
    shown = np.ones(len(first.segments), dtype=np.bool_)
    chain = packed_chain(first, poses.reference, shown)
    skin = packed_skin(first, shown)
    world = np.empty((len(bodies), len(first.segments), 3, 4))
    world[:, poses.reference] = poses.world_from_reference
    centres = np.empty(family.centre.shape)
    fields = (
        family.in_parent,
        family.in_child,
        family.centre,
        family.twist_point,
        family.twist_axis,
        family.twist_share,
        family.blend_share,
    )

    def work(begin: int, end: int) -> None:
        place_crew(
            poses.rotations, chain, skin, first.sphere_segment, fields, world, centres, begin, end
        )

    in_pieces(work, len(bodies), PIECE, threads=threads)
    return PeoplePlaced(world, centres, family.radius)
