"""What is wrong with a mesh, counted and told; and the two things that are mended, with a word: faces that lie exactly
on others are left out, and closed shells that are inside out are turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.meshes.planes import degenerate_faces
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Faults", "examined"]


@dataclass(frozen=True)
class Faults:
    """Counts for one part: triangles as read, degenerate and duplicate ones, edges that only one face has, edges that
    three or more have, shells turned; closed: consistently wound with no edge open."""

    faces: int
    degenerate: int
    duplicate: int
    open_edges: int
    crowded_edges: int
    turned: int
    closed: bool

    def sentences(self) -> list[str]:
        """What there is to say, in plain words."""
        said = [
            f"{_count(self.degenerate, 'degenerate face')} kept (without area, they count as lines)",
            f"{_count(self.duplicate, 'duplicate face')} left out (exactly on others)",
            f"{_count(self.open_edges, 'open edge')}: a surface, not a solid; what lies wholly inside is not noticed",
            f"{_count(self.crowded_edges, 'edge')} shared by more than two faces",
            f"{_count(self.turned, 'closed shell')} inside out: turned for the inside/outside test",
        ]
        number = (self.degenerate, self.duplicate, self.open_edges, self.crowded_edges, self.turned)
        return [sentence for sentence, n in zip(said, number, strict=True) if n]


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


def examined(part: RawPart) -> tuple[RawPart, Faults]:
    """The part without duplicate faces and with its shells turned outward, and what was found. Lengths in metres."""
    kept = _firsts(part.faces)
    faces = part.faces[kept]
    edge, sense, uses = _edges(faces)
    balanced = np.bincount(edge, sense, len(uses)) == 0
    closed = bool(len(faces) and balanced.all())
    inward = _inward(part.vertices, faces, edge) if closed else np.zeros(len(faces), dtype=np.bool_)
    faces = np.where(inward[:, None], faces[:, ::-1], faces)
    found = Faults(
        faces=len(part.faces),
        degenerate=int(degenerate_faces(part.vertices, part.faces).sum()),
        duplicate=int((~kept).sum()),
        open_edges=int((uses == 1).sum()),
        crowded_edges=int((uses > 2).sum()),
        turned=len(np.unique(_shells(faces, edge)[inward])) if inward.any() else 0,
        closed=closed,
    )
    return RawPart(part.name, part.vertices, faces), found


def _firsts(faces: Ints) -> Bools:
    """(T,) True for the first face on its three corners; a copy wound the other way is a copy too: it is the second
    side of a sheet, which has no thickness. Faces collapsed to a line are kept."""
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)
    copy = np.zeros(len(faces), dtype=np.bool_)
    copy[order[1:]] = (np.diff(corners[order], axis=0) == 0).all(axis=1)
    collapsed: Bools = (np.diff(corners, axis=1) == 0).any(axis=1)
    return ~copy | collapsed


def _edges(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """(3 T,) the edge of each half-edge and its sense (+1, -1; 0 for one from a vertex to itself), (E,) its uses."""
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    key = np.minimum(tail, head) * (int(faces.max(initial=0)) + 1) + np.maximum(tail, head)
    edge, uses = np.unique(key, return_inverse=True, return_counts=True)[1:]
    itself = np.bincount(edge[tail == head], minlength=len(uses)) > 0
    return edge, np.sign(head - tail), np.where(itself, 0, uses)


def _shells(faces: Ints, edge: Ints) -> Ints:
    """(T,) the shell of each face: connected through edges."""
    from scipy.sparse import coo_array  # takes a third of a second to load
    from scipy.sparse.csgraph import connected_components

    face = np.repeat(np.arange(len(faces)), 3)
    size = len(faces) + int(edge.max(initial=-1)) + 1
    graph = coo_array((np.ones(len(face), dtype=np.int8), (face, edge + len(faces))), shape=(size, size))
    label = connected_components(graph, directed=False)[1][: len(faces)]
    return np.unique(label, return_inverse=True)[1].astype(np.int64)


def _inward(vertices: Floats, faces: Ints, edge: Ints) -> Bools:
    """(T,) faces of closed shells with negative volume that lie in no shell of positive volume (those are cavities)."""
    shell = _shells(faces, edge)
    corner = vertices[faces] - vertices[faces].reshape(-1, 3).mean(axis=0)
    volume = np.bincount(shell, np.einsum("nc,nc->n", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6)
    order = np.argsort(shell, kind="stable")
    first = np.searchsorted(shell[order], np.arange(len(volume)))
    low = np.minimum.reduceat(corner.min(axis=1)[order], first)
    high = np.maximum.reduceat(corner.max(axis=1)[order], first)
    outer = np.flatnonzero(volume > 0)
    turned = np.zeros(len(volume), dtype=np.bool_)
    for one in np.flatnonzero(volume < 0):
        around = (low[outer] <= low[one]).all(axis=1) & (high[one] <= high[outer]).all(axis=1)
        turned[one] = not around.any()
    inward: Bools = turned[shell]
    return inward
