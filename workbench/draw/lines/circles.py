"""The paper's vector display: every sphere's outline circle, stronger the nearer, as a
self-contained SVG text."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, projective_depth
from workbench.draw.colours import INKS, PAPER, hexadecimal
from workbench.draw.kernels.occlusion import hidden_arcs
from workbench.draw.lines.arcs import rim_ellipses, rim_planes
from workbench.draw.lines.hidden_lines import Surroundings, surroundings
from workbench.draw.lines.outline import ghost_paths
from workbench.draw.lines.svg import environment_paths, number_rows, page, section_paths
from workbench.draw.scene import Scene
from workbench.draw.visibility import Disks, depth_share, projected_disks
from workbench.model.arrays import Floats, Ints

__all__ = ["circles", "max_outline_difference"]

_LEVELS = 64  # of depth, as strengths of line


class _Rims(NamedTuple):
    """The outlines of a scene's spheres, back to front: ellipses, circles where they are the
    paper's.

    sphere (K,); disk (K, 3) middle and longer half axis [pixels]; squeeze (K, 2) the shorter as a
    share of it and the direction [rad] of the longer; planes (K, 3): projective depth at the middle
    and its change a pixel right and down.
    """

    sphere: Ints
    disk: Floats
    squeeze: Floats
    planes: Floats


def circles(scene: Scene, camera: Camera, *, exact: bool = False, hidden: str = "veiled") -> str:
    """SVG text of width x height of the camera: environment's edges, then circles back to front,
    then marks.

    exact: in perspective the spheres' true outlines, ellipses, in place of the paper's circles;
    those of spheres that reach beside the eye are none and are left out. The largest difference is
    told in the group's description. hidden: veiled draws what of a circle is behind a wall pale;
    hidden_line leaves it out. No script, no reference to anything outside; labels are escaped. Of
    more than 9,000 line pieces the longest stay.
    """
    walls = surroundings(scene, camera, hidden)
    flat = projected_disks(scene, camera)
    true = exact and math.isfinite(camera.distance)
    rims = _ellipses(flat, camera) if true else _plain(flat, camera)
    shapes = _shapes(rims, true)
    styles = _looks(scene, flat, rims)
    parts = [shape + style for shape, style in zip(shapes, styles, strict=True)]
    if walls is not None:
        for number, path in _cut_rims(rims, true, walls).items():
            pale = f'{parts[number][:-2]} stroke-opacity="0.3"/>' if hidden == "veiled" else ""
            parts[number] = pale + (
                f'<path class="rim" fill="none"{styles[number]}'.replace("/>", f' d="{path}"/>')
                if path
                else ""
            )
    start = f'<g class="bodies" fill="{hexadecimal(PAPER)}" fill-opacity="0.45">'
    shown = [part for part in (_said(flat, camera, true), *parts) if part]
    parts = [*ghost_paths(scene, camera), start, *shown, "</g>"]
    if walls is not None:
        parts = [*environment_paths(walls.lines), *parts, *section_paths(walls.sections, hidden)]
    return page(scene, camera, "the outline circle of every sphere", parts)


def max_outline_difference(disks: Disks, camera: Camera) -> float:
    """[pixels] how far the true outline of any sphere, an ellipse, lies at most from the paper's
    circle; 0 in parallel.

    Of spheres that are drawn and do not reach beside the eye. The ellipse is farthest from the
    circle on the line through the middle of the picture, at its outer end.
    """
    if math.isinf(camera.distance):
        return 0.0
    rims = _ellipses(disks, camera)
    circle = disks.disk[rims.sphere]
    middle = np.array([camera.width, camera.height]) / 2.0
    off = [np.hypot(*(disk[:, :2] - middle).T) for disk in (rims.disk, circle)]
    ends = [off[0] + way * rims.disk[:, 2] - off[1] - way * circle[:, 2] for way in (1.0, -1.0)]
    across = rims.disk[:, 2] * rims.squeeze[:, 0] - circle[:, 2]
    return float(np.max(np.abs([*ends, across]), initial=0.0))


def _said(flat: Disks, camera: Camera, exact: bool) -> str:
    """The largest difference as an element, none in a parallel view, where there is no
    difference."""
    if math.isinf(camera.distance):
        return ""
    apart = f"{max_outline_difference(flat, camera):.1f} pixels"
    told = (
        f"True outlines, ellipses; at most {apart} from circles about the centres"
        if exact
        else f"Circles about the centres; at most {apart} from the true outlines, ellipses"
    )
    return f"<desc>{told}</desc>"


def _plain(flat: Disks, camera: Camera) -> _Rims:
    """The paper's circles."""
    order = flat.order
    zero = np.zeros(len(flat.order))
    depth = projective_depth(camera, flat.centre[order])
    return _Rims(
        order,
        flat.disk[order],
        np.column_stack([zero + 1.0, zero]),
        np.column_stack([depth, zero, zero]),
    )


def _ellipses(flat: Disks, camera: Camera) -> _Rims:
    """The true outlines in perspective, of what does not reach beside the eye or the nearest
    plane."""
    balls = flat.view[flat.order] * [1.0, -1.0, -1.0, 1.0] + [0.0, 0.0, camera.distance, 0.0]
    ahead = balls[:, 2] - balls[:, 3] > camera.distance - camera.nearest
    balls = balls[ahead]
    order = flat.order[ahead]
    disk, squeeze = rim_ellipses(camera, balls)
    tangent = np.sqrt(np.sum(balls[:, :3] ** 2, axis=1) - balls[:, 3] ** 2)
    depth, tilt = rim_planes(camera, balls[:, :3], tangent, disk)
    return _Rims(order, disk, squeeze, np.column_stack([depth, tilt]))


def _shapes(rims: _Rims, exact: bool) -> list[str]:
    """The beginning of one element a rim."""
    if not exact:
        return number_rows('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}"', rims.disk)
    x, y, longer = rims.disk.T
    turn = np.degrees(rims.squeeze[:, 1])
    pattern = '<ellipse cx="{:.1f}" cy="{:.1f}" rx="{:.1f}" ry="{:.1f}" transform="rotate({:.1f} {:.1f} {:.1f})"'
    return number_rows(
        pattern, np.column_stack([x, y, longer, longer * rims.squeeze[:, 0], turn, x, y])
    )


def _looks(scene: Scene, flat: Disks, rims: _Rims) -> list[str]:
    """The line of each rim, by its sphere's depth, and the end of its element."""
    level = (
        np.round(depth_share(flat.front) * (_LEVELS - 1)).astype(np.int64)
        + _LEVELS * scene.spheres.body
    )
    styles = [text for shown in scene.bodies for text in _styles(shown.colour)]
    return [styles[k] for k in level[rims.sphere].tolist()]


def _styles(colour: str) -> list[str]:
    """How the line looks in each level of depth, far to near, and the end of the element."""
    paper = np.array(PAPER, dtype=np.float64)
    ink = np.array(INKS[colour], dtype=np.float64)
    near = np.linspace(0.0, 1.0, _LEVELS)
    strokes = paper + (ink - paper) * (0.5 + 0.5 * near[:, None])
    return [
        f' stroke="{hexadecimal(stroke)}" stroke-width="{0.5 + 0.7 * share:.2f}"/>'
        for stroke, share in zip(strokes, near, strict=True)
    ]


def _cut_rims(rims: _Rims, exact: bool, walls: Surroundings) -> dict[int, str]:
    """Of the rims, by number, that a polygon hides in part or whole: path commands of what is
    seen."""
    ratio, turn = rims.squeeze.T
    along = np.column_stack([np.cos(turn), np.sin(turn)]) * rims.disk[:, 2:]
    across = np.column_stack([-np.sin(turn), np.cos(turn)]) * (rims.disk[:, 2] * ratio)[:, None]
    depths = [rims.planes[:, 0]] + [
        np.sum(rims.planes[:, 1:] * way, axis=1) for way in (along, across)
    ]
    columns = zip((rims.disk[:, :2], along, across), depths, strict=True)
    frames = np.stack([np.column_stack(column) for column in columns], axis=1)
    of, angle, behind = hidden_arcs(
        frames, np.tile([0.0, 2.0 * math.pi], (len(frames), 1)), walls.hiders
    )
    found: dict[int, str] = {}
    for row in np.flatnonzero(np.isin(of, of[behind == 1])):
        number = int(of[row])
        seen = "" if behind[row] else _arc(frames[number], rims, number, angle[row].tolist())
        found[number] = found.get(number, "") + seen
    return found


def _arc(frame: Floats, rims: _Rims, number: int, angle: list[float]) -> str:
    """Path commands of an arc, in two halves: an arc of near a whole turn is ill-determined by its
    ends."""
    ends = (angle[0], (angle[0] + angle[1]) / 2.0, angle[1])
    turns = np.array([[1.0, math.cos(turn), math.sin(turn)] for turn in ends])
    (a, b), (c, d), (e, f) = (turns @ frame[:, :2]).tolist()
    longer = rims.disk[number, 2]
    shorter = rims.disk[number, 2] * rims.squeeze[number, 0]
    round_ = f"A{longer:.1f} {shorter:.1f} {math.degrees(rims.squeeze[number, 1]):.4g} 0 1"
    return f"M{a:.1f} {b:.1f}{round_} {c:.1f} {d:.1f}{round_} {e:.1f} {f:.1f}"
