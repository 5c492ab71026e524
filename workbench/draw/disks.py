"""The paper's raster display: every sphere a solid disk of one shade by depth, painted back to front.

Around the bodies stands the environment, flat shaded and pale, with dark edges. What stands in front of a body
is a veil over it, what stands nearer than every body is cut away (see visibility).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from workbench.draw.camera import Camera, facing
from workbench.draw.colours import GLASS, INK, PAPER, SECTION, ramp
from workbench.draw.edges import Lines, drawn_edges, visible_lines
from workbench.draw.frames import Surfaces, shaded
from workbench.draw.ghosts import paint_ghosts
from workbench.draw.mark_pictures import paint_mark_shapes, paint_mark_texts
from workbench.draw.scene import Scene
from workbench.draw.visibility import Layers, depth_share, projected_disks, triangle_polygons, visible_layers
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Bools
from workbench.model.environment import Environment

__all__ = ["MODES", "POLYGONS", "disks"]

MODES = ("flat", "shaded", "depth", "id")
POLYGONS = ("shaded", "hidden_line")

_Pixels = NDArray[np.float32]

_JUMP = 0.03  # [m] a step in depth that is drawn as an outline within a body
_LIGHT = np.array([-0.35, 0.62, 0.70])  # right, up, toward: over the viewer's left shoulder
_WALL_DARK, _WALL_LIGHT = np.array([190.0, 197.0, 206.0]), np.array([244.0, 246.0, 248.0])


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

    mode: one of MODES. flat: the paper's, one shade a sphere; shaded: light and intersections pixel by pixel; depth:
    grey (L), 255 nearest to 1 farthest, 0 nothing; id: the number of the sphere + 1 in 24 bits of red, green and blue,
    0 for none (see `frames.sphere_at` for names). exact: the true outlines of spheres in perspective, not the paper's
    circles; all modes but flat are exact. polygons: one of POLYGONS; hidden_line: edges only, which hide one another.
    supersample: pixels drawn each way for one of the picture, for flat and shaded. veil: opacity, 0 to 1, of what is
    in front of a body; with 1 it hides the body.
    """
    if mode not in MODES or polygons not in POLYGONS:
        raise UsageError(f"no mode {mode!r}; {one_of(mode, MODES)}" if mode not in MODES else
                         f"no style of polygons {polygons!r}; {one_of(polygons, POLYGONS)}")  # fmt: skip
    if mode in ("depth", "id"):
        return _measured(scene, camera, mode)
    fine = camera.enlarged(supersample)
    layers = visible_layers(scene, fine, spheres="surfaces" if mode == "shaded" else "exact" if exact else "painted")
    picture: _Pixels = np.full((fine.height, fine.width, 3), PAPER, dtype=np.float32)
    if scene.environment is not None and polygons == "shaded":
        _paint_environment(picture, scene.environment, fine, layers)
    body = _lit(scene, fine, layers) if mode == "shaded" else _flat(scene, fine, layers)
    _paint_bodies(picture, body, layers, _outline(layers, supersample), veil)
    paint_ghosts(picture, scene, fine, layers, supersample)
    if scene.environment is not None:
        if polygons == "shaded":
            _paint_glass(picture, layers)
        edges, clear = drawn_edges(scene.environment, fine, layers.cut)
        _paint_lines(picture, visible_lines(edges, clear, layers), supersample)
    image = Image.fromarray(np.round(picture).astype(np.uint8))
    paint_mark_shapes(image, scene, camera, supersample)
    if supersample > 1:
        image = image.resize((camera.width, camera.height), Image.Resampling.BOX)
    paint_mark_texts(image, scene, camera)
    return image


def _measured(scene: Scene, camera: Camera, mode: str) -> Image.Image:
    """The pictures that are data: depth or numbers of spheres."""
    layers = visible_layers(scene, camera, spheres="surfaces")
    if mode == "id":
        number = layers.sphere + 1
        return Image.fromarray(np.stack([number >> 16, number >> 8 & 255, number & 255], axis=-1).astype(np.uint8))
    depth = np.maximum(layers.depth, layers.body_depth)
    there = np.isfinite(depth)
    grey = np.zeros(depth.shape, dtype=np.uint8)
    grey[there] = np.round(1.0 + 254.0 * depth_share(depth[there]))
    return Image.fromarray(grey)


def _paint_environment(picture: _Pixels, environment: Environment, camera: Camera, layers: Layers) -> None:
    """Flat shade by the polygon's normal, either side alike; paler with distance; cut faces in one plain tint."""
    light = _LIGHT @ np.array([camera.right, camera.up, camera.toward])
    polygon = triangle_polygons(environment)
    side = np.where(facing(camera, environment.normal, environment.offset) < 0, -1.0, 1.0)
    lit = np.clip((environment.normal @ light) * side / np.linalg.norm(light), 0.0, 1.0)[polygon, None]
    colour = (_WALL_DARK + (_WALL_LIGHT - _WALL_DARK) * lit).astype(np.float32)
    colour = np.concatenate([colour, np.array([PAPER], dtype=np.float32)])  # the last one, found by -1: nothing here
    np.take(colour, layers.triangle, axis=0, out=picture, mode="wrap")
    picture += (np.float32(255.0) - picture) * _fade(layers)[..., None]
    picture[layers.section] = SECTION


def _fade(layers: Layers) -> _Pixels:
    """How far the environment has faded into the paper: 0 as far as the bodies reach, more beyond."""
    body = layers.body_depth[layers.sphere >= 0]
    if not len(body):
        return np.zeros(layers.depth.shape, dtype=np.float32)
    near = float(body.min())
    return np.clip((near - layers.depth) / 1.5, 0.0, 1.0).astype(np.float32) * np.float32(0.6)


def _flat(scene: Scene, camera: Camera, layers: Layers) -> _Pixels:
    """Colours (K, 3) of the K body pixels in turn: one shade a sphere, by its depth."""
    spheres = scene.spheres
    share = depth_share(projected_disks(scene, camera).front)
    colour = np.zeros((len(share), 3), dtype=np.float32)
    for index, shown in enumerate(scene.bodies):
        mine = spheres.body == index
        colour[mine] = ramp(shown.colour, share[mine])
    return colour[layers.sphere[layers.sphere >= 0]]


def _lit(scene: Scene, camera: Camera, layers: Layers) -> _Pixels:
    """The same by light and shade."""
    full = np.array([ramp(shown.colour, np.array(0.9)) for shown in scene.bodies]).reshape(-1, 3)
    surfaces = Surfaces(layers.body_depth, layers.sphere.astype(np.int32))
    picture = shaded(projected_disks(scene, camera), surfaces, camera, full[scene.spheres.body])
    return picture[layers.sphere >= 0].astype(np.float32)


def _paint_bodies(picture: _Pixels, body: _Pixels, layers: Layers, outline: Bools, veil: float) -> None:
    """The body pixels' colours (K, 3), a darker line at the outline, a veil of what stands in front."""
    here = layers.sphere >= 0
    body[outline[here]] *= 0.42
    front = layers.veiled[here][:, None] * np.float32(veil)
    picture[here] = picture[here] * front + body * (1 - front)


def _outline(layers: Layers, width: int) -> Bools:
    """Body pixels near one that lies more than _JUMP farther: a silhouette, or a limb before the trunk.

    width: of the line [pixels of the layers].
    """
    depth = layers.body_depth
    found = np.zeros(depth.shape, dtype=np.bool_)
    for step in range(1, width + 1):
        with np.errstate(invalid="ignore"):  # background minus background
            down, across = depth[step:] - depth[:-step], depth[:, step:] - depth[:, :-step]
        found[step:] |= down > _JUMP
        found[:-step] |= down < -_JUMP
        found[:, step:] |= across > _JUMP
        found[:, :-step] |= across < -_JUMP
    return found


def _paint_glass(picture: _Pixels, layers: Layers) -> None:
    """A thin tint where a see-through part is the foremost thing."""
    foremost = np.maximum(layers.depth, layers.body_depth)
    tinted = (layers.glass >= 0) & (layers.glass_depth > foremost)
    share = tinted.astype(np.float32)[..., None] * np.float32(0.1)
    picture += (np.array(GLASS, dtype=np.float32) - picture) * share


def _paint_lines(picture: _Pixels, lines: Lines, supersample: int) -> None:
    """Edges in ink through a mask of opacities, far to near."""
    mask = Image.new("L", (picture.shape[1], picture.shape[0]), 0)
    draw = ImageDraw.Draw(mask)
    opacity = np.where(lines.faint, 60, 150)
    for index in np.argsort(lines.depth, kind="stable"):
        (x, y), (u, v) = lines.ends[index]
        draw.line((float(x), float(y), float(u), float(v)), fill=int(opacity[index]), width=max(1, supersample))
    strength = np.asarray(mask, dtype=np.float32)[..., None] / np.float32(255.0)
    picture += (np.array(INK, dtype=np.float32) - picture) * strength
