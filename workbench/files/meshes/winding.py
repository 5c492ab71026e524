"""Make the winding of a mesh consistent, as far as its edges determine it.

Two faces that share an edge are wound alike if they run along it in opposite senses. Faces that are
connected through edges of exactly two faces form a patch. The relation "wound alike or not" is
propagated through a patch by the connected components of its double cover: each face is two nodes,
one for each sense of winding.

- If both nodes of a face fall into one component, the patch has one side only (a Moebius strip),
  and no winding is consistent.
- Otherwise the faces of a patch fall into two groups, and the smaller one is wound against the
  larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.geometry.components import component_labels
from workbench.model.arrays import Bools, Ints

__all__ = [
    "HalfEdges",
    "Winding",
    "consistent_winding",
    "edge_keys",
    "half_edges",
    "is_closed",
    "winding_sense",
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


def edge_keys(tail: Ints, head: Ints, vertices: int) -> Ints:
    """Number undirected edges (N,), the same for both directions; `vertices`: number of vertices."""
    return np.minimum(tail, head) * vertices + np.maximum(tail, head)


def half_edges(faces: Ints) -> HalfEdges:
    """List the half-edges of triangles (T, 3).

    Faces collapsed to a line or a point have no winding, and none here.
    """
    real = np.flatnonzero((faces != np.roll(faces, -1, axis=1)).all(axis=1))
    tail = faces[real].ravel()
    head = np.roll(faces[real], -1, axis=1).ravel()
    key = edge_keys(tail, head, int(faces.max(initial=0)) + 1)
    edge, uses = np.unique(key, return_inverse=True, return_counts=True)[1:]
    return HalfEdges(np.repeat(real, 3), edge.reshape(-1), np.sign(head - tail), uses)


def is_closed(halves: HalfEdges, turned: Bools) -> bool:
    """Return whether each edge is run along as often one way as the other.

    Parameters
    ----------
    halves
        The half-edges of a mesh.
    turned
        (T,) faces that count as wound the other way.
    """
    sense = np.where(turned[halves.face], -halves.sense, halves.sense)
    return len(halves.edge) > 0 and not np.any(np.bincount(halves.edge, sense, len(halves.uses)))


def winding_sense(faces: Ints) -> Ints:
    """Return +1 or -1 (T,): the parity of the corners of triangles (T, 3) against ascending order."""
    row = np.arange(len(faces))
    first = np.argmin(faces, axis=1)
    ascending = faces[row, (first + 1) % 3] < faces[row, (first + 2) % 3]
    return np.where(ascending, 1, -1)


def consistent_winding(count: int, halves: HalfEdges) -> Winding:
    """Find the patches of a mesh and the faces that are wound against most of their patch.

    If a patch is in two halves of equal size, the half of its first face counts as right.

    Parameters
    ----------
    count
        Number of faces T.
    halves
        Their half-edges.
    """
    two = halves.uses[halves.edge] == 2
    order = np.flatnonzero(two)[np.argsort(halves.edge[two], kind="stable")]
    alike = halves.sense[order[::2]] != halves.sense[order[1::2]]
    one = halves.face[order[::2]]
    other = halves.face[order[1::2]]
    if alike.all():
        return Winding(component_labels(one, other, count), np.zeros(count, dtype=np.bool_), 0)
    # node f is face f as wound, node f + count the same face turned
    cover = component_labels(
        np.concatenate([one, one + count]),
        np.concatenate(
            [np.where(alike, other, other + count), np.where(alike, other + count, other)]
        ),
        2 * count,
    )
    return _winding_from_cover(cover[:count], cover[count:])


def _winding_from_cover(as_wound: Ints, turned: Ints) -> Winding:
    """Read the winding from the components (T,) of both nodes of each face."""
    patch = np.unique(np.minimum(as_wound, turned), return_inverse=True)[1].reshape(-1)
    one_sided = as_wound == turned
    group = as_wound > turned
    first = np.unique(patch, return_index=True)[1]
    differs = group != group[first][patch]  # from the first face of the patch
    most_differ = 2 * np.bincount(patch, differs) > np.bincount(patch)
    against: Bools = (differs != most_differ[patch]) & ~one_sided
    return Winding(patch, against, len(np.unique(patch[one_sided])))
