"""What one eye sees in every direction: item buffers on the six faces of a cube about it.

A face is a picture of a quarter turn in width and height, gnomonic: straight edges are straight, and
a plane has a depth that is linear across the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.geometry.clipping import clip_triangles
from workbench.model.arrays import Bools, Floats, Ints
from workbench.sight.kernels.bands import FaceShapes, Items, fill_bands
from workbench.sight.scenery import Scenery, check_eye
from workbench.threads import in_pieces

__all__ = [
    "BAND",
    "FACES",
    "PIECES",
    "STEP",
    "Panorama",
    "bands_of",
    "face_directions",
    "face_pixels",
    "panorama",
    "pixel_weights",
    "pixels_of",
    "shapes_before",
]

STEP = math.radians(0.1)
"""The usual width [rad] of a pixel."""
_NEAREST = 1e-6
"""Distance [m] before the eye, along the middle of a face, from which on triangles are seen."""
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


def bands_of(face: Ints, row: Ints, n: int) -> Bools:
    """Return which bands (6, N) of rows of faces hold some pixels, given by face and row (...)."""
    bands = np.zeros((6, -(-n // BAND)), dtype=np.bool_)
    bands[face, row // BAND] = True
    return bands


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
    way: Floats = ahead + middle[None, :, None] * right - middle[:, None, None] * above
    return way


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
    bands: Bools | None = None,
) -> Panorama:
    """Look in every direction from one eye, or in some.

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
    bands
        (6, N) of `bands_of`: which rows of the faces are filled; all if None. The others have -1.

    Raises
    ------
    InputError
        If the eye is inside a solid part or a sphere, or the step is not 0.02 to 45 degrees.
    """
    frame = np.eye(3) if axes is None else np.asarray(axes, dtype=np.float64)
    n = pixels_of(step)
    wanted = np.ones((6, -(-n // BAND)), dtype=np.bool_) if bands is None else bands
    faces = np.flatnonzero(wanted.any(axis=1))
    shapes = shapes_before(scenery, eye, row, n, FACES[faces] @ frame)
    item = np.full((6, n, n), -1, dtype=np.int32)
    glass = np.full((6, n, n), -1, dtype=np.int32)
    face_of, band = np.nonzero(wanted[faces])

    def work(begin: int, end: int) -> None:
        for k in range(begin, end):
            face = faces[face_of[k]]
            first = BAND * int(band[k])
            last = min(first + BAND, n)
            fill_bands(shapes[face_of[k]], first, last, BAND, item[face], glass[face])

    in_pieces(work, len(band), -(-len(band) // (6 * PIECES)))
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
    away = own.shifts(0) - point
    corners = own.triangles + away[:, None]
    turned = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0.0
    seen = ~(own.solid[own.item] & turned)
    ball = own.ball[:, :3] + away
    found = []
    for right, above, ahead in views:
        # planes through the eye and the sides of the face, whose normals are sqrt(2) long
        sides = np.stack([ahead + right, ahead - right, ahead + above, ahead - above])
        on = seen & np.all(ball @ sides.T >= -math.sqrt(2.0) * own.ball[:, 3:], axis=1)
        view = np.stack([right, above, ahead])
        before = (corners[on].reshape(-1, 3) @ view.T).reshape(-1, 3, 3)
        pieces, source = clip_triangles(before, np.array([0.0, 0.0, -1.0]), -_NEAREST)
        near = 1.0 / pieces[:, :, 2:]
        pixels = np.concatenate([pieces[:, :, :2] * near * [1.0, -1.0] + 1.0, near], axis=2)
        pixels[:, :, :2] *= n / 2.0
        item = own.item[on][source]
        clear = own.see_through[item]
        triangles = pixels[~clear], item[~clear], pixels[clear], item[clear]
        found.append(FaceShapes(*triangles, *_balls(own, point, view)))
    return found


def _balls(own: Scenery, point: Floats, view: Floats) -> tuple[Floats, Ints, Ints]:
    """The last three of `FaceShapes`, of a scenery of one row seen from a point."""
    there = np.flatnonzero(np.isfinite(own.radius[0]))
    balls = np.concatenate([own.centre[0] - point, own.radius[0, :, None]], axis=1)[there]
    balls[:, :3] = balls[:, :3] @ view.T * [1.0, 1.0, -1.0] + [0.0, 0.0, 1.0]
    order = np.argsort(balls[:, 2] + balls[:, 3], kind="stable")
    order = order[balls[order, 2] - balls[order, 3] < 1.0]
    return balls, order, own.sphere_item[there]
