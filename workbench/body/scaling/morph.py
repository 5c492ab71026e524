"""Compute members of a family of bodies, at any level of detail, on the skeleton of a known member."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.scaling.rig import Shape
from workbench.body.scaling.space import ON_JOINT, volumes
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import Detail, ShapeBasis
from workbench.model.body import Body, check_one
from workbench.model.skinning import with_derived_fields

__all__ = ["lengthened", "morph"]


def morph(template: Body, at: ArrayLike | Sequence[float], level: str) -> Body:
    """Compute the member of a template's family with given coefficients.

    The template lends segments, stops, directions, allowances for soft flesh and density: masses
    are the template's by how much the member's segments hold more than its own member's, both at
    the template's level of detail, so that they are the same at every level. On a seat its flesh spreads as that of the
    nearest known member.

    Parameters
    ----------
    template
        A member of the family.
    at
        (K,) coefficients.
    level
        Name of a level of detail.

    Raises
    ------
    InputError
        If the template has no family, there is no such level, or no such member.
    """
    check_one(template)
    basis = template.basis
    if basis is None:
        raise InputError(f"body {template.name} belongs to no family of bodies")
    z = np.asarray(at, dtype=np.float64)
    if z.shape != (len(basis),) or not np.all(np.isfinite(z)):
        raise InputError(
            f"{basis.name}: {len(basis)} finite coefficients are needed, got {z.shape}"
        )
    detail = basis.detail(level)
    shape = _member(basis, detail, template.parent[1:], z)
    if not np.all(shape.radius > 0):
        raise InputError(
            f"{basis.name}: no body has these coefficients (a radius falls to nothing)"
        )
    made = _with_shape(template, basis, detail, shape)
    mass = template.mass * _growth(template, basis, basis.detail(template.detail or level), z)
    flesh = basis.anchor_seated[basis.nearest_anchor(z)]
    return with_derived_fields(
        replace(made, mass=mass, basis_at=z[None], seated_factors=flesh[None])
    )


def _growth(template: Body, basis: ShapeBasis, detail: Detail, z: Floats) -> Floats:
    """(N,) volumes of the segments of the member at z (K,) by those of the template's own member."""
    before, after = (
        _member(basis, detail, template.parent[1:], at) for at in (template.basis_at[0], z)
    )
    held = _with_shape(template, basis, detail, before)
    return volumes(held, after) / np.maximum(volumes(held, before), 1e-12)


def _with_shape(template: Body, basis: ShapeBasis, detail: Detail, shape: Shape) -> Body:
    """The template with the spheres of a level of detail."""
    topology = replace(
        template.topology,
        start=np.searchsorted(detail.segment, np.arange(len(basis.segments) + 1)),
        sphere_names=detail.names,
        sphere_direction=detail.direction,
        blend_joint=detail.blend_joint,
    )
    return replace(
        template,
        topology=topology,
        centre=shape.centre[None],
        radius=shape.radius[None],
        twist_share=np.zeros((1, len(detail.names))),
        blend_share=detail.blend_share[None],
        joint_in_parent=shape.in_parent[None],
        joint_in_child=shape.in_child[None],
        fit_error=detail.fit_error[None],
    )


def _member(basis: ShapeBasis, detail: Detail, parent: Ints, z: Floats) -> Shape:
    """Return the spheres and joints of a family's member in the frames of their segments.

    parent: (N - 1,) the parent of each segment but the first; z: (K,) coefficients.
    """
    joint = basis.joint_mean + np.tensordot(z, basis.joint_basis, axes=1)
    origin = basis.origin_mean + np.tensordot(z, basis.origin_basis, axes=1)
    centre = detail.centre_mean + np.tensordot(z, detail.centre_basis, axes=1)
    gap = np.linalg.norm(detail.centre_mean[:, None] - basis.joint_mean[None], axis=-1)
    near = (detail.segment[:, None] == parent[None]) | (
        detail.segment[:, None] == np.arange(1, len(origin))[None]
    )
    sphere, at = np.nonzero((gap < ON_JOINT) & near)
    centre[sphere] = joint[at]  # a sphere on a joint has exactly its coordinates
    return Shape(
        centre - origin[detail.segment],
        detail.radius_mean + z @ detail.radius_basis,
        joint - origin[parent],
        joint - origin[1:],
    )


_MIN_FACTOR = 0.4
_MAX_FACTOR = 2.0
"""Factors that people have. One beyond them comes from a wrong unit or name."""


def lengthened(body: Body, factors: Mapping[str, float]) -> Body:
    """Multiply the lengths of segments by factors.

    Spheres and joints move along z of the segment's frame, in which the limbs and the trunk of the
    paper's body lie. Girths stay as they are, and masses are proportional to lengths. The soles of the
    zero pose stay at their height.

    Parameters
    ----------
    body
        One body.
    factors
        Factors by segment, 0.4 to 2.

    Raises
    ------
    InputError
        If there is no such segment, or a factor is out of its range.
    """
    check_one(body)
    along = np.ones(len(body.segments))
    for segment, factor in factors.items():
        if not _MIN_FACTOR <= factor <= _MAX_FACTOR:
            raise InputError(
                f"segment {segment} of {body.name} would be {factor:.2f} times as long; {_MIN_FACTOR:g} to "
                f"{_MAX_FACTOR:g} are possible: is the unit right?"
            )
        along[body.segment(segment)] = factor
    size = np.stack([np.ones_like(along), np.ones_like(along), along], axis=1)
    parent = body.parent[1:]
    in_parent = body.joint_in_parent * size[parent]
    made = replace(
        body,
        topology=replace(body.topology, basis=None),
        centre=body.centre * size[body.sphere_segment],
        joint_in_parent=in_parent,
        joint_in_child=body.joint_in_child * size[1:],
        mass=body.mass * along,
        basis_at=np.zeros((1, 0)),
    )
    standing = in_parent.copy()
    standing[0, parent == 0, 2] += _lowest(body) - _lowest(made)
    return with_derived_fields(replace(made, joint_in_parent=standing))


def _lowest(body: Body) -> float:
    """Height [m] of the lowest surface in the zero pose."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z - body.radius[0]).min())
