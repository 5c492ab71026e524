"""Choose and make marks of what was measured: contacts, clearances, joint stops, controls, segments, axes.

Every function returns marks to be put into a scene; none depends on the camera. Lengths in labels
are millimetres.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.contact.collide import allowed_depth, contacts, nearest
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.source import Source
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Bools, Floats, xyz
from workbench.model.contacts import Clearance, Contacts
from workbench.model.environment import Environment
from workbench.model.person import Person
from workbench.model.poses import Placed
from workbench.model.units import plain
from workbench.posture.stops import stops

__all__ = [
    "MARKS",
    "axes_marks",
    "clearance_marks",
    "contact_marks",
    "control_marks",
    "dimension",
    "marks_for_scene",
    "segment_marks",
    "stop_marks",
    "with_marks",
]

_Point = tuple[float, float, float]


def contact_marks(contacts: Contacts, pose: int = 0, *, most: int = 20) -> tuple[Mark, ...]:
    """Mark the deepest contact of every segment with every part or other segment.

    Contacts deeper than allowed carry their excess, "12.4 mm". Allowed ones have no label.

    Parameters
    ----------
    contacts
        Contacts of some poses.
    pose
        The pose to mark.
    most
        Largest number of contacts deeper than allowed; the worst are marked.
    """
    deepest = contacts.deepest()
    order = np.argsort(-deepest.excess, kind="stable")
    chosen = order[deepest.pose[order] == pose]
    is_allowed = deepest.excess[chosen] <= 0
    allowed = tuple(Mark(xyz(deepest.point[row]), "", "allowed") for row in chosen[is_allowed])
    return allowed + tuple(
        Mark(xyz(deepest.point[row]), _millimetres(deepest.excess[row]), "contact")
        for row in chosen[~is_allowed][:most]
    )


def clearance_marks(
    placed: Placed,
    near: Clearance,
    pose: int = 0,
    *,
    most: int = 3,
    within: float = 0.15,
    named: bool = False,
) -> tuple[Mark, ...]:
    """Mark the nearest parts, or segments, that are not touched with dimension lines.

    Each line goes from the surface of the nearest sphere to the nearest point of the part. Pairs
    that may touch are left out.

    Parameters
    ----------
    placed, near
        Placed body and its clearances.
    pose
        The pose to mark.
    most
        Largest number of dimension lines.
    within
        Largest distance [m].
    named
        Whether labels begin with the name of the part.
    """
    clear = _keeps_apart(near) & (near.distance[pose] > 0.0)
    distance = np.where(clear, near.distance[pose], np.inf)
    segment = distance.argmin(axis=0)
    nearest = distance[segment, np.arange(distance.shape[1])] if distance.size else np.empty(0)
    order = np.argsort(nearest, kind="stable")[:most]
    parts = [int(part) for part in order if nearest[part] <= within]
    return tuple(dimension(placed, near, (pose, int(segment[k]), k), named=named) for k in parts)


def _keeps_apart(near: Clearance) -> Bools:
    """Return which (N, K) pairs must not touch: pairs without an allowance, and segments that are
    neither the same nor neighbours."""
    if isinstance(near.other, Environment):
        return (allowed_depth(near.body, near.other) == 0.0) & ~near.other.hidden[None, :]
    if near.body is not near.other:
        return np.ones(near.distance.shape[1:], dtype=np.bool_)
    return ~near.body.adjacent


def dimension(
    placed: Placed, near: Clearance, pair: tuple[int, int, int], *, named: bool = False
) -> Mark:
    """Make the dimension line of one nearest pair, labelled "56.1 mm", or "canopy 56.1 mm".

    Parameters
    ----------
    placed, near
        Placed body and its clearances.
    pair
        Indices of pose, segment and part.
    named
        Whether the label begins with the name of the part.
    """
    pose = pair[0]
    sphere = int(near.sphere[pair])
    point = near.point[pair]
    centre = placed.centres[pose, sphere]
    length = float(np.linalg.norm(point - centre))
    radius = placed.body.radius[placed.person[pose], sphere]
    on_body = centre + (point - centre) * (radius / length) if length > 0.0 else centre
    label = _millimetres(near.distance[pair])
    if named:
        other = near.other
        names = other.parts if isinstance(other, Environment) else other.segment_names
        label = f"{plain(names[pair[2]])} {label}"
    return Mark(xyz(on_body), label, "clearance", xyz(point))


def stop_marks(
    placed: Placed, margin: Floats, pose: int = 0, *, tolerance: float = 1e-9
) -> tuple[Mark, ...]:
    """Mark every joint that is past its stop, with the excess: "right elbow +4.2°".

    Parameters
    ----------
    placed
        Placed body.
    margin
        (P, J) angle [rad] to the stop, negative past it.
    pose
        The pose to mark.
    tolerance
        Excess [rad] that is not marked.
    """
    body = placed.body
    marks = []
    for joint in np.flatnonzero(margin[pose] < -tolerance):
        world = placed.world_from_segment[pose, body.parent[joint + 1]]
        if np.all(np.isfinite(world)):
            excess = np.degrees(-margin[pose, joint])
            centre = body.joint_in_parent[placed.person[pose], joint]
            point = xyz(world[:, :3] @ centre + world[:, 3])
            marks.append(Mark(point, f"{body.joint_names[joint]} +{excess:.1f}°", "stop"))
    return tuple(marks)


def control_marks(
    environment: Environment, reached: dict[str, bool] | None = None
) -> tuple[Mark, ...]:
    """Mark every control of an environment with its name.

    Parameters
    ----------
    environment
        The environment.
    reached
        Whether each control is reached; those that are not are marked as missed.
    """
    reached = reached or {}
    return tuple(
        Mark(
            control.at,
            plain(control.name),
            "reach" if reached.get(control.name, True) else "missed",
        )
        for control in environment.controls
    )


def segment_marks(placed: Placed, pose: int = 0) -> tuple[Mark, ...]:
    """Write the mnemonic of every segment that has spheres at the middle of its spheres."""
    body = placed.body
    marks = []
    for segment, name in enumerate(body.segments):
        centres = placed.centres[pose, body.spheres(segment)]
        if len(centres) and np.all(np.isfinite(centres)):
            middle = (centres.min(axis=0) + centres.max(axis=0)) / 2.0
            marks.append(Mark(xyz(middle), name, "segment"))
    return tuple(marks)


def axes_marks(origin: _Point = (0.0, 0.0, 0.0), *, length: float = 0.2) -> tuple[Mark, ...]:
    """Draw arrows along the axes of the world: x forward, y left, z up.

    Parameters
    ----------
    origin
        Point [m] where the arrows begin.
    length
        Length [m] of the arrows.

    Raises
    ------
    UsageError
        If the length is not positive.
    """
    if not (np.isfinite(length) and length > 0.0):
        raise UsageError(f"axes: a length above 0 m is needed, got {length}")
    tips = np.asarray(origin, dtype=np.float64) + length * np.eye(3)
    return tuple(
        Mark(origin, name, f"axis_{name}", xyz(tip)) for name, tip in zip("xyz", tips, strict=True)
    )


def _millimetres(metres: float) -> str:
    return f"{1000.0 * float(metres):.1f} mm"


MARKS = ("axes", "clearances", "contacts", "controls", "segments", "stops")
"""Kinds of marks."""


def with_marks(source: Source, kinds: tuple[str, ...]) -> Source:
    """Add marks of some kinds to a source.

    Parameters
    ----------
    source
        What is drawn.
    kinds
        Names of `MARKS`.

    Raises
    ------
    UsageError
        If there is no such kind.
    """
    for kind in kinds:
        if kind not in MARKS:
            raise UsageError(f"no marks {kind!r}; {one_of(kind, MARKS)}")
    marked = replace(source, kinds=kinds, fixed=source.scene.marks)
    scene = replace(source.scene, marks=marks_for_scene(marked, source.scene))
    return replace(marked, scene=scene)


def marks_for_scene(source: Source, scene: Scene) -> tuple[Mark, ...]:
    """Return the marks of a scene that shows some poses of a source.

    Marks of the kinds that were asked for follow the poses; the others stay.
    """
    if not source.kinds:
        return scene.marks
    marks = source.fixed
    for kind in source.kinds:
        marks += _marks_of_kind(source, scene, kind)
    return marks


def _marks_of_kind(source: Source, scene: Scene, kind: str) -> tuple[Mark, ...]:
    if kind == "axes":
        low, high = scene.bounds
        return axes_marks((0.0, 0.0, 0.0), length=float(np.max(high - low)) / 5.0)
    if kind == "controls":
        return control_marks(scene.environment) if scene.environment is not None else ()
    marks: tuple[Mark, ...] = ()
    for shown, person in zip(scene.bodies, source.persons, strict=True):
        marks += _body_marks(scene, shown, person, kind)
    return marks


def _body_marks(scene: Scene, shown: SceneBody, person: Person, kind: str) -> tuple[Mark, ...]:
    """Return the marks of one body in the pose that is shown."""
    placed = _shown_pose(shown)
    if kind == "segments":
        return segment_marks(placed)
    if kind == "stops":
        pose = range(len(person.poses))[shown.pose]
        return stop_marks(
            placed, stops(person.body, person.poses.rows(slice(pose, pose + 1))).margin
        )
    if scene.environment is None:
        return ()
    if kind == "contacts":
        return contact_marks(contacts(placed, scene.environment))
    return clearance_marks(placed, nearest(placed, scene.environment))


def _shown_pose(shown: SceneBody) -> Placed:
    """Return the placed body in the shown pose only."""
    placed = shown.placed
    pose = range(len(placed))[shown.pose]  # a pose may be counted from the end
    rows = slice(pose, pose + 1)
    return Placed(placed.body, placed.world_from_segment[rows], placed.centres[rows], placed.window)
