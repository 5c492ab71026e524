"""The raster display of spheres alone, fast enough for films and live use: flat, shaded, depth and
numbers.

`disks_of` sorts disks by their frontmost points; given the frame before, from that frame's order by
insertion. `painted` paints them back to front, as the paper does. `surfaces_of` finds for each
pixel which sphere's surface a ray through it meets first, so that spheres cut one another where
they should; `shaded` lights that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.draw.camera import Camera
from workbench.draw.kernels.disk_painter import paint_disks, project_spheres, update_depth_order
from workbench.draw.kernels.shading import BLOCK, light_surfaces, paint_rays, surface_depths
from workbench.draw.scene import Spheres
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats, Ints

__all__ = [
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
"""(height, width) of a sphere or a triangle in each pixel, -1 for none."""

_PAPER = 255  # grey
_LIGHT = np.array([-0.35, 0.62, 0.70])  # right, up, toward: over the viewer's left shoulder
_REACH = 0.03  # [m] creases are looked for so far around


class Disks(NamedTuple):
    """Projected spheres: disk (S, 3) x, y, radius [pixels]; centre, radius, front (S,): depths and
    radius [m].

    The paper's perspective: a circle about the image of the centre, its radius in inverse
    proportion to the centre's distance along the view. Spheres that hold the eye are not drawn.
    Those that the nearest plane cuts end there: where it takes their centre, their disk, centre and
    radius are those of the cut face. disk is 0 and front -inf where nothing is drawn. order (K,):
    those drawn back to front by the frontmost point; the first given comes first where two are
    equal. view (S, 4): whole spheres in view coordinates. all (S,): the order with those not drawn,
    which a next frame begins with; moves: by how many places spheres were moved from it.
    """

    disk: Floats
    centre: Floats
    radius: Floats
    front: Floats
    order: Ints
    view: Floats
    all: Ints
    moves: int


class Surfaces(NamedTuple):
    """Of each pixel (height, width) the foremost surface: depth [m], -inf for none; sphere, -1 for
    none."""

    depth: Floats
    sphere: ItemBuffer


def _lens(camera: Camera) -> Floats:
    """A camera as the kernels take it (18,); see kernels.pictures.frames."""
    middle = (camera.width / 2.0, camera.height / 2.0)
    rest = (camera.scale, camera.bend, *middle, camera.nearest, camera.distance)
    return np.concatenate([camera.right, camera.up, camera.toward, camera.centre, rest])


def project_disks(spheres: Spheres, camera: Camera, *, last: Ints | None = None) -> Disks:
    """Spheres as disks, with their painter's order.

    last (S,): the order of a frame before, from which this one is sorted by insertion. UsageError
    where it is not of as many spheres; InputError where centres or radii are not finite.
    """
    count = len(spheres.radius)
    if not (np.isfinite(spheres.centre).all() and np.isfinite(spheres.radius).all()):
        raise InputError("spheres to be drawn must have finite centres and radii")
    view = np.empty((count, 4))
    shown = np.empty((count, 2))
    disk = np.empty((count, 3))
    front = np.empty(count)
    drawn = project_spheres(spheres.centre, spheres.radius, _lens(camera), view, shown, disk, front)
    moves = 0
    if last is None:
        order = np.argsort(front, kind="stable")
    elif len(last) != count:
        raise UsageError(
            f"the last frame's order is of {len(last)} spheres, this frame has {count}"
        )
    else:
        order = last.copy()
        moves = update_depth_order(order, front)
    depth, radius = np.ascontiguousarray(shown.T)
    return Disks(disk, depth, radius, front, order[count - drawn :], view, order, moves)


def painter_item_buffer(disks: Disks, camera: Camera) -> ItemBuffer:
    """(height, width) the sphere that a painter of disks shows in each pixel, -1 for none."""
    picture = np.full((camera.height, camera.width), -1, dtype=np.int32)
    covered = np.empty((camera.height, 4), dtype=np.int64)
    numbers = np.arange(len(disks.front), dtype=np.int32)
    paint_disks(disks.disk, disks.order, numbers, -1, picture, covered)
    return picture


def exact_item_buffer(disks: Disks, camera: Camera) -> ItemBuffer:
    """The same with the true outline of each sphere, an ellipse in perspective, in place of the
    paper's circle."""
    picture = np.full((camera.height, camera.width), -1, dtype=np.int32)
    paint_rays(
        disks.view, disks.order, _lens(camera), np.arange(len(disks.front), dtype=np.int32), picture
    )
    return picture


def cast_rays(disks: Disks, camera: Camera) -> Surfaces:
    """What a ray through the middle of each pixel meets first; in perspective always exact.

    Where the nearest plane goes through a sphere, its cut face shows.
    """
    height = camera.height
    width = camera.width
    depth = np.full((height, width), -np.inf)
    sphere = np.full((height, width), -1, dtype=np.int32)
    bound = np.full((height, -(-width // BLOCK)), -np.inf)
    surface_depths(disks.view, disks.order, _lens(camera), depth, sphere, bound)
    return Surfaces(depth, sphere)


def shade_surfaces(
    disks: Disks, surfaces: Surfaces, camera: Camera, colour: Floats
) -> NDArray[np.uint8]:
    """(height, width, 3) soft light and ambient shade in creases, on white; colour (S, 3): 0 to 255
    in full light."""
    picture = np.full((camera.height, camera.width, 3), _PAPER, dtype=np.uint8)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    light_surfaces(
        disks.view, colour, light, _lens(camera), _REACH, surfaces.depth, surfaces.sphere, picture
    )
    return picture
