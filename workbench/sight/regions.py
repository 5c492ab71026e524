"""Regions of directions, and solid angles in closed form.

Angles of a region are azimuth, positive to the left, and elevation, positive up, about three axes:
forward, left, up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.geometry.polygon import inside_loops
from workbench.model.arrays import Bools, Floats, read_only

__all__ = [
    "WHOLE",
    "Region",
    "azimuth_elevation",
    "cone",
    "direction_of",
    "outline",
    "solid_angle_of_triangles",
]


@dataclass(frozen=True, eq=False)
class Region:
    """Some of all directions.

    Parameters
    ----------
    name
        What it is called.
    axes
        (3, 3) forward, left, up as rows.
    half_angle
        [rad] of a cone about forward; pi for all directions.
    corners
        (K, 2) [rad] azimuth and elevation of the corners of an outline whose sides are straight in
        azimuth and elevation; empty for a cone. Azimuths may pass pi where the outline does.
    """

    name: str
    axes: Floats = field(default_factory=lambda: np.eye(3))
    half_angle: float = math.pi
    corners: Floats = field(default_factory=lambda: np.zeros((0, 2)))

    def __post_init__(self) -> None:
        for name, shape in (("axes", (3, 3)), ("corners", (None, 2))):
            given = read_only(getattr(self, name), np.float64, shape, f"region.{name}")
            object.__setattr__(self, name, given)
        if not np.allclose(self.axes @ self.axes.T, np.eye(3), atol=1e-6):
            raise InputError(f"region {self.name}: expected unit axes at right angles")
        if len(self.corners) in (1, 2):
            raise InputError(f"region {self.name}: expected 3 corners or more, got fewer")
        if len(self.corners) and not np.all(np.abs(self.corners[:, 1]) <= math.pi / 2 + 1e-9):
            raise InputError(f"region {self.name}: expected elevations of -90 to 90 degrees")
        if not 0.0 < self.half_angle <= math.pi:
            raise InputError(
                f"region {self.name}: expected a half angle above 0, up to 180 degrees"
            )

    def contains(self, directions: ArrayLike) -> Bools:
        """Return whether directions (..., 3) of any length are in the region (...)."""
        if not len(self.corners):
            way = np.asarray(directions, dtype=np.float64)
            if self.half_angle >= math.pi:
                return np.ones(way.shape[:-1], dtype=np.bool_)
            along = way @ self.axes[0]
            length = np.sqrt(np.einsum("...i,...i->...", way, way))  # a fifth of the time of norm
            return np.asarray(along >= math.cos(self.half_angle) * length)
        angles = azimuth_elevation(directions, self.axes)
        inside = np.zeros(angles.shape[:-1], dtype=np.bool_)
        low = self.corners.min(axis=0)
        high = self.corners.max(axis=0)
        level = (angles[..., 1] >= low[1]) & (angles[..., 1] <= high[1])
        for turn in (-2.0 * math.pi, 0.0, 2.0 * math.pi):
            azimuth = angles[..., 0] + turn
            near = level & (azimuth >= low[0]) & (azimuth <= high[0])
            inside[near] |= inside_loops(angles[near] + [turn, 0.0], [self.corners])
        return inside

    @property
    def solid_angle(self) -> float:
        """[sr], exact: of an outline the integral of sin(elevation) along its sides."""
        if not len(self.corners):
            return 2.0 * math.pi * (1.0 - math.cos(self.half_angle))
        begin = self.corners
        end = np.roll(begin, -1, axis=0)
        rise = end[:, 1] - begin[:, 1]
        level = np.abs(rise) < 1e-9
        # the mean of sin along a side, (cos b - cos e) / (e - b)
        mean = np.where(
            level,
            np.sin((begin[:, 1] + end[:, 1]) / 2.0),
            (np.cos(begin[:, 1]) - np.cos(end[:, 1])) / np.where(level, 1.0, rise),
        )
        return float(abs(np.sum((end[:, 0] - begin[:, 0]) * mean)))


WHOLE = Region("all directions")
"""All directions."""


def cone(name: str, ahead: ArrayLike, half_angle: float) -> Region:
    """Return the directions within an angle [rad] of one direction (3,)."""
    forward = np.asarray(ahead, dtype=np.float64)
    forward = forward / np.linalg.norm(forward)
    other = np.eye(3)[int(np.argmin(np.abs(forward)))]
    left = np.cross(other, forward)
    left /= np.linalg.norm(left)
    return Region(name, np.stack([forward, left, np.cross(forward, left)]), half_angle)


def outline(name: str, corners: ArrayLike, axes: ArrayLike | None = None) -> Region:
    """Return the directions inside an outline.

    Parameters
    ----------
    name
        What it is called.
    corners
        (K, 2) [rad] azimuth, positive to the left, and elevation, positive up.
    axes
        (3, 3) forward, left, up as rows; the world's if None.
    """
    given = np.eye(3) if axes is None else np.asarray(axes, dtype=np.float64)
    return Region(name, given, math.pi, np.asarray(corners, dtype=np.float64))


def azimuth_elevation(directions: ArrayLike, axes: ArrayLike | None = None) -> Floats:
    """Return the azimuth, positive to the left, and elevation (..., 2) [rad] of directions (..., 3).

    axes (3, 3): forward, left, up as rows; the world's if None.
    """
    way = np.asarray(directions, dtype=np.float64)
    if axes is not None:
        way = way @ np.asarray(axes, dtype=np.float64).T
    level = np.hypot(way[..., 0], way[..., 1])
    return np.stack([np.arctan2(way[..., 1], way[..., 0]), np.arctan2(way[..., 2], level)], axis=-1)


def direction_of(azimuth: ArrayLike, elevation: ArrayLike) -> Floats:
    """Return the unit directions (..., 3) of azimuths, positive to the left, and elevations [rad]."""
    side, above = np.broadcast_arrays(np.asarray(azimuth, float), np.asarray(elevation, float))
    level = np.cos(above)
    return np.stack([level * np.cos(side), level * np.sin(side), np.sin(above)], axis=-1)


def solid_angle_of_triangles(corners: ArrayLike, eye: ArrayLike) -> Floats:
    """Return the solid angles [sr] of triangles (..., 3, 3) [m] seen from a point (3,) [m].

    Positive where the corners run counter-clockwise as seen from the point. Those of a closed
    surface add up to 0, or to -4 pi from inside where its triangles face outward.

    References
    ----------
    van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983: tan(angle / 2) =
    a . (b x c) / (|a||b||c| + a.b |c| + b.c |a| + c.a |b|).
    """
    seen = np.asarray(corners, dtype=np.float64) - np.asarray(eye, dtype=np.float64)
    a, b, c = (seen[..., k, :] for k in range(3))
    length = np.linalg.norm(seen, axis=-1)
    volume = np.sum(a * np.cross(b, c), axis=-1)
    whole = (
        length[..., 0] * length[..., 1] * length[..., 2]
        + np.sum(a * b, axis=-1) * length[..., 2]
        + np.sum(b * c, axis=-1) * length[..., 0]
        + np.sum(c * a, axis=-1) * length[..., 1]
    )
    return np.asarray(-2.0 * np.arctan2(volume, whole))
