"""The paper's vector display: every sphere's outline circle, stronger the nearer, as a self-contained SVG text."""

from __future__ import annotations

from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, PAPER, hexadecimal
from workbench.draw.edges import Lines, drawn_edges, visible_lines
from workbench.draw.mark_pictures import svg_bar, svg_marks
from workbench.draw.scene import Scene
from workbench.draw.visibility import depth_share, projected_disks, visible_layers

__all__ = ["circles"]

_MOST_LINES = 9000  # keeps a picture under 400 kB


def circles(scene: Scene, camera: Camera) -> str:
    """SVG text of width x height of the camera: environment's edges, then circles back to front, then marks.

    No script, no reference to anything outside; labels are escaped. Of more than 9,000 line pieces the longest stay.
    """
    width, height = camera.width, camera.height
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
        ' role="img">',
        f"<title>{escape(scene.title)}</title>",
        f"<desc>{escape(scene.description or _description(scene, camera))}</desc>",
        f'<rect width="{width}" height="{height}" fill="{hexadecimal(PAPER)}"/>',
    ]
    if scene.environment is not None:
        layers = visible_layers(scene, camera)
        edges, clear = drawn_edges(scene.environment, camera, layers.cut)
        parts += _lines(visible_lines(edges, clear, layers))
    parts += [*_circles(scene, camera), *svg_marks(scene, camera), *svg_bar(camera), "</svg>", ""]
    return "\n".join(parts)


def _description(scene: Scene, camera: Camera) -> str:
    """What a reader who cannot see the picture should know."""
    where = f" in {scene.environment.name}" if scene.environment is not None else ""
    names = ", ".join(shown.placed.body.name for shown in scene.bodies) or "no body"
    view = camera.name.replace("_", "-")
    return f"{names}{where}, {view} view: the outline circle of every sphere; {len(scene.marks)} points marked."


def _lines(lines: Lines) -> list[str]:
    """Two paths, plain and faint lines."""
    length = np.linalg.norm(lines.ends[:, 1] - lines.ends[:, 0], axis=1)
    kept = np.sort(np.argsort(-length, kind="stable")[:_MOST_LINES])
    parts = ['<g class="environment" fill="none" stroke-linecap="round" stroke="#8d99a8">']
    for faint, style in ((True, 'stroke-width="0.6" stroke-opacity="0.45"'), (False, 'stroke-width="0.8"')):
        chosen = kept[lines.faint[kept] == faint]
        pieces = [f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}" for (a, b), (c, d) in lines.ends[chosen]]
        if pieces:
            parts.append(f'<path {style} d="{"".join(pieces)}"/>')
    return [*parts, "</g>"]


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
