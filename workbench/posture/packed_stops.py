"""Pack the joint stops of a body for the kernels that measure one pose at a time."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.stops import StopKind, Stops
from workbench.posture.kernels.past_stops import StopPack

__all__ = ["packed_stops", "polygon_sides"]


def packed_stops(body: Body) -> StopPack:
    """Pack the joint stops of a body as the arrays that the kernel `past_stops` reads."""
    stops = body.stops
    couplings = [
        [c.joint, c.axis, c.side, c.driver_joint, c.driver_axis, *c.driver_angle, *c.limit]
        for c in stops.couplings
    ]
    sides, corners = _polygons(stops)
    return StopPack(
        kind=stops.kind,
        axes=stops.axes,
        limits=stops.limits,
        play=stops.play,
        coupling=np.array(couplings, dtype=np.float64).reshape(-1, 9),
        sides=sides,
        corners=corners,
        limb=stops.limb,
        before=_joints_before(body),
    )


def _polygons(stops: Stops) -> tuple[Floats, Ints]:
    """Sides (J, V, 5, 3) and numbers of corners (J,) of the spherical polygons; 0 for others."""
    joints = len(stops.kind)
    polygonal = np.flatnonzero(stops.kind == StopKind.POLYGON)
    most = max((len(stops.polygon[j]) for j in polygonal), default=1)
    sides = np.zeros((joints, most, 5, 3))
    corners = np.zeros(joints, dtype=np.int64)
    for j in polygonal:
        corners[j] = len(stops.polygon[j])
        sides[j, : corners[j]] = polygon_sides(stops.polygon[j], stops.polygon_centre[j])
    return sides, corners


def _joints_before(body: Body) -> Ints:
    """(J, B) joints from a polygon's frame to its joint, padded with -1; none for other kinds."""
    chains = [
        _chain_before(body, j) if body.stops.kind[j] == StopKind.POLYGON else []
        for j in range(len(body.joints))
    ]
    longest = max((len(chain) for chain in chains), default=0)
    padded = [chain + [-1] * (longest - len(chain)) for chain in chains]
    return np.array(padded, dtype=np.int64).reshape(len(chains), longest)


def _chain_before(body: Body, joint: int) -> list[int]:
    """The joints from the frame of a joint's polygon to the joint, without itself."""
    segment = int(body.parent[joint + 1])
    chain = list[int]()
    while segment != body.stops.polygon_frame[joint]:
        chain.insert(0, segment - 1)
        segment = int(body.parent[segment])
    return chain


def polygon_sides(corner: Floats, centre: Floats) -> Floats:
    """(V, 5, 3) sides of a spherical polygon with corners (V, 3) about a centre (3,).

    A side has its first corner, its inward normal, the normals of its two ends, and the normal of
    the plane through centre and corner.
    """
    following = np.roll(corner, -1, axis=0)
    inward = np.cross(corner, following)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    spoke = np.cross(centre, corner)
    return np.stack(
        [corner, inward, np.cross(inward, corner), np.cross(following, inward), spoke], axis=1
    )
