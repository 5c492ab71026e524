"""An environment cut open by a plane, for any display to look into."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.faces import filled_loops
from workbench.draw.camera import Camera
from workbench.draw.clipping import (
    chain_segments,
    clip_segments,
    clip_triangles,
    plane_intersections,
)
from workbench.draw.scene import Scene, shown_corners
from workbench.errors import UsageError, one_of
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment

__all__ = ["SectionPlane", "apply_section", "cut_away", "parse_section_plane"]

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
_ALONG = 1e-6  # a view that turns no more than this toward a plane looks along it


@dataclass(frozen=True)
class SectionPlane:
    """A plane across an axis (0 x, 1 y, 2 z) at a coordinate [m], None: the middle of the bodies.

    side: what goes away is on the side of larger coordinates (1), of smaller ones (-1), or of the
    viewer (0). said: how it was asked for.
    """

    axis: int
    side: float
    at: float | None
    said: str


def parse_section_plane(text: str) -> SectionPlane:
    """A cut from "left", "left=0.3", "y=300mm": the side that goes, or an axis whose viewer's side
    goes; and where.

    Metres where no unit is given. UsageError for anything else.
    """
    name, equals, where = (part.strip() for part in text.partition("="))
    if name not in _SIDES:
        raise UsageError(f"--cut: no side or axis {name!r}; {one_of(name, _SIDES)}")
    axis, side = _SIDES[name]
    if not equals:
        return SectionPlane(axis, side, None, text)
    found = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)", where)
    unit = (found[2] or "m") if found else ""
    if found is None or unit not in metres_in:
        raise UsageError(
            f"--cut {text}: a place such as {name}=0.3 [m] or {name}=300mm is needed; "
            f"units: {', '.join(metres_in)}"
        )
    return SectionPlane(axis, side, float(found[1]) * metres_in[unit], text)


def apply_section(scene: Scene, camera: Camera, cut: SectionPlane) -> Environment:
    """The environment of a scene cut open; bodies stay whole. See cut_away.

    UsageError where there is no environment, where the plane misses it, and for a cut on the
    viewer's side by a plane that this camera looks along.
    """
    if scene.environment is None:
        raise UsageError(
            f"--cut {cut.said}: it opens an environment, and there is none in {scene.title}"
        )
    side = cut.side or float(np.sign(camera.toward[cut.axis]))
    if not cut.side and abs(camera.toward[cut.axis]) < _ALONG:
        sides = [name for name, (axis, sense) in _SIDES.items() if axis == cut.axis and sense]
        raise UsageError(
            f"--cut {cut.said}: the view {camera.name} looks along this plane; say which side goes: "
            f"{' or '.join(sides)}"
        )
    at = float(scene.bounds[:, cut.axis].mean()) if cut.at is None else cut.at
    reach = shown_corners(scene.environment)[:, cut.axis]
    if not (len(reach) and reach.min() < at < reach.max()):
        raise UsageError(
            f"--cut {cut.said}: {scene.environment.name} goes from {reach.min(initial=0.0):.3g} to "
            f"{reach.max(initial=0.0):.3g} m along {'xyz'[cut.axis]}; this plane misses it"
        )
    axis = np.eye(3)[cut.axis]
    return cut_away(scene.environment, at * axis, side * axis)


def cut_away(environment: Environment, point: ArrayLike, normal: ArrayLike) -> Environment:
    """An environment to be drawn, without what lies beyond the plane through `point` (3,) [m],
    where `normal` points.

    Cut polygons end in an edge; where the plane goes through a solid its cut face is a polygon
    more, at the end of the part. Only for pictures: the parts are no longer what they were, and
    keep their polygons' planes and circles. UsageError for no plane, and where nothing is left.
    """
    through = np.asarray(point, dtype=np.float64)
    toward = np.asarray(normal, dtype=np.float64)
    length = float(np.linalg.norm(toward)) if toward.shape == through.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0 and np.isfinite(through).all()):
        raise UsageError(
            f"cut: a point and a direction of 3 numbers each are needed, got {through.tolist()} and {toward.tolist()}"
        )
    toward, offset = toward / length, float(through @ toward / length)
    faces = len(environment.normal)
    corners = environment.vertices[environment.triangles]
    polygon = np.repeat(np.arange(faces), np.diff(environment.triangle_start))
    pieces, of = clip_triangles(corners, toward, offset)
    if not len(pieces):
        raise UsageError(
            f"cut: nothing of {environment.name} is left on the near side of the plane"
        )
    owner = np.repeat(np.arange(faces), np.diff(environment.edge_start))
    ends, kept = clip_segments(environment.vertices[environment.edges], toward, offset)
    rims, rim_of = plane_intersections(corners, toward, offset)
    edges = np.concatenate([ends, rims])
    edge_polygon = np.concatenate([owner[kept], polygon[rim_of]])
    order = np.argsort(edge_polygon, kind="stable")
    count = 3 * len(pieces)
    open_ = replace(
        environment,
        vertices=np.concatenate([pieces.reshape(-1, 3), edges[order].reshape(-1, 3)]),
        triangles=np.arange(count).reshape(-1, 3),
        triangle_start=_starts(polygon[of], faces),
        edges=count + np.arange(2 * len(edges)).reshape(-1, 2),
        edge_start=_starts(edge_polygon, faces),
    )
    return _capped(open_, rims, environment.polygon_part[polygon[rim_of]], (toward, offset))


def _starts(polygon: Ints, faces: int) -> Ints:
    """(F + 1,) where the rows of each polygon start, given the polygon (M,) of each, in any
    order."""
    starts: Ints = np.concatenate([[0], np.cumsum(np.bincount(polygon, minlength=faces))])
    return starts


def _capped(
    environment: Environment, rims: Floats, part: Ints, plane: tuple[Floats, float]
) -> Environment:
    """The environment with a cut face for each of its solid parts: inside the lines rims (K, 2, 3)
    of part (K,).

    The faces have no edges of their own: those of the polygons that end there are drawn.
    """
    toward, offset = plane
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(toward)))], toward)
    across /= np.linalg.norm(across)
    frame = np.array([across, np.cross(toward, across)])
    caps: list[tuple[int, Floats]] = []
    for number in np.flatnonzero(environment.solid & ~environment.hidden):
        flat, triangles = filled_loops(
            [loop @ frame.T for loop in chain_segments(rims[part == number])]
        )
        if len(triangles):
            caps.append((int(number), (flat @ frame + offset * toward)[triangles]))
    if not caps:
        return environment
    owner = np.concatenate([environment.polygon_part, [number for number, _ in caps]])
    return _with_polygons(environment, [corners for _, corners in caps], owner, toward)


def _with_polygons(
    environment: Environment, made: list[Floats], owner: Ints, normal: Floats
) -> Environment:
    """The environment with one more polygon for each of `made`, triangles (T, 3, 3) in one
    direction, and no edges.

    owner (F + M,): the part of each polygon, old and made; they are put in the order of the parts.
    """
    order = np.argsort(owner, kind="stable")
    count = len(environment.vertices)
    sizes = np.append(np.diff(environment.triangle_start), [len(corners) for corners in made])
    edge_sizes = np.append(np.diff(environment.edge_start), [0] * len(made))
    points = np.concatenate(made).reshape(-1, 3)
    triangles = np.concatenate(
        [environment.triangles, count + np.arange(len(points)).reshape(-1, 3)]
    )
    rank = np.argsort(order)[np.repeat(np.arange(len(order)), sizes)]
    middle = np.array([corners.mean(axis=(0, 1)) for corners in made])
    reach = [
        np.linalg.norm(corners - centre, axis=2).max()
        for corners, centre in zip(made, middle, strict=True)
    ]
    return replace(
        environment,
        vertices=np.concatenate([environment.vertices, points]),
        part_start=np.searchsorted(owner[order], np.arange(len(environment.parts) + 1)),
        triangles=triangles[np.argsort(rank, kind="stable")],
        triangle_start=np.append(0, np.cumsum(sizes[order])),
        edge_start=np.append(0, np.cumsum(edge_sizes[order])),
        normal=np.concatenate([environment.normal, np.tile(normal, (len(made), 1))])[order],
        offset=np.append(environment.offset, middle @ normal)[order],
        circle_centre=np.concatenate([environment.circle_centre, middle])[order],
        circle_radius=np.append(environment.circle_radius, reach)[order],
    )
