"""The mesh of a place as it is drawn, and that of a place in two states."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.draw.lines.edges import feature_edges
from workbench.draw.scene import Colour
from workbench.draw.web.views import WebPlace
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = [
    "CONTROL_PART",
    "GLASS_PART",
    "MOST_DRAWN",
    "PLAIN_PART",
    "SEAT_PART",
    "ThinMesh",
    "changed_parts",
    "environment_mesh",
    "paired_mesh",
    "sharp_edges",
    "thinned",
]

PLAIN_PART = (176, 184, 193)
SEAT_PART = (158, 146, 134)
CONTROL_PART = (96, 116, 138)
GLASS_PART = (150, 190, 205)
_SAME = 5e-5
"""Distance [m] within which the corners of a part are where they were: half a packed step."""


def environment_mesh(environment: Environment) -> WebPlace:
    """Return what is seen of an environment: hidden parts are left out."""
    faces, face_part = _shown_triangles(environment)
    edges, edge_part = feature_edges(environment)
    count = len(environment.vertices)
    keys = np.concatenate(
        [
            (face_part[:, None] * count + faces).ravel(),
            (edge_part[:, None] * count + edges).ravel(),
        ]
    )
    kept, index = np.unique(keys, return_inverse=True)
    parts = np.flatnonzero(~environment.hidden)
    renumbered = np.zeros(len(environment.parts), dtype=np.int64)
    renumbered[parts] = np.arange(len(parts))
    return WebPlace(
        environment.vertices[kept % max(count, 1)],
        renumbered[kept // max(count, 1)],
        index[: faces.size].reshape(-1, 3),
        index[faces.size :].reshape(-1, 2),
        tuple(environment.parts[int(k)] for k in parts),
        tuple(_colour(environment, int(k)) for k in parts),
        tuple(bool(environment.see_through[k]) for k in parts),
    )


def paired_mesh(before: Environment, after: Environment) -> WebPlace:
    """Return what is seen of a place in two states: a part that is alike in both once, any other
    in each of the states in which it is there."""
    one = environment_mesh(before)
    two = environment_mesh(after)
    kept = _changed(one, two)
    there = set(one.names) - set(kept.names)
    return WebPlace(
        np.concatenate([two.vertices, kept.vertices]),
        np.concatenate([two.part, kept.part + len(two.names)]),
        np.concatenate([two.triangles, kept.triangles + len(two.vertices)]),
        np.concatenate([two.edges, kept.edges + len(two.vertices)]),
        two.names + kept.names,
        two.colours + kept.colours,
        two.glass + kept.glass,
        (*(None if name in there else 1 for name in two.names), *(0 for _ in kept.names)),
    )


def changed_parts(before: Environment, after: Environment) -> WebPlace:
    """Return what is seen of the parts of a place that are not alike in another: as they are in the
    first."""
    return _changed(environment_mesh(before), environment_mesh(after))


def _changed(one: WebPlace, two: WebPlace) -> WebPlace:
    alike = np.array([_is_alike(one, two, name) for name in one.names], dtype=np.bool_)
    return _parts(one, ~alike)


def _is_alike(one: WebPlace, two: WebPlace, name: str) -> bool:
    """Whether a part of the first place is the same in the second."""
    if name not in two.names:
        return False
    first = _parts(one, np.array([each == name for each in one.names]))
    second = _parts(two, np.array([each == name for each in two.names]))
    return (
        (first.colours, first.glass) == (second.colours, second.glass)
        and first.vertices.shape == second.vertices.shape
        and bool(np.all(np.abs(first.vertices - second.vertices) < _SAME))
        and np.array_equal(first.triangles, second.triangles)
    )


def _parts(place: WebPlace, wanted: Bools) -> WebPlace:
    """Some parts of a place. wanted: (parts,)."""
    rows = wanted[place.part] if len(place.part) else np.zeros(0, dtype=np.bool_)
    number = np.cumsum(rows) - 1
    chosen = np.flatnonzero(wanted).tolist()
    return replace(
        place,
        vertices=place.vertices[rows],
        part=(np.cumsum(wanted) - 1)[place.part[rows]],
        triangles=number[place.triangles[rows[place.triangles[:, 0]]]],
        edges=number[place.edges[rows[place.edges[:, 0]]]],
        names=tuple(place.names[k] for k in chosen),
        colours=tuple(place.colours[k] for k in chosen),
        glass=tuple(place.glass[k] for k in chosen),
    )


def _shown_triangles(environment: Environment) -> tuple[Ints, Ints]:
    """Return the triangles (T, 3) of the parts that are not hidden, and the part (T,) of each."""
    polygon = np.repeat(np.arange(len(environment.normal)), np.diff(environment.triangle_start))
    part = environment.polygon_part[polygon]
    shown = ~environment.hidden[part]
    return environment.triangles[shown], part[shown]


def _colour(environment: Environment, k: int) -> Colour:
    """Colour of a part: glass, what is handled and what goes with a seat differ."""
    name = environment.parts[k]
    if environment.see_through[k]:
        return GLASS_PART
    if any(name in control.own_parts for control in environment.controls):
        return CONTROL_PART
    return SEAT_PART if any(name in seat.moves for seat in environment.seats) else PLAIN_PART


# A mesh for a picture: fewer triangles where there are many, and the edges that are drawn.
#
# Vertices that lie in one cell of a grid become one, their mean, and triangles that are collapsed by
# that go (Rossignac and Borrel 1993, Multi-resolution 3D approximations for rendering complex
# scenes). The same mesh gives the same picture.

MOST_DRAWN = 150_000
"""Triangles of a picture that a computer without a graphics card still turns."""
SHARP = np.radians(30.0)
"""Angle [rad] between faces from which their edge is drawn."""
_FINER = 0.8
_TRIES = 40


@dataclass(frozen=True, eq=False)
class ThinMesh:
    """A mesh as it is drawn.

    Parameters
    ----------
    vertices
        (V, 3).
    faces
        (T, 3).
    source
        (T,) a face of the whole mesh that each stands for.
    edges
        (E, 2) edges that are drawn.
    """

    vertices: Floats
    faces: Ints
    source: Ints
    edges: Ints


def thinned(vertices: Floats, faces: Ints, group: Ints, *, most: int = MOST_DRAWN) -> ThinMesh:
    """Thin a mesh to a number of triangles.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (T, 3).
    group
        (V,) vertices of different groups stay apart.
    most
        Triangles there are at most; a mesh with fewer stays as it is.
    """
    if len(faces) <= most:
        return ThinMesh(vertices, faces, np.arange(len(faces)), sharp_edges(vertices, faces))
    size = float(np.ptp(vertices, axis=0).max()) or 1.0
    cells = 4.0 * np.sqrt(most)
    found = _clustered(vertices, faces, group, size / cells)
    for _ in range(_TRIES):
        if len(found[1]) <= most:
            break
        cells *= _FINER
        found = _clustered(vertices, faces, group, size / cells)
    points, kept, source = found
    if len(kept) > most:  # groups that are too small to become fewer: some are not drawn
        step = np.linspace(0, len(kept) - 1, most).astype(np.int64)
        kept = kept[step]
        source = source[step]
    return ThinMesh(points, kept, source, sharp_edges(points, kept))


def _clustered(
    vertices: Floats, faces: Ints, group: Ints, cell: float
) -> tuple[Floats, Ints, Ints]:
    """Vertices and faces with one vertex a cell and group, and the face that each stands for."""
    grid = np.floor((vertices - vertices.min(axis=0)) / cell).astype(np.int64)
    wide = grid.max(axis=0) + 1
    key = ((group * wide[0] + grid[:, 0]) * wide[1] + grid[:, 1]) * wide[2] + grid[:, 2]
    _, index, count = np.unique(key, return_inverse=True, return_counts=True)
    points = np.stack(
        [np.bincount(index, vertices[:, k], len(count)) / count for k in range(3)], axis=1
    )
    own = index[faces]
    open_ = (own[:, 0] != own[:, 1]) & (own[:, 1] != own[:, 2]) & (own[:, 2] != own[:, 0])
    source = np.flatnonzero(open_)
    own = own[source]
    corners = np.sort(own, axis=1)
    order = np.lexsort((source, corners[:, 2], corners[:, 1], corners[:, 0]))
    first = np.ones(len(order), dtype=np.bool_)
    first[1:] = (corners[order][1:] != corners[order][:-1]).any(axis=1)
    keep = np.sort(order[first])
    return points, own[keep], source[keep]


def sharp_edges(vertices: Floats, faces: Ints) -> Ints:
    """Find the edges at which faces end, or meet at an angle.

    Returns
    -------
    Ints
        (E, 2) vertices.
    """
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0.0, length, 1.0)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    face = np.tile(np.arange(len(faces)), 3)
    ends = np.sort(ends, axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends = ends[order]
    face = face[order]
    edge = np.ones(len(ends), dtype=np.bool_)
    edge[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    first = np.flatnonzero(edge)
    count = np.diff([*first, len(ends)])
    second = np.minimum(first + 1, len(ends) - 1)
    along = np.abs(np.einsum("ij,ij->i", normal[face[first]], normal[face[second]]))
    drawn = (count != 2) | (along < np.cos(SHARP))
    return ends[first[drawn]]
