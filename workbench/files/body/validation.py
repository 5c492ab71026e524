"""What no schema can check in a body file: one tree, a sphere at every joint, tables that fit
together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from workbench.errors import one_of
from workbench.files.body.schema import BodyFile, JointFile, SegmentFile
from workbench.files.body.stops import axis_vector
from workbench.files.schema import error_at
from workbench.files.yaml_text import Document
from workbench.model.arrays import Floats
from workbench.model.body import DIRECTIONS, OPPOSITE

__all__ = ["depth_first", "direction_table", "segment_faults", "validate_tree"]

JOINT_SPHERE_TOLERANCE = 1e-6
_TRUNK = {"LT", "CT", "UT", "H"}
"""Segments that tell a person."""
_Problem = tuple[tuple[str | int, ...], str]
"""A key of the file, and what is wrong there."""


def validate_tree(document: Document, file: BodyFile) -> list[str]:
    """A joint joins exactly two known segments; together they make one tree."""
    problems: list[_Problem] = []
    above: dict[str, str] = {}
    for name, joint in file.joints.items():
        problems += _end_problems(file, name, joint)
        distal = joint.between[1]
        if distal in above:
            what = f"segment {distal!r} is already the distal one of joint {above[distal]!r}"
            problems.append((("joints", name, "between"), what))
        above.setdefault(distal, name)
    if not problems:
        problems += _root_problems(file, [name for name in file.segments if name not in above])
    return [error_at(document, key, what) for key, what in problems]


def _root_problems(file: BodyFile, roots: list[str]) -> Iterator[_Problem]:
    """Why the segments are not one tree, and where. roots: those that hang from nothing."""
    if not roots:
        yield ("joints",), "the joints form a circle: no segment is the stage (root)"
        return
    if len(roots) > 1:
        what = f"one tree is needed, but {len(roots)} segments hang from nothing: "
        yield ("segments", roots[1]), what + ", ".join(roots)
        return
    reached = set(depth_first(file)[0])
    lost = [name for name in file.segments if name not in reached]
    if lost:
        yield ("segments", lost[0]), f"segments in a circle: {', '.join(lost)}"


def _end_problems(file: BodyFile, name: str, joint: JointFile) -> Iterator[_Problem]:
    """What is wrong with the two ends of a joint, and where."""
    key = ("joints", name)
    for end, segment in enumerate(joint.between):
        if segment not in file.segments:
            what = f"unknown segment {segment!r}; {one_of(segment, file.segments)}"
            yield (*key, "between", end), what
    if joint.between[0] == joint.between[1]:
        yield (*key, "between"), "a joint joins two different segments"
    if set(joint.at) != set(joint.between):
        frames = f"{list(joint.between)} (got {list(joint.at)})"
        yield (*key, "at"), f"coordinates are needed in exactly the two frames {frames}"


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
    problems = [
        *(problem for name in file.segments for problem in _segment_problems(file, name)),
        *_number_problems(file),
        *_joint_sphere_problems(file),
        *_lost_limbs(file),
    ]
    faults = [error_at(document, key, what) for key, what in problems]
    return faults + _allowance_faults(document, file)


def _segment_problems(file: BodyFile, name: str) -> Iterator[_Problem]:
    """What is wrong with the twist, the spheres and the directions of a segment, and where."""
    segment = file.segments[name]
    key = ("segments", name)
    if problem := _twist_problem(file, name):
        yield (*key, "twist_along"), problem
    named = [row[4] for row in segment.spheres if len(row) > 4]
    for twice in sorted({label for label in named if named.count(label) > 1}):
        yield (*key, "spheres"), f"two spheres are named {twice!r}"
    yield from _blend_problems(file, name)
    if problem := _direction_problem(segment):
        yield (*key, "directions"), problem


def _number_problems(file: BodyFile) -> Iterator[_Problem]:
    """A body without spheres, and numbers that two segments or two joints have, and where."""
    if not any(segment.spheres for segment in file.segments.values()):
        yield ("segments",), "a body is made of spheres; none of its segments has one"
    entries: Mapping[str, SegmentFile | JointFile]
    for kind, entries in (("segments", file.segments), ("joints", file.joints)):
        numbers: dict[int, str] = {}
        for name, entry in entries.items():
            if entry.number in numbers:
                what = f"number {entry.number} is taken by {numbers[entry.number]!r}"
                yield (kind, name, "number"), what
            numbers.setdefault(entry.number, name)


def _allowance_faults(document: Document, file: BodyFile) -> list[str]:
    """Two known segments, and each pair once: two depths for one pair would leave open which of
    them counts."""
    faults = []
    seen = dict[frozenset[str], int]()
    for row, allowance in enumerate(file.allowances):
        key = ("allowances", row)
        first = seen.setdefault(frozenset(allowance.between), row)
        if first != row:
            pair = " and ".join(allowance.between)
            before = document.where(("allowances", first)).removeprefix(f"{document.file}:")
            what = f"{pair} have an allowance already, at {before}; one for each pair"
            faults.append(error_at(document, key, what))
        faults += [
            error_at(document, (*key, "between", end), _unknown_segment(file, name))
            for end, name in enumerate(allowance.between)
            if name not in file.segments
        ]
    return faults


def _unknown_segment(file: BodyFile, name: str) -> str:
    """That a body has no such segment, with one that may be meant."""
    words = {segment.name: mnemonic for mnemonic, segment in file.segments.items()}
    return f"unknown segment {name!r}; {one_of(name, file.segments, words=words)}"


def _blend_problems(file: BodyFile, name: str) -> Iterator[_Problem]:
    """What is wrong with the blends of a segment: a sphere is there, and blended across one joint
    of its own segment."""
    key = ("segments", name, "blend")
    near = [j for j, joint in file.joints.items() if name in joint.between]
    count = len(file.segments[name].spheres)
    taken = dict[int, str]()
    for joint, rows in file.segments[name].blend.items():
        if joint not in near:
            yield (*key, joint), f"not a joint of {name} (got {joint!r}); {one_of(joint, near)}"
        for row in rows:
            before = taken.get(int(row))
            if int(row) >= count:
                what = f"{name} has the spheres 0 to {count - 1} (got {row})"
                yield (*key, joint, row), what
            elif before is not None:
                what = f"sphere {row} is blended across {before} already; one joint a sphere"
                yield (*key, joint, row), what
            taken.setdefault(int(row), joint)


def _twist_problem(file: BodyFile, name: str) -> str:
    """Why the twist of a segment cannot be shared, "" where it can: it is shared along the line
    from the proximal joint (the origin, at the stage) to a distal one."""
    twist = file.segments[name].twist_along
    if twist is None:
        return ""
    joints = file.joints.values()
    distal = [j for j, joint in file.joints.items() if joint.between[0] == name]
    if twist not in distal:
        return f"not a distal joint of {name} (got {twist!r}); {one_of(twist, distal)}"
    proximal = (j.at[name] for j in joints if j.between[1] == name and name in j.at)
    start = next(proximal, (0.0, 0.0, 0.0))
    end = file.joints[twist].at.get(name)
    if end is not None and float(np.linalg.norm(np.subtract(start, end))) <= JOINT_SPHERE_TOLERANCE:
        return (
            f"joint {twist} lies where the proximal joint of {name} is: no line for the twist to be "
            "shared along"
        )
    return ""


def _joint_sphere_problems(file: BodyFile) -> Iterator[_Problem]:
    """Joints without a sphere at them, and where. The paper's rule: a sphere sits exactly at every
    joint, in at least one of the two segments."""
    for name, joint in file.joints.items():
        if not set(joint.between) <= set(joint.at) & set(file.segments):
            continue  # reported with the tree
        if _is_missing(file, joint.between[1]):
            continue
        nearest = min(
            (
                float(np.linalg.norm(np.subtract(row[:3], joint.at[segment])))
                for segment in joint.between
                for row in file.segments[segment].spheres
            ),
            default=math.inf,
        )
        if nearest > JOINT_SPHERE_TOLERANCE:
            far = "neither segment has spheres"
            if math.isfinite(nearest):
                far = f"the nearest is {nearest * 1000:.1f} mm away"
            ends = " or ".join(joint.between)
            what = f"a sphere must sit exactly at the joint in {ends} ({far})"
            yield ("joints", name, "at"), what


def _twin(name: str) -> str:
    """The mnemonic of the same segment on the other side; the same where it has no side."""
    return {"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]


def _is_missing(file: BodyFile, name: str) -> bool:
    """Whether a segment stands for a limb that is missing: without spheres, which its twin has."""
    twin = file.segments.get(_twin(name))
    return not file.segments[name].spheres and twin is not None and bool(twin.spheres)


def _lost_limbs(file: BodyFile) -> Iterator[_Problem]:
    """Limbs of a person that only one side has, and where: seats and postures need their joints."""
    if not file.segments.keys() >= _TRUNK:
        return
    for name, segment in file.segments.items():
        if _twin(name) not in file.segments and segment.name.startswith(("left ", "right ")):
            what = (
                f"a person has {_twin(name)} too: of a limb that is missing keep the segment, with "
                "'mass: 0' and 'spheres: []', and its joint"
            )
            yield ("segments", name), what


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
