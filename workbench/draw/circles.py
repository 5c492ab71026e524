"""The paper's vector display: every sphere's outline circle, stronger the nearer, as a self-contained SVG text."""

from __future__ import annotations

import math

import numpy as np

from workbench.draw.arcs import rim_ellipses
from workbench.draw.camera import Camera, projective
from workbench.draw.colours import INKS, PAPER, hexadecimal
from workbench.draw.hiding import Surroundings, surroundings
from workbench.draw.outline import ghost_paths
from workbench.draw.scene import Scene
from workbench.draw.svg import environment_paths, page, section_paths
from workbench.draw.visibility import Disks, depth_share, projected_disks
from workbench.kernels.hiding import hidden_arcs

__all__ = ["circles"]

_LEVELS = 64  # of depth, as strengths of line


def circles(scene: Scene, camera: Camera, *, exact: bool = False, hidden: str = "veiled") -> str:
    """SVG text of width x height of the camera: environment's edges, then circles back to front, then marks.

    exact: in perspective the spheres' true outlines, ellipses, in place of the paper's circles; those of spheres that
    reach beside the eye are none and are left out, and walls do not cut them. hidden: veiled draws what of a circle is
    behind a wall pale; hidden_line leaves it out. No script, no reference to anything outside; labels are escaped.
    Of more than 9,000 line pieces the longest stay.
    """
    walls = surroundings(scene, camera, hidden)
    parts = [*ghost_paths(scene, camera), *_circles(scene, camera, exact and math.isfinite(camera.distance))]
    if walls is not None:
        parts = _behind_walls(parts, _cut_circles(projected_disks(scene, camera), camera, walls), exact, hidden)
        parts = [*environment_paths(walls.lines), *parts, *section_paths(walls.sections, hidden)]
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


def _cut_circles(flat: Disks, camera: Camera, walls: Surroundings) -> dict[int, str]:
    """Of the circles, by their number back to front, that a polygon hides in part or whole: a path of what is seen."""
    disk, zero = flat.disk[flat.order], np.zeros(len(flat.order))
    middle = np.column_stack([disk[:, :2], projective(camera, flat.centre[flat.order])])
    rims = np.stack([middle, np.column_stack([disk[:, 2], zero, zero]), np.column_stack([zero, disk[:, 2], zero])], 1)
    of, angle, behind = hidden_arcs(rims, np.tile([0.0, 2.0 * math.pi], (len(rims), 1)), walls.hiders)
    found: dict[int, str] = {}
    for row in np.flatnonzero(np.isin(of, of[behind == 1])):
        number = int(of[row])
        seen = "" if behind[row] else _arc(disk[number].tolist(), *angle[row].tolist())
        found[number] = found.get(number, "") + seen
    return found


def _arc(disk: list[float], low: float, high: float) -> str:
    """Path commands of an arc, in two halves: an arc of near a whole turn is ill-determined by its ends."""
    x, y, radius = disk
    (a, b), (c, d), (e, f) = (
        (x + radius * math.cos(turn), y + radius * math.sin(turn)) for turn in (low, (low + high) / 2.0, high)
    )
    round_ = f"A{radius:.1f} {radius:.1f} 0 0 1"
    return f"M{a:.1f} {b:.1f}{round_} {c:.1f} {d:.1f}{round_} {e:.1f} {f:.1f}"


def _behind_walls(parts: list[str], cut: dict[int, str], exact: bool, hidden: str) -> list[str]:
    """The drawn circles, with those of `cut` made pale or taken out, and their visible arcs in their place."""
    if exact or not cut:
        return parts
    first = next(k for k, part in enumerate(parts) if part.startswith('<g class="bodies"')) + 1
    found = list(parts)
    for number, path in cut.items():
        circle = parts[first + number]
        style = circle[circle.index(" stroke=") : -2]
        pale = f'{circle[:-2]} stroke-opacity="0.3"/>' if hidden == "veiled" else ""
        found[first + number] = pale + (f'<path class="rim" fill="none"{style} d="{path}"/>' if path else "")
    return [part for part in found if part]
