"""What one eye sees in every direction: item buffers on the six faces of a cube about it.

A face is a picture of a quarter turn in width and height, gnomonic: straight edges are straight, and
a plane has a depth that is linear across the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.sight.kernels.bands import FaceShapes, Items, fill_bands
from workbench.sight.kernels.projection import Triangles, project_triangles
from workbench.sight.scenery import Scenery, check_eye
from workbench.threads import run_in_threads

__all__ = [
    "BAND",
    "FACES",
    "PIECES",
    "STEP",
    "Lookout",
    "Panorama",
    "face_directions",
    "face_pixels",
    "look_out",
    "lookout",
    "panorama",
    "pixel_weights",
    "pixels_of",
    "shapes_before",
]

STEP = math.radians(0.1)
"""The usual width [rad] of a pixel."""
_FINEST = math.radians(0.02)
"""Least width [rad] of a pixel: 2 x 10^8 of them have 0.8 GB."""
BAND = 32
"""Rows that are filled at once: a band of 1,146 pixels a row has 0.6 MB, which stays in the cache."""
PIECES = 4
"""Into how many a face is cut for threads."""

_FORWARD = np.array([1.0, 0.0, 0.0])
_LEFT = np.array([0.0, 1.0, 0.0])
_UP = np.array([0.0, 0.0, 1.0])
FACES = np.stack(
    [
        np.stack([-_LEFT, _UP, _FORWARD]),
        np.stack([_FORWARD, _UP, _LEFT]),
        np.stack([_LEFT, _UP, -_FORWARD]),
        np.stack([-_FORWARD, _UP, -_LEFT]),
        np.stack([-_LEFT, -_FORWARD, _UP]),
        np.stack([-_LEFT, _FORWARD, -_UP]),
    ]
)
"""(6, 3, 3) right, up and ahead of the faces forward, left, back, right, up, down, as rows of
forward, left, up."""


@dataclass(frozen=True, eq=False)
class Panorama:
    """What one eye sees in every direction.

    Parameters
    ----------
    names
        Of the N items.
    eye
        (3,) [m].
    axes
        (3, 3) forward, left, up as rows; the faces are forward, left, back, right, up, down.
    item
        (6, n, n) the opaque item in the middle of each pixel, -1 where there is none. Rows run down,
        columns to the right.
    glass
        (6, n, n) the see-through item that is looked through first, -1 where there is none before
        what is seen.
    """

    names: tuple[str, ...]
    eye: Floats
    axes: Floats
    item: Items
    glass: Items

    @property
    def weight(self) -> Floats:
        """(n, n) [sr] the solid angle of each pixel of every face."""
        return pixel_weights(self.item.shape[1])[0]

    def look(self, directions: ArrayLike) -> Items:
        """Return the opaque items (...) in directions (..., 3), -1 for none."""
        return self.item[self.pixels(directions)]

    def look_through(self, directions: ArrayLike) -> Items:
        """Return the see-through items (...) looked through first in directions (..., 3)."""
        return self.glass[self.pixels(directions)]

    def pixels(self, directions: ArrayLike) -> tuple[Ints, Ints, Ints]:
        """Return face, row and column (...) of the pixels in directions (..., 3)."""
        way = np.asarray(directions, dtype=np.float64) @ self.axes.T
        return face_pixels(way, self.item.shape[1])


def face_pixels(way: Floats, n: int) -> tuple[Ints, Ints, Ints]:
    """Return face, row and column (...) of the pixels, n along a face, in directions (..., 3) in the
    axes of the faces."""
    ahead = np.stack([way @ face[2] for face in FACES], axis=-1)
    face = np.argmax(ahead, axis=-1)
    depth = np.take_along_axis(ahead, face[..., None], axis=-1)[..., 0]
    right = np.sum(way * FACES[face, 0], axis=-1) / depth
    above = np.sum(way * FACES[face, 1], axis=-1) / depth
    column = np.clip(((1.0 + right) * (n / 2.0)).astype(np.int64), 0, n - 1)
    row = np.clip(((1.0 - above) * (n / 2.0)).astype(np.int64), 0, n - 1)
    return face, row, column


class Lookout(NamedTuple):
    """Directions in which one eye after another looks, and the K bands of rows that hold their pixels.

    n: pixels along a face. face, first (K,): the face of each band, and its first row. pixel (...): of
    each direction, in pictures (K, BAND, n) of the bands.
    """

    n: int
    face: Ints
    first: Ints
    pixel: Ints


def lookout(ways: Floats, step: float) -> Lookout:
    """Return how to look in directions (..., 3) in pixels of at most `step` [rad]."""
    n = pixels_of(step)
    face, row, column = face_pixels(ways, n)
    bands, band = np.unique(face * n + row // BAND, return_inverse=True)
    pixel = (band.reshape(face.shape) * BAND + row % BAND) * n + column
    return Lookout(n, bands // n, bands % n * BAND, pixel)


def look_out(
    scenery: Scenery, eye: ArrayLike, view: Lookout, *, row: int = 0, through: bool = False
) -> tuple[Items, Items]:
    """Return the opaque items (...) that one eye meets in the directions of a `Lookout`, -1 for none.

    Parameters
    ----------
    scenery, eye, row
        As for `panorama`, with its errors.
    through
        Whether the see-through items that are looked through first are asked for too; these are
        (0,) where they are not.
    """
    n = view.n
    faces = np.unique(view.face)
    shapes = dict(zip(faces, shapes_before(scenery, eye, row, n, FACES[faces]), strict=True))
    item = np.empty((len(view.face), BAND, n), dtype=np.int32)
    glass = np.empty(item.shape if through else (len(item), 0, n), dtype=np.int32)

    def work(begin: int, end: int) -> None:
        for k in range(begin, end):
            first = int(view.first[k])
            last = min(first + BAND, n)
            fill_bands(shapes[view.face[k]], first, last, BAND, item[k, : last - first], glass[k])

    run_in_threads(work, len(item), -(-len(item) // PIECES))
    return item.reshape(-1)[view.pixel], glass.reshape(-1)[view.pixel if through else slice(0)]


@lru_cache(maxsize=4)
def pixel_weights(n: int) -> tuple[Floats, Floats]:
    """Return the exact solid angles (n, n) [sr] of the pixels of a face, and (n, n + 1) their sums
    to the left of each column.

    From the middle of a face to (x, y) on it, at distance 1, it is atan(x y / sqrt(1 + x^2 + y^2)).
    """
    edge = np.linspace(-1.0, 1.0, n + 1)
    x, y = np.meshgrid(edge, edge)
    corner = np.arctan(x * y / np.sqrt(1.0 + x * x + y * y))
    weights = np.diff(np.diff(corner, axis=0), axis=1)
    before = np.zeros((n, n + 1))
    np.cumsum(weights, axis=1, out=before[:, 1:])
    return weights, before


def face_directions(axes: Floats, face: int, n: int) -> Floats:
    """Return the directions (n, n, 3), not of unit length, of the middles of a face's pixels."""
    middle = (np.arange(n) + 0.5) * (2.0 / n) - 1.0
    right, above, ahead = FACES[face] @ axes
    return ahead + middle[None, :, None] * right - middle[:, None, None] * above


def pixels_of(step: float) -> int:
    """Return the number of pixels along a face whose pixels are at most `step` [rad] wide.

    The widest are those in the middle, of 2 / n. InputError where the step is none.
    """
    if not (math.isfinite(step) and _FINEST <= step <= math.pi / 4):
        raise InputError(f"step: expected 0.02 to 45 degrees, got {math.degrees(step):g} degrees")
    return math.ceil(2.0 / step)


def panorama(
    scenery: Scenery,
    eye: ArrayLike,
    *,
    row: int = 0,
    step: float = STEP,
    axes: ArrayLike | None = None,
) -> Panorama:
    """Look in every direction from one eye.

    Parameters
    ----------
    scenery
        What may be seen.
    eye
        (3,) [m].
    row
        Whose scenery.
    step
        Largest width [rad] of a pixel. What is thinner may be missed.
    axes
        (3, 3) forward, left, up of the faces as rows; the world's if None.

    Raises
    ------
    InputError
        If the eye is inside a solid part or a sphere, or the step is not 0.02 to 45 degrees.
    """
    frame = np.eye(3) if axes is None else np.asarray(axes, dtype=np.float64)
    n = pixels_of(step)
    shapes = shapes_before(scenery, eye, row, n, FACES @ frame)
    item = np.empty((6, n, n), dtype=np.int32)
    glass = np.empty((6, n, n), dtype=np.int32)
    height = BAND * -(-n // (BAND * PIECES))

    def work(begin: int, end: int) -> None:
        for k in range(begin, end):
            face, piece = divmod(k, PIECES)
            rows = slice(piece * height, min((piece + 1) * height, n))
            fill_bands(
                shapes[face], rows.start, rows.stop, BAND, item[face, rows], glass[face, rows]
            )

    run_in_threads(work, 6 * PIECES, 1)
    return Panorama(scenery.names, np.asarray(eye, dtype=np.float64), frame, item, glass)


def shapes_before(
    scenery: Scenery, eye: ArrayLike, row: int, n: int, views: Floats
) -> list[FaceShapes]:
    """Project a scenery on faces of n x n pixels.

    Parameters
    ----------
    scenery, eye, row
        As for `panorama`, with its errors.
    n
        Pixels along an edge.
    views
        (F, 3, 3) right, up and ahead of each face.
    """
    point = np.asarray(eye, dtype=np.float64)
    check_eye(scenery, point, row=row)
    own = scenery.of_row(row)
    away = np.where(own.moving[:, None], own.displacement[0], 0.0) - point
    triangles = Triangles(own.triangles, own.item, own.ball, away, own.solid)
    found = []
    for view in views:
        pixels, item = project_triangles(triangles, np.ascontiguousarray(view), n)
        clear = own.see_through[item]
        shown = pixels[~clear], item[~clear], pixels[clear], item[clear]
        found.append(FaceShapes(*shown, *_balls(own, point, view)))
    return found


def _balls(own: Scenery, point: Floats, view: Floats) -> tuple[Floats, Ints, Ints]:
    """The last three of `FaceShapes`, of a scenery of one row seen from a point."""
    there = np.flatnonzero(np.isfinite(own.radius[0]))
    balls = np.concatenate([own.centre[0] - point, own.radius[0, :, None]], axis=1)[there]
    balls[:, :3] = balls[:, :3] @ view.T * [1.0, 1.0, -1.0] + [0.0, 0.0, 1.0]
    order = np.argsort(balls[:, 2] + balls[:, 3], kind="stable")
    order = order[balls[order, 2] - balls[order, 3] < 1.0]
    return balls, order, own.sphere_item[there]
