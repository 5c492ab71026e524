"""Rasterize spheres: painter's algorithm, ray casting, shading. Fast enough for films.

`project_disks` sorts disks by their frontmost points. `painter_item_buffer` paints them back to
front, as the paper does. `cast_rays` finds the sphere that a ray through each pixel meets first, so
that spheres intersect where they should; `shade_surfaces` lights that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.draw.camera import Camera
from workbench.draw.kernels.disk_painter import (
    Projection,
    paint_disks,
    project_spheres,
    update_depth_order,
)
from workbench.draw.kernels.shading import Light, light_surfaces, paint_rays
from workbench.draw.scene import Spheres
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats, Ints
from workbench.sight.kernels.sphere_rays import RUN_LENGTH, Lens, surface_depths

__all__ = [
    "LIGHT",
    "Disks",
    "ItemBuffer",
    "Surfaces",
    "cast_rays",
    "exact_item_buffer",
    "painter_item_buffer",
    "project_disks",
    "shade_surfaces",
]

ItemBuffer = NDArray[np.int32]
"""(height, width) index of the sphere or triangle in each pixel, -1 for none."""

LIGHT = np.array([-0.35, 0.62, 0.70])
"""Direction to the light: right, up, toward the viewer; over the viewer's left shoulder."""
_PAPER_GREY = 255
_CREASE_RADIUS = 0.03
"""Distance [m] within which surfaces darken creases (ambient occlusion)."""


class Disks(NamedTuple):
    """Projected spheres, as in the paper.

    In perspective a disk is a circle about the image of the centre. Its radius is in inverse
    proportion to the distance of the centre along the view. Spheres that hold the eye are not
    drawn. Spheres that the near plane cuts end there: where it takes their centre, disk, centre and
    radius are those of the cut face.
    """

    disk: Floats
    """(S, 3) x, y, radius [pixels]; 0 where nothing is drawn."""
    centre: Floats
    """(S,) depth of the centre [m]."""
    radius: Floats
    """(S,) [m]."""
    front: Floats
    """(S,) depth of the frontmost point [m]; -inf where nothing is drawn."""
    order: Ints
    """(K,) the drawn spheres, back to front by `front`. Equal ones keep their order."""
    view: Floats
    """(S, 4) centre in view coordinates, and radius, of the whole spheres [m]."""
    all: Ints
    """(S,) the order of all spheres, from which the next frame starts."""
    moves: int
    """Number of places by which spheres were moved from the order of the last frame."""


class Surfaces(NamedTuple):
    """The foremost sphere surface of each pixel (height, width)."""

    depth: Floats
    """[m]; -inf for none."""
    sphere: ItemBuffer


def _lens(camera: Camera) -> Lens:
    """Return a camera as the kernels take it."""
    return Lens(
        np.stack([camera.right, camera.up, camera.toward, camera.centre]),
        float(camera.scale),
        float(camera.inverse_distance),
        camera.width / 2.0,
        camera.height / 2.0,
        float(camera.nearest),
        float(camera.distance),
    )


def project_disks(spheres: Spheres, camera: Camera, *, last: Ints | None = None) -> Disks:
    """Project spheres to disks and sort them back to front.

    Parameters
    ----------
    spheres, camera
        What is seen, and from where.
    last
        (S,) the order of the frame before. An insertion sort updates it, which is fast if little
        has changed.

    Raises
    ------
    UsageError
        If `last` has another number of spheres.
    InputError
        If a centre or radius is not finite.
    """
    count = len(spheres.radius)
    if not (np.isfinite(spheres.centre).all() and np.isfinite(spheres.radius).all()):
        raise InputError("spheres to be drawn must have finite centres and radii")
    if last is not None and len(last) != count:
        raise UsageError(
            f"the last frame's order is of {len(last)} spheres, this frame has {count}"
        )
    out = Projection(
        np.empty((count, 4)), np.empty((count, 2)), np.empty((count, 3)), np.empty(count)
    )
    drawn = project_spheres(spheres.centre, spheres.radius, _lens(camera), out)
    moves = 0
    if last is None:
        order = np.argsort(out.front, kind="stable")
    else:
        order = last.copy()
        moves = update_depth_order(order, out.front)
    depth, radius = np.ascontiguousarray(out.shown.T)
    shown = order[count - drawn :]
    return Disks(out.disk, depth, radius, out.front, shown, out.balls, order, moves)


def _empty_item_buffer(camera: Camera) -> ItemBuffer:
    return np.full((camera.height, camera.width), -1, dtype=np.int32)


def painter_item_buffer(disks: Disks, camera: Camera) -> ItemBuffer:
    """Paint disks back to front; returns the sphere (height, width) shown in each pixel."""
    picture = _empty_item_buffer(camera)
    covered = np.empty((camera.height, 4), dtype=np.int64)
    numbers = np.arange(len(disks.front), dtype=np.int32)
    paint_disks(disks.disk, disks.order, numbers, -1, picture, covered)
    return picture


def exact_item_buffer(disks: Disks, camera: Camera) -> ItemBuffer:
    """Paint the true outlines of spheres, ellipses in perspective, back to front."""
    picture = _empty_item_buffer(camera)
    numbers = np.arange(len(disks.front), dtype=np.int32)
    paint_rays(disks.view, disks.order, _lens(camera), numbers, picture)
    return picture


def cast_rays(disks: Disks, camera: Camera) -> Surfaces:
    """Find what a ray through the middle of each pixel meets first. Always exact in perspective.

    Where the near plane cuts a sphere, the cut face is met.
    """
    sphere = _empty_item_buffer(camera)
    depth = np.full(sphere.shape, -np.inf)
    bound = np.full((camera.height, -(-camera.width // RUN_LENGTH)), -np.inf)
    surface_depths(disks.view, disks.order, _lens(camera), depth, sphere, bound)
    return Surfaces(depth, sphere)


def shade_surfaces(
    disks: Disks, surfaces: Surfaces, camera: Camera, colour: Floats
) -> NDArray[np.uint8]:
    """Light surfaces softly, with ambient occlusion in creases, on white paper.

    Parameters
    ----------
    disks, surfaces, camera
        The spheres, their surfaces in each pixel, and the camera.
    colour
        (S, 3) colour of each sphere in full light, 0 to 255.

    Returns
    -------
    NDArray[np.uint8]
        (height, width, 3) colours.
    """
    picture = np.full((camera.height, camera.width, 3), _PAPER_GREY, dtype=np.uint8)
    x, y, z = (LIGHT / np.linalg.norm(LIGHT)).tolist()
    light = Light(x, y, z, _CREASE_RADIUS)
    light_surfaces(
        disks.view, colour, light, _lens(camera), surfaces.depth, surfaces.sphere, picture
    )
    return picture
