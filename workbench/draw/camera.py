"""Place cameras, and project points of the world into pixels.

This is the only module that converts between the world, view coordinates and pixels.

View coordinates (`to_view`) are metres to the right, up and toward the viewer, from the camera's
centre. The last one is the depth z: larger is nearer. A camera at `distance` D sees a point at
depth z enlarged by 1 / (1 - z / D) against a point at depth 0. D = infinity gives the parallel
projection as the limit of the same formulae.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats, read_only

__all__ = [
    "TO_VIEWER",
    "VIEWS",
    "Camera",
    "facing",
    "fit_to_spheres",
    "look_at",
    "metric_depth",
    "orbit",
    "project",
    "projective_depth",
    "standard_view",
    "to_projective",
    "to_view",
    "view_to_pixels",
]

# name -> (from the scene to the viewer, up in the picture); x forward, y left, z up
_VIEW_AXES: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "front": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "back": ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "left": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "right": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "top": ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    "bottom": ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
    "corner": ((0.78, 0.66, 0.46), (0.0, 0.0, 1.0)),
}
TO_VIEWER = np.array([0.0, 0.0, 1.0])
"""Direction to the viewer in view coordinates."""
VIEWS: tuple[str, ...] = tuple(_VIEW_AXES)
"""Names of the standard views, see `standard_view`."""
_MIN_EYE_DISTANCE = 1e-3
"""Smallest distance from the eye that is drawn, as a share of the camera's distance. A point there
appears a thousand times as large as at the centre."""
_MIN_EXTENT = 1e-3
"""Smallest extent [m] that a view is fitted to, so that a single point still gets a picture."""
_MAX_FIELD = 3.1
"""Largest angle of view [rad]; at pi the picture would be infinite."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel or perspective camera with a picture of `width` x `height` pixels.

    Raises `UsageError` if the axes are no right-handed orthonormal frame, or if a size, the scale
    or the distance is not positive.
    """

    name: str
    right: Floats
    """(3,) unit vector to the right in the picture."""
    up: Floats
    """(3,) unit vector up in the picture."""
    toward: Floats
    """(3,) unit vector from the scene to the viewer."""
    centre: Floats
    """(3,) point [m] that falls on the middle of the picture; its depth is 0."""
    scale: float
    """Pixels per metre at depth 0."""
    width: int
    height: int
    distance: float = math.inf
    """Distance [m] from the centre to the eye; infinite for a parallel view."""
    cut: float = math.inf
    """Depth [m] of the near plane. Whatever is nearer is cut away."""
    opened: float = -math.inf
    """Smallest depth [m] at which the environment is cut open. It is cut at the foremost body, but
    never behind this depth. All frames of a film share it, so that they are cut alike."""
    aside: tuple[float, float, float] | Floats = (0.0, 0.0, 0.0)
    """(3,) [m] from midway between two eyes to the left one, where both see the picture; else 0."""
    focus: float = math.inf
    """Distance [m] that two eyes look into."""

    def __post_init__(self) -> None:
        for field in ("right", "up", "toward", "centre", "aside"):
            vector = read_only(getattr(self, field), np.float64, (3,), f"camera.{field}")
            object.__setattr__(self, field, vector)
        for problem in (self._frame_error(), self._size_error()):
            if problem:
                raise UsageError(f"camera {self.name}: {problem}")

    def _frame_error(self) -> str:
        axes = np.array([self.right, self.up, self.toward])
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) or np.linalg.det(axes) < 0:
            return "right, up and toward must be a right-handed frame of unit vectors"
        return ""

    def _size_error(self) -> str:
        if self.width < 1 or self.height < 1:
            return f"a picture of {self.width} x {self.height} pixels; at least 1 x 1"
        if not (np.isfinite(self.scale) and self.scale > 0 and np.all(np.isfinite(self.centre))):
            return "scale must be positive and the centre finite"
        if not self.distance > 0 or math.isnan(self.cut):
            return f"the distance of the eye must be positive, got {self.distance}"
        return ""

    @property
    def inverse_distance(self) -> float:
        """1 / distance [1/m]; 0 for a parallel view."""
        return 1.0 / self.distance

    @property
    def closest(self) -> float:
        """Largest depth [m] that has pixels: a thousandth of the distance in front of the eye."""
        return self.distance * (1.0 - _MIN_EYE_DISTANCE)

    @property
    def nearest(self) -> float:
        """Largest depth [m] that is drawn: the near plane, or `closest` if that is farther."""
        return min(self.cut, self.closest)

    def enlarged(self, factor: int) -> Camera:
        """Return the same view on a picture of `factor` times as many pixels each way."""
        return replace(
            self, scale=self.scale * factor, width=self.width * factor, height=self.height * factor
        )


def _orthonormal_frame(toward: Floats, up: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Return right, up and toward as unit vectors. If `up` is along the view, x is up."""
    toward = toward / np.linalg.norm(toward)
    right = np.cross(np.asarray(up, dtype=np.float64), toward)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross([1.0, 0.0, 0.0], toward)
    right /= np.linalg.norm(right)
    return right, np.cross(toward, right), toward


def standard_view(
    name: str,
    bounds: ArrayLike,
    *,
    width: int = 640,
    height: int = 640,
    margin: float = 0.06,
    field: float = 0.0,
) -> Camera:
    """Return a standard view, fitted to a box.

    ===============  ======================  ===============================================
    name             the viewer stands       in the picture
    ===============  ======================  ===============================================
    front            at +x                   the body's left is on the right
    back             at -x                   the body's left is on the left
    left             at +y                   forward is to the left
    right            at -y                   forward is to the right
    top              at +z                   forward is up, the body's left is on the left
    bottom           at -z                   forward is up, the body's left is on the right
    corner           front left and above    all three sides show
    ===============  ======================  ===============================================

    Parameters
    ----------
    name
        One of `VIEWS`.
    bounds
        (2, 3) least and greatest corner [m] of the box.
    width, height
        Size of the picture [pixels].
    margin
        Free border on each side, as a share of the picture.
    field
        Angle of view [rad] from bottom to top; 0 for a parallel view.

    Raises
    ------
    UsageError
        If there is no such view, or the box is empty or not finite.
    """
    if name not in _VIEW_AXES:
        raise UsageError(f"no view {name!r}; {one_of(name, VIEWS)}")
    box = np.asarray(bounds, dtype=np.float64)
    if box.shape != (2, 3) or not np.all(np.isfinite(box)) or np.any(box[0] > box[1]):
        raise UsageError(
            f"view {name}: bounds must be the least and greatest corner, finite, got {box.tolist()}"
        )
    toward, up = (np.array(axis) for axis in _VIEW_AXES[name])
    middle = box.mean(axis=0)
    camera = look_at(middle + toward, middle, up=up, field=field, width=width, height=height)
    corners = np.array(list(itertools.product(*box.T)))
    return fit_to_spheres(replace(camera, name=name), corners, np.zeros(8), margin=margin)


def look_at(
    eye: ArrayLike,
    target: ArrayLike,
    *,
    up: ArrayLike = (0.0, 0.0, 1.0),
    field: float = math.radians(40.0),
    width: int = 640,
    height: int = 640,
    cut: float = math.inf,
) -> Camera:
    """Return a camera at a point that looks at another point.

    Parameters
    ----------
    eye
        (3,) position of the eye [m].
    target
        (3,) point [m] in the middle of the picture.
    up
        (3,) direction that is upright in the picture.
    field
        Angle of view [rad] from bottom to top. 0 gives a parallel view that shows as many metres
        from bottom to top as eye and target are apart.
    width, height
        Size of the picture [pixels].
    cut
        Depth [m] of the near plane, see `Camera`.

    Raises
    ------
    UsageError
        If eye and target coincide or are not finite, or the angle of view is out of range.
    """
    position = np.asarray(eye, dtype=np.float64)
    middle = np.asarray(target, dtype=np.float64)
    toward = position - middle
    length = float(np.linalg.norm(toward)) if toward.shape == (3,) else math.nan
    if not (math.isfinite(length) and length > 1e-9):
        raise UsageError(
            "camera: eye and target must be two finite points, "
            f"got {position.tolist()}, {middle.tolist()}"
        )
    if not 0.0 <= field < _MAX_FIELD:
        raise UsageError(
            f"camera: the angle of view must be from 0 to 177 degrees, got {math.degrees(field):g}"
        )
    half_height = math.tan(field / 2.0) if field else 0.5  # as a share of the distance
    scale = height / (2.0 * half_height * length)
    distance = length if field else math.inf
    frame = _orthonormal_frame(toward, up)
    return Camera("look_at", *frame, middle, scale, width, height, distance, cut)


def fit_to_spheres(
    camera: Camera, centre: ArrayLike, radius: ArrayLike, *, margin: float = 0.06
) -> Camera:
    """Move a camera, without turning it, so that spheres just fill its picture.

    A parallel view changes its scale. A perspective view keeps its angle of view and moves its eye.
    Depth 0 becomes the middle of the spheres' depths.

    Parameters
    ----------
    camera
        The camera to move.
    centre, radius
        (S, 3) and (S,) the spheres [m].
    margin
        Free border on each side, as a share of the picture.

    Raises
    ------
    UsageError
        If there is no sphere, or one is not finite.
    """
    seen = to_view(camera, centre)
    radii = np.asarray(radius, dtype=np.float64)
    if not len(radii) or not np.all(np.isfinite(seen)):
        raise UsageError(f"camera {camera.name}: finite spheres are needed to fit the view to")
    free_size = np.array([camera.width, camera.height]) * (1.0 - 2.0 * margin)
    fit = _fit_parallel if math.isinf(camera.distance) else _fit_perspective
    return fit(camera, seen, radii, free_size)


def _depth_bounds(seen: Floats, radii: Floats) -> tuple[Floats, Floats]:
    """Return the least and greatest view coordinates (3,) of spheres."""
    return (seen - radii[:, None]).min(axis=0), (seen + radii[:, None]).max(axis=0)


def _fit_parallel(camera: Camera, seen: Floats, radii: Floats, free_size: Floats) -> Camera:
    low, high = _depth_bounds(seen, radii)
    scale = float(np.min(free_size / np.maximum(high[:2] - low[:2], _MIN_EXTENT)))
    return replace(camera, centre=_view_to_world(camera, (low + high) / 2.0), scale=scale)


def _fit_perspective(camera: Camera, seen: Floats, radii: Floats, free_size: Floats) -> Camera:
    # Each side of the picture is a plane through the eye (x, z): |x_i - x| <= t (z - z_i) - n r_i
    # with slope t and n = sqrt(1 + t^2). The tightest left and right planes are two linear
    # equations in x and z; bottom and top give two more. The farther of the two eyes holds.
    low, high = _depth_bounds(seen, radii)
    slope = free_size / (2.0 * camera.scale * camera.distance)
    normal_length = np.sqrt(1.0 + slope * slope)
    least = (seen[:, :2] - slope * seen[:, 2:] - normal_length * radii[:, None]).min(axis=0)
    most = (seen[:, :2] + slope * seen[:, 2:] + normal_length * radii[:, None]).max(axis=0)
    eye_depth = max(float(np.max((most - least) / (2.0 * slope))), high[2] + _MIN_EXTENT)
    middle = np.append((least + most) / 2.0, ((low + high) / 2.0)[2])
    distance = eye_depth - float(middle[2])
    return replace(
        camera,
        centre=_view_to_world(camera, middle),
        scale=camera.scale * camera.distance / distance,
        distance=distance,
    )


def _view_to_world(camera: Camera, seen: Floats) -> Floats:
    """Return the point (3,) [m] of the world at view coordinates (3,)."""
    return camera.centre + seen @ np.array([camera.right, camera.up, camera.toward])


def orbit(camera: Camera, angle: float, *, axis: ArrayLike = (0.0, 0.0, 1.0)) -> Camera:
    """Turn a camera round its centre.

    Parameters
    ----------
    camera
        The camera to turn.
    angle
        Angle [rad], anticlockwise as seen from the tip of the axis. A whole turn gives exactly the
        same camera.
    axis
        (3,) direction of the axis of rotation.
    """
    unit = np.asarray(axis, dtype=np.float64)
    unit = unit / np.linalg.norm(unit)
    cross = np.cross(np.eye(3), unit)  # cross @ v = unit x v
    rest = angle % math.tau
    # Rodrigues' formula: R = I + sin(a) K + (1 - cos(a)) K^2
    rotation = np.eye(3) + math.sin(rest) * cross + (1.0 - math.cos(rest)) * (cross @ cross)
    right, up, toward = (rotation @ vector for vector in (camera.right, camera.up, camera.toward))
    return replace(camera, right=right, up=up, toward=toward)


def to_view(camera: Camera, points: ArrayLike) -> Floats:
    """Return the view coordinates (..., 3) [m] of points (..., 3) [m] of the world."""
    given = np.asarray(points, dtype=np.float64)
    x, y, z = (given[..., k] - camera.centre[k] for k in range(3))
    axes = (camera.right, camera.up, camera.toward)
    return np.stack([x * axis[0] + y * axis[1] + z * axis[2] for axis in axes], axis=-1)


def view_to_pixels(camera: Camera, seen: Floats) -> Floats:
    """Project view coordinates (..., 3) [m].

    Returns
    -------
    Floats
        (..., 3) x (right) and y (down) [pixels], and depth [m]. x and y are NaN for points nearer
        than `camera.closest`; lines and surfaces are clipped there first (see `clipping`).
    """
    nearest = camera.distance * (1.0 - _MIN_EYE_DISTANCE / 2.0)  # clipped ends are rounded
    depth = seen[..., 2]
    inside = np.where(depth <= nearest, depth, np.nan)
    size = float(camera.scale) / (1.0 - inside * camera.inverse_distance)
    x = camera.width / 2.0 + size * seen[..., 0]
    y = camera.height / 2.0 - size * seen[..., 1]
    return np.stack([x, y, depth], axis=-1)


def to_projective(camera: Camera, seen: Floats) -> Floats:
    """Return x, y [pixels] and projective depth (..., 3) of view coordinates (..., 3)."""
    points = view_to_pixels(camera, seen)
    points[..., 2] = projective_depth(camera, points[..., 2])
    return points


def project(camera: Camera, points: ArrayLike) -> Floats:
    """Project points (..., 3) [m] of the world into the picture.

    Returns
    -------
    Floats
        (..., 3) x (right) and y (down) [pixels], and depth [m]. Pixel (column, row) covers
        [column, column + 1) x [row, row + 1). x and y are NaN for points nearer than
        `camera.closest`.
    """
    return view_to_pixels(camera, to_view(camera, points))


def projective_depth(camera: Camera, depth: Floats) -> Floats:
    """Return the projective depth z / (1 - z / D) of depths z (...,) [m].

    It changes linearly along straight lines of the picture, so a plane of the world is a plane in
    pixels and projective depth. Larger is nearer. In a parallel view it equals the depth.
    """
    return np.asarray(depth, dtype=np.float64) / (1.0 - np.asarray(depth) * camera.inverse_distance)


def metric_depth(camera: Camera, depth: Floats) -> Floats:
    """Return the depth [m] of projective depths (...,): inverse of `projective_depth`.

    -inf stays -inf.
    """
    given = np.asarray(depth, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        return np.where(np.isneginf(given), given, given / (1.0 + given * camera.inverse_distance))


def facing(camera: Camera, normal: Floats, offset: Floats) -> Floats:
    """Tell which side of planes the camera sees.

    Parameters
    ----------
    camera
        The camera.
    normal, offset
        (..., 3) and (...,) the planes normal . x = offset.

    Returns
    -------
    Floats
        (...,) positive where the viewer is on the side that the normal points to.
    """
    return normal @ camera.toward + camera.inverse_distance * (normal @ camera.centre - offset)
