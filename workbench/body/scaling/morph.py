"""Compute members of a family of bodies, at any level of detail, on the skeleton of a known member."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.scaling.rig import Shape
from workbench.body.scaling.space import ON_JOINT, volumes
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import Detail, ShapeBasis
from workbench.model.body import Body, check_one
from workbench.model.settled import settled

__all__ = ["morph"]


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
    return settled(replace(made, mass=mass, basis_at=z[None], seated_factors=flesh[None]))


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
