"""What is in front of what: the shared depth buffers of bodies and environment, seen through one
camera.

What stands between the viewer and the bodies must not hide them. So (1) nothing nearer than the
bodies' foremost point is drawn: it is cut away by a plane across the view; (2) what is left in
front of a body pixel can be told apart by its depth, for a display to draw it as a veil. Where the
plane cuts a solid, the cut face is told apart too (`section`): there the first surface behind the
plane is one seen from inside.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, facing, projective_depth, to_view, view_to_pixels
from workbench.draw.clipping import clip_triangles
from workbench.draw.kernels.rasterization import fill_triangles, sphere_depths
from workbench.draw.scene import Scene
from workbench.draw.sphere_raster import (
    Disks,
    ItemBuffer,
    cast_rays,
    exact_item_buffer,
    painter_item_buffer,
    project_disks,
)
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = [
    "DepthBuffers",
    "Disks",
    "cut_depth",
    "depth_share",
    "foremost_depth",
    "projected_disks",
    "render_buffers",
    "triangle_polygons",
]

# [m] where the faces of two touching parts coincide, the one that looks at the viewer wins
_BEHIND = 1e-4
_SLACK = 1e-3  # [m] a surface that just touches the foremost point of a body is still shown


@dataclass(frozen=True, eq=False)
class DepthBuffers:
    """Pixel arrays (height, width); depths in metres, -inf where there is nothing; numbers, -1
    where nothing.

    camera: what they were seen through. cut [m]: nothing nearer than this is in the environment's
    arrays. sphere: the sphere that the painter shows; body_depth: the foremost sphere surface.
    triangle, depth: the foremost opaque triangle; section: it is the cut face of a solid. glass,
    glass_depth: the same for see-through parts. seen (V, 3): the environment's vertices in view
    coordinates [m].
    """

    camera: Camera
    cut: float
    sphere: ItemBuffer
    body_depth: Floats
    triangle: ItemBuffer
    depth: Floats
    section: Bools
    glass: ItemBuffer
    glass_depth: Floats
    seen: Floats


def projected_disks(scene: Scene, camera: Camera) -> Disks:
    """The scene's spheres as disks, with their painter's order."""
    return project_disks(scene.spheres, camera)


def render_buffers(
    scene: Scene, camera: Camera, *, spheres: str = "painter_item_buffer"
) -> DepthBuffers:
    """All depth buffers of a scene at the camera's own resolution.

    spheres: painted, in the paper's order and circles; exact, in its order by their true outlines,
    ellipses in perspective; or surfaces, each pixel the one whose surface is foremost there. In a
    parallel view the first two are one.
    """
    size = (camera.height, camera.width)
    disks = projected_disks(scene, camera)
    if spheres == "surfaces":
        surfaces = cast_rays(disks, camera)
        body_depth = surfaces.depth
        sphere = surfaces.sphere
    elif spheres == "exact" and np.isfinite(camera.distance):
        sphere = exact_item_buffer(disks, camera)
        body_depth = cast_rays(disks, camera).depth
    else:
        sphere = painter_item_buffer(disks, camera)
        body_depth = np.full(size, -np.inf)
        sphere_depths(
            disks.disk[disks.order],
            disks.centre[disks.order],
            disks.radius[disks.order],
            body_depth,
        )
        np.minimum(body_depth, camera.nearest, out=body_depth)
    cut = cut_depth(disks, camera)
    opaque = _buffers(size)
    glass = _buffers(size)
    section = np.zeros(size, dtype=np.bool_)
    seen = np.empty((0, 3))
    if scene.environment is not None:
        solid, clear = _triangle_kinds(scene.environment)
        seen = to_view(camera, scene.environment.vertices)
        _fill(scene.environment, camera, cut, seen, solid, opaque)
        _fill(scene.environment, camera, cut, seen, clear, glass)
        section = _sections(scene.environment, camera, opaque)
        opaque.depth[section] = cut
    return DepthBuffers(
        camera,
        cut,
        sphere,
        body_depth,
        opaque.triangle,
        opaque.depth,
        section,
        glass.triangle,
        glass.depth,
        seen,
    )


def cut_depth(disks: Disks, camera: Camera) -> float:
    """The depth [m] of the plane that cuts the environment: at the foremost body, or where the
    camera has it."""
    return min(max(foremost_depth(disks), camera.opened) + _SLACK, camera.nearest)


def foremost_depth(disks: Disks) -> float:
    """The depth [m] of the foremost point of all bodies, infinite where there is none."""
    return float(disks.front[disks.order[-1]]) if len(disks.order) else np.inf


def triangle_polygons(environment: Environment) -> Ints:
    """(T,) the polygon of each triangle."""
    return np.repeat(np.arange(len(environment.normal)), np.diff(environment.triangle_start))


class _Buffers(NamedTuple):
    """Foremost triangle, its depth, and whether something nearer was cut away; (height, width)
    each."""

    triangle: ItemBuffer
    depth: Floats
    was_cut: Bools


def _buffers(size: tuple[int, int]) -> _Buffers:
    return _Buffers(
        np.full(size, -1, dtype=np.int32), np.full(size, -np.inf), np.zeros(size, dtype=np.bool_)
    )


def _triangle_kinds(environment: Environment) -> tuple[Ints, Ints]:
    """Numbers of the opaque triangles and of the see-through ones; those of hidden parts are in
    neither."""
    part = environment.polygon_part[triangle_polygons(environment)]
    shown = ~environment.hidden[part]
    clear = environment.see_through[part]
    return np.flatnonzero(shown & ~clear), np.flatnonzero(shown & clear)


def _fill(
    environment: Environment, camera: Camera, cut: float, seen: Floats, chosen: Ints, into: _Buffers
) -> None:
    """Fill the chosen triangles of an environment; seen (V, 3): its vertices in view
    coordinates."""
    away = (facing(camera, environment.normal, environment.offset) < 0)[
        triangle_polygons(environment)[chosen]
    ]
    of = np.arange(len(chosen))
    if not seen[:, 2].max(initial=-np.inf) > camera.closest:
        points = view_to_pixels(camera, seen)
        points[:, 2] = projective_depth(camera, points[:, 2])
        corners = points[environment.triangles[chosen]]
    else:
        near, of = clip_triangles(
            seen[environment.triangles[chosen]], np.array([0.0, 0.0, 1.0]), camera.closest
        )
        corners = view_to_pixels(camera, near)
        corners[..., 2] = projective_depth(camera, corners[..., 2])
    corners[away[of], :, 2] -= _BEHIND
    fill_triangles(corners, chosen[of], camera.bend, cut, into.depth, into.triangle, into.was_cut)


def _sections(environment: Environment, camera: Camera, opaque: _Buffers) -> Bools:
    """Pixels where the plane went through a solid: something was cut here and a solid is seen from
    inside."""
    polygon = triangle_polygons(environment)
    away = facing(camera, environment.normal, environment.offset)[polygon] < 0
    inside = environment.solid[environment.polygon_part[polygon]] & away
    found: Bools = (opaque.triangle >= 0) & opaque.was_cut
    found[found] = inside[opaque.triangle[found]]
    return found


def depth_share(depth: Floats) -> Floats:
    """Depth (S,) [m] as a share: 0 at the farthest, 1 at the nearest; 1 where all are alike; -inf
    counts as 0."""
    finite = depth[np.isfinite(depth)]
    if not len(finite):
        return np.zeros_like(depth)
    far = float(finite.min())
    near = float(finite.max())
    return np.maximum(depth - far, 0.0) / (near - far) if near > far else np.ones_like(depth)
