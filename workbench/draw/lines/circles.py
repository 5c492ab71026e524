"""Draw the paper's vector display as SVG: the outline circle of every sphere, stronger the nearer."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, projective_depth
from workbench.draw.lines.arcs import rim_ellipses, rim_planes
from workbench.draw.lines.hidden_lines import DrawnSolids, ellipse_frames, surroundings
from workbench.draw.lines.occlusion import hidden_arcs
from workbench.draw.lines.outline import ghost_paths
from workbench.draw.lines.svg import environment_paths, number_rows, page, section_paths
from workbench.draw.scene import INKS, PAPER, Scene, hexadecimal
from workbench.draw.visibility import Disks, depth_share, projected_disks
from workbench.model.arrays import Floats, Ints

__all__ = ["circles", "max_outline_difference"]

_STRENGTH_LEVELS = 64
"""Number of strengths of line, from far to near."""


class _Rims(NamedTuple):
    """Outlines of spheres, back to front: ellipses, or the paper's circles."""

    sphere: Ints
    """(K,)."""
    disk: Floats
    """(K, 3) middle and longer half axis [pixels]."""
    squeeze: Floats
    """(K, 2) shorter half axis as a share of the longer, and direction [rad] of the longer."""
    depth: Floats
    """(K,) projective depth at the middle."""
    tilt: Floats
    """(K, 2) change of the projective depth per pixel right and down."""


def circles(scene: Scene, camera: Camera, *, exact: bool = False, hidden: str = "veiled") -> str:
    """Draw a scene: edges of the environment, then circles back to front, then marks.

    The text holds no script and no reference to anything outside; labels are escaped. Of more than
    9,000 pieces of lines the longest stay.

    Parameters
    ----------
    scene, camera
        What is drawn, and from where.
    exact
        Whether perspective shows the true outlines, ellipses, in place of the paper's circles.
        Spheres that reach beside the eye have none and are left out. The description of the group
        gives the largest difference.
    hidden
        veiled: what of a circle is behind a wall is pale. hidden_line: it is left out.

    Returns
    -------
    str
        SVG text in the size of the camera.
    """
    walls = surroundings(scene, camera, hidden)
    disks = projected_disks(scene, camera)
    true_outlines = exact and math.isfinite(camera.distance)
    rims = _true_rims(disks, camera) if true_outlines else _paper_rims(disks, camera)
    shapes = _rim_shapes(rims, true_outlines)
    styles = _rim_styles(scene, disks, rims)
    elements = [shape + style for shape, style in zip(shapes, styles, strict=True)]
    if walls is not None:
        for number, path in _partly_hidden_rims(rims, walls).items():
            pale = f'{elements[number][:-2]} stroke-opacity="0.3"/>' if hidden == "veiled" else ""
            style = styles[number].replace("/>", f' d="{path}"/>')
            elements[number] = pale + (f'<path class="rim" fill="none"{style}' if path else "")
    parts = [
        *ghost_paths(scene, camera),
        f'<g class="bodies" fill="{hexadecimal(PAPER)}" fill-opacity="0.45">',
        *_difference_note(disks, camera, true_outlines),
        *(element for element in elements if element),
        "</g>",
    ]
    if walls is not None:
        parts = [*environment_paths(walls.lines), *parts, *section_paths(walls.sections, hidden)]
    return page(scene, camera, "the outline circle of every sphere", parts)


def max_outline_difference(disks: Disks, camera: Camera) -> float:
    """Return the largest distance [pixels] between a true outline and the paper's circle.

    It is 0 in a parallel view. Spheres that reach beside the eye do not count.
    """
    if math.isinf(camera.distance):
        return 0.0
    # The ellipse is farthest from the circle on the line through the middle of the picture, at one
    # of the ends of its longer axis, or across it.
    rims = _true_rims(disks, camera)
    circle = disks.disk[rims.sphere]
    middle = np.array([camera.width, camera.height]) / 2.0
    ellipse_offset, circle_offset = (
        np.hypot(*(disk[:, :2] - middle).T) for disk in (rims.disk, circle)
    )
    ends = [
        ellipse_offset + side * rims.disk[:, 2] - circle_offset - side * circle[:, 2]
        for side in (1.0, -1.0)
    ]
    across = rims.disk[:, 2] * rims.squeeze[:, 0] - circle[:, 2]
    return float(np.max(np.abs([*ends, across]), initial=0.0))


def _difference_note(disks: Disks, camera: Camera, true_outlines: bool) -> list[str]:
    """Return an element with the largest difference; none in a parallel view."""
    if math.isinf(camera.distance):
        return []
    difference = f"{max_outline_difference(disks, camera):.1f} pixels"
    if true_outlines:
        text = f"True outlines, ellipses; at most {difference} from circles about the centres"
    else:
        text = f"Circles about the centres; at most {difference} from the true outlines, ellipses"
    return [f"<desc>{text}</desc>"]


def _paper_rims(disks: Disks, camera: Camera) -> _Rims:
    """Return the paper's circles."""
    order = disks.order
    count = len(order)
    depth = projective_depth(camera, disks.centre[order])
    circle = np.tile([1.0, 0.0], (count, 1))
    return _Rims(order, disks.disk[order], circle, depth, np.zeros((count, 2)))


def _true_rims(disks: Disks, camera: Camera) -> _Rims:
    """Return the outlines in perspective, of spheres that do not reach beside the near plane."""
    balls = disks.view[disks.order] * [1.0, -1.0, -1.0, 1.0] + [0.0, 0.0, camera.distance, 0.0]
    ahead = balls[:, 2] - balls[:, 3] > camera.distance - camera.nearest
    balls = balls[ahead]
    disk, squeeze = rim_ellipses(camera, balls)
    tangent = np.sqrt(np.sum(balls[:, :3] ** 2, axis=1) - balls[:, 3] ** 2)
    depth, tilt = rim_planes(camera, balls[:, :3], tangent, disk)
    return _Rims(disks.order[ahead], disk, squeeze, depth, tilt)


def _rim_shapes(rims: _Rims, true_outlines: bool) -> list[str]:
    """Return the beginning of the element of each rim."""
    if not true_outlines:
        return number_rows('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}"', rims.disk)
    x, y, longer = rims.disk.T
    turn = np.degrees(rims.squeeze[:, 1])
    pattern = '<ellipse cx="{:.1f}" cy="{:.1f}" rx="{:.1f}" ry="{:.1f}" transform="rotate({:.1f} {:.1f} {:.1f})"'
    return number_rows(
        pattern, np.column_stack([x, y, longer, longer * rims.squeeze[:, 0], turn, x, y])
    )


def _rim_styles(scene: Scene, disks: Disks, rims: _Rims) -> list[str]:
    """Return the end of the element of each rim: its line, by the depth of its sphere."""
    level = np.round(depth_share(disks.front) * (_STRENGTH_LEVELS - 1)).astype(np.int64)
    row = level + _STRENGTH_LEVELS * scene.spheres.body
    styles = [text for shown in scene.bodies for text in _level_styles(shown.colour)]
    return [styles[k] for k in row[rims.sphere].tolist()]


def _level_styles(colour: str) -> list[str]:
    """Return the line of each level of depth, far to near."""
    paper = np.array(PAPER, dtype=np.float64)
    ink = np.array(INKS[colour], dtype=np.float64)
    near = np.linspace(0.0, 1.0, _STRENGTH_LEVELS)
    strokes = paper + (ink - paper) * (0.5 + 0.5 * near[:, None])
    return [
        f' stroke="{hexadecimal(stroke)}" stroke-width="{0.5 + 0.7 * share:.2f}"/>'
        for stroke, share in zip(strokes, near, strict=True)
    ]


def _partly_hidden_rims(rims: _Rims, walls: DrawnSolids) -> dict[int, str]:
    """Return path commands of the visible arcs of each rim that a polygon hides in part or whole,
    by the number of the rim."""
    frames = ellipse_frames(rims.disk, rims.squeeze, rims.depth, rims.tilt)
    whole_turn = np.tile([0.0, 2.0 * math.pi], (len(frames), 1))
    source, angle, hidden = hidden_arcs(frames, whole_turn, walls.occluders)
    paths: dict[int, str] = {}
    for row in np.flatnonzero(np.isin(source, source[hidden])):
        number = int(source[row])
        visible = "" if hidden[row] else _arc_path(frames[number], rims, number, angle[row])
        paths[number] = paths.get(number, "") + visible
    return paths


def _arc_path(frame: Floats, rims: _Rims, number: int, angle: Floats) -> str:
    """Write an arc (2,) [rad] in two halves, since the ends of nearly a whole turn are too close to
    determine it."""
    first, last = angle.tolist()
    turns = (first, (first + last) / 2.0, last)
    weights = np.array([[1.0, math.cos(turn), math.sin(turn)] for turn in turns])
    (a, b), (c, d), (e, f) = (weights @ frame[:, :2]).tolist()
    longer = rims.disk[number, 2]
    shorter = rims.disk[number, 2] * rims.squeeze[number, 0]
    command = f"A{longer:.1f} {shorter:.1f} {math.degrees(rims.squeeze[number, 1]):.4g} 0 1"
    return f"M{a:.1f} {b:.1f}{command} {c:.1f} {d:.1f}{command} {e:.1f} {f:.1f}"
