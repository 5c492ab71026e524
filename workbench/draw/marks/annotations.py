"""Marks of what was found: contacts, nearest clearances with dimension lines, stops, controls,
segments, axes.

Every function returns marks to be put into a scene; none looks at the camera. Lengths in labels are
millimetres.
"""

from __future__ import annotations

import numpy as np

from workbench.contact.collide import allowed_depth
from workbench.draw.scene import Mark
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats
from workbench.model.contacts import Clearance, Contacts
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = [
    "axes_marks",
    "clearance_marks",
    "contact_marks",
    "control_marks",
    "dimension",
    "segment_marks",
    "stop_marks",
]

_Point = tuple[float, float, float]


def contact_marks(contacts: Contacts, pose: int = 0, *, most: int = 20) -> tuple[Mark, ...]:
    """The deepest contact of every segment and part (or other segment) of a pose, worst first, at
    most `most` faults.

    Faults carry how far they go beyond what is allowed, "12.4 mm"; allowed contact is an amber dot
    without a label.
    """
    deepest = contacts.deepest()
    order = np.argsort(-deepest.excess, kind="stable")
    chosen = order[deepest.pose[order] == pose]
    faults = chosen[deepest.excess[chosen] > 0][:most]
    allowed = chosen[deepest.excess[chosen] <= 0]
    rest = tuple(Mark(_point(deepest.point[row]), "", "allowed") for row in allowed)
    return rest + tuple(
        Mark(_point(deepest.point[row]), _length(deepest.excess[row]), "contact") for row in faults
    )


def clearance_marks(
    placed: Placed, near: Clearance, pose: int = 0, *, most: int = 3, within: float = 0.15
) -> tuple[Mark, ...]:
    """Dimension lines of the `most` parts (or segments) that are nearest without touching, within
    `within` [m].

    One for each part, from its nearest sphere's surface to the part's nearest point; pairs whose
    contact is allowed are left out.
    """
    distance = np.where(_measured(near) & (near.distance[pose] > 0.0), near.distance[pose], np.inf)
    best = distance.argmin(axis=0)
    least = distance[best, np.arange(distance.shape[1])] if distance.size else np.empty(0)
    parts = [int(k) for k in np.argsort(least, kind="stable")[:most] if least[k] <= within]
    return tuple(dimension(placed, near, (pose, int(best[k]), k)) for k in parts)


def _measured(near: Clearance) -> Bools:
    """(N, K) pairs that keep apart: by no rule may they touch, and they are not one segment or
    neighbours."""
    if isinstance(near.other, Environment):
        kept: Bools = (allowed_depth(near.body, near.other) == 0.0) & ~near.other.hidden[None, :]
        return kept
    if near.body is not near.other:
        return np.ones(near.distance.shape[1:], dtype=np.bool_)
    apart: Bools = ~near.body.adjacent
    return apart


def dimension(placed: Placed, near: Clearance, where: tuple[int, int, int]) -> Mark:
    """The dimension line of one nearest pair at (pose, segment, part), labelled "56.1 mm"."""
    pose = where[0]
    sphere = int(near.sphere[where])
    point = near.point[where]
    centre = placed.centres[pose, sphere]
    away = float(np.linalg.norm(point - centre))
    radius = placed.body.radius[placed.person[pose], sphere]
    on_body = centre + (point - centre) * (radius / away) if away > 0.0 else centre
    return Mark(_point(on_body), _length(near.distance[where]), "clearance", _point(point))


def stop_marks(
    placed: Placed, margin: Floats, pose: int = 0, *, tolerance: float = 1e-9
) -> tuple[Mark, ...]:
    """A diamond at every joint that is past its stop, with how far: "right elbow +4.2°". margin (P,
    J) [rad]."""
    body = placed.body
    world = placed.world_from_segment[pose]
    marks = []
    for joint in np.flatnonzero(margin[pose] < -tolerance):
        frame = world[body.parent[joint + 1]]
        if not np.all(np.isfinite(frame)):
            continue
        past = np.degrees(-margin[pose, joint])
        at = frame[:, :3] @ body.joint_in_parent[placed.person[pose], joint] + frame[:, 3]
        marks.append(Mark(_point(at), f"{body.joint_names[joint]} +{past:.1f}°", "stop"))
    return tuple(marks)


def control_marks(
    environment: Environment, reached: dict[str, bool] | None = None
) -> tuple[Mark, ...]:
    """A target at every control of an environment, by name; those that `reached` says no to are
    marked as missed."""
    return tuple(
        Mark(
            control.at,
            control.name.replace("_", " "),
            "reach" if reached is None or reached.get(control.name, True) else "missed",
        )
        for control in environment.controls
    )


def segment_marks(placed: Placed, pose: int = 0) -> tuple[Mark, ...]:
    """The mnemonic of every segment that has spheres, at the middle of its spheres."""
    body = placed.body
    marks = []
    for segment, name in enumerate(body.segments):
        centres = placed.centres[pose, body.spheres(segment)]
        if len(centres) and np.all(np.isfinite(centres)):
            marks.append(
                Mark(_point((centres.min(axis=0) + centres.max(axis=0)) / 2.0), name, "segment")
            )
    return tuple(marks)


def axes_marks(origin: _Point = (0.0, 0.0, 0.0), *, length: float = 0.2) -> tuple[Mark, ...]:
    """Arrows of the world's axes at a point [m]: x forward, y left, z up."""
    if not (np.isfinite(length) and length > 0.0):
        raise UsageError(f"axes: a length above 0 m is needed, got {length}")
    tips = np.asarray(origin, dtype=np.float64) + length * np.eye(3)
    return tuple(
        Mark(origin, name, f"axis_{name}", _point(tip))
        for name, tip in zip("xyz", tips, strict=True)
    )


def _point(point: Floats) -> _Point:
    x, y, z = (float(value) for value in point)
    return x, y, z


def _length(metres: float) -> str:
    return f"{1000.0 * float(metres):.1f} mm"
