"""The chain of joints from one segment of a body to another, packed for the kernels."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.stops import StopKind
from workbench.posture.kernels.limits import WHOLE_CONE, WHOLE_POLYGON, WHOLE_TURN
from workbench.posture.kernels.linkage import Linkage
from workbench.posture.reaching.comfort import comfort_modes

__all__ = ["joints_between", "linkage"]


def joints_between(body: Body, base: int, end: int) -> list[int]:
    """The joints from segment `base` out to segment `end`. InputError where `end` does not lie
    beyond `base`."""
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
    """Pack the chain from segment `base`, which is held, to `end`, with some joints free.

    tip (B, 3) [m]: the point that arrives, pointing (B, 3): the direction it points in, both in the
    last segment, by row of the body. A hinge has one free angle, and its twist where the stops give
    it a range; other joints have three.
    """
    joints = joints_between(body, base, end)
    chosen = set(free)
    stops = body.stops
    rows = [
        (k, axis)
        for k, j in enumerate(joints)
        if j in chosen
        for axis in range(3)
        if _turns(body, j, axis)
    ]
    free_of = np.full((len(joints), 3), -1)
    for d, (k, axis) in enumerate(rows):
        free_of[k, axis] = d
    comfort = [comfort_modes(body, j) for j in joints]
    shaped = [k for k, j in enumerate(joints) if stops.kind[j] == StopKind.POLYGON and j in chosen]
    k = shaped[0] if shaped else -1
    sides, link = _polygon(body, joints, k)
    coupled, coupling = _couplings(body, joints)
    return Linkage(
        at_parent=np.ascontiguousarray(body.joint_in_parent[:, joints]),
        at_child=np.ascontiguousarray(body.joint_in_child[:, joints]),
        axes=np.ascontiguousarray(stops.axes[joints].reshape(-1, 3, 3)),
        rows=_rows(body, joints, free_of),
        limits=np.ascontiguousarray(stops.limits[joints].reshape(-1, 3, 2)),
        coupling=coupling,
        coupled=coupled,
        free_joint=np.array([k for k, _ in rows], dtype=np.int64),
        free_axis=np.array([axis for _, axis in rows], dtype=np.int64),
        free_of=free_of.astype(np.int64),
        mode=np.array([comfort[k][0][axis] for k, axis in rows]),
        weight=np.array([comfort[k][1][axis] ** -2.0 for k, axis in rows]),
        sides=sides,
        limb=np.ascontiguousarray(stops.limb[joints[max(k, 0)]]),
        polygon_link=link,
        tip=np.array(tip),
        pointing=np.array(pointing),
    )


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
    """Couplings within the chain by its own joint numbers; one that is driven from elsewhere holds
    at its least."""
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


def _polygon(body: Body, joints: list[int], k: int) -> tuple[Floats, int]:
    """The sides (V, 5, 3) of joint k's polygon and the link in whose frame they stand; empty and -1
    where k is -1.

    InputError where that link is not in the chain.
    """
    if k < 0:
        return np.zeros((0, 5, 3)), -1
    j = joints[k]
    frame = int(body.stops.polygon_frame[j])
    links = [int(body.parent[joints[0] + 1]), *(joint + 1 for joint in joints)]
    if frame not in links[: k + 1]:
        what = f"the stop of the {body.joint_names[j]} stands in {body.segment_names[frame]}, which must be held or beyond"
        raise InputError(f"body {body.name}: {what}")
    corner = body.stops.polygon[j]
    following = np.roll(corner, -1, axis=0)
    inward = np.cross(corner, following)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    spoke = np.cross(body.stops.polygon_centre[j], corner)
    ends = np.cross(inward, corner), np.cross(following, inward)
    return np.ascontiguousarray(np.stack([corner, inward, *ends, spoke], axis=1)), links.index(
        frame
    )
