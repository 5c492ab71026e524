"""Cameras: where the viewer stands, and the one place where points become pixels.

Only parallel (orthographic) cameras exist today. A perspective camera changes `project` and `pixels_per_metre`,
the two functions through which every display goes, and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats, frozen

__all__ = ["VIEWS", "Camera", "pixels_per_metre", "project", "standard_view"]

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


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel camera. `centre` (3,) [m] falls on the middle of a picture of width x height pixels.

    right, up, toward (3,): unit vectors to the picture's right, its top, and from the scene to the viewer; a
    right-handed frame. scale: pixels a metre.
    """

    name: str
    right: Floats
    up: Floats
    toward: Floats
    centre: Floats
    scale: float
    width: int
    height: int

    def __post_init__(self) -> None:
        for field in ("right", "up", "toward", "centre"):
            object.__setattr__(self, field, frozen(getattr(self, field), np.float64, (3,), f"camera.{field}"))
        axes = np.array([self.right, self.up, self.toward])
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) or np.linalg.det(axes) < 0:
            raise UsageError(f"camera {self.name}: right, up and toward must be a right-handed frame of unit vectors")
        if self.width < 1 or self.height < 1:
            raise UsageError(f"camera {self.name}: a picture of {self.width} x {self.height} pixels; at least 1 x 1")
        if not (np.isfinite(self.scale) and self.scale > 0 and np.all(np.isfinite(self.centre))):
            raise UsageError(f"camera {self.name}: scale must be positive and the centre finite")

    def enlarged(self, factor: int) -> Camera:
        """The same view on a picture of `factor` times as many pixels each way."""
        return replace(self, scale=self.scale * factor, width=self.width * factor, height=self.height * factor)


def standard_view(name: str, bounds: ArrayLike, *, width: int = 640, height: int = 640, margin: float = 0.06) -> Camera:
    """One of VIEWS, fitted so that the box `bounds` (2, 3) [m] fills the picture up to `margin` on each side.

    front: the viewer stands at +x; the body's left is on the picture's right. back: from -x. left: from +y; forward
    is to the picture's left. right: from -y; forward is to the right. top: from +z; forward is up, the body's left
    on the left. bottom: from -z; forward is up, the body's left on the right. three_quarter: from the front left
    and above.
    """
    if name not in _TOWARD_UP:
        raise UsageError(f"no view {name!r}; {one_of(name, VIEWS)}")
    box = np.asarray(bounds, dtype=np.float64)
    if box.shape != (2, 3) or not np.all(np.isfinite(box)) or np.any(box[0] > box[1]):
        raise UsageError(f"view {name}: bounds must be the least and greatest corner, finite, got {box.tolist()}")
    toward = np.array(_TOWARD_UP[name][0])
    toward /= np.linalg.norm(toward)
    right = np.cross(_TOWARD_UP[name][1], toward)
    right /= np.linalg.norm(right)
    up = np.cross(toward, right)
    half = (box[1] - box[0]) / 2.0
    across, high = 2.0 * np.abs(right) @ half, 2.0 * np.abs(up) @ half  # extents of the box as seen from here
    least = 1e-3  # [m] a single point still gets a picture
    scale = (1.0 - 2.0 * margin) * min(width / max(across, least), height / max(high, least))
    return Camera(name, right, up, toward, box.mean(axis=0), float(scale), width, height)


def project(camera: Camera, points: ArrayLike) -> Floats:
    """Pixels x (right) and y (down) and depth [m] (larger is nearer the viewer) of points (..., 3) [m].

    Pixel (column, row) covers [column, column + 1) x [row, row + 1); the camera's centre has depth 0.
    """
    away = np.asarray(points, dtype=np.float64) - camera.centre
    x = camera.width / 2.0 + camera.scale * (away @ camera.right)
    y = camera.height / 2.0 - camera.scale * (away @ camera.up)
    return np.stack([x, y, away @ camera.toward], axis=-1)


def pixels_per_metre(camera: Camera, depth: Floats) -> Floats:
    """Scale of what lies across the view at `depth` (...,) [m]: with a parallel camera the same everywhere."""
    return np.full(np.shape(depth), camera.scale)
