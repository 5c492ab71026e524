"""Body files: the tree is checked, put in depth-first order and packed into a Body."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.basis import load_basis
from workbench.files.body.checks import depth_first, direction_table, segment_faults, tree_faults
from workbench.files.body.schema import BodyFile, SegmentFile
from workbench.files.body.stops import pack_stops, stop_faults
from workbench.files.catalogue import find, find_beside
from workbench.files.schema import fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import in_order
from workbench.model.body import Body, Topology
from workbench.model.settled import settled
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["body_path", "load_body"]


def body_path(source: str | Path, *, near: Path | None = None) -> Path:
    """The file of a body given by catalogue name or by path."""
    return find("bodies", str(source), near=near)


def load_body(source: str | Path, *, near: Path | None = None) -> Body:
    """Load a body by catalogue name ("bubbleman") or by path.

    near: the folder of the file that names it. InputError lists every fault of the file with its
    line.
    """
    document = read_yaml(body_path(source, near=near))
    file = validate(document, BodyFile)
    faults = (
        tree_faults(document, file) + segment_faults(document, file) + stop_faults(document, file)
    )
    if faults:
        raise InputError(faults)
    body = settled(_pack(file, depth_first(file)))
    return _of_family(document, file, body) if file.basis else body


def _of_family(document: Document, file: BodyFile, body: Body) -> Body:
    """The body with the basis that lies beside its file; InputError where the two do not belong
    together."""
    basis = load_basis(find_beside(document, ("basis",), str(file.basis)))
    try:
        basis = in_order(basis, body.segments, body.joints)
    except InputError as error:
        raise InputError(fail(document, ("basis",), str(error))) from None
    if len(file.basis_at) != len(basis):
        what = f"{len(basis)} coefficients are needed for {basis.name} (got {len(file.basis_at)})"
        raise InputError(fail(document, ("basis_at",) if file.basis_at else ("basis",), what))
    if not basis.level(np.diff(body.start)):
        told = ", ".join(f"{level} {len(detail.names)}" for level, detail in basis.details.items())
        what = f"{basis.name} has spheres for {told}; this body's {len(body.sphere_names)} spheres fit none of these levels"
        raise InputError(fail(document, ("basis",), what))
    topology = replace(body.topology, basis=basis)
    return replace(body, topology=topology, basis_at=np.array([file.basis_at]))


def _pack(file: BodyFile, tree: tuple[list[str], list[str]]) -> Body:
    order, joints = tree
    segments = [file.segments[name] for name in order]
    entries = [file.joints[name] for name in joints]
    index = {name: i for i, name in enumerate(order)}
    rows = [row for segment in segments for row in segment.spheres]
    blend = _blend(segments, joints)
    topology = Topology(
        segments=tuple(order),
        segment_names=tuple(s.name for s in segments),
        segment_numbers=tuple(s.number for s in segments),
        joints=tuple(joints),
        joint_names=tuple(j.name for j in entries),
        joint_numbers=tuple(j.number for j in entries),
        parent=np.array([-1] + [index[j.between[0]] for j in entries]),
        stops=pack_stops(file, tree),
        start=np.concatenate([[0], np.cumsum([len(segment.spheres) for segment in segments])]),
        sphere_names=tuple(row[4] if len(row) > 4 else "" for row in rows),
        sphere_direction=np.array(
            [DIRECTIONS.index(row[5]) if len(row) > 5 else -1 for row in rows], np.int64
        ),
        directions=np.array([direction_table(s) for s in segments]),
        twist_joint=np.array(
            [joints.index(s.twist_along) if s.twist_along else -1 for s in segments], np.int64
        ),
        blend_joint=blend[0],
    )
    in_child = [j.at[name] for j, name in zip(entries, order[1:], strict=True)]
    in_parent = [j.at[j.between[0]] for j in entries]
    return Body(
        name=file.body,
        description=file.description,
        topology=topology,
        joint_in_parent=np.array(in_parent, dtype=np.float64).reshape(1, -1, 3),
        joint_in_child=np.array(in_child, dtype=np.float64).reshape(1, -1, 3),
        mass=np.array([[s.mass for s in segments]]),
        centre=np.array([row[:3] for row in rows], dtype=np.float64).reshape(1, -1, 3),
        radius=np.array([[row[3] for row in rows]], dtype=np.float64),
        enclosing_centre=np.zeros((1, len(order), 3)),
        enclosing_radius=np.zeros((1, len(order))),
        twist_point=np.zeros((1, len(order), 3)),
        twist_axis=np.zeros((1, len(order), 3)),
        twist_share=np.zeros((1, len(rows))),
        allowance=_allowance(file, index)[None],
        fit_error=np.array([[_fit_error(segment) for segment in segments]]),
        blend_share=blend[1][None],
    )


def _blend(segments: list[SegmentFile], joints: list[str]) -> tuple[Ints, Floats]:
    """The joint each sphere is blended across, -1 where none, and its share."""
    joint: list[int] = []
    share: list[float] = []
    for segment in segments:
        rows = {
            int(row): (joints.index(name), part)
            for name, parts in segment.blend.items()
            for row, part in parts.items()
        }
        found = [rows.get(row, (-1, 0.0)) for row in range(len(segment.spheres))]
        joint += [at for at, _ in found]
        share += [part for _, part in found]
    return np.array(joint, dtype=np.int64), np.array(share)


def _allowance(file: BodyFile, index: dict[str, int]) -> Floats:
    """(N, N) the overlap of soft flesh that is no contact, both ways."""
    depth = np.zeros((len(index), len(index)))
    for row in file.allowances:
        a, b = (index[name] for name in row.between)
        depth[a, b] = depth[b, a] = row.depth
    return depth


def _fit_error(segment: SegmentFile) -> tuple[float, float]:
    """How far the true surface may lie outside and inside; NaN where the file does not say."""
    told = segment.fit_error
    return (told.outside, told.inside) if told else (math.nan, math.nan)
