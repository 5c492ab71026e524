"""Compute mass properties of a sphere body: segment masses, inertia tensors, and joint loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.poses import Placed

__all__ = [
    "CompositeBody",
    "composite_bodies",
    "root_segment",
    "segment_inertia",
    "segment_masses",
]

_CELLS = 22
"""Grid cells along the longest side of a segment, for the volume integral of its inertia."""
_MIN_MASS_SHARE = 1e-4
"""Least mass of a segment, as a share of the body's. A massless rigid body has no dynamics."""
_BARE_INERTIA = 1e-4
"""Inertia [kg m2] per kg of a segment without spheres, about that of a ball of radius 16 mm."""


@dataclass(frozen=True, eq=False)
class CompositeBody:
    """The rigid body that each of J joints carries in one pose: all segments beyond the joint."""

    mass: Floats
    """(J,) [kg]."""
    lever: Floats
    """(J,) distance [m] of the centre of gravity from the joint."""
    inertia: Floats
    """(J,) [kg m2] about the joint, the mean of the three principal moments."""


def root_segment(body: Body) -> int:
    """Return the index of the first segment that has mass, spheres, or several children.

    Segments before it are a reference frame only, such as a stage.
    """
    segment = 0
    while body.mass[0, segment] == 0 and body.start[segment] == body.start[segment + 1]:
        children = np.flatnonzero(body.parent == segment)
        if len(children) != 1:
            break
        segment = int(children[0])
    return segment


def segment_masses(body: Body) -> Floats:
    """Return the masses of a body's segments, none of them zero.

    Returns
    -------
    Floats
        (N,) [kg]. A segment without mass gets a ten-thousandth of the body's mass.

    Raises
    ------
    InputError
        If the body has no mass.
    """
    total = float(body.mass[0].sum())
    if not total > 0:
        raise InputError(f"body {body.name} has no mass, so it cannot be simulated")
    mass: Floats = np.maximum(body.mass[0], _MIN_MASS_SHARE * total)
    return mass


def segment_inertia(body: Body, mass: Floats) -> Floats:
    """Compute the inertia tensors of a body's segments about their centres of gravity.

    A segment is the union of its spheres, with an even density. The volume integral is a sum over
    the cells of a grid. The centre of gravity is the one of the body file, so the mean of the cells
    is subtracted.

    Parameters
    ----------
    mass
        (N,) masses of the segments [kg].

    Returns
    -------
    Floats
        (N, 3, 3) [kg m2] in the segments' frames.
    """
    inertia = np.zeros((len(mass), 3, 3))
    for segment in range(len(mass)):
        spheres = body.spheres(segment)
        if spheres.start == spheres.stop:
            inertia[segment] = _BARE_INERTIA * mass[segment] * np.eye(3)
            continue
        covariance = _covariance(body.centre[0, spheres], body.radius[0, spheres])
        # I = m (tr(C) 1 - C), C being the covariance of the mass distribution
        inertia[segment] = mass[segment] * (np.trace(covariance) * np.eye(3) - covariance)
    return inertia


def _covariance(centre: Floats, radius: Floats) -> Floats:
    """(3, 3) [m2] covariance of the points in a union of spheres, centres (C, 3), radii (C,)."""
    low = (centre - radius[:, None]).min(axis=0)
    high = (centre + radius[:, None]).max(axis=0)
    cell = float((high - low).max()) / _CELLS
    axes = [np.arange(a + cell / 2, b, cell) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    filled = _inside(grid, centre, radius)
    points = grid[filled] if filled.any() else centre
    points = points - points.mean(axis=0)
    # each cell adds its own variance, cell^2 / 12 along each axis
    return np.asarray(
        np.einsum("gi,gj->ij", points, points) / len(points) + cell * cell / 12.0 * np.eye(3)
    )


def _inside(points: Floats, centre: Floats, radius: Floats) -> Bools:
    """(G,) True for points (G, 3) in any of the spheres."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for c, r in zip(centre, radius, strict=True):
        inside |= np.sum((points - c) ** 2, axis=1) <= r * r
    return inside


def composite_bodies(placed: Placed, mass: Floats, inertia: Floats) -> CompositeBody:
    """Compute what every joint carries in the first pose.

    Parameters
    ----------
    mass, inertia
        (N,) [kg] and (N, 3, 3) [kg m2] of the segments, see `segment_inertia`.

    Returns
    -------
    CompositeBody
        Mass, lever and inertia (J,) of the segments beyond each joint.
    """
    body = placed.body
    joints = len(body.joints)
    rows = np.empty((joints, 3))
    for joint in range(joints):
        beyond = [n for n in range(joint + 1, len(mass)) if _descends(body, n, joint + 1)]
        rows[joint] = _composite(placed, joint, mass[beyond], inertia[beyond], beyond)
    return CompositeBody(rows[:, 0], rows[:, 1], rows[:, 2])


def _composite(
    placed: Placed, joint: int, mass: Floats, inertia: Floats, segments: list[int]
) -> tuple[float, float, float]:
    """Mass [kg], lever [m] and mean inertia [kg m2] about a joint of the segments beyond it."""
    body = placed.body
    world = placed.world_from_segment[0]
    child = world[joint + 1]
    centre = child[:, :3] @ body.joint_in_child[0, joint] + child[:, 3]
    arm = world[segments, :, 3] - centre
    rotation = world[segments, :, :3]
    # parallel axes (Steiner): I = R I0 R^T + m (|a|^2 1 - a a^T)
    own = np.einsum("nij,njk,nlk->nil", rotation, inertia, rotation)
    about = own + mass[:, None, None] * (
        np.sum(arm**2, axis=1)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None, :]
    )
    total = float(mass.sum())
    lever = float(np.linalg.norm(mass @ arm)) / total
    return total, lever, float(np.trace(about.sum(axis=0))) / 3.0


def _descends(body: Body, segment: int, ancestor: int) -> bool:
    """True where a segment is the ancestor or lies beyond it; parents precede their children."""
    while segment > ancestor:
        segment = int(body.parent[segment])
    return segment == ancestor
