"""Joint stops of a body file, packed into arrays."""

from __future__ import annotations

import numpy as np

from workbench.errors import one_of
from workbench.files.body.schema import BodyFile, CouplingFile, JointFile, MotionFile, PolygonFile
from workbench.files.schema import fail
from workbench.files.yaml_text import Document
from workbench.model.arrays import Floats
from workbench.model.stops import Coupling, StopKind, Stops

__all__ = ["axis_vector", "pack_stops", "stop_faults"]

POLYGON_VERTICES = 360


def axis_vector(axis: str | tuple[float, float, float]) -> Floats:
    """(3,) unit vector of "+x" ... "-z" or of a given vector."""
    if isinstance(axis, str):
        vector = np.zeros(3)
        vector["xyz".index(axis[1])] = 1.0 if axis[0] == "+" else -1.0
        return vector
    given = np.array(axis, dtype=np.float64)
    unit: Floats = given / max(float(np.linalg.norm(given)), 1e-300)
    return unit


def stop_faults(document: Document, file: BodyFile) -> list[str]:
    """Axes, motion names, couplings and polygons that no schema can check, of all joints."""
    return [line for name in file.joints for line in _faults(document, file, name)]


def pack_stops(file: BodyFile, tree: tuple[list[str], list[str]]) -> Stops:
    """The stops of all joints in body order, from a file without faults."""
    order, joints = tree
    entries = [file.joints[name] for name in joints]
    count = len(entries)
    couplings = [
        _coupling(file, joints, (j, row))
        for j, entry in enumerate(entries)
        for row in entry.couplings
    ]
    polygons = [entry.polygon for entry in entries]
    return Stops(
        kind=np.array([StopKind[entry.stop.upper()] for entry in entries], dtype=np.int64),
        axes=np.array([[axis_vector(m.axis) for m in _motions(e)] for e in entries]).reshape(
            count, 3, 3
        ),
        limits=np.array([[m.limits for m in _motions(e)] for e in entries]).reshape(count, 3, 2),
        play=np.array([entry.play for entry in entries]),
        motions=tuple(tuple(m.motion for m in _motions(entry)) for entry in entries),
        couplings=tuple(couplings),
        polygon=tuple(_vertices(p) if p else np.zeros((0, 3)) for p in polygons),
        polygon_centre=np.array(
            [axis_vector(p.centre) if p else [0, 0, 0] for p in polygons]
        ).reshape(count, 3),
        polygon_frame=np.array(
            [order.index(p.frame) if p else -1 for p in polygons], dtype=np.int64
        ),
        limb=np.array([axis_vector(p.limb) if p else [0, 0, 0] for p in polygons]).reshape(
            count, 3
        ),
    )


def _motions(joint: JointFile) -> list[MotionFile]:
    return [*joint.swing, joint.twist]


def _motion_names(joint: JointFile) -> list[str]:
    return [name for motion in _motions(joint) for name in motion.motion]


def _faults(document: Document, file: BodyFile, name: str) -> list[str]:
    joint = file.joints[name]
    key = ("joints", name)
    faults = []
    axes = np.array([axis_vector(motion.axis) for motion in _motions(joint)])
    if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6):
        faults.append(
            fail(
                document,
                (*key, "swing"),
                "the two swing axes and the twist axis must be at right angles",
            )
        )
    labels = _motion_names(joint)
    if len(set(labels)) < len(labels):
        faults.append(
            fail(document, (*key, "swing"), f"motion names must differ (got {', '.join(labels)})")
        )
    for row, coupling in enumerate(joint.couplings):
        where = (*key, "couplings", row)
        if coupling.limit not in labels:
            what = f"unknown motion {coupling.limit!r} of {name}; {one_of(coupling.limit, labels)}"
            faults.append(fail(document, (*where, "limit"), what))
        driver, motion = coupling.driver.split(".", 1)
        if driver not in file.joints:
            what = f"unknown joint {driver!r}; {one_of(driver, file.joints)}"
            faults.append(fail(document, (*where, "driver"), what))
        elif motion not in _motion_names(file.joints[driver]):
            what = f"unknown motion {motion!r} of {driver}; {one_of(motion, _motion_names(file.joints[driver]))}"
            faults.append(fail(document, (*where, "driver"), what))
        if coupling.from_[0] >= coupling.from_[1]:
            faults.append(fail(document, (*where, "from"), "the two driver angles must rise"))
    if joint.polygon:
        faults += _polygon_faults(document, file, name)
    return faults


def _polygon_faults(document: Document, file: BodyFile, name: str) -> list[str]:
    polygon = file.joints[name].polygon
    key = ("joints", name, "polygon")
    assert polygon is not None
    faults = []
    above = {joint.between[1]: joint.between[0] for joint in file.joints.values()}
    ancestors = {file.joints[name].between[0]: None}
    segment = file.joints[name].between[0]
    while (
        segment in above and above[segment] not in ancestors
    ):  # a tree may turn out to be a circle
        segment = above[segment]
        ancestors[segment] = None
    if polygon.frame not in ancestors:
        what = f"no segment {polygon.frame!r} between the stage and joint {name}; {one_of(polygon.frame, ancestors)}"
        faults.append(fail(document, (*key, "frame"), what))
    frame = np.array([axis_vector(v) for v in (polygon.centre, polygon.clock_0, polygon.clock_90)])
    if not np.allclose(frame @ frame.T, np.eye(3), atol=5e-3):
        faults.append(
            fail(document, (*key, "centre"), "centre, clock_0 and clock_90 must be at right angles")
        )
    clock = np.array(polygon.limits)[:, 0]
    if np.any(np.diff(clock) <= 0) or clock[0] < 0 or clock[-1] >= 2 * np.pi:
        faults.append(
            fail(document, (*key, "limits"), "clock angles must rise from 0 to below 360")
        )
    return faults


def _vertices(polygon: PolygonFile) -> Floats:
    """(360, 3) the polygon's boundary, one vertex a clock degree, the polar limit interpolated
    linearly.

    Source: the construction of the shoulder limits, centre direction and clock angles as the body
    file gives them.
    """
    centre = axis_vector(polygon.centre)
    up = axis_vector(polygon.clock_0)
    up = axis_vector(tuple(up - (up @ centre) * centre))
    side = np.cross(centre, up)
    side = side if side @ axis_vector(polygon.clock_90) > 0 else -side
    given = np.array(polygon.limits)
    clock = np.arange(POLYGON_VERTICES) * (2 * np.pi / POLYGON_VERTICES)
    polar = np.interp(clock, given[:, 0], given[:, 1], period=2 * np.pi)
    around = np.cos(clock)[:, None] * up + np.sin(clock)[:, None] * side
    points = np.cos(polar)[:, None] * centre + np.sin(polar)[:, None] * around
    # counter-clockwise about the centre whichever way the file's clock runs
    boundary: Floats = points if np.cross(up, side) @ centre > 0 else points[::-1]
    return boundary


def _coupling(file: BodyFile, joints: list[str], entry: tuple[int, CouplingFile]) -> Coupling:
    j, row = entry
    labels = _motion_names(file.joints[joints[j]])
    driver, motion = row.driver.split(".", 1)
    place = labels.index(row.limit)
    driven = _motion_names(file.joints[driver]).index(motion)
    sign = -1.0 if driven % 2 else 1.0
    low, high = (sign * angle for angle in row.from_)
    limit = row.to
    if sign < 0:
        low, high, limit = high, low, (limit[1], limit[0])
    return Coupling(j, place // 2, place % 2, joints.index(driver), driven // 2, (low, high), limit)
