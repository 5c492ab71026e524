"""Cut an environment open by a plane, so that every display can look into it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.surface import triangulate_loops
from workbench.draw.camera import Camera
from workbench.draw.scene import Scene, shown_corners
from workbench.errors import UsageError, one_of
from workbench.files.schema import metres_in
from workbench.geometry.clipping import (
    chain_segments,
    clip_segments,
    clip_triangles,
    plane_intersections,
)
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment

__all__ = ["SectionPlane", "apply_section", "cut_away", "parse_section_plane", "side_name"]

_SIDES = {
    "front": (0, 1.0),
    "back": (0, -1.0),
    "left": (1, 1.0),
    "right": (1, -1.0),
    "top": (2, 1.0),
    "bottom": (2, -1.0),
    "x": (0, 0.0),
    "y": (1, 0.0),
    "z": (2, 0.0),
}
"""Axis of each side, and the sign of the coordinates on it; 0 for the viewer's side."""
_ALONG_PLANE = 1e-6
"""Component of the line of sight across a plane below which the camera looks along the plane."""


@dataclass(frozen=True)
class SectionPlane:
    """A plane across an axis of the world, and the side that is cut away."""

    axis: int
    """0 x, 1 y, 2 z."""
    side: float
    """Side that is cut away: 1 larger coordinates, -1 smaller ones, 0 the viewer's side."""
    at: float | None
    """Coordinate [m] of the plane, None for the middle of the bodies."""
    text: str
    """The option as given."""


def parse_section_plane(text: str, *, option: str = "--cut") -> SectionPlane:
    """Read a section plane such as "left", "left=0.3" or "y=300mm".

    Parameters
    ----------
    text
        The side to cut away, or an axis whose viewer's side is cut away. Then optionally "=" and
        the coordinate, in metres if no unit is given.
    option
        What messages call it.

    Raises
    ------
    UsageError
        If the text is anything else.
    """
    name, equals, where = (part.strip() for part in text.partition("="))
    if name not in _SIDES:
        raise UsageError(f"{option}: no side or axis {name!r}; {one_of(name, _SIDES)}")
    axis, side = _SIDES[name]
    if not equals:
        return SectionPlane(axis, side, None, text)
    match = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)", where)
    unit = (match[2] or "m") if match else ""
    if match is None or unit not in metres_in:
        raise UsageError(
            f"{option} {text}: a place such as {name}=0.3 [m] or {name}=300mm is needed; "
            f"units: {', '.join(metres_in)}"
        )
    return SectionPlane(axis, side, float(match[1]) * metres_in[unit], text)


def apply_section(scene: Scene, camera: Camera, plane: SectionPlane) -> Environment:
    """Return the environment of a scene cut open by a plane; bodies stay whole. See `cut_away`.

    Raises
    ------
    UsageError
        If there is no environment, if the plane misses it, or if the viewer's side is to be cut
        away by a plane that the camera looks along.
    """
    if scene.environment is None:
        raise UsageError(
            f"--cut {plane.text}: it opens an environment, and there is none in {scene.title}"
        )
    side = plane.side or _viewer_side(camera, plane)
    at = float(scene.bounds[:, plane.axis].mean()) if plane.at is None else plane.at
    extent = shown_corners(scene.environment)[:, plane.axis]
    if not (len(extent) and extent.min() < at < extent.max()):
        raise UsageError(
            f"--cut {plane.text}: {scene.environment.name} goes from {extent.min(initial=0.0):.3g} "
            f"to {extent.max(initial=0.0):.3g} m along {'xyz'[plane.axis]}; this plane misses it"
        )
    axis = np.eye(3)[plane.axis]
    return cut_away(scene.environment, at * axis, side * axis)


def side_name(plane: SectionPlane) -> str:
    """Return the name of the side that a section plane cuts away.

    Raises
    ------
    UsageError
        If it is the viewer's side.
    """
    sides = _sides_of(plane)
    if not plane.side:
        raise UsageError(
            f"section {plane.text}: say which side goes: {' or '.join(sides.values())}"
        )
    return sides[plane.side]


def _sides_of(plane: SectionPlane) -> dict[float, str]:
    """Return the two sides of a plane by the sign of their coordinates."""
    return {sign: name for name, (axis, sign) in _SIDES.items() if axis == plane.axis and sign}


def _viewer_side(camera: Camera, plane: SectionPlane) -> float:
    """Return 1 or -1, the side of a plane on which the viewer is."""
    across = camera.toward[plane.axis]
    if abs(across) < _ALONG_PLANE:
        sides = _sides_of(plane).values()
        raise UsageError(
            f"--cut {plane.text}: the view {camera.name} looks along this plane; say which side "
            f"goes: {' or '.join(sides)}"
        )
    return float(np.sign(across))


def cut_away(environment: Environment, point: ArrayLike, normal: ArrayLike) -> Environment:
    """Remove what of an environment lies beyond a plane, for pictures only.

    Cut polygons end in an edge. Where the plane cuts a solid, the cut face is added at the end of
    the part as a polygon. The other polygons keep their planes and enclosing circles.

    Parameters
    ----------
    environment
        The environment to cut.
    point, normal
        (3,) a point [m] of the plane and the direction of what is removed.

    Raises
    ------
    UsageError
        If point and normal give no plane, or nothing is left.
    """
    unit, offset = _checked_plane(point, normal)
    polygons = len(environment.normal)
    corners = environment.vertices[environment.triangles]
    triangle_polygon = np.repeat(np.arange(polygons), np.diff(environment.triangle_start))
    pieces, source = clip_triangles(corners, unit, offset)
    if not len(pieces):
        raise UsageError(
            f"cut: nothing of {environment.name} is left on the near side of the plane"
        )
    section_lines, crossed = plane_intersections(corners, unit, offset)
    section_polygon = triangle_polygon[crossed]
    edge_polygon = np.repeat(np.arange(polygons), np.diff(environment.edge_start))
    clipped_edges, kept = clip_segments(environment.vertices[environment.edges], unit, offset)
    edges = np.concatenate([clipped_edges, section_lines])
    owner = np.concatenate([edge_polygon[kept], section_polygon])
    edges = edges[np.argsort(owner, kind="stable")]
    count = 3 * len(pieces)
    cut = replace(
        environment,
        vertices=np.concatenate([pieces.reshape(-1, 3), edges.reshape(-1, 3)]),
        triangles=np.arange(count).reshape(-1, 3),
        triangle_start=_row_starts(triangle_polygon[source], polygons),
        edges=count + np.arange(2 * len(edges)).reshape(-1, 2),
        edge_start=_row_starts(owner, polygons),
    )
    return _with_section_faces(
        cut, section_lines, environment.polygon_part[section_polygon], unit, offset
    )


def _checked_plane(point: ArrayLike, normal: ArrayLike) -> tuple[Floats, float]:
    """Return the unit normal (3,) and the offset [m] of a plane."""
    through = np.asarray(point, dtype=np.float64)
    direction = np.asarray(normal, dtype=np.float64)
    three = direction.shape == through.shape == (3,)
    length = float(np.linalg.norm(direction)) if three else 0.0
    if not (np.isfinite(length) and length > 0.0 and np.isfinite(through).all()):
        raise UsageError(
            "cut: a point and a direction of 3 numbers each are needed, "
            f"got {through.tolist()} and {direction.tolist()}"
        )
    return direction / length, float(through @ direction / length)


def _row_starts(polygon: Ints, polygons: int) -> Ints:
    """Return where (F + 1,) the rows of each of F polygons start, given the polygon (M,) of each
    row in any order."""
    return np.concatenate([[0], np.cumsum(np.bincount(polygon, minlength=polygons))])


def _with_section_faces(
    environment: Environment, lines: Floats, part: Ints, normal: Floats, offset: float
) -> Environment:
    """Add a cut face to each solid part: what lies inside the lines (K, 2, 3) of part (K,).

    The faces have no edges of their own, since the polygons that end there have them.
    """
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(normal)))], normal)
    across /= np.linalg.norm(across)
    frame = np.array([across, np.cross(normal, across)])  # axes of the plane
    faces: list[Floats] = []
    parts: list[int] = []
    for number in np.flatnonzero(environment.solid & ~environment.hidden):
        loops = [loop @ frame.T for loop in chain_segments(lines[part == number])]
        flat, triangles = triangulate_loops(loops)
        if len(triangles):
            faces.append((flat @ frame + offset * normal)[triangles])
            parts.append(int(number))
    if not faces:
        return environment
    owner = np.concatenate([environment.polygon_part, parts])
    return _with_polygons(environment, faces, owner, normal)


def _with_polygons(
    environment: Environment, faces: list[Floats], owner: Ints, normal: Floats
) -> Environment:
    """Add polygons without edges, in the order of their parts.

    Parameters
    ----------
    environment
        The environment of F polygons.
    faces
        M polygons, as triangles (T, 3, 3) each.
    owner
        (F + M,) the part of each polygon, old and new.
    normal
        (3,) unit normal of all new polygons.
    """
    order = np.argsort(owner, kind="stable")
    sizes = np.append(np.diff(environment.triangle_start), [len(face) for face in faces])
    edge_sizes = np.append(np.diff(environment.edge_start), [0] * len(faces))
    points = np.concatenate(faces).reshape(-1, 3)
    new_triangles = len(environment.vertices) + np.arange(len(points)).reshape(-1, 3)
    triangles = np.concatenate([environment.triangles, new_triangles])
    centre, radius = _enclosing_circles(faces)
    return replace(
        environment,
        vertices=np.concatenate([environment.vertices, points]),
        part_start=np.searchsorted(owner[order], np.arange(len(environment.parts) + 1)),
        triangles=triangles[_row_order(order, sizes)],
        triangle_start=np.append(0, np.cumsum(sizes[order])),
        edge_start=np.append(0, np.cumsum(edge_sizes[order])),
        normal=np.concatenate([environment.normal, np.tile(normal, (len(faces), 1))])[order],
        offset=np.append(environment.offset, centre @ normal)[order],
        circle_centre=np.concatenate([environment.circle_centre, centre])[order],
        circle_radius=np.append(environment.circle_radius, radius)[order],
    )


def _row_order(order: Ints, sizes: Ints) -> Ints:
    """Return the order (T,) of the rows of polygons that come in `order` (M,), `sizes` (M,) each."""
    rank = np.argsort(order)[np.repeat(np.arange(len(order)), sizes)]
    return np.asarray(np.argsort(rank, kind="stable"))


def _enclosing_circles(faces: list[Floats]) -> tuple[Floats, Floats]:
    """Return the middle (M, 3) and the enclosing radius (M,) [m] of triangles (T, 3, 3) each."""
    centre = np.array([face.mean(axis=(0, 1)) for face in faces])
    radius = [
        np.linalg.norm(face - middle, axis=2).max()
        for face, middle in zip(faces, centre, strict=True)
    ]
    return centre, np.array(radius)
