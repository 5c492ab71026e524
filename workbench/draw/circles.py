"""The paper's vector display: every sphere's outline circle, stronger the nearer, as a self-contained SVG text."""

from __future__ import annotations

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, PAPER, hexadecimal
from workbench.draw.edges import drawn_edges, visible_lines
from workbench.draw.scene import Scene
from workbench.draw.svg import environment_paths, page
from workbench.draw.visibility import depth_share, projected_disks, visible_layers

__all__ = ["circles"]


def circles(scene: Scene, camera: Camera) -> str:
    """SVG text of width x height of the camera: environment's edges, then circles back to front, then marks.

    No script, no reference to anything outside; labels are escaped. Of more than 9,000 line pieces the longest stay.
    """
    parts: list[str] = []
    if scene.environment is not None:
        layers = visible_layers(scene, camera)
        edges, clear = drawn_edges(scene.environment, camera, layers.cut)
        parts += environment_paths(visible_lines(edges, clear, layers))
    parts += _circles(scene, camera)
    return page(scene, camera, "the outline circle of every sphere", parts)


def _circles(scene: Scene, camera: Camera) -> list[str]:
    """One circle a sphere. Paper shines through a little less with each circle: what is far sinks back."""
    spheres, flat = scene.spheres, projected_disks(scene, camera)
    share = depth_share(flat.front)
    ink = [np.array(INKS[shown.colour], dtype=np.float64) for shown in scene.bodies]
    parts = [f'<g class="bodies" fill="{hexadecimal(PAPER)}" fill-opacity="0.45">']
    for sphere in flat.order:
        x, y, radius = flat.disk[sphere]
        near = float(share[sphere])
        stroke = np.array(PAPER) + (ink[spheres.body[sphere]] - np.array(PAPER)) * (0.5 + 0.5 * near)
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" stroke="{hexadecimal(stroke)}"'
            f' stroke-width="{0.5 + 0.7 * near:.2f}"/>'
        )
    return [*parts, "</g>"]
