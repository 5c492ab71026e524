"""Chains of joints from one segment of a body to another, packed for the kernels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.stops import StopKind
from workbench.posture.kernels.chain_kinematics import Linkage
from workbench.posture.kernels.inequality_constraints import WHOLE_CONE, WHOLE_POLYGON, WHOLE_TURN
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.stops import polygon_sides

__all__ = ["joints_between", "linkage"]


def joints_between(body: Body, base: int, end: int) -> list[int]:
    """List the joints from segment `base` out to segment `end`.

    Raises
    ------
    InputError
        If `end` does not lie beyond `base`.
    """
    joints: list[int] = []
    at = end
    while at != base:
        if at <= 0:
            names = body.segment_names
            raise InputError(f"body {body.name}: {names[end]} does not lie beyond {names[base]}")
        joints.append(at - 1)
        at = int(body.parent[at])
    return joints[::-1]


def linkage(
    body: Body, base: int, end: int, free: Iterable[int], tip: Floats, pointing: Floats
) -> Linkage:
    """Pack a chain of joints. A hinge has one free angle, and its twist if its stops give it a range;
    other joints have three.

    Parameters
    ----------
    body
        B bodies of a family.
    base, end
        The segment that is held, and the last one.
    free
        The joints that turn.
    tip, pointing
        (B, 3) the point that arrives [m] and the unit direction it points in, in the last segment.

    Returns
    -------
    Linkage
        The chain, its stops and its comfort.

    Raises
    ------
    InputError
        If `end` does not lie beyond `base`, or a spherical polygon stands in a segment before it.
    """
    joints = joints_between(body, base, end)
    stops = body.stops
    angles = _free_angles(body, joints, set(free))
    comfort = _comfort(body, joints, angles)
    shaped = next((k for k in angles.joint if stops.kind[joints[k]] == StopKind.POLYGON), None)
    sides, link = _polygon(body, joints, shaped)
    coupled, coupling = _couplings(body, joints)
    return Linkage(
        at_parent=np.ascontiguousarray(body.joint_in_parent[:, joints]),
        at_child=np.ascontiguousarray(body.joint_in_child[:, joints]),
        axes=np.ascontiguousarray(stops.axes[joints].reshape(-1, 3, 3)),
        rows=_rows(body, joints, angles.number),
        limits=np.ascontiguousarray(stops.limits[joints].reshape(-1, 3, 2)),
        coupling=coupling,
        coupled=coupled,
        free_joint=angles.joint,
        free_axis=angles.axis,
        free_of=angles.number,
        mode=comfort[0],
        weight=comfort[1],
        sides=sides,
        limb=np.ascontiguousarray(stops.limb[joints[shaped or 0]]),
        polygon_link=link,
        tip=np.array(tip),
        pointing=np.array(pointing),
    )


@dataclass(frozen=True, eq=False)
class _FreeAngles:
    """The n angles of a chain of K joints that are ways to move."""

    joint: Ints
    """(n,) joint of the chain."""
    axis: Ints
    """(n,) 0, 1 swing, 2 twist."""
    number: Ints
    """(K, 3) number of each angle among these, -1 for one that is fixed."""


def _free_angles(body: Body, joints: list[int], free: set[int]) -> _FreeAngles:
    """Number the free angles of a chain outward from its base."""
    found = [
        (k, axis)
        for k, joint in enumerate(joints)
        if joint in free
        for axis in range(3)
        if _turns(body, joint, axis)
    ]
    number = np.full((len(joints), 3), -1, dtype=np.int64)
    for n, (k, axis) in enumerate(found):
        number[k, axis] = n
    pairs = np.array(found, dtype=np.int64).reshape(-1, 2)
    return _FreeAngles(pairs[:, 0].copy(), pairs[:, 1].copy(), number)


def _comfort(body: Body, joints: list[int], angles: _FreeAngles) -> tuple[Floats, Floats]:
    """Modes (n,) [rad] and weights (n,) [1/rad2] of the free angles: 1 / (half a range)^2."""
    modes = np.zeros(len(angles.joint))
    weights = np.zeros(len(angles.joint))
    for n, (k, axis) in enumerate(zip(angles.joint, angles.axis, strict=True)):
        mode, half = comfort_modes(body, joints[k])
        modes[n] = mode[axis]
        weights[n] = half[axis] ** -2.0
    return modes, weights


def _turns(body: Body, joint: int, axis: int) -> bool:
    """Whether an angle of a joint is a way to move: the play of a hinge is not."""
    if body.stops.kind[joint] != StopKind.HINGE:
        return True
    return axis == 0 or (axis == 2 and bool(body.stops.limits[joint, 2].sum() > 0))


def _rows(body: Body, joints: list[int], free_of: Ints) -> Ints:
    """(R, 3) the stops that hold the free angles, as the kernels number them."""
    rows: list[tuple[int, int, int]] = []
    for k, j in enumerate(joints):
        kind = body.stops.kind[j]
        swings = bool((free_of[k, :2] >= 0).any())
        twists = free_of[k, 2] >= 0
        if kind == StopKind.CONE and swings:
            rows.append((k, WHOLE_CONE, 0))
        if kind == StopKind.HINGE and free_of[k, 0] >= 0:
            rows += [(k, 0, 0), (k, 0, 1)]
        if kind == StopKind.POLYGON and swings:
            rows += [(k, WHOLE_POLYGON, 0), (k, WHOLE_TURN, 0)]
        if kind != StopKind.FREE and twists:
            rows += [(k, 2, 0), (k, 2, 1)]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)


def _couplings(body: Body, joints: list[int]) -> tuple[Ints, Floats]:
    """Couplings within the chain: their rows (K, 3, 2), -1 for none, and the couplings (M, 6).

    A limit whose driver is not in the chain is taken as constant, at its least.
    """
    coupled = np.full((len(joints), 3, 2), -1)
    rows: list[list[float]] = []
    for c in body.stops.couplings:
        if c.joint not in joints:
            continue
        limit = c.limit
        driver = c.driver_joint
        if driver not in joints:
            limit = (min(limit), min(limit))
            driver = c.joint
        coupled[joints.index(c.joint), c.axis, c.side] = len(rows)
        rows.append([joints.index(driver), c.driver_axis, *c.driver_angle, *limit])
    return coupled, np.array(rows, dtype=np.float64).reshape(-1, 6)


def _polygon(body: Body, joints: list[int], k: int | None) -> tuple[Floats, int]:
    """Sides (V, 5, 3) of joint k's polygon and the link in whose frame they stand.

    Without a polygon (None) they are empty and -1. The rows of a side are as in
    `posture.kernels.linkage.Linkage`.

    Raises
    ------
    InputError
        If that link is not in the chain.
    """
    if k is None:
        return np.zeros((0, 5, 3)), -1
    j = joints[k]
    frame = int(body.stops.polygon_frame[j])
    links = [int(body.parent[joints[0] + 1]), *(joint + 1 for joint in joints)]
    if frame not in links[: k + 1]:
        what = f"the stop of the {body.joint_names[j]} stands in {body.segment_names[frame]}, which must be held or beyond"
        raise InputError(f"body {body.name}: {what}")
    sides = polygon_sides(body.stops.polygon[j], body.stops.polygon_centre[j])
    return sides, links.index(frame)
