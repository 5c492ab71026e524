"""Draw the paper's raster display: every sphere a solid disk of one shade by its depth.

The painter's algorithm draws disks back to front. The environment around the bodies is pale and
flat shaded, with dark edges. What stands in front of a body is drawn as a veil over it; what stands
nearer than every body is cut away (see `visibility`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from workbench.draw.camera import Camera, facing
from workbench.draw.kernels.compositing import (
    SolidLayers,
    blend_overlays,
    compose_solids,
    darken_rims,
)
from workbench.draw.lines.edges import Lines, drawn_edges, paint_lines, visible_lines
from workbench.draw.marks.pictures import paint_mark_shapes, paint_mark_texts
from workbench.draw.scene import GLASS, INK, INKS, PAPER, SECTION, Scene, ramp
from workbench.draw.sphere_raster import LIGHT, Surfaces, shade_surfaces
from workbench.draw.visibility import (
    DepthBuffers,
    depth_share,
    projected_disks,
    render_buffers,
    triangle_polygons,
)
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment

__all__ = ["MODES", "POLYGONS", "disks", "ghost_strengths", "paint_overlays"]

MODES = ("flat", "shaded", "depth", "id")
"""How bodies are drawn, see `disks`."""
POLYGONS = ("shaded", "hidden_line")
"""How the environment is drawn, see `disks`."""

_Pixels = NDArray[np.float32]

_RIM_DARKNESS = 0.42
"""Share of the light that an outline takes away."""
_RIM_STEP = 0.03
"""Step of depth [m] within a body that is drawn as an outline."""
_WALL_DARK = np.array([190.0, 197.0, 206.0])
"""Colour of walls that face away from the light."""
_WALL_LIGHT = np.array([244.0, 246.0, 248.0])
"""Colour of walls that face the light."""
_FADE_LENGTH = 1.5
"""Distance [m] behind the bodies over which walls fade into the paper."""
_FADE_SHARE = 0.6
"""Largest share of paper in the colour of a wall."""
_GLASS_TINT = 0.1
"""Opacity of see-through parts."""
_FAINT_OPACITY = 60
_EDGE_OPACITY = 150
"""Opacity of edges, 0 to 255."""


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
    """Draw a scene in pixels, in the size of the camera. The bytes are the same each time.

    Parameters
    ----------
    scene, camera
        What is drawn, and from where.
    mode
        flat: one shade for each sphere, as in the paper. shaded: light and intersections for each
        pixel. depth: grey (L), 255 nearest to 1 farthest, 0 for nothing. id: number of the sphere
        + 1 in 24 bits of red, green and blue, 0 for none.
    exact
        Whether perspective shows the true outlines, ellipses, in place of the paper's circles. All
        modes but flat are exact.
    polygons
        shaded, or hidden_line: edges only, which hide one another.
    supersample
        Pixels drawn each way for one of the picture, in the modes flat and shaded.
    veil
        Opacity, 0 to 1, of what is in front of a body; with 1 it hides the body.

    Raises
    ------
    UsageError
        If there is no such mode or style of polygons.
    """
    if mode not in MODES:
        raise UsageError(f"no mode {mode!r}; {one_of(mode, MODES)}")
    if polygons not in POLYGONS:
        raise UsageError(f"no style of polygons {polygons!r}; {one_of(polygons, POLYGONS)}")
    if mode in ("depth", "id"):
        return _data_image(scene, camera, mode)
    fine = camera.enlarged(supersample)
    spheres = "surfaces" if mode == "shaded" else "exact" if exact else "painted"
    buffers = render_buffers(scene, fine, spheres=spheres)
    bodies = _shaded_bodies(scene, buffers) if mode == "shaded" else _flat_bodies(scene, buffers)
    darken_rims(bodies, buffers.body_depth, supersample, _RIM_STEP, _RIM_DARKNESS)
    filled = polygons == "shaded"
    picture = _with_walls(bodies, scene.environment if filled else None, buffers, veil)
    paint_overlays(picture, scene, fine, buffers, supersample)
    tint = _GLASS_TINT if filled else 0.0
    image = _with_glass_and_edges(picture, scene, buffers, supersample, tint)
    paint_mark_shapes(image, scene, camera, supersample)
    if supersample > 1:
        image = image.resize((camera.width, camera.height), Image.Resampling.BOX)
    paint_mark_texts(image, scene, camera)
    return image


def _data_image(scene: Scene, camera: Camera, mode: str) -> Image.Image:
    """Draw depth or sphere numbers."""
    buffers = render_buffers(scene, camera, spheres="surfaces")
    if mode == "id":
        number = buffers.sphere + 1
        return Image.fromarray(
            np.stack([number >> 16, number >> 8 & 255, number & 255], axis=-1).astype(np.uint8)
        )
    depth = np.maximum(buffers.depth, buffers.body_depth)
    filled = np.isfinite(depth)
    grey = np.zeros(depth.shape, dtype=np.uint8)
    grey[filled] = np.round(1.0 + 254.0 * depth_share(depth[filled]))
    return Image.fromarray(grey)


def _flat_bodies(scene: Scene, buffers: DepthBuffers) -> _Pixels:
    """Colour the bodies (height, width, 3) with one shade for each sphere, by its depth."""
    spheres = scene.spheres
    share = depth_share(projected_disks(scene, buffers.camera).front)
    colour = np.zeros((len(share) + 1, 3), dtype=np.float32)  # the last one, for -1, is not used
    for index, shown in enumerate(scene.bodies):
        own = np.flatnonzero(spheres.body == index)
        colour[own] = ramp(shown.colour, share[own])
    return np.take(colour, buffers.sphere, axis=0, mode="wrap")


def _shaded_bodies(scene: Scene, buffers: DepthBuffers) -> _Pixels:
    """Colour the bodies (height, width, 3) by light and shade."""
    full = np.array([ramp(shown.colour, np.array(0.9)) for shown in scene.bodies]).reshape(-1, 3)
    surfaces = Surfaces(buffers.body_depth, buffers.sphere)
    camera = buffers.camera
    flat = projected_disks(scene, camera)
    shaded = shade_surfaces(flat, surfaces, camera, full[scene.spheres.body])
    return shaded.astype(np.float32)


def _with_walls(
    bodies: _Pixels, environment: Environment | None, buffers: DepthBuffers, veil: float
) -> _Pixels:
    """Compose bodies and walls; without an environment the walls are left out.

    Walls fade into the paper from where the bodies end.
    """
    triangle = buffers.triangle
    section = buffers.section
    colour = np.empty((0, 3))
    if environment is None:
        triangle = np.full_like(triangle, -1)
        section = np.zeros_like(section)
    else:
        colour = _wall_colours(environment, buffers.camera)
    body_depth = buffers.body_depth[buffers.sphere >= 0]
    fade_start = float(body_depth.min()) if len(body_depth) else -np.inf
    picture: _Pixels = np.empty_like(bodies)
    compose_solids(
        np.concatenate([colour, [SECTION, PAPER]]),
        bodies,
        SolidLayers(triangle, buffers.depth, section, buffers.sphere, buffers.body_depth),
        np.array([fade_start, _FADE_LENGTH, _FADE_SHARE]),
        veil,
        picture,
    )
    return picture


def _wall_colours(environment: Environment, camera: Camera) -> Floats:
    """Return the flat shade (T, 3) of each triangle, the same for both of its sides."""
    light = LIGHT @ np.array([camera.right, camera.up, camera.toward])
    side = np.where(facing(camera, environment.normal, environment.offset) < 0, -1.0, 1.0)
    cosine = (environment.normal @ light) * side / np.linalg.norm(light)
    shade = np.clip(cosine, 0.0, 1.0)[:, None]
    colour: Floats = _WALL_DARK + (_WALL_LIGHT - _WALL_DARK) * shade
    return colour[triangle_polygons(environment)]


def _with_glass_and_edges(
    picture: _Pixels, scene: Scene, buffers: DepthBuffers, width: int, tint: float
) -> Image.Image:
    """Tint the picture where a see-through part is foremost, and draw edges `width` pixels wide."""
    edge_mask = np.zeros(buffers.glass.shape, dtype=np.uint8)
    if scene.environment is not None:
        edges, see_through = drawn_edges(
            scene.environment, buffers.camera, buffers.cut, seen=buffers.seen
        )
        edge_mask = _line_mask(visible_lines(edges, see_through, buffers), buffers.camera, width)
    blended = np.empty(picture.shape, dtype=np.uint8)
    blend_overlays(
        picture,
        buffers.glass,
        buffers.glass_depth,
        buffers.depth,
        buffers.body_depth,
        edge_mask,
        np.array([[*GLASS, tint], [*INK, 1.0]]),
        blended,
    )
    return Image.fromarray(blended)


def _line_mask(lines: Lines, camera: Camera, width: int) -> NDArray[np.uint8]:
    """Return the opacity (height, width) of edges, drawn from far to near."""
    mask = np.zeros((camera.height, camera.width), dtype=np.uint8)
    order = np.argsort(lines.depth, kind="stable")
    opacity = np.where(lines.faint, _FAINT_OPACITY, _EDGE_OPACITY).astype(np.uint8)
    paint_lines(lines.ends[order].reshape(-1, 4), opacity[order], float(width), mask)
    return mask


# Paint ghosts: bodies shown pale behind all others.
#
# Ghosts are earlier frames of a motion, or a measurement behind a prediction. They hide nothing, and
# every body hides them. Later ghosts are stronger.

_MIN_STRENGTH = 0.25
_MAX_STRENGTH = 0.55
_STRENGTH_BEHIND_WALL = 0.4
"""Share of its strength that a ghost keeps behind a wall."""


def ghost_strengths(scene: Scene) -> Floats:
    """Return the opacity (G,) of each ghost, 0 to 1.

    Ghosts with the same pose number are alike. Later poses are stronger.
    """
    poses, step = np.unique([shown.pose for shown in scene.ghosts], return_inverse=True)
    if len(poses) < 2:
        return np.full(len(scene.ghosts), _MAX_STRENGTH)
    return np.linspace(_MIN_STRENGTH, _MAX_STRENGTH, len(poses))[step]


def paint_overlays(
    picture: NDArray[np.float32], scene: Scene, camera: Camera, buffers: DepthBuffers, line: int
) -> None:
    """Blend the ghosts of a scene into its picture.

    Parameters
    ----------
    picture
        (height, width, 3) of 0 to 255, with environment and bodies; changed in place.
    scene, camera, buffers
        The scene, its camera, and its depth buffers.
    line
        Width of an outline [pixels].
    """
    free = buffers.sphere < 0
    for shown, strength in zip(scene.ghosts, ghost_strengths(scene).tolist(), strict=True):
        alone = Scene((shown,))
        own = render_buffers(alone, camera)
        here = (own.sphere >= 0) & free
        colour = ramp(shown.colour, depth_share(projected_disks(alone, camera).front))[
            own.sphere[here]
        ]
        colour[_border(own.sphere >= 0, line)[here]] = INKS[shown.colour]
        behind_wall = buffers.depth[here] > own.body_depth[here]
        opacity = np.where(behind_wall, _STRENGTH_BEHIND_WALL * strength, strength)[:, None]
        picture[here] = picture[here] * (1.0 - opacity) + colour * opacity


def _border(mask: Bools, width: int) -> Bools:
    """Return the pixels of a mask within `width` pixels of its border, along rows and columns."""
    inner = mask.copy()
    for step in range(1, width + 1):
        inner[step:] &= mask[:-step]
        inner[:-step] &= mask[step:]
        inner[:, step:] &= mask[:, :-step]
        inner[:, :-step] &= mask[:, step:]
    return mask & ~inner
