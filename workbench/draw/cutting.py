"""An environment cut open by a plane, for any display to look into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.draw.clipping import clip_segments, clip_triangles, cut_lines
from workbench.errors import UsageError
from workbench.model.arrays import Ints
from workbench.model.environment import Environment

__all__ = ["cut_away"]


def cut_away(environment: Environment, point: ArrayLike, normal: ArrayLike) -> Environment:
    """An environment to be drawn, without what lies beyond the plane through `point` (3,) [m], where `normal` points.

    Cut polygons end in an edge; solids are shown open. Only for pictures: the parts are no longer what they were, and
    keep their polygons' planes and circles. UsageError for no plane, and where nothing is left.
    """
    through, toward = np.asarray(point, dtype=np.float64), np.asarray(normal, dtype=np.float64)
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
        raise UsageError(f"cut: nothing of {environment.name} is left on the near side of the plane")
    owner = np.repeat(np.arange(faces), np.diff(environment.edge_start))
    ends, kept = clip_segments(environment.vertices[environment.edges], toward, offset)
    rims, rim_of = cut_lines(corners, toward, offset)
    edges, edge_polygon = np.concatenate([ends, rims]), np.concatenate([owner[kept], polygon[rim_of]])
    order = np.argsort(edge_polygon, kind="stable")
    count = 3 * len(pieces)
    return replace(
        environment,
        vertices=np.concatenate([pieces.reshape(-1, 3), edges[order].reshape(-1, 3)]),
        triangles=np.arange(count).reshape(-1, 3),
        triangle_start=_starts(polygon[of], faces),
        edges=count + np.arange(2 * len(edges)).reshape(-1, 2),
        edge_start=_starts(edge_polygon, faces),
    )


def _starts(polygon: Ints, faces: int) -> Ints:
    """(F + 1,) where the rows of each polygon start, given the polygon (M,) of each, in any order."""
    starts: Ints = np.concatenate([[0], np.cumsum(np.bincount(polygon, minlength=faces))])
    return starts
