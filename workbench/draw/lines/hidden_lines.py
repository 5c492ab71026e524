"""Remove hidden lines from vector pictures, exactly and at any size of picture.

Only opaque parts of the environment hide, and only what of them lies behind the near plane. Bodies
hide the lines of the environment: a line is cut where it goes behind the outline of a sphere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import (
    TO_VIEWER,
    Camera,
    metric_depth,
    projective_depth,
    to_projective,
    to_view,
    view_to_pixels,
)
from workbench.draw.lines.arcs import Arcs
from workbench.draw.lines.edges import Lines, drawn_edges
from workbench.draw.lines.occlusion import (
    Occluders,
    build_grid,
    hidden_arcs,
    hidden_lines,
    lines_among_balls,
    occluder_planes,
)
from workbench.draw.scene import Scene
from workbench.draw.visibility import (
    cut_depth,
    projected_disks,
    triangle_polygons,
    triangles_shown,
)
from workbench.errors import UsageError, one_of
from workbench.geometry.clipping import (
    chain_segments,
    clip_segments,
    clip_triangles,
    plane_intersections,
)
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = [
    "HIDDEN",
    "DrawnSolids",
    "build_occluders",
    "ellipse_frames",
    "sections",
    "split_hidden_arcs",
    "surroundings",
    "visible_edge_lines",
]

HIDDEN = ("veiled", "hidden_line")
"""Styles of hidden lines: drawn pale, or left out."""
_DEPTH_BIAS = 1e-3
"""Depth [m] by which a polygon must lie in front of a rim or an edge to hide it, so that one that
touches it does not."""


class DrawnSolids(NamedTuple):
    """What vector displays draw of an environment."""

    occluders: Occluders
    """The opaque triangles, as they hide."""
    lines: Lines
    """The visible lines."""
    sections: list[list[Floats]]
    """Loops (K, 2) [pixels] of the cut face of each solid part."""


def surroundings(scene: Scene, camera: Camera, hidden: str) -> DrawnSolids | None:
    """Prepare the environment of a scene for vector displays, None without an environment.

    Parameters
    ----------
    scene, camera
        What is seen, and from where.
    hidden
        One of `HIDDEN`.

    Raises
    ------
    UsageError
        If there is no such style.
    """
    if hidden not in HIDDEN:
        raise UsageError(f"no style {hidden!r}; {one_of(hidden, HIDDEN)}")
    if scene.environment is None:
        return None
    cut = cut_depth(projected_disks(scene, camera), camera)
    occluders = build_occluders(scene.environment, camera, cut)
    edges, see_through = drawn_edges(scene.environment, camera, cut)
    lines = visible_edge_lines(edges, see_through, scene, camera, occluders, cut)
    return DrawnSolids(occluders, lines, sections(scene.environment, camera, cut))


def _from_projective(camera: Camera, points: Floats) -> Floats:
    """Return view coordinates (..., 3) [m] of x, y [pixels] and projective depth (..., 3)."""
    depth = metric_depth(camera, points[..., 2])
    scale = camera.scale / (1.0 - depth * camera.inverse_distance)
    x = (points[..., 0] - camera.width / 2.0) / scale
    y = (camera.height / 2.0 - points[..., 1]) / scale
    return np.stack([x, y, depth], axis=-1)


class _PictureBoxes(NamedTuple):
    """Bounding boxes of things in the picture, in pixels."""

    low: Floats
    """(M, 2)."""
    high: Floats
    """(M, 2)."""
    inside: Bools
    """(M,) whether they meet the picture."""


def _picture_boxes(camera: Camera, points: Floats) -> _PictureBoxes:
    """Return the boxes of M things with K points (M, K, 3) each."""
    low = points[:, :, :2].min(axis=1)
    high = points[:, :, :2].max(axis=1)
    inside = np.all((high >= 0.0) & (low <= (camera.width, camera.height)), axis=1)
    return _PictureBoxes(low, high, inside)


def build_occluders(environment: Environment, camera: Camera, cut: float) -> Occluders:
    """Collect the opaque triangles of an environment behind a near plane, in a grid.

    Parameters
    ----------
    environment, camera
        What is seen, and from where.
    cut
        Depth [m] of the near plane.
    """
    shown = triangles_shown(environment)
    part = environment.polygon_part[triangle_polygons(environment)[shown]]
    opaque = shown[~environment.see_through[part]]
    seen = to_view(camera, environment.vertices)[environment.triangles[opaque]]
    seen, _ = clip_triangles(seen, TO_VIEWER, min(cut, camera.closest))
    corners = to_projective(camera, seen)
    # the nearest first: what they hide as a whole asks no other
    corners = corners[np.argsort(-corners[:, :, 2].max(axis=1), kind="stable")]
    boxes = _picture_boxes(camera, corners)
    planes = occluder_planes(corners[boxes.inside], _DEPTH_BIAS)
    sides = np.column_stack([boxes.low, boxes.high])[boxes.inside]
    return build_grid(planes, sides, camera.width, camera.height)


def ellipse_frames(disk: Floats, squeeze: Floats, depth: Floats, tilt: Floats) -> Floats:
    """Return ellipses as p(t) = frame[0] + cos(t) frame[1] + sin(t) frame[2].

    Parameters
    ----------
    disk, squeeze
        (S, 3) and (S, 2) the ellipses, see `arcs.Arcs`.
    depth, tilt
        (S,) and (S, 2) projective depth at the middle, and its change per pixel right and down.

    Returns
    -------
    Floats
        (S, 3, 3) x, y [pixels] and projective depth of each row.
    """
    ratio, turn = squeeze.T
    longer = np.column_stack([np.cos(turn), np.sin(turn)]) * disk[:, 2:]
    shorter = np.column_stack([-np.sin(turn), np.cos(turn)]) * (disk[:, 2] * ratio)[:, None]
    rows = [np.column_stack([disk[:, :2], depth])]
    for axis in (longer, shorter):
        rows.append(np.column_stack([axis, np.sum(tilt * axis, axis=1)]))
    return np.stack(rows, axis=1)


def split_hidden_arcs(arcs: Arcs, occluders: Occluders) -> Arcs:
    """Cut arcs where a polygon starts or ends to hide them, and mark the hidden ones `veiled`."""
    frames = ellipse_frames(arcs.disk, arcs.squeeze, arcs.depth, arcs.tilt)
    source, angle, hidden = hidden_arcs(frames, arcs.angle, occluders)
    lead = arcs.lead[source].copy()
    lead[angle[:, 0] > arcs.angle[source, 0], 0] = -1
    lead[angle[:, 1] < arcs.angle[source, 1], 1] = -1
    pieces = Arcs._make(column[source] for column in arcs)
    return pieces._replace(angle=angle, lead=lead, veiled=hidden)


def visible_edge_lines(
    edges: Floats,
    see_through: Bools,
    scene: Scene,
    camera: Camera,
    occluders: Occluders,
    cut: float,
) -> Lines:
    """Return the pieces of edges that nothing hides.

    A piece is faint if it belongs to a see-through part or lies in front of a body. Edges beside
    the picture are left out.

    Parameters
    ----------
    edges, see_through
        (M, 2, 3) ends as x, y [pixels] and depth [m], and whether (M,) the part is see-through.
    scene, camera, occluders
        Whose bodies hide, from where, and which triangles hide.
    cut
        Depth [m] of the near plane.
    """
    source, seen = _behind_near_plane(edges, camera, cut)
    ends = to_projective(camera, seen)
    inside = _picture_boxes(camera, ends).inside
    ends = ends[inside]
    source = source[inside]
    piece, share, hidden = hidden_lines(ends, occluders)
    piece = piece[~hidden]
    share = share[~hidden]
    visible = _from_projective(camera, _subsegments(ends[piece], share))
    spheres = scene.spheres
    balls = np.column_stack([to_view(camera, spheres.centre), spheres.radius])
    segment, share, is_before = lines_among_balls(visible, balls, camera.distance)
    drawn = view_to_pixels(camera, _subsegments(visible[segment], share))
    faint = see_through[source[piece[segment]]] | is_before
    return Lines(drawn[:, :, :2], drawn[:, :, 2].mean(axis=1), faint)


def _behind_near_plane(edges: Floats, camera: Camera, cut: float) -> tuple[Ints, Floats]:
    """Clip edges at the near plane; returns their indices and view coordinates (K, 2, 3)."""
    points = edges.copy()
    points[:, :, 2] = projective_depth(camera, edges[:, :, 2])
    seen, source = clip_segments(_from_projective(camera, points), TO_VIEWER, cut + _DEPTH_BIAS)
    return source, seen


def _subsegments(ends: Floats, share: Floats) -> Floats:
    """Return the parts of segments (K, 2, 3) between shares (K, 2) of their length."""
    return ends[:, :1] * (1.0 - share[:, :, None]) + ends[:, 1:] * share[:, :, None]


def sections(environment: Environment, camera: Camera, cut: float) -> list[list[Floats]]:
    """Intersect the near plane with solid parts.

    Parameters
    ----------
    environment, camera
        What is seen, and from where.
    cut
        Depth [m] of the near plane; infinity gives nothing.

    Returns
    -------
    list[list[Floats]]
        Of each part its loops (K, 2) [pixels], to be filled by the even-odd rule.
    """
    if not math.isfinite(cut):
        return []
    part = environment.polygon_part[triangle_polygons(environment)]
    solid = environment.solid & ~environment.hidden & ~environment.see_through
    seen = to_view(camera, environment.vertices)
    faces = []
    for number in np.flatnonzero(solid):
        triangles = seen[environment.triangles[part == number]]
        lines, _ = plane_intersections(triangles, TO_VIEWER, cut)
        faces.append([view_to_pixels(camera, loop)[:, :2] for loop in chain_segments(lines)])
    return [loops for loops in faces if loops]
