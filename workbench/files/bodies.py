"""Body files: the tree is checked, put in depth-first order and packed into a Body."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.body_schema import BodyFile, JointFile, SegmentFile
from workbench.files.body_stops import axis_vector, pack_stops
from workbench.files.catalogue import find
from workbench.files.schema import fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.vocabulary import DIRECTIONS, OPPOSITE

__all__ = ["body_path", "load_body"]

JOINT_SPHERE_TOLERANCE = 1e-6


def body_path(source: str | Path, *, near: Path | None = None) -> Path:
    """The file of a body given by catalogue name or by path."""
    return find("bodies", str(source), near=near)


def load_body(source: str | Path, *, near: Path | None = None) -> Body:
    """Load a body by catalogue name ("bubbleman") or by path.

    near: the folder of the file that names it. InputError lists every fault of the file with its line.
    """
    document = read_yaml(body_path(source, near=near))
    file = validate(document, BodyFile)
    faults = _tree_faults(document, file)
    if faults:
        raise InputError(faults)
    order, joints = _depth_first(file)
    faults = _segment_faults(document, file)
    if faults:
        raise InputError(faults)
    return _pack(document, file, (order, joints))


def _tree_faults(document: Document, file: BodyFile) -> list[str]:
    """A joint joins exactly two known segments; together they make one tree."""
    faults, proximal = [], {}
    for name, joint in file.joints.items():
        key = ("joints", name)
        for end, segment in enumerate(joint.between):
            if segment not in file.segments:
                what = f"unknown segment {segment!r}; {one_of(segment, file.segments)}"
                faults.append(fail(document, (*key, "between", end), what))
        if joint.between[0] == joint.between[1]:
            faults.append(fail(document, (*key, "between"), "a joint joins two different segments"))
        if set(joint.at) != set(joint.between):
            what = f"coordinates are needed in exactly the two frames {list(joint.between)} (got {list(joint.at)})"
            faults.append(fail(document, (*key, "at"), what))
        if joint.between[1] in proximal:
            what = f"segment {joint.between[1]!r} is already the distal one of joint {proximal[joint.between[1]]!r}"
            faults.append(fail(document, (*key, "between"), what))
        proximal.setdefault(joint.between[1], name)
    if faults:
        return faults
    roots = [name for name in file.segments if name not in proximal]
    if not roots:
        return [fail(document, ("joints",), "the joints form a circle: no segment is the stage (root)")]
    if len(roots) > 1:
        what = f"one tree is needed, but {len(roots)} segments hang from nothing: {', '.join(roots)}"
        return [fail(document, ("segments", roots[1]), what)]
    reached = set(_depth_first(file)[0])
    lost = [name for name in file.segments if name not in reached]
    return [fail(document, ("segments", lost[0]), f"segments in a circle: {', '.join(lost)}")] if lost else []


def _depth_first(file: BodyFile) -> tuple[list[str], list[str]]:
    """Segments in depth-first order from the stage, and the joint above each but the first."""
    above = {joint.between[1]: name for name, joint in file.joints.items()}
    below: dict[str, list[str]] = {name: [] for name in file.segments}
    for joint in file.joints.values():
        below[joint.between[0]].append(joint.between[1])
    todo = [name for name in file.segments if name not in above]
    order: list[str] = []
    while todo:
        order.append(todo.pop())
        todo += reversed(below[order[-1]])
    return order, [above[name] for name in order[1:]]


def _segment_faults(document: Document, file: BodyFile) -> list[str]:
    """Directions, twists, names, numbers, joint spheres and allowances that no schema can check."""
    faults = []
    for name, segment in file.segments.items():
        key = ("segments", name)
        if (twist := segment.twist_along) is not None:
            distal = [j for j, joint in file.joints.items() if joint.between[0] == name]
            if twist not in distal:
                faults.append(fail(document, (*key, "twist_along"), f"not a distal joint of {name} (got {twist!r}); "
                                                                    f"{one_of(twist, distal)}"))  # fmt: skip
        named = [row[4] for row in segment.spheres if len(row) > 4]
        for twice in sorted({label for label in named if named.count(label) > 1}):
            faults.append(fail(document, (*key, "spheres"), f"two spheres are named {twice!r}"))
        if problem := _direction_problem(segment):
            faults.append(fail(document, (*key, "directions"), problem))
    for kind, entries in (("segments", file.segments), ("joints", file.joints)):
        numbers: dict[int, str] = {}
        for name, entry in entries.items():
            if entry.number in numbers:
                what = f"number {entry.number} is taken by {numbers[entry.number]!r}"
                faults.append(fail(document, (kind, name, "number"), what))
            numbers.setdefault(entry.number, name)
    faults += [line for name, joint in file.joints.items() for line in _joint_sphere(document, file, (name, joint))]
    for row, allowance in enumerate(file.allowances):
        for end, segment_name in enumerate(allowance.between):
            if segment_name not in file.segments:
                what = f"unknown segment {segment_name!r}; {one_of(segment_name, file.segments)}"
                faults.append(fail(document, ("allowances", row, "between", end), what))
    return faults


def _joint_sphere(document: Document, file: BodyFile, entry: tuple[str, JointFile]) -> list[str]:
    """The paper's rule: a sphere sits exactly at every joint, in at least one of the two segments."""
    name, joint = entry
    nearest = np.inf
    for segment in joint.between:
        for row in file.segments[segment].spheres:
            nearest = min(nearest, float(np.linalg.norm(np.subtract(row[:3], joint.at[segment]))))
    if nearest <= JOINT_SPHERE_TOLERANCE:
        return []
    far = f"the nearest is {nearest * 1000:.1f} mm away" if np.isfinite(nearest) else "neither segment has spheres"
    what = f"a sphere must sit exactly at the joint in {joint.between[0]} or {joint.between[1]} ({far})"
    return [fail(document, ("joints", name, "at"), what)]


def _direction_problem(segment: SegmentFile) -> str:
    if len({frozenset((name, OPPOSITE[name])) for name in segment.directions}) < 3:
        return "three directions of different pairs are needed (front/back, left/right, top/bottom)"
    table = _directions(segment)
    gram = table[::2] @ table[::2].T
    if not np.allclose(gram, np.eye(3), atol=1e-6):
        return "the directions must be unit vectors at right angles to one another"
    for name, axis in segment.directions.items():
        if not np.allclose(table[DIRECTIONS.index(name)], axis_vector(axis), atol=1e-6):
            return f"{name!r} and {OPPOSITE[name]!r} must be opposite"
    return ""


def _directions(segment: SegmentFile) -> Floats:
    """(6, 3) the six-direction table: what is given, and the opposites of what is given."""
    table = np.zeros((len(DIRECTIONS), 3))
    for name, axis in segment.directions.items():
        table[DIRECTIONS.index(name)] = axis_vector(axis)
        table[DIRECTIONS.index(OPPOSITE[name])] = -axis_vector(axis)
    return table


def _pack(document: Document, file: BodyFile, tree: tuple[list[str], list[str]]) -> Body:
    order, joints = tree
    index = {name: i for i, name in enumerate(order)}
    segments = [file.segments[name] for name in order]
    rows = [row for segment in segments for row in segment.spheres]
    counts = [len(segment.spheres) for segment in segments]
    start = np.concatenate([[0], np.cumsum(counts)])
    centre = np.array([row[:3] for row in rows]).reshape(-1, 3)
    radius = np.array([row[3] for row in rows])
    in_child = np.array([file.joints[j].at[n] for j, n in zip(joints, order[1:], strict=True)]).reshape(-1, 3)
    in_parent = np.array([file.joints[j].at[file.joints[j].between[0]] for j in joints]).reshape(-1, 3)
    lines = _twist_lines((order, joints), file, (in_parent, in_child))
    share = _twist_share(lines, (centre, start))
    around = [_enclosing((centre[a:b], radius[a:b]), _axis_of(lines, n)) for n, (a, b) in enumerate(
        zip(start[:-1], start[1:], strict=True))]  # fmt: skip
    allowance = np.zeros((len(order), len(order)))
    for row in file.allowances:
        a, b = (index[name] for name in row.between)
        allowance[a, b] = allowance[b, a] = row.depth
    return Body(
        name=file.body,
        description=file.description,
        segments=tuple(order),
        segment_names=tuple(s.name for s in segments),
        segment_numbers=tuple(s.number for s in segments),
        joints=tuple(joints),
        joint_names=tuple(file.joints[j].name for j in joints),
        joint_numbers=tuple(file.joints[j].number for j in joints),
        parent=np.array([-1] + [index[file.joints[j].between[0]] for j in joints]),
        joint_in_parent=in_parent,
        joint_in_child=in_child,
        stops=pack_stops(document, file, (order, joints)),
        mass=np.array([s.mass for s in segments]),
        centre=centre,
        radius=radius,
        start=start,
        enclosing_centre=np.array([c for c, _ in around]).reshape(-1, 3),
        enclosing_radius=np.array([r for _, r in around]),
        sphere_names=tuple(row[4] if len(row) > 4 else "" for row in rows),
        sphere_direction=np.array([DIRECTIONS.index(row[5]) if len(row) > 5 else -1 for row in rows], dtype=np.int64),
        directions=np.array([_directions(s) for s in segments]),
        twist_joint=lines[0],
        twist_point=lines[1],
        twist_axis=lines[2],
        twist_share=share,
        allowance=allowance,
        fit_error=np.array([[s.fit_error.outside, s.fit_error.inside] if s.fit_error else [np.nan] * 2
                            for s in segments]),  # fmt: skip
    )


Lines = tuple[np.ndarray, Floats, Floats, Floats]


def _twist_lines(tree: tuple[list[str], list[str]], file: BodyFile, ends: tuple[Floats, Floats]) -> Lines:
    """For each segment: the distal joint whose twist it shares, the line it turns about, and the line's length.

    The line runs from the proximal to the distal joint; its sense is that of the joint's own twist axis.
    """
    order, joints = tree
    in_parent, in_child = ends
    joint = np.full(len(order), -1)
    point, axis, length = np.zeros((len(order), 3)), np.zeros((len(order), 3)), np.ones(len(order))
    for n, name in enumerate(order):
        if (twist := file.segments[name].twist_along) is None:
            continue
        joint[n] = joints.index(twist)
        proximal = in_child[n - 1] if n else np.zeros(3)
        span = in_parent[joint[n]] - proximal
        length[n] = np.linalg.norm(span)
        point[n] = proximal
        axis[n] = span / length[n]
    return joint, point, axis, length


def _twist_share(lines: Lines, spheres: tuple[Floats, np.ndarray]) -> Floats:
    joint, point, axis, length = lines
    centre, start = spheres
    share = np.zeros(len(centre))
    for n in np.flatnonzero(joint >= 0):
        rows = slice(start[n], start[n + 1])
        share[rows] = np.clip((centre[rows] - point[n]) @ axis[n] / length[n], 0.0, 1.0)
    return share


def _axis_of(lines: Lines, segment: int) -> tuple[Floats, Floats] | None:
    return (lines[1][segment], lines[2][segment]) if lines[0][segment] >= 0 else None


def _enclosing(spheres: tuple[Floats, Floats], axis: tuple[Floats, Floats] | None) -> tuple[Floats, float]:
    """A small sphere around spheres; with its centre on the twist axis where there is one, so that any twist fits."""
    centre, radius = spheres
    if not len(centre):
        return np.zeros(3), 0.0
    best = (centre * radius[:, None]).sum(axis=0) / radius.sum()
    step = 1.0
    for _ in range(200):
        if axis is not None:
            best = axis[0] + axis[1] * ((best - axis[0]) @ axis[1])
        reach = np.linalg.norm(centre - best, axis=1) + radius
        far = int(np.argmax(reach))
        step *= 0.95
        best = best + step * 0.5 * (centre[far] - best)
    if axis is not None:
        best = axis[0] + axis[1] * ((best - axis[0]) @ axis[1])
    return best, float((np.linalg.norm(centre - best, axis=1) + radius).max()) + 1e-12
