"""Make the winding of a mesh consistent, as far as its edges determine it.

Two faces that share an edge are wound alike when they run along it in opposite senses. Faces
connected through edges of exactly two faces form a patch. The relation "wound alike or not" is
propagated through a patch by the connected components of its double cover: each face is two nodes,
one for each way round. Where both nodes of a face fall into one component the patch has one side
only (a Moebius strip), and no winding is consistent. Otherwise the faces of a patch fall into two
groups, and the smaller one is wound against the larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Ints

__all__ = [
    "HalfEdges",
    "Winding",
    "balanced",
    "component_labels",
    "consistent_winding",
    "half_edges",
    "way_round",
]


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """Edges of the faces that have three different corners; H = three times their number."""

    face: Ints
    """(H,) the face of each half-edge."""
    edge: Ints
    """(H,) the edge of each half-edge."""
    sense: Ints
    """(H,) +1 or -1: the sense in which the face runs along the edge."""
    uses: Ints
    """(E,) the number of faces at each edge."""


@dataclass(frozen=True, eq=False)
class Winding:
    """How the faces of a mesh are wound."""

    patch: Ints
    """(T,) the patch of each face."""
    against: Bools
    """(T,) True for faces wound against most of their patch."""
    one_sided: int
    """Number of patches that have one side only."""


def half_edges(faces: Ints) -> HalfEdges:
    """List the half-edges of triangles (T, 3); faces collapsed to a line or a point have no winding
    and none here."""
    real = np.flatnonzero((faces != np.roll(faces, -1, axis=1)).all(axis=1))
    tail = faces[real].ravel()
    head = np.roll(faces[real], -1, axis=1).ravel()
    key = np.minimum(tail, head) * (int(faces.max(initial=0)) + 1) + np.maximum(tail, head)
    edge, uses = np.unique(key, return_inverse=True, return_counts=True)[1:]
    return HalfEdges(np.repeat(real, 3), edge.reshape(-1), np.sign(head - tail), uses)


def balanced(halves: HalfEdges, turned: Bools) -> bool:
    """True where each edge is run along as often one way as the other, once the `turned` faces (T,)
    are turned."""
    sense = np.where(turned[halves.face], -halves.sense, halves.sense)
    return len(halves.edge) > 0 and not np.any(np.bincount(halves.edge, sense, len(halves.uses)))


def way_round(faces: Ints) -> Ints:
    """(T,) +1 or -1: which way round triangles (T, 3) are wound on their corners."""
    row = np.arange(len(faces))
    first = np.argmin(faces, axis=1)
    way: Ints = np.where(faces[row, (first + 1) % 3] < faces[row, (first + 2) % 3], 1, -1)
    return way


def consistent_winding(count: int, halves: HalfEdges) -> Winding:
    """Find the patches of `count` faces and the faces that are wound against most of their patch.

    Where a patch is in two halves of equal size, the half of its first face is taken to be right.
    """
    two = halves.uses[halves.edge] == 2
    order = np.flatnonzero(two)[np.argsort(halves.edge[two], kind="stable")]
    one = order[::2]
    other = order[1::2]
    alike = halves.sense[one] != halves.sense[other]
    a = halves.face[one]
    b = halves.face[other]
    if alike.all():
        return Winding(component_labels(a, b, count), np.zeros(count, dtype=np.bool_), 0)
    cover = component_labels(
        np.concatenate([a, a + count]),
        np.concatenate([np.where(alike, b, b + count), np.where(alike, b + count, b)]),
        2 * count,
    )
    first_way = cover[:count]
    second_way = cover[count:]
    patch = np.unique(np.minimum(first_way, second_way), return_inverse=True)[1].reshape(-1)
    one_sided = first_way == second_way
    other_way = first_way > second_way
    start = np.unique(patch, return_index=True)[1]
    differs = other_way != other_way[start][patch]  # from the first face of the patch
    most = 2 * np.bincount(patch, differs) > np.bincount(patch)
    against: Bools = (differs != most[patch]) & ~one_sided
    return Winding(patch, against, len(np.unique(patch[one_sided])))


def component_labels(one: Ints, other: Ints, count: int) -> Ints:
    """(count,) the connected component of each node of a graph with the links one[i] - other[i]."""
    from scipy.sparse import coo_array  # takes a third of a second to load
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)
