"""What is in front of what: the shared depth buffers of bodies and environment, seen through one camera.

What stands between the viewer and the bodies must not hide them. So (1) nothing nearer than the bodies' foremost
point is drawn: it is cut away by a plane across the view; (2) what is left in front of a body pixel is told apart
(`veiled`), for a display to draw it as a veil. Where the plane cuts a solid, the cut face is told apart too
(`section`): there the first surface behind the plane is one seen from inside.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, pixels_per_metre, project
from workbench.draw.scene import Scene
from workbench.kernels.raster import fill_triangles, paint_disks, sphere_depths
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["Disks", "Layers", "depth_share", "projected_disks", "triangle_polygons", "visible_layers"]

_BEHIND = 1e-4  # [m] where the faces of two touching parts coincide, the one that looks at the viewer wins
_SLACK = 1e-3  # [m] a surface that just touches the foremost point of a body is still shown


class Disks(NamedTuple):
    """Projected spheres: disk (S, 3) x, y, radius [pixels]; centre, radius, front (S,): depths and radius [m].

    order (S,): back to front by the frontmost point; the first given comes first where two are equal.
    """

    disk: Floats
    centre: Floats
    radius: Floats
    front: Floats
    order: Ints


@dataclass(frozen=True, eq=False)
class Layers:
    """Pixel arrays (height, width); depths in metres, -inf where there is nothing; numbers, -1 where nothing.

    sphere: the sphere that the painter shows; body_depth: the foremost sphere surface. triangle, depth: the
    foremost opaque triangle; section: it is the cut face of a solid. glass, glass_depth: the same for see-through
    parts. cut [m]: nothing nearer than this is in the environment's arrays. veiled: the body lies behind a triangle.
    """

    cut: float
    sphere: Ints
    body_depth: Floats
    triangle: Ints
    depth: Floats
    section: Bools
    glass: Ints
    glass_depth: Floats

    @property
    def veiled(self) -> Bools:
        """(height, width) a body is here and an opaque triangle stands in front of it."""
        return (self.sphere >= 0) & (self.depth > self.body_depth)


def projected_disks(scene: Scene, camera: Camera) -> Disks:
    """The scene's spheres as disks, with their painter's order."""
    spheres = scene.spheres
    seen = project(camera, spheres.centre)
    size = spheres.radius * pixels_per_metre(camera, seen[:, 2])
    front = seen[:, 2] + spheres.radius
    disk = np.column_stack([seen[:, :2], size])
    return Disks(disk, np.ascontiguousarray(seen[:, 2]), spheres.radius, front, np.argsort(front, kind="stable"))


def visible_layers(scene: Scene, camera: Camera) -> Layers:
    """All depth buffers of a scene at the camera's own resolution."""
    size = (camera.height, camera.width)
    disks = projected_disks(scene, camera)
    sphere, body_depth = np.full(size, -1, dtype=np.int64), np.full(size, -np.inf)
    paint_disks(disks.disk, disks.order, sphere)
    sphere_depths(disks.disk, disks.centre, disks.radius, body_depth)
    cut = float(disks.front.max()) + _SLACK if len(disks.front) else np.inf
    opaque, glass = _buffers(size), _buffers(size)
    section = np.zeros(size, dtype=np.bool_)
    if scene.environment is not None:
        solid, clear = _triangle_kinds(scene.environment)
        _fill(scene.environment, camera, cut, solid, opaque)
        _fill(scene.environment, camera, cut, clear, glass)
        section = _sections(scene.environment, camera, opaque)
        opaque.depth[section] = cut
    return Layers(cut, sphere, body_depth, opaque.triangle, opaque.depth, section, glass.triangle, glass.depth)


def triangle_polygons(environment: Environment) -> Ints:
    """(T,) the polygon of each triangle."""
    return np.repeat(np.arange(len(environment.normal)), np.diff(environment.triangle_start))


class _Buffers(NamedTuple):
    """Foremost triangle, its depth, and whether something nearer was cut away; (height, width) each."""

    triangle: Ints
    depth: Floats
    was_cut: Bools


def _buffers(size: tuple[int, int]) -> _Buffers:
    return _Buffers(np.full(size, -1, dtype=np.int64), np.full(size, -np.inf), np.zeros(size, dtype=np.bool_))


def _triangle_kinds(environment: Environment) -> tuple[Ints, Ints]:
    """Numbers of the opaque triangles and of the see-through ones; those of hidden parts are in neither."""
    part = environment.polygon_part[triangle_polygons(environment)]
    shown, clear = ~environment.hidden[part], environment.see_through[part]
    return np.flatnonzero(shown & ~clear), np.flatnonzero(shown & clear)


def _fill(environment: Environment, camera: Camera, cut: float, chosen: Ints, into: _Buffers) -> None:
    """Fill the chosen triangles of an environment."""
    corners = project(camera, environment.vertices)[environment.triangles[chosen]]
    away = environment.normal[triangle_polygons(environment)[chosen]] @ camera.toward < 0
    corners[away, :, 2] -= _BEHIND
    fill_triangles(np.ascontiguousarray(corners), chosen, cut, into.depth, into.triangle, into.was_cut)


def _sections(environment: Environment, camera: Camera, opaque: _Buffers) -> Bools:
    """Pixels where the plane went through a solid: something was cut here and a solid is seen from inside."""
    polygon = triangle_polygons(environment)
    inside = environment.solid[environment.polygon_part[polygon]] & (environment.normal[polygon] @ camera.toward < 0)
    found: Bools = (opaque.triangle >= 0) & opaque.was_cut
    found[found] = inside[opaque.triangle[found]]
    return found


def depth_share(depth: Floats) -> Floats:
    """Depth (S,) [m] as a share: 0 at the farthest, 1 at the nearest; 1 where all are alike."""
    if not len(depth):
        return depth
    far, near = float(depth.min()), float(depth.max())
    return (depth - far) / (near - far) if near > far else np.ones_like(depth)
