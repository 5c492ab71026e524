"""The paper's vector display: every sphere's outline circle, stronger the nearer, as a self-contained SVG text."""

from __future__ import annotations

import math

import numpy as np

from workbench.draw.arcs import rim_ellipses
from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, PAPER, hexadecimal
from workbench.draw.edges import drawn_edges, visible_lines
from workbench.draw.scene import Scene
from workbench.draw.svg import environment_paths, page
from workbench.draw.visibility import depth_share, projected_disks, visible_layers

__all__ = ["circles"]

_LEVELS = 64  # of depth, as strengths of line


def circles(scene: Scene, camera: Camera, *, exact: bool = False) -> str:
    """SVG text of width x height of the camera: environment's edges, then circles back to front, then marks.

    exact: in perspective the spheres' true outlines, ellipses, in place of the paper's circles; those of spheres that
    reach beside the eye are none and are left out. No script, no reference to anything outside; labels are escaped.
    Of more than 9,000 line pieces the longest stay.
    """
    parts: list[str] = []
    if scene.environment is not None:
        layers = visible_layers(scene, camera)
        edges, clear = drawn_edges(scene.environment, camera, layers.cut)
        parts += environment_paths(visible_lines(edges, clear, layers))
    parts += _circles(scene, camera, exact and math.isfinite(camera.distance))
    return page(scene, camera, "the outline circle of every sphere", parts)


def _circles(scene: Scene, camera: Camera, exact: bool) -> list[str]:
    """One shape a sphere. Paper shines through a little less with each: what is far sinks back."""
    flat, spheres = projected_disks(scene, camera), scene.spheres
    level = np.round(depth_share(flat.front) * (_LEVELS - 1)).astype(np.int64) + _LEVELS * spheres.body
    style = [text for shown in scene.bodies for text in _styles(shown.colour)]
    start = f'<g class="bodies" fill="{hexadecimal(PAPER)}" fill-opacity="0.45">'
    order = flat.order
    if not exact:
        rows = np.round(flat.disk[order], 1).tolist()
        drawn = [
            f'<circle cx="{x}" cy="{y}" r="{r}"{style[k]}'
            for (x, y, r), k in zip(rows, level[order].tolist(), strict=True)
        ]
        return [start, *drawn, "</g>"]
    balls = flat.view[order] * [1.0, -1.0, -1.0, 1.0] + [0.0, 0.0, camera.distance, 0.0]
    disk, squeeze = rim_ellipses(camera, balls)
    turn, rows = np.degrees(squeeze[:, 1]), np.round(np.column_stack([disk, disk[:, 2] * squeeze[:, 0]]), 1)
    ahead = np.flatnonzero(balls[:, 2] - balls[:, 3] > camera.distance - camera.nearest).tolist()
    table = np.column_stack([rows, np.round(turn, 1)]).tolist()
    ellipses = []
    for k in ahead:
        x, y, a, b, angle = table[k]
        place = f'cx="{x}" cy="{y}" rx="{a}" ry="{b}" transform="rotate({angle} {x} {y})"'
        ellipses.append(f"<ellipse {place}{style[level[order[k]]]}")
    return [start, *ellipses, "</g>"]


def _styles(colour: str) -> list[str]:
    """How the line looks in each level of depth, far to near, and the end of the element."""
    paper, ink = np.array(PAPER, dtype=np.float64), np.array(INKS[colour], dtype=np.float64)
    near = np.linspace(0.0, 1.0, _LEVELS)
    strokes = paper + (ink - paper) * (0.5 + 0.5 * near[:, None])
    return [
        f' stroke="{hexadecimal(stroke)}" stroke-width="{0.5 + 0.7 * share:.2f}"/>'
        for stroke, share in zip(strokes, near, strict=True)
    ]
