"""Examine the mesh of a part: count its faults, and mend what its edges determine.

Three things are mended, and each is reported: faces that lie exactly on others are left out, faces
wound against their neighbours are turned, and closed shells that are inside out are turned. Winding
is mended only where the part comes out closed: what stays open is a surface, whose winding decides
nothing. Mending keeps the order of the faces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.meshes.planes import degenerate_faces
from workbench.files.meshes.shells import Shells, shell_labels, sorted_shells
from workbench.files.meshes.winding import (
    HalfEdges,
    Winding,
    balanced,
    consistent_winding,
    half_edges,
    way_round,
)
from workbench.model.arrays import Bools, Ints

__all__ = ["Fault", "Faults", "examined"]


@dataclass(frozen=True)
class Fault:
    """One kind of fault: how often it is there, what is counted, and what it means or what was
    done."""

    count: int
    what: str
    meaning: str

    def sentence(self) -> str:
        """The fault in plain words."""
        return f"{self.count} {self.what}{'' if self.count == 1 else 's'}{self.meaning}"


@dataclass(frozen=True)
class Faults:
    """What was found in the mesh of one part."""

    faces: int
    """Triangles as read."""
    degenerate: int
    duplicate: int
    """Faces that lie exactly on others of the part."""
    open_edges: int
    """Edges that only one face has."""
    crowded_edges: int
    """Edges that three or more faces have."""
    against: int
    """Faces wound against most of those they are connected with."""
    one_sided: int
    """Patches without a consistent winding, such as a Moebius strip."""
    turned: int
    """Closed shells inside out."""
    cavities: int
    nested: int
    """Closed shells inside others and wound alike."""
    crossing: int
    """Closed shells that cross others or themselves."""
    closed: bool
    """No edge is open, and the winding is consistent after mending."""

    def found(self) -> list[Fault]:
        """The faults that there are, each with its count."""
        surface = ": a surface, not a solid; what lies wholly inside is not noticed"
        unknown = self.open_edges == 0 and not self.closed
        rows = [
            Fault(self.degenerate, "degenerate face", " kept (without area, they count as lines)"),
            Fault(self.duplicate, "duplicate face", " left out (exactly on others)"),
            Fault(self.open_edges, "open edge", surface),
            Fault(self.crowded_edges, "edge", " shared by more than two faces" + surface * unknown),
            Fault(
                self.one_sided,
                "patch",
                " with one side only, as a Moebius strip has" + surface * unknown,
            ),
            Fault(
                self.against,
                "face",
                " wound against neighbours" + (": turned" if self.closed else ""),
            ),
            Fault(self.turned, "closed shell", " inside out: turned for the inside/outside test"),
            Fault(
                self.nested,
                "closed shell",
                " inside others, wound alike: solid in solid, counted once",
            ),
            Fault(
                self.crossing,
                "closed shell",
                " crossing others or themselves: what they enclose is solid",
            ),
        ]
        return [row for row in rows if row.count]

    def sentences(self) -> list[str]:
        """The faults in plain words."""
        return [fault.sentence() for fault in self.found()]


@dataclass(frozen=True, eq=False)
class _Mesh:
    """Faces without copies, and how they are wound."""

    faces: Ints
    halves: HalfEdges
    winding: Winding
    closed: bool


def examined(part: RawPart) -> tuple[RawPart, Faults]:
    """Count the faults of a part and mend it.

    Returns the part without duplicate faces, wound consistently and with its shells outward where
    it is closed, and what was found. Lengths in metres.
    """
    mesh = _measured(part.faces[_firsts(part.faces)])
    if not mesh.closed:
        without_walls = part.faces[_unpaired(part.faces)]
        if len(without_walls) < len(mesh.faces):
            other = _measured(without_walls)
            mesh = other if other.closed else mesh
    faces = mesh.faces
    shells = Shells(np.zeros(len(faces), dtype=np.bool_), 0, 0, 0, 0)
    if mesh.closed:
        against = mesh.winding.against
        sense = np.where(against[mesh.halves.face], -mesh.halves.sense, mesh.halves.sense)
        faces = _turned(faces, against)
        shells = sorted_shells(
            part.vertices, faces, shell_labels(mesh.halves, mesh.winding.patch, sense)
        )
        faces = _turned(faces, shells.inward)
    found = Faults(
        faces=len(part.faces),
        degenerate=int(degenerate_faces(part.vertices, part.faces).sum()),
        duplicate=len(part.faces) - len(faces),
        open_edges=int((mesh.halves.uses == 1).sum()),
        crowded_edges=int((mesh.halves.uses > 2).sum()),
        against=int(mesh.winding.against.sum()),
        one_sided=mesh.winding.one_sided,
        turned=shells.turned,
        cavities=shells.cavities,
        nested=shells.nested,
        crossing=shells.crossing,
        closed=mesh.closed,
    )
    return RawPart(part.name, part.vertices, faces), found


def _measured(faces: Ints) -> _Mesh:
    halves = half_edges(faces)
    winding = consistent_winding(len(faces), halves)
    return _Mesh(faces, halves, winding, balanced(halves, winding.against))


def _turned(faces: Ints, which: Bools) -> Ints:
    """The faces with some wound the other way; each keeps its first corner."""
    turned: Ints = np.where(which[:, None], faces[:, [0, 2, 1]], faces)
    return turned


def _copies(faces: Ints) -> tuple[Ints, Ints]:
    """(T,) the set of corners of each face, by number; and +1 or -1: which way round it is wound on
    them.

    Faces collapsed to a line or a point are sets of their own.
    """
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)
    label = np.empty(len(faces), dtype=np.int64)
    label[order] = np.cumsum(np.append(False, (np.diff(corners[order], axis=0) != 0).any(axis=1)))[
        : len(faces)
    ]
    collapsed = np.flatnonzero((np.diff(corners, axis=1) == 0).any(axis=1))
    label[collapsed] = len(faces) + np.arange(len(collapsed))
    return label, way_round(faces)


def _firsts(faces: Ints) -> Bools:
    """(T,) True for the first face on its three corners; a copy wound the other way is a copy too:
    it is the second side of a sheet, which has no thickness. Faces collapsed to a line are kept."""
    kept = np.zeros(len(faces), dtype=np.bool_)
    kept[np.unique(_copies(faces)[0], return_index=True)[1]] = True
    return kept


def _unpaired(faces: Ints) -> Bools:
    """(T,) as `_firsts`, but also without faces that lie on each other as often one way round as
    the other.

    Such a pair is the wall between two shells that touch: without it they are one closed shell.
    """
    label, sense = _copies(faces)
    kept = _firsts(faces)
    sets, inverse = np.unique(label, return_inverse=True)
    unpaired: Bools = (
        kept & (np.bincount(inverse.reshape(-1), sense, len(sets)) != 0)[inverse.reshape(-1)]
    )
    return unpaired
