"""Compute the depth buffers of bodies and environment through one camera.

What stands between the viewer and the bodies must not hide them:

1. A near plane at the bodies' foremost point cuts the environment. Nothing nearer is drawn.
2. What is left in front of a body pixel has a greater depth there, so that a display can draw it
   as a veil.

Where the near plane cuts a solid, `section` marks the cut face: the first surface behind the plane
is seen from inside there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.draw.camera import (
    TO_VIEWER,
    Camera,
    facing,
    to_projective,
    to_view,
)
from workbench.draw.kernels.disk_painter import sphere_depths
from workbench.draw.scene import Scene
from workbench.draw.sphere_raster import (
    Disks,
    ItemBuffer,
    cast_rays,
    exact_item_buffer,
    painter_item_buffer,
    project_disks,
)
from workbench.geometry.clipping import clip_triangles
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment
from workbench.sight.kernels.rasterization import Fragments, fill_triangles

__all__ = [
    "DepthBuffers",
    "Disks",
    "cut_depth",
    "depth_share",
    "foremost_depth",
    "projected_disks",
    "render_buffers",
    "triangle_polygons",
    "triangles_shown",
]

_BACK_FACE_BIAS = 1e-4
"""Projective depth [m] by which triangles that face away are set back. Where faces of two touching
parts coincide, the one that faces the viewer wins."""
_CUT_MARGIN = 1e-3
"""Distance [m] of the near plane in front of the foremost body, so that a surface that touches the
body there is still shown."""


@dataclass(frozen=True, eq=False)
class DepthBuffers:
    """Images (height, width) of a scene: depths [m], -inf for nothing; indices, -1 for nothing."""

    camera: Camera
    cut: float
    """Depth [m] of the near plane of the environment."""
    sphere: ItemBuffer
    """Index of the sphere shown in each pixel."""
    body_depth: Floats
    """Depth of the foremost sphere surface."""
    triangle: ItemBuffer
    """Index of the foremost opaque triangle."""
    depth: Floats
    """Depth of the foremost opaque triangle."""
    section: Bools
    """Whether the opaque surface is the cut face of a solid."""
    glass: ItemBuffer
    """Index of the foremost triangle of a see-through part."""
    glass_depth: Floats
    """Depth of that triangle."""
    seen: Floats
    """(V, 3) view coordinates [m] of the environment's vertices."""


def projected_disks(scene: Scene, camera: Camera) -> Disks:
    """Project the spheres of a scene to disks, in painter's order."""
    return project_disks(scene.spheres, camera)


def render_buffers(scene: Scene, camera: Camera, *, spheres: str = "painted") -> DepthBuffers:
    """Compute all buffers of a scene at the resolution of the camera.

    Parameters
    ----------
    scene, camera
        What is seen, and from where.
    spheres
        Which sphere a pixel shows. "painted": the painter's order, circles as in the paper.
        "exact": the painter's order, true outlines (ellipses in perspective; the same as painted
        in a parallel view). "surfaces": the foremost surface in the pixel.
    """
    disks = projected_disks(scene, camera)
    sphere, body_depth = _sphere_buffers(disks, camera, spheres)
    cut = cut_depth(disks, camera)
    opaque = _empty_buffers(camera)
    glass = _empty_buffers(camera)
    section = np.zeros_like(opaque.was_cut)
    seen = np.empty((0, 3))
    environment = scene.environment
    if environment is not None:
        seen = to_view(camera, environment.vertices)
        see_through = environment.see_through[
            environment.polygon_part[triangle_polygons(environment)]
        ]
        shown = triangles_shown(environment)
        _rasterize(environment, camera, cut, seen, shown[~see_through[shown]], opaque)
        _rasterize(environment, camera, cut, seen, shown[see_through[shown]], glass)
        section = _section_pixels(environment, camera, opaque)
        opaque.depth[section] = cut
    return DepthBuffers(
        camera,
        cut,
        sphere,
        body_depth,
        triangle=opaque.number,
        depth=opaque.depth,
        section=section,
        glass=glass.number,
        glass_depth=glass.depth,
        seen=seen,
    )


def _sphere_buffers(disks: Disks, camera: Camera, spheres: str) -> tuple[ItemBuffer, Floats]:
    """Return the item buffer and the depth buffer (height, width) of the bodies."""
    if spheres == "surfaces":
        surfaces = cast_rays(disks, camera)
        return surfaces.sphere, surfaces.depth
    if spheres == "exact" and np.isfinite(camera.distance):
        return exact_item_buffer(disks, camera), cast_rays(disks, camera).depth
    depth = np.full((camera.height, camera.width), -np.inf)
    order = disks.order
    sphere_depths(disks.disk[order], disks.centre[order], disks.radius[order], depth)
    np.minimum(depth, camera.nearest, out=depth)
    return painter_item_buffer(disks, camera), depth


def cut_depth(disks: Disks, camera: Camera) -> float:
    """Return the depth [m] of the environment's near plane: at the foremost body, or the camera's
    own if that is farther."""
    return min(max(foremost_depth(disks), camera.opened) + _CUT_MARGIN, camera.nearest)


def foremost_depth(disks: Disks) -> float:
    """Return the depth [m] of the foremost point of all bodies, infinity without bodies."""
    return float(disks.front[disks.order[-1]]) if len(disks.order) else np.inf


def triangle_polygons(environment: Environment) -> Ints:
    """Return the polygon (T,) of each triangle."""
    return np.repeat(np.arange(len(environment.normal)), np.diff(environment.triangle_start))


def triangles_shown(environment: Environment) -> Ints:
    """Return the indices of all triangles that belong to parts that are not hidden."""
    part = environment.polygon_part[triangle_polygons(environment)]
    return np.flatnonzero(~environment.hidden[part])


def _empty_buffers(camera: Camera) -> Fragments:
    size = (camera.height, camera.width)
    return Fragments(
        np.full(size, -np.inf), np.full(size, -1, dtype=np.int32), np.zeros(size, dtype=np.bool_)
    )


def _rasterize(
    environment: Environment,
    camera: Camera,
    cut: float,
    seen: Floats,
    chosen: Ints,
    buffers: Fragments,
) -> None:
    """Fill the chosen triangles into buffers; seen (V, 3): view coordinates of the vertices."""
    source = np.arange(len(chosen))
    if seen[:, 2].max(initial=-np.inf) > camera.closest:
        near, source = clip_triangles(
            seen[environment.triangles[chosen]], TO_VIEWER, camera.closest
        )
        corners = to_projective(camera, near)
    else:  # no clipping needed: project each vertex once
        corners = to_projective(camera, seen)[environment.triangles[chosen]]
    facing_away = facing(camera, environment.normal, environment.offset) < 0
    polygon = triangle_polygons(environment)[chosen][source]
    corners[facing_away[polygon], :, 2] -= _BACK_FACE_BIAS
    fill_triangles(corners, chosen[source], camera.inverse_distance, cut, buffers)


def _section_pixels(environment: Environment, camera: Camera, opaque: Fragments) -> Bools:
    """Find the pixels where the near plane cuts a solid: something was cut away there, and a solid
    is seen from inside."""
    polygon = triangle_polygons(environment)
    facing_away = facing(camera, environment.normal, environment.offset)[polygon] < 0
    inside = environment.solid[environment.polygon_part[polygon]] & facing_away
    section: Bools = (opaque.number >= 0) & opaque.was_cut
    section[section] = inside[opaque.number[section]]
    return section


def depth_share(depth: Floats) -> Floats:
    """Scale depths (S,) [m] to 0 at the farthest and 1 at the nearest.

    Equal depths give 1. -inf counts as the farthest.
    """
    finite = depth[np.isfinite(depth)]
    if not len(finite):
        return np.zeros_like(depth)
    low = float(finite.min())
    high = float(finite.max())
    return np.maximum(depth - low, 0.0) / (high - low) if high > low else np.ones_like(depth)
