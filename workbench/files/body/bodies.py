"""Body files: the tree is checked, put in depth-first order and packed into a Body."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.basis import load_basis
from workbench.files.body.schema import BodyFile, SegmentFile
from workbench.files.body.stops import pack_stops, stop_faults
from workbench.files.body.validation import (
    depth_first,
    direction_table,
    segment_faults,
    validate_tree,
)
from workbench.files.catalogue import find, find_beside
from workbench.files.schema import error_at, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import ShapeBasis, in_order
from workbench.model.body import DIRECTIONS, Body, Topology
from workbench.model.skinning import with_derived_fields

__all__ = ["body_path", "load_body"]


def body_path(source: str | Path, *, near: Path | None = None) -> Path:
    """The file of a body given by catalogue name or by path."""
    return find("bodies", str(source), near=near)


def load_body(source: str | Path, *, near: Path | None = None) -> Body:
    """Load a body by catalogue name ("bubbleman") or by path.

    Parameters
    ----------
    source
        The name of a body of the catalogue, or the path of a file.
    near
        The folder of the file that names it.

    Raises
    ------
    InputError
        With every fault of the file and its line.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> len(body.segments), len(body.joints), body.radius.shape[1]  # spheres
    (20, 19, 399)
    """
    document = read_yaml(body_path(source, near=near))
    file = validate(document, BodyFile)
    faults = (
        validate_tree(document, file) + segment_faults(document, file) + stop_faults(document, file)
    )
    if faults:
        raise InputError(faults)
    body = with_derived_fields(_pack(file))
    return _of_family(document, file, body) if file.basis else body


def _of_family(document: Document, file: BodyFile, body: Body) -> Body:
    """The body with the basis that lies beside its file; InputError where the two do not belong
    together."""
    basis = load_basis(find_beside(document, ("basis",), str(file.basis)))
    try:
        basis = in_order(basis, body.segments, body.joints)
    except InputError as error:
        raise InputError(error_at(document, ("basis",), str(error))) from None
    if len(file.basis_at) != len(basis):
        what = f"{len(basis)} coefficients are needed for {basis.name} (got {len(file.basis_at)})"
        raise InputError(error_at(document, ("basis_at",) if file.basis_at else ("basis",), what))
    if not basis.level(np.diff(body.start)):
        raise InputError(error_at(document, ("basis",), _no_level(basis, body)))
    topology = replace(body.topology, basis=basis)
    return replace(body, topology=topology, basis_at=np.array([file.basis_at]))


def _no_level(basis: ShapeBasis, body: Body) -> str:
    """Why the spheres of a body are none of the levels of detail of its basis."""
    levels = ", ".join(f"{level} {len(detail.names)}" for level, detail in basis.details.items())
    count = len(body.sphere_names)
    return (
        f"{basis.name} has spheres for {levels}; this body's {count} spheres fit none of these "
        "levels"
    )


def _pack(file: BodyFile) -> Body:
    """The body of a file without faults; what is derived from its arrays is left at zero."""
    order, joints = depth_first(file)
    segments = [file.segments[name] for name in order]
    entries = [file.joints[name] for name in joints]
    rows = [row for segment in segments for row in segment.spheres]
    blend_joint, blend_share = _blend(segments, joints)
    in_child = [j.at[name] for j, name in zip(entries, order[1:], strict=True)]
    in_parent = [j.at[j.between[0]] for j in entries]
    n = len(order)
    return Body(
        name=file.body,
        description=file.description,
        topology=_topology(file, order, joints, blend_joint),
        joint_in_parent=np.array(in_parent, dtype=np.float64).reshape(1, -1, 3),
        joint_in_child=np.array(in_child, dtype=np.float64).reshape(1, -1, 3),
        mass=np.array([[s.mass for s in segments]]),
        centre=np.array([row[:3] for row in rows], dtype=np.float64).reshape(1, -1, 3),
        radius=np.array([[row[3] for row in rows]], dtype=np.float64),
        enclosing_centre=np.zeros((1, n, 3)),
        enclosing_radius=np.zeros((1, n)),
        twist_point=np.zeros((1, n, 3)),
        twist_axis=np.zeros((1, n, 3)),
        twist_share=np.zeros((1, len(rows))),
        allowance=_allowance(file, order)[None],
        fit_error=np.array([[_fit_error(segment) for segment in segments]]),
        blend_share=blend_share[None],
        seated_factors=_seated(file),
    )


def _topology(file: BodyFile, order: list[str], joints: list[str], blend_joint: Ints) -> Topology:
    """What all sizes of the body share.

    Parameters
    ----------
    order, joints
        The segments in depth-first order, and the joint above each but the first.
    blend_joint
        (S,) the joint that each sphere is blended across, -1 where none.
    """
    segments = [file.segments[name] for name in order]
    entries = [file.joints[name] for name in joints]
    rows = [row for segment in segments for row in segment.spheres]
    sides = [DIRECTIONS.index(row[5]) if len(row) > 5 else -1 for row in rows]
    twists = [joints.index(s.twist_along) if s.twist_along else -1 for s in segments]
    return Topology(
        segments=tuple(order),
        segment_names=tuple(s.name for s in segments),
        segment_numbers=tuple(s.number for s in segments),
        joints=tuple(joints),
        joint_names=tuple(j.name for j in entries),
        joint_numbers=tuple(j.number for j in entries),
        parent=np.array([-1] + [order.index(j.between[0]) for j in entries]),
        stops=pack_stops(file, order, joints),
        start=np.cumsum([0] + [len(s.spheres) for s in segments]),
        sphere_names=tuple(row[4] if len(row) > 4 else "" for row in rows),
        sphere_direction=np.array(sides, np.int64),
        directions=np.array([direction_table(s) for s in segments]),
        twist_joint=np.array(twists, np.int64),
        blend_joint=blend_joint,
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


def _allowance(file: BodyFile, order: list[str]) -> Floats:
    """(N, N) the overlap of soft flesh that is no contact [m], both ways."""
    depth = np.zeros((len(order), len(order)))
    for row in file.allowances:
        a, b = (order.index(name) for name in row.between)
        depth[a, b] = depth[b, a] = row.depth
    return depth


def _seated(file: BodyFile) -> Floats:
    """(1, 2) breadth and thickness of hips and thighs on a seat as shares of those standing."""
    given = file.seated
    return np.array([[given.breadth, given.thickness]]) if given else np.ones((1, 2))


def _fit_error(segment: SegmentFile) -> tuple[float, float]:
    """How far the true surface may lie outside and inside [m]; NaN where the file does not say."""
    given = segment.fit_error
    return (given.outside, given.inside) if given else (math.nan, math.nan)
