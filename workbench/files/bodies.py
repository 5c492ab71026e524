"""Body files: the tree is checked, put in depth-first order and packed into a Body."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.body_checks import depth_first, direction_table, segment_faults, tree_faults
from workbench.files.body_geometry import enclosing, line_of, twist_lines, twist_share
from workbench.files.body_schema import BodyFile, SegmentFile
from workbench.files.body_stops import pack_stops
from workbench.files.catalogue import find
from workbench.files.schema import validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["body_path", "load_body"]


def body_path(source: str | Path, *, near: Path | None = None) -> Path:
    """The file of a body given by catalogue name or by path."""
    return find("bodies", str(source), near=near)


def load_body(source: str | Path, *, near: Path | None = None) -> Body:
    """Load a body by catalogue name ("bubbleman") or by path.

    near: the folder of the file that names it. InputError lists every fault of the file with its line.
    """
    document = read_yaml(body_path(source, near=near))
    file = validate(document, BodyFile)
    faults = tree_faults(document, file)
    if faults:
        raise InputError(faults)
    order, joints = depth_first(file)
    faults = segment_faults(document, file)
    if faults:
        raise InputError(faults)
    return _pack(document, file, (order, joints))


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
    lines = twist_lines((order, joints), file, (in_parent, in_child))
    share = twist_share(lines, (centre, start))
    around = [
        enclosing((centre[a:b], radius[a:b]), line_of(lines, n)) for n, (a, b) in enumerate(pairwise(start.tolist()))
    ]
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
        directions=np.array([direction_table(s) for s in segments]),
        twist_joint=lines[0],
        twist_point=lines[1],
        twist_axis=lines[2],
        twist_share=share,
        allowance=allowance,
        fit_error=np.array([_fit_error(segment) for segment in segments]),
    )


def _fit_error(segment: SegmentFile) -> tuple[float, float]:
    """How far the true surface may lie outside and inside; NaN where the file does not say."""
    told = segment.fit_error
    return (told.outside, told.inside) if told else (math.nan, math.nan)
