"""What no schema can check in a body file: one tree, a sphere at every joint, tables that fit
together."""

from __future__ import annotations

import numpy as np

from workbench.errors import one_of
from workbench.files.body.schema import BodyFile, JointFile, SegmentFile
from workbench.files.body.stops import axis_vector
from workbench.files.schema import fail
from workbench.files.yaml_text import Document
from workbench.model.arrays import Floats
from workbench.model.vocabulary import DIRECTIONS, OPPOSITE

__all__ = ["depth_first", "direction_table", "segment_faults", "tree_faults"]

JOINT_SPHERE_TOLERANCE = 1e-6


def tree_faults(document: Document, file: BodyFile) -> list[str]:
    """A joint joins exactly two known segments; together they make one tree."""
    faults: list[str] = []
    proximal: dict[str, str] = {}
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
        return [
            fail(document, ("joints",), "the joints form a circle: no segment is the stage (root)")
        ]
    if len(roots) > 1:
        what = (
            f"one tree is needed, but {len(roots)} segments hang from nothing: {', '.join(roots)}"
        )
        return [fail(document, ("segments", roots[1]), what)]
    reached = set(depth_first(file)[0])
    lost = [name for name in file.segments if name not in reached]
    return (
        [fail(document, ("segments", lost[0]), f"segments in a circle: {', '.join(lost)}")]
        if lost
        else []
    )


def depth_first(file: BodyFile) -> tuple[list[str], list[str]]:
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


def segment_faults(document: Document, file: BodyFile) -> list[str]:
    """Directions, twists, names, numbers, joint spheres and allowances that no schema can check."""
    faults = []
    for name, segment in file.segments.items():
        key = ("segments", name)
        if problem := _twist_problem(file, name):
            faults.append(fail(document, (*key, "twist_along"), problem))
        named = [row[4] for row in segment.spheres if len(row) > 4]
        for twice in sorted({label for label in named if named.count(label) > 1}):
            faults.append(fail(document, (*key, "spheres"), f"two spheres are named {twice!r}"))
        faults += _blend_faults(document, file, name)
        if problem := _direction_problem(segment):
            faults.append(fail(document, (*key, "directions"), problem))
    if not any(segment.spheres for segment in file.segments.values()):
        faults.append(
            fail(document, ("segments",), "a body is made of spheres; none of its segments has one")
        )
    for kind, entries in (("segments", file.segments), ("joints", file.joints)):
        numbers: dict[int, str] = {}
        for name, entry in entries.items():
            if entry.number in numbers:
                what = f"number {entry.number} is taken by {numbers[entry.number]!r}"
                faults.append(fail(document, (kind, name, "number"), what))
            numbers.setdefault(entry.number, name)
    faults += [
        line
        for name, joint in file.joints.items()
        for line in _joint_sphere(document, file, (name, joint))
    ]
    faults += _allowance_faults(document, file)
    return faults


def _allowance_faults(document: Document, file: BodyFile) -> list[str]:
    """Two known segments, and each pair once: two depths for one pair would leave open which of
    them counts."""
    faults = []
    seen = dict[frozenset[str], int]()
    words = {segment.name: name for name, segment in file.segments.items()}
    for row, allowance in enumerate(file.allowances):
        pair = frozenset(allowance.between)
        if pair in seen:
            before = document.where(("allowances", seen[pair])).removeprefix(f"{document.file}:")
            what = f"{' and '.join(allowance.between)} have an allowance already, at {before}; one for each pair"
            faults.append(fail(document, ("allowances", row), what))
        seen.setdefault(pair, row)
        for end, segment_name in enumerate(allowance.between):
            if segment_name not in file.segments:
                what = f"unknown segment {segment_name!r}; {one_of(segment_name, file.segments, words=words)}"
                faults.append(fail(document, ("allowances", row, "between", end), what))
    return faults


def _blend_faults(document: Document, file: BodyFile, name: str) -> list[str]:
    """A sphere is there, and blended across one joint of its own segment."""
    segment = file.segments[name]
    key = ("segments", name, "blend")
    near = [j for j, joint in file.joints.items() if name in joint.between]
    faults = []
    taken = dict[int, str]()
    for joint, rows in segment.blend.items():
        if joint not in near:
            what = f"not a joint of {name} (got {joint!r}); {one_of(joint, near)}"
            faults.append(fail(document, (*key, joint), what))
        for row in rows:
            where = (*key, joint, row)
            if int(row) >= len(segment.spheres):
                what = f"{name} has the spheres 0 to {len(segment.spheres) - 1} (got {row})"
                faults.append(fail(document, where, what))
            elif int(row) in taken:
                what = (
                    f"sphere {row} is blended across {taken[int(row)]} already; one joint a sphere"
                )
                faults.append(fail(document, where, what))
            taken.setdefault(int(row), joint)
    return faults


def _twist_problem(file: BodyFile, name: str) -> str:
    """Twist is shared along the line from the proximal joint (the origin, at the stage) to a distal
    one."""
    twist = file.segments[name].twist_along
    if twist is None:
        return ""
    distal = [j for j, joint in file.joints.items() if joint.between[0] == name]
    if twist not in distal:
        return f"not a distal joint of {name} (got {twist!r}); {one_of(twist, distal)}"
    proximal = [
        joint.at[name]
        for joint in file.joints.values()
        if joint.between[1] == name and name in joint.at
    ]
    start = (proximal or [(0.0, 0.0, 0.0)])[0]
    end = file.joints[twist].at.get(name)
    if end is not None and float(np.linalg.norm(np.subtract(start, end))) <= JOINT_SPHERE_TOLERANCE:
        return f"joint {twist} lies where the proximal joint of {name} is: no line for the twist to be shared along"
    return ""


def _joint_sphere(document: Document, file: BodyFile, entry: tuple[str, JointFile]) -> list[str]:
    """The paper's rule: a sphere sits exactly at every joint, in at least one of the two
    segments."""
    name, joint = entry
    if not set(joint.between) <= set(joint.at) & set(file.segments):
        return []  # told already
    nearest = np.inf
    for segment in joint.between:
        for row in file.segments[segment].spheres:
            nearest = min(nearest, float(np.linalg.norm(np.subtract(row[:3], joint.at[segment]))))
    if nearest <= JOINT_SPHERE_TOLERANCE:
        return []
    far = (
        f"the nearest is {nearest * 1000:.1f} mm away"
        if np.isfinite(nearest)
        else "neither segment has spheres"
    )
    what = f"a sphere must sit exactly at the joint in {joint.between[0]} or {joint.between[1]} ({far})"
    return [fail(document, ("joints", name, "at"), what)]


def _direction_problem(segment: SegmentFile) -> str:
    if len({frozenset((name, OPPOSITE[name])) for name in segment.directions}) < 3:
        return "three directions of different pairs are needed (front/back, left/right, top/bottom)"
    table = direction_table(segment)
    gram = table[::2] @ table[::2].T
    if not np.allclose(gram, np.eye(3), atol=1e-6):
        return "the directions must be unit vectors at right angles to one another"
    for name, axis in segment.directions.items():
        if not np.allclose(table[DIRECTIONS.index(name)], axis_vector(axis), atol=1e-6):
            return f"{name!r} and {OPPOSITE[name]!r} must be opposite"
    if np.linalg.det(table[::2]) < 0:
        return (
            "front, left and top must be a right-handed set, as +x, +y, +z are (front x left = top)"
        )
    return ""


def direction_table(segment: SegmentFile) -> Floats:
    """(6, 3) the six-direction table: what is given, and the opposites of what is given."""
    table = np.zeros((len(DIRECTIONS), 3))
    for name, axis in segment.directions.items():
        table[DIRECTIONS.index(name)] = axis_vector(axis)
        table[DIRECTIONS.index(OPPOSITE[name])] = -axis_vector(axis)
    return table
