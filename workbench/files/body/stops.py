"""Joint stops of a body file, packed into arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from workbench.errors import one_of
from workbench.files.body.schema import BodyFile, CouplingFile, JointFile, MotionFile, PolygonFile
from workbench.files.schema import error_at
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
    return given / max(float(np.linalg.norm(given)), 1e-300)


def stop_faults(document: Document, file: BodyFile) -> list[str]:
    """Axes, motion names, couplings and polygons that no schema can check, of all joints."""
    return [line for name in file.joints for line in _faults(document, file, name)]


def pack_stops(file: BodyFile, order: list[str], joints: list[str]) -> Stops:
    """Pack the stops of all joints of a file without faults.

    Parameters
    ----------
    file
        The body.
    order, joints
        Its segments in depth-first order, and the joint above each but the first.
    """
    entries = [file.joints[name] for name in joints]
    shape = (len(entries), 3)
    motions = [_motions(entry) for entry in entries]
    polygons = [entry.polygon for entry in entries]
    centre = [axis_vector(p.centre) if p else np.zeros(3) for p in polygons]
    limb = [axis_vector(p.limb) if p else np.zeros(3) for p in polygons]
    frame = [order.index(p.frame) if p else -1 for p in polygons]
    return Stops(
        kind=np.array([StopKind[entry.stop.upper()] for entry in entries], dtype=np.int64),
        axes=np.array([[axis_vector(m.axis) for m in row] for row in motions]).reshape(*shape, 3),
        limits=np.array([[m.limits for m in row] for row in motions]).reshape(*shape, 2),
        play=np.array([entry.play for entry in entries]),
        motions=tuple(tuple(m.motion for m in row) for row in motions),
        couplings=tuple(
            _coupling(file, joints, j, row)
            for j, entry in enumerate(entries)
            for row in entry.couplings
        ),
        polygon=tuple(_vertices(p) if p else np.zeros((0, 3)) for p in polygons),
        polygon_centre=np.array(centre).reshape(shape),
        polygon_frame=np.array(frame, dtype=np.int64),
        limb=np.array(limb).reshape(shape),
    )


def _motions(joint: JointFile) -> list[MotionFile]:
    return [*joint.swing, joint.twist]


def _motion_names(joint: JointFile) -> list[str]:
    return [name for motion in _motions(joint) for name in motion.motion]


def _faults(document: Document, file: BodyFile, name: str) -> list[str]:
    """Faults of the axes, motion names, couplings and polygon of one joint."""
    joint = file.joints[name]
    key = ("joints", name)
    faults = []
    if not _is_square([motion.axis for motion in _motions(joint)], 1e-6):
        what = "the two swing axes and the twist axis must be at right angles"
        faults.append(error_at(document, (*key, "swing"), what))
    labels = _motion_names(joint)
    if len(set(labels)) < len(labels):
        what = f"motion names must differ (got {', '.join(labels)})"
        faults.append(error_at(document, (*key, "swing"), what))
    for row, coupling in enumerate(joint.couplings):
        faults += [
            error_at(document, (*key, "couplings", row, field), what)
            for field, what in _coupling_problems(file, name, coupling)
        ]
    if joint.polygon:
        faults += _polygon_faults(document, file, name, joint.polygon)
    return faults


def _coupling_problems(
    file: BodyFile, name: str, coupling: CouplingFile
) -> Iterator[tuple[str, str]]:
    """The fields of a coupling of a joint that are wrong, and how."""
    labels = _motion_names(file.joints[name])
    if coupling.limit not in labels:
        hint = one_of(coupling.limit, labels)
        yield "limit", f"unknown motion {coupling.limit!r} of {name}; {hint}"
    if what := _driver_problem(file, coupling):
        yield "driver", what
    if coupling.from_[0] >= coupling.from_[1]:
        yield "from", "the two driver angles must rise"


def _is_square(axes: Iterable[str | tuple[float, float, float]], tolerance: float) -> bool:
    """Whether axes are at right angles to one another."""
    units = np.array([axis_vector(axis) for axis in axes])
    return np.allclose(units @ units.T, np.eye(3), atol=tolerance)


def _driver_problem(file: BodyFile, coupling: CouplingFile) -> str:
    """Why the joint and motion that drive a coupling are none; "" where they are there."""
    driver, motion = coupling.driver.split(".", 1)
    if driver not in file.joints:
        return f"unknown joint {driver!r}; {one_of(driver, file.joints)}"
    labels = _motion_names(file.joints[driver])
    if motion not in labels:
        return f"unknown motion {motion!r} of {driver}; {one_of(motion, labels)}"
    return ""


def _polygon_faults(
    document: Document, file: BodyFile, name: str, polygon: PolygonFile
) -> list[str]:
    """Faults of the polygon of a joint: its frame, its axes and its clock angles."""
    key = ("joints", name, "polygon")
    faults = []
    ancestors = _ancestors(file, file.joints[name].between[0])
    if polygon.frame not in ancestors:
        hint = one_of(polygon.frame, ancestors)
        what = f"no segment {polygon.frame!r} between the stage and joint {name}; {hint}"
        faults.append(error_at(document, (*key, "frame"), what))
    if not _is_square((polygon.centre, polygon.clock_0, polygon.clock_90), 5e-3):
        what = "centre, clock_0 and clock_90 must be at right angles"
        faults.append(error_at(document, (*key, "centre"), what))
    clock = np.array(polygon.limits)[:, 0]
    if np.any(np.diff(clock) <= 0) or clock[0] < 0 or clock[-1] >= 2 * np.pi:
        what = "clock angles must rise from 0 to below 360"
        faults.append(error_at(document, (*key, "limits"), what))
    return faults


def _ancestors(file: BodyFile, segment: str) -> list[str]:
    """A segment and those above it, up to the stage."""
    above = {joint.between[1]: joint.between[0] for joint in file.joints.values()}
    found = [segment]
    # in a file with faults the tree may be a circle
    while above.get(found[-1], segment) not in found:
        found.append(above[found[-1]])
    return found


def _vertices(polygon: PolygonFile) -> Floats:
    """(360, 3) the polygon's boundary, one vertex a clock degree, the polar limit interpolated
    linearly.

    Source: the construction of the shoulder limits, centre direction and clock angles as the body
    file gives them.
    """
    centre, up, side = _clock_axes(polygon)
    given = np.array(polygon.limits)
    clock = np.arange(POLYGON_VERTICES) * (2 * np.pi / POLYGON_VERTICES)
    polar = np.interp(clock, given[:, 0], given[:, 1], period=2 * np.pi)
    around = np.cos(clock)[:, None] * up + np.sin(clock)[:, None] * side
    points = np.cos(polar)[:, None] * centre + np.sin(polar)[:, None] * around
    # counter-clockwise about the centre whichever way the file's clock runs
    return points if np.cross(up, side) @ centre > 0 else points[::-1]


def _clock_axes(polygon: PolygonFile) -> tuple[Floats, Floats, Floats]:
    """Unit vectors (3,) at right angles: the centre, clock 0, and clock 90 on the side given."""
    centre = axis_vector(polygon.centre)
    up = axis_vector(polygon.clock_0)
    up = axis_vector(tuple(up - (up @ centre) * centre))
    side = np.cross(centre, up)
    return centre, up, side if side @ axis_vector(polygon.clock_90) > 0 else -side


def _coupling(file: BodyFile, joints: list[str], j: int, row: CouplingFile) -> Coupling:
    """A coupling of joint j; motions stand in pairs of a positive and a negative one."""
    place = _motion_names(file.joints[joints[j]]).index(row.limit)
    driver, motion = row.driver.split(".", 1)
    driven = _motion_names(file.joints[driver]).index(motion)
    low, high = row.from_
    limit = row.to
    if driven % 2:  # angles of the negative motion of a pair count down
        low, high, limit = -high, -low, (limit[1], limit[0])
    return Coupling(j, place // 2, place % 2, joints.index(driver), driven // 2, (low, high), limit)
