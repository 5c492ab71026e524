"""Cameras: where the viewer stands, and the one place where points become pixels.

A camera is parallel where its `distance` is infinite and perspective where it is not; the formulae
are the same, and the parallel view is the limit of the perspective one. View coordinates
(`in_view`) are metres to the right, up and toward the viewer from the camera's centre; the last one
is the depth, larger is nearer. A point at depth z is drawn 1 / (1 - z / distance) times as large as
one at depth 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.draw.kernels.projection import pixel_points, view_points
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats, frozen

__all__ = [
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
    "to_view",
    "view_to_pixels",
]

# name -> (from the scene to the viewer, the picture's up); x forward, y left, z up
_TOWARD_UP: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "front": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "back": ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "left": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "right": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "top": ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    "bottom": ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
    "three_quarter": ((0.78, 0.66, 0.46), (0.0, 0.0, 1.0)),
}
VIEWS: tuple[str, ...] = tuple(_TOWARD_UP)
# of the distance: what is so near the eye would be drawn a thousand times as large as at the centre
_CLOSEST = 1e-3
_LEAST = 1e-3  # [m] a single point still gets a picture


@dataclass(frozen=True, eq=False)
class Camera:
    """`centre` (3,) [m] falls on the middle of a picture of width x height pixels.

    right, up, toward (3,): unit vectors to the picture's right, its top, and from the scene to the
    viewer; a right-handed frame. scale: pixels a metre at the centre's depth. distance [m]: from
    the centre to the eye; infinite: a parallel view. cut [m]: a depth; what is nearer than this
    plane across the view is cut away. opened [m]: a depth; an environment is opened at the foremost
    body, but no farther back than there, so that the pictures of a film are opened alike.
    """

    name: str
    right: Floats
    up: Floats
    toward: Floats
    centre: Floats
    scale: float
    width: int
    height: int
    distance: float = math.inf
    cut: float = math.inf
    opened: float = -math.inf

    def __post_init__(self) -> None:
        for field in ("right", "up", "toward", "centre"):
            object.__setattr__(
                self, field, frozen(getattr(self, field), np.float64, (3,), f"camera.{field}")
            )
        axes = np.array([self.right, self.up, self.toward])
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) or np.linalg.det(axes) < 0:
            raise UsageError(
                f"camera {self.name}: right, up and toward must be a right-handed frame of unit vectors"
            )
        if self.width < 1 or self.height < 1:
            raise UsageError(
                f"camera {self.name}: a picture of {self.width} x {self.height} pixels; at least 1 x 1"
            )
        if not (np.isfinite(self.scale) and self.scale > 0 and np.all(np.isfinite(self.centre))):
            raise UsageError(f"camera {self.name}: scale must be positive and the centre finite")
        if not self.distance > 0 or math.isnan(self.cut):
            raise UsageError(
                f"camera {self.name}: the distance of the eye must be positive, got {self.distance}"
            )

    @property
    def bend(self) -> float:
        """1 / distance [1/m]; 0 for a parallel view."""
        return 1.0 / self.distance

    @property
    def closest(self) -> float:
        """The depth [m] of what is a thousandth of the distance from the eye: nothing nearer has
        pixels."""
        return self.distance * (1.0 - _CLOSEST)

    @property
    def nearest(self) -> float:
        """The depth [m] of the nearest thing that is drawn."""
        return min(self.cut, self.closest)

    def enlarged(self, factor: int) -> Camera:
        """The same view on a picture of `factor` times as many pixels each way."""
        return replace(
            self, scale=self.scale * factor, width=self.width * factor, height=self.height * factor
        )


def _frame(toward: Floats, up: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Right, up, toward: unit vectors; where `up` is along the view, x forward is up."""
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
    """One of VIEWS, fitted so that the box `bounds` (2, 3) [m] fills the picture up to `margin` on
    each side.

    field [rad]: the angle of view from the bottom of the picture to its top; 0: a parallel view.
    front: the viewer stands at +x; the body's left is on the picture's right. back: from -x. left:
    from +y; forward is to the picture's left. right: from -y; forward is to the right. top: from
    +z; forward is up, the body's left on the left. bottom: from -z; forward is up, the body's left
    on the right. three_quarter: from the front left and above.
    """
    if name not in _TOWARD_UP:
        raise UsageError(f"no view {name!r}; {one_of(name, VIEWS)}")
    box = np.asarray(bounds, dtype=np.float64)
    if box.shape != (2, 3) or not np.all(np.isfinite(box)) or np.any(box[0] > box[1]):
        raise UsageError(
            f"view {name}: bounds must be the least and greatest corner, finite, got {box.tolist()}"
        )
    toward, up = (np.array(way) for way in _TOWARD_UP[name])
    middle = box.mean(axis=0)
    camera = replace(
        look_at(middle + toward, middle, up=up, field=field, width=width, height=height), name=name
    )
    corners = np.array(
        [[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    )
    return fit_to_spheres(camera, corners, np.zeros(8), margin=margin)


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
    """A camera at `eye` (3,) [m] with `target` (3,) [m] in the middle of its picture and `up` (3,)
    upright in it.

    field [rad]: the angle of view from bottom to top, below pi; 0 gives a parallel view that shows
    as many metres from bottom to top as eye and target are apart. cut: see Camera. UsageError where
    eye and target are one point.
    """
    there = np.asarray(eye, dtype=np.float64)
    middle = np.asarray(target, dtype=np.float64)
    away = there - middle
    apart = float(np.linalg.norm(away)) if away.shape == (3,) else math.nan
    if not (math.isfinite(apart) and apart > 1e-9):
        raise UsageError(
            f"camera: eye and target must be two finite points, got {there.tolist()}, {middle.tolist()}"
        )
    if not 0.0 <= field < 3.1:
        raise UsageError(
            f"camera: the angle of view must be from 0 to 177 degrees, got {math.degrees(field):g}"
        )
    half = math.tan(field / 2.0) if field else 0.5
    distance = apart if field else math.inf
    return Camera(
        "look_at",
        *_frame(away, up),
        middle,
        height / (2.0 * half * apart),
        width,
        height,
        distance,
        cut,
    )


def fit_to_spheres(
    camera: Camera, centre: ArrayLike, radius: ArrayLike, *, margin: float = 0.06
) -> Camera:
    """The camera moved, not turned, so that spheres `centre` (S, 3), `radius` (S,) [m] just fill
    its picture.

    `margin` is left free on each side, as a share of the picture. In perspective the angle of view
    stays and the eye moves: each side of the picture is a plane through the eye that all spheres
    must be behind, so that left and right give the eye's place and depth from two linear equations,
    and so do bottom and top; the farther one holds. Depth 0 becomes the middle of the spheres'.
    UsageError without spheres.
    """
    seen = to_view(camera, centre)
    reach = np.asarray(radius, dtype=np.float64)
    if not len(reach) or not np.all(np.isfinite(seen)):
        raise UsageError(f"camera {camera.name}: finite spheres are needed to fit the view to")
    low = (seen - reach[:, None]).min(axis=0)
    high = (seen + reach[:, None]).max(axis=0)
    middle = (low + high) / 2.0
    size = np.array([camera.width, camera.height]) * (1.0 - 2.0 * margin)
    if math.isinf(camera.distance):
        scale = float(np.min(size / np.maximum(high[:2] - low[:2], _LEAST)))
        return replace(camera, centre=_moved(camera, middle), scale=scale)
    slope = size / (2.0 * camera.scale * camera.distance)  # of each side against the line of sight
    steep = np.sqrt(1.0 + slope * slope)
    least = (seen[:, :2] - slope * seen[:, 2:] - steep * reach[:, None]).min(axis=0)
    most = (seen[:, :2] + slope * seen[:, 2:] + steep * reach[:, None]).max(axis=0)
    depth = max(float(np.max((most - least) / (2.0 * slope))), high[2] + _LEAST)  # of the eye
    distance = depth - float(middle[2])
    across = (least + most) / 2.0
    scale = camera.scale * camera.distance / distance
    return replace(
        camera, centre=_moved(camera, np.append(across, middle[2])), scale=scale, distance=distance
    )


def _moved(camera: Camera, seen: Floats) -> Floats:
    """The point (3,) [m] at view coordinates `seen` (3,)."""
    point: Floats = camera.centre + seen @ np.array([camera.right, camera.up, camera.toward])
    return point


def orbit(camera: Camera, angle: float, *, axis: ArrayLike = (0.0, 0.0, 1.0)) -> Camera:
    """The camera carried round its centre by `angle` [rad] about `axis` (3,), anticlockwise seen
    from its tip.

    A whole turn gives the very same camera.
    """
    along = np.asarray(axis, dtype=np.float64)
    along = along / np.linalg.norm(along)
    cross = np.cross(np.eye(3), along)  # cross @ v = along x v
    share = angle % math.tau
    turn = np.eye(3) + math.sin(share) * cross + (1.0 - math.cos(share)) * (cross @ cross)
    right, up, toward = (turn @ way for way in (camera.right, camera.up, camera.toward))
    return replace(camera, right=right, up=up, toward=toward)


def to_view(camera: Camera, points: ArrayLike) -> Floats:
    """View coordinates (..., 3) [m] to the right, up and toward the viewer of points (..., 3)
    [m]."""
    given = np.asarray(points, dtype=np.float64)
    axes = np.array([camera.right, camera.up, camera.toward])
    seen: Floats = view_points(np.ascontiguousarray(given).reshape(-1, 3), axes, camera.centre)
    return seen.reshape(given.shape)


def view_to_pixels(camera: Camera, seen: Floats) -> Floats:
    """Pixels x (right) and y (down) and depth [m] of view coordinates (..., 3) [m].

    x and y are NaN for points nearer than `camera.closest`: cut lines and surfaces there first (see
    clipping).
    """
    nearest = camera.distance * (1.0 - _CLOSEST / 2.0)  # clipped ends are rounded
    middle = np.array([camera.width / 2.0, camera.height / 2.0])
    flat = np.ascontiguousarray(seen).reshape(-1, 3)
    shown: Floats = pixel_points(flat, float(camera.scale), camera.bend, nearest, middle)
    return shown.reshape(seen.shape)


def project(camera: Camera, points: ArrayLike) -> Floats:
    """Pixels x (right) and y (down) and depth [m] (larger is nearer the viewer) of points (..., 3)
    [m].

    Pixel (column, row) covers [column, column + 1) x [row, row + 1); the camera's centre has depth
    0. x and y are NaN for points nearer than `camera.closest`.
    """
    return view_to_pixels(camera, to_view(camera, points))


def projective_depth(camera: Camera, depth: Floats) -> Floats:
    """The measure of `depth` (...,) [m] that changes linearly along straight lines in the picture:
    z / (1 - z / D).

    Larger is nearer; in a parallel view it is the depth. Planes are planes in pixels and projective
    depth.
    """
    return np.asarray(depth, dtype=np.float64) / (1.0 - np.asarray(depth) * camera.bend)


def metric_depth(camera: Camera, depth: Floats) -> Floats:
    """Depth [m] of a projective depth (...,); the inverse of `projective`. -inf stays -inf."""
    given = np.asarray(depth, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        return np.where(np.isneginf(given), given, given / (1.0 + given * camera.bend))


def facing(camera: Camera, normal: Floats, offset: Floats) -> Floats:
    """(...,) positive where planes normal . x = offset, (..., 3) and (...,), show the viewer their
    front."""
    front: Floats = normal @ camera.toward + camera.bend * (normal @ camera.centre - offset)
    return front
