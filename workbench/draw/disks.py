"""The paper's raster display: every sphere a solid disk of one shade by depth, painted back to
front.

Around the bodies stands the environment, flat shaded and pale, with dark edges. What stands in
front of a body is a veil over it, what stands nearer than every body is cut away (see visibility).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from workbench.draw.camera import Camera, facing
from workbench.draw.colours import GLASS, INK, PAPER, SECTION, ramp
from workbench.draw.ghosts import paint_overlays
from workbench.draw.kernels.compositing import blend_overlays, compose_solids, darken_rims
from workbench.draw.kernels.edge_lines import paint_lines
from workbench.draw.lines.edges import Lines, drawn_edges, visible_lines
from workbench.draw.marks.pictures import paint_mark_shapes, paint_mark_texts
from workbench.draw.scene import Scene
from workbench.draw.sphere_raster import Surfaces, shade_surfaces
from workbench.draw.visibility import (
    DepthBuffers,
    depth_share,
    projected_disks,
    render_buffers,
    triangle_polygons,
)
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats
from workbench.model.environment import Environment

__all__ = ["MODES", "POLYGONS", "disks"]

MODES = ("flat", "shaded", "depth", "id")
POLYGONS = ("shaded", "hidden_line")

_Pixels = NDArray[np.float32]

_RIM = 0.42  # how dark an outline is
_JUMP = 0.03  # [m] a step in depth that is drawn as an outline within a body
_LIGHT = np.array([-0.35, 0.62, 0.70])  # right, up, toward: over the viewer's left shoulder
_WALL_DARK = np.array([190.0, 197.0, 206.0])
_WALL_LIGHT = np.array([244.0, 246.0, 248.0])


def disks(
    scene: Scene,
    camera: Camera,
    *,
    mode: str = "flat",
    exact: bool = False,
    polygons: str = "shaded",
    supersample: int = 2,
    veil: float = 0.28,
) -> Image.Image:
    """Picture of a scene, width x height of the camera; byte for byte the same each time.

    mode: one of MODES. flat: the paper's, one shade a sphere; shaded: light and intersections pixel
    by pixel; depth: grey (L), 255 nearest to 1 farthest, 0 nothing; id: the number of the sphere +
    1 in 24 bits of red, green and blue, 0 for none. exact: the true outlines of spheres in
    perspective, not the paper's circles; all modes but flat are exact. polygons: one of POLYGONS;
    hidden_line: edges only, which hide one another. supersample: pixels drawn each way for one of
    the picture, for flat and shaded. veil: opacity, 0 to 1, of what is in front of a body; with 1
    it hides the body.
    """
    if mode not in MODES or polygons not in POLYGONS:
        raise UsageError(
            f"no mode {mode!r}; {one_of(mode, MODES)}"
            if mode not in MODES
            else f"no style of polygons {polygons!r}; {one_of(polygons, POLYGONS)}"
        )
    if mode in ("depth", "id"):
        return _measured(scene, camera, mode)
    fine = camera.enlarged(supersample)
    layers = render_buffers(
        scene, fine, spheres="surfaces" if mode == "shaded" else "exact" if exact else "painted"
    )
    body = _lit(scene, fine, layers) if mode == "shaded" else _flat(scene, fine, layers)
    picture: _Pixels = np.empty((fine.height, fine.width, 3), dtype=np.float32)
    wall, fade = _walls(scene.environment if polygons == "shaded" else None, fine, layers)
    seen = (layers.triangle, layers.depth, layers.section, layers.sphere, layers.body_depth)
    if polygons == "hidden_line":
        seen = (
            np.full_like(layers.triangle, -1),
            layers.depth,
            np.zeros_like(layers.section),
            *seen[3:],
        )
    darken_rims(body, layers.body_depth, supersample, _JUMP, _RIM)
    compose_solids(wall, body, seen, fade, veil, picture)
    paint_overlays(picture, scene, fine, layers, supersample)
    image = _finished(picture, scene, layers, supersample, 0.1 if polygons == "shaded" else 0.0)
    paint_mark_shapes(image, scene, camera, supersample)
    if supersample > 1:
        image = image.resize((camera.width, camera.height), Image.Resampling.BOX)
    paint_mark_texts(image, scene, camera)
    return image


def _measured(scene: Scene, camera: Camera, mode: str) -> Image.Image:
    """The pictures that are data: depth or numbers of spheres."""
    layers = render_buffers(scene, camera, spheres="surfaces")
    if mode == "id":
        number = layers.sphere + 1
        return Image.fromarray(
            np.stack([number >> 16, number >> 8 & 255, number & 255], axis=-1).astype(np.uint8)
        )
    depth = np.maximum(layers.depth, layers.body_depth)
    there = np.isfinite(depth)
    grey = np.zeros(depth.shape, dtype=np.uint8)
    grey[there] = np.round(1.0 + 254.0 * depth_share(depth[there]))
    return Image.fromarray(grey)


def _walls(
    environment: Environment | None, camera: Camera, layers: DepthBuffers
) -> tuple[Floats, Floats]:
    """Colours of triangles, of cut faces and of paper, and how walls fade, as `compose_solids`
    takes them.

    Flat shade by the polygon's normal, either side alike. Walls fade into the paper from where the
    bodies end.
    """
    colour = np.empty((0, 3))
    if environment is not None:
        light = _LIGHT @ np.array([camera.right, camera.up, camera.toward])
        side = np.where(facing(camera, environment.normal, environment.offset) < 0, -1.0, 1.0)
        lit = np.clip((environment.normal @ light) * side / np.linalg.norm(light), 0.0, 1.0)[
            :, None
        ]
        colour = (_WALL_DARK + (_WALL_LIGHT - _WALL_DARK) * lit)[triangle_polygons(environment)]
    body = layers.body_depth[layers.sphere >= 0]
    near = float(body.min()) if len(body) else -np.inf
    return np.concatenate([colour, [SECTION, PAPER]]), np.array([near, 1.5, 0.6])


def _flat(scene: Scene, camera: Camera, layers: DepthBuffers) -> _Pixels:
    """Picture (height, width, 3) of the bodies: one shade a sphere, by its depth."""
    spheres = scene.spheres
    share = depth_share(projected_disks(scene, camera).front)
    colour = np.zeros(
        (len(share) + 1, 3), dtype=np.float32
    )  # the last one, found by -1, is not looked at
    for index, shown in enumerate(scene.bodies):
        mine = np.flatnonzero(spheres.body == index)
        colour[mine] = ramp(shown.colour, share[mine])
    return np.take(colour, layers.sphere, axis=0, mode="wrap")


def _lit(scene: Scene, camera: Camera, layers: DepthBuffers) -> _Pixels:
    """The same by light and shade."""
    full = np.array([ramp(shown.colour, np.array(0.9)) for shown in scene.bodies]).reshape(-1, 3)
    surfaces = Surfaces(layers.body_depth, layers.sphere)
    return shade_surfaces(
        projected_disks(scene, camera), surfaces, camera, full[scene.spheres.body]
    ).astype(np.float32)


def _finished(
    picture: _Pixels, scene: Scene, layers: DepthBuffers, width: int, tint: float
) -> Image.Image:
    """The picture with a `tint` where a see-through part is the foremost thing, and with edges
    `width` wide."""
    lines = np.zeros(layers.glass.shape, dtype=np.uint8)
    if scene.environment is not None:
        edges, clear = drawn_edges(scene.environment, layers.camera, layers.cut, seen=layers.seen)
        lines = _line_mask(visible_lines(edges, clear, layers), layers.camera, width)
    out = np.empty(picture.shape, dtype=np.uint8)
    inks = np.array([[*GLASS, tint], [*INK, 1.0]])
    blend_overlays(
        picture, layers.glass, layers.glass_depth, layers.depth, layers.body_depth, lines, inks, out
    )
    return Image.fromarray(out)


def _line_mask(lines: Lines, camera: Camera, width: int) -> NDArray[np.uint8]:
    """(height, width) opacity of edges, drawn from far to near."""
    mask = np.zeros((camera.height, camera.width), dtype=np.uint8)
    order = np.argsort(lines.depth, kind="stable")
    opacity = np.where(lines.faint, 60, 150).astype(np.uint8)
    paint_lines(lines.ends[order].reshape(-1, 4), opacity[order], float(width), mask)
    return mask
