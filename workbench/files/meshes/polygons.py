"""Coplanar neighbouring triangles become planar polygons again: concave, with holes, in any number
of pieces.

Two triangles belong together when they share an edge that no third face has, are wound the same
way, and lie in one plane. A region of them is accepted as a polygon only when every one of its
corners lies within `PLANE_TOLERANCE` of the region's plane; a region that fails is cut up and tried
again, if need be down to single triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.circles import enclosing_circles
from workbench.files.meshes.planes import Faced, faced
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["PLANE_TOLERANCE", "Polygons", "merge_coplanar", "shared_edges"]

PLANE_TOLERANCE = 1e-6
"""How far a corner may lie from its polygon's plane [m]."""
_GROWING = 4
"""Attempts to find the largest planes in a region that bends, before it is halved and halved
again."""
_STEPS = 64
"""Far more halvings than a region of any size needs; what is left after them would stay bent."""


@dataclass(frozen=True)
class Polygons:
    """F polygons over the given vertices; the arrays are those of `Environment`, and face_polygon
    (T,) says where each triangle went. Polygons stand in the order of their first triangle."""

    edges: Ints
    edge_start: Ints
    normal: Floats
    offset: Floats
    circle_centre: Floats
    circle_radius: Floats
    triangles: Ints
    triangle_start: Ints
    face_polygon: Ints


def merge_coplanar(vertices: Floats, faces: Ints) -> Polygons:
    """Merge the triangles `faces` (T, 3) over `vertices` (V, 3) [m] into planar polygons.

    Triangles are neighbours when they share vertex indices: merge equal positions first. No face is
    dropped: a degenerate one becomes a polygon of three edges in some plane through its longest
    edge.
    """
    mesh = faced(vertices, faces)
    pairs, halves = shared_edges(faces)
    links = pairs[_linked(mesh, pairs)]
    label = _regions(mesh, links)
    polygons = int(label.max(initial=-1)) + 1
    normal, offset = _region_planes(mesh, label, polygons)
    edges, edge_start = _outlines(mesh, label, halves)
    centre, radius = enclosing_circles(vertices, (edges, edge_start), normal)
    centre += (offset - np.einsum("ij,ij->i", centre, normal))[:, None] * normal
    order = np.argsort(label, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(label, minlength=polygons))])
    return Polygons(edges, edge_start, normal, offset, centre, radius, faces[order], start, label)


def shared_edges(faces: Ints) -> tuple[Ints, Ints]:
    """Neighbours by edge: pairs (n, 2) of faces that alone share an edge and run along it in
    opposite senses.

    The second array (3 T,) gives, for half-edge k of face t at 3 t + k, the neighbouring face, or
    -1.
    """
    tail = faces.ravel()
    head = np.roll(faces, -1, axis=1).ravel()
    low = np.minimum(tail, head)
    high = np.maximum(tail, head)
    key = low * (int(faces.max(initial=0)) + 1) + high
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1) != 0)
    two = first[np.diff(first, append=len(key)) == 2]
    one = order[two]
    other = order[two + 1]
    opposite = (tail[one] == head[other]) & (tail[one] != head[one]) & (one // 3 != other // 3)
    one = one[opposite]
    other = other[opposite]
    across = np.full(len(key), -1, dtype=np.int64)
    across[one] = other // 3
    across[other] = one // 3
    return np.column_stack([one // 3, other // 3]), across


def _linked(mesh: Faced, pairs: Ints) -> Bools:
    """Whether the smaller of two neighbours lies in the plane of the larger, facing the same way.

    One-sided on purpose: the plane of a sliver is rounding noise, that of its large neighbour is
    not.
    """
    larger = np.where(mesh.area[pairs[:, 0]] >= mesh.area[pairs[:, 1]], pairs[:, 0], pairs[:, 1])
    smaller = pairs.sum(axis=1) - larger
    normal = mesh.normal[larger]
    base = np.einsum("nc,nc->n", mesh.vertices[mesh.faces[larger, 0]], normal)
    height = np.abs(mesh.heights(smaller, normal) - base[:, None]).max(axis=1, initial=0)
    same_way = np.einsum("nc,nc->n", normal, mesh.normal[smaller]) > 0
    linked: Bools = (
        (height <= PLANE_TOLERANCE) & same_way & ~mesh.flat[larger] & ~mesh.flat[smaller]
    )
    return linked


def _components(links: Ints, count: int) -> Ints:
    from scipy.sparse import coo_array  # takes a third of a second to load
    from scipy.sparse.csgraph import connected_components

    graph = coo_array(
        (np.ones(len(links), dtype=np.int8), (links[:, 0], links[:, 1])), shape=(count, count)
    )
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _regions(mesh: Faced, links: Ints) -> Ints:
    """(T,) the polygon of each face: connected, and flat to the tolerance. Polygons count from
    their first faces."""
    piece = np.zeros(len(mesh.faces), dtype=np.int64)
    done = 0
    left = np.arange(len(mesh.faces))
    for step in range(_STEPS):
        label = _components(links, len(left))
        bent = _bent(mesh, label)
        piece[left[~bent]] = label[~bent] + done
        done += int(label.max(initial=-1)) + 1
        if not bent.any():
            break
        place = np.cumsum(bent) - 1
        left = left[bent]
        mesh = mesh.only(bent)
        links = place[links[bent[links[:, 0]]]]
        label = np.unique(label[bent], return_inverse=True)[1]
        links = links[(_grown if step < _GROWING else _halved)(mesh, label, links)]
    _, first, inverse = np.unique(piece, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    ranked: Ints = rank[inverse]
    return ranked


def _bent(mesh: Faced, label: Ints) -> Bools:
    """(T,) whether a face belongs to a region whose corners leave the region's plane by more than
    the tolerance.

    One that faces back counts too: a grain smaller than the tolerance, closed on itself, has no
    outline at all.
    """
    polygons = int(label.max(initial=-1)) + 1
    normal = _mean_normals(mesh, label, polygons)
    low, high = _spread(mesh, label, normal)
    backward = (
        np.bincount(label, np.einsum("nc,nc->n", mesh.normal, normal[label]) <= 0, polygons) > 0
    )
    wrong = (high - low > 2 * PLANE_TOLERANCE) | backward
    bent: Bools = (wrong & (np.bincount(label, minlength=polygons) > 1))[label]
    return bent


def _grown(mesh: Faced, label: Ints, links: Ints) -> Bools:
    """Which links to keep when each region is cut where it leaves the plane of its largest
    triangle.

    The plane is fitted twice, since that of one triangle is too uncertain far away from it.
    """
    polygons = int(label.max()) + 1
    order = np.lexsort((mesh.area, label))
    seed = order[np.cumsum(np.bincount(label, minlength=polygons)) - 1]
    normal = mesh.normal[seed]
    base = np.einsum("nc,nc->n", mesh.vertices[mesh.faces[seed, 0]], mesh.normal[seed])
    for _ in range(2):
        height = mesh.heights(np.arange(len(label)), normal[label]) - base[label, None]
        inside = np.abs(height).max(axis=1) <= PLANE_TOLERANCE
        kept = np.where(inside, label, polygons)
        normal = _mean_normals(mesh, kept, polygons + 1)
        low, high = _spread(mesh, kept, normal)
        base = (low + high) / 2
    same: Bools = inside[links[:, 0]] == inside[links[:, 1]]
    return same


def _halved(mesh: Faced, label: Ints, links: Ints) -> Bools:
    """Which links to keep when each region is cut across the middle of its longest extent."""
    polygons = int(label.max()) + 1
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    mean = np.column_stack([np.bincount(label, middle[:, k], polygons) for k in range(3)])
    away = middle - (mean / np.bincount(label, minlength=polygons)[:, None])[label]
    width = np.column_stack([np.bincount(label, away[:, k] ** 2, polygons) for k in range(3)])
    side = away[np.arange(len(away)), width.argmax(axis=1)[label]] > 0
    same: Bools = side[links[:, 0]] == side[links[:, 1]]
    return same


def _mean_normals(mesh: Faced, label: Ints, polygons: int) -> Floats:
    """(F, 3) unit normals of regions: the sum of the area vectors, which only the region's outline
    decides."""
    total = np.column_stack([np.bincount(label, mesh.vector[:, k], polygons) for k in range(3)])
    length = np.linalg.norm(total, axis=1)
    unit: Floats = total / np.where(length == 0, 1, length)[:, None]
    return unit


def _spread(mesh: Faced, label: Ints, normal: Floats) -> tuple[Floats, Floats]:
    """(F,), (F,) least and greatest height of a region's corners along its normal [m]; 0 for a
    region of nothing."""
    height = mesh.heights(np.arange(len(label)), normal[label])
    low = np.zeros(len(normal))
    high = np.zeros(len(normal))
    order = np.argsort(label, kind="stable")
    present, first = np.unique(label[order], return_index=True)
    if len(present):
        low[present] = np.minimum.reduceat(height.min(axis=1)[order], first)
        high[present] = np.maximum.reduceat(height.max(axis=1)[order], first)
    return low, high


def _region_planes(mesh: Faced, label: Ints, polygons: int) -> tuple[Floats, Floats]:
    normal = _mean_normals(mesh, label, polygons)
    alone = np.flatnonzero(mesh.flat)
    normal[label[alone]] = mesh.normal[alone]
    low, high = _spread(mesh, label, normal)
    return normal, (low + high) / 2


def _outlines(mesh: Faced, label: Ints, across: Ints) -> tuple[Ints, Ints]:
    """Edges (E, 2) of all polygons, and where each polygon's begin (F + 1,): what two of its faces
    share is gone."""
    owner = np.repeat(label, 3)
    inner = (across >= 0) & (label[across] == owner)
    tail = mesh.faces.ravel()
    head = np.roll(mesh.faces, -1, axis=1).ravel()
    kept = np.flatnonzero(~inner)
    kept = kept[np.argsort(owner[kept], kind="stable")]
    count = np.bincount(owner[kept], minlength=int(label.max(initial=-1)) + 1)
    return np.column_stack([tail[kept], head[kept]]), np.concatenate([[0], np.cumsum(count)])
