"""Spherical polygons: how far a direction is from the boundary of the directions that are
allowed."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Bools, Floats

__all__ = ["nearest_on_polygon"]


def nearest_on_polygon(direction: Floats, polygon: Floats, centre: Floats) -> tuple[Floats, Floats]:
    """Nearest boundary point of a spherical polygon that is star-shaped about `centre`.

    direction (P, 3), polygon (V, 3) counter-clockwise about centre, centre (3,): unit vectors.
    Edges are great circles. Returns the point (P, 3) and the signed angle (P,) [rad], positive
    inside.
    """
    following = np.roll(polygon, -1, axis=0)
    normal = np.cross(polygon, following)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = direction @ normal.T
    foot = direction[:, None, :] - height[..., None] * normal
    foot /= np.maximum(np.linalg.norm(foot, axis=-1, keepdims=True), 1e-300)
    within = (np.sum(np.cross(polygon, foot) * normal, axis=-1) >= 0) & (
        np.sum(np.cross(foot, following) * normal, axis=-1) >= 0
    )
    to_corner = np.sum(direction[:, None, :] * polygon, axis=-1)
    cosine = np.where(within, np.sum(direction[:, None, :] * foot, axis=-1), to_corner)
    nearest = np.argmax(cosine, axis=1)
    rows = np.arange(len(direction))
    point = np.where(within[rows, nearest, None], foot[rows, nearest], polygon[nearest])
    angle = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(direction - point, axis=1), 0.0, 1.0))
    return point, np.where(_inside(direction, polygon, (normal, centre)), angle, -angle)


def _inside(direction: Floats, polygon: Floats, frame: tuple[Floats, Floats]) -> Bools:
    """In the wedge between the centre and an edge, a direction is inside on the centre's side of
    the edge."""
    normal, centre = frame
    to = np.cross(centre, polygon)
    left = direction @ to.T >= 0
    right = direction @ np.roll(to, -1, axis=0).T < 0
    wedge = np.argmax(left & right, axis=1)
    inside: Bools = np.sum(direction * normal[wedge], axis=1) >= 0
    return inside
