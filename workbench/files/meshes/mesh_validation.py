"""Validate the mesh of a part: count its defects, and repair what its edges determine.

Four things are repaired, and each is reported: faces that lie exactly on others are removed, faces
wound against their neighbours are turned, closed shells that are inside out are turned, and solids
that overlap are united. All but the first only if the part comes out closed: what stays open is a
surface, whose winding decides nothing. The order of the faces stays, those of unions come last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.meshes.planes import degenerate_faces
from workbench.files.meshes.shells import OrientedShells, one_shell, orient_shells, shell_labels
from workbench.files.meshes.union import united
from workbench.files.meshes.winding import (
    HalfEdges,
    Winding,
    consistent_winding,
    half_edges,
    is_closed,
    winding_sense,
)
from workbench.model.arrays import Bools, Ints

__all__ = ["Defect", "MeshDefects", "validate_part"]


@dataclass(frozen=True)
class Defect:
    """One kind of defect."""

    count: int
    what: str
    """What is counted, in the singular."""
    meaning: str
    """What it means, or what was done."""

    def sentence(self) -> str:
        """Return the defect in words."""
        return f"{self.count} {self.what}{'' if self.count == 1 else 's'}{self.meaning}"


@dataclass(frozen=True)
class MeshDefects:
    """The defects of the mesh of one part."""

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
    tangled: int
    """Solids whose own shells cross, so that no union removes the faces inside."""
    closed: bool
    """No edge is open, and the winding is consistent after repair."""

    def present(self) -> list[Defect]:
        """Return the kinds of defects that the mesh has."""
        surface = ": a surface, not a solid; what lies wholly inside is not noticed, and a depth is a lower bound"
        crowded = " shared by more than two faces"
        one_sided = " with one side only, as a Moebius strip has"
        if self.open_edges == 0 and not self.closed:  # the reason why it is no solid
            crowded += surface
            one_sided += surface
        turned = ": turned" if self.closed else ""
        shell = "closed shell"
        kinds = [
            Defect(self.degenerate, "degenerate face", " kept (without area, they count as lines)"),
            Defect(self.duplicate, "duplicate face", " left out (exactly on others)"),
            Defect(self.open_edges, "open edge", surface),
            Defect(self.crowded_edges, "edge", crowded),
            Defect(self.one_sided, "patch", one_sided),
            Defect(self.against, "face", " wound against neighbours" + turned),
            Defect(self.turned, shell, " inside out: turned for the inside/outside test"),
            Defect(self.nested, shell, " inside others, wound alike: solid in solid, counted once"),
            Defect(
                self.crossing, shell, " crossing others or themselves: what they enclose is solid"
            ),
            Defect(
                self.tangled,
                "solid",
                " crossing itself, which cannot be united: depths in it are lower bounds, since "
                "faces inside count; mend the mesh (Blender: Boolean, Union, self intersection)",
            ),
        ]
        return [kind for kind in kinds if kind.count]

    def sentences(self) -> list[str]:
        """Return the defects in words."""
        return [defect.sentence() for defect in self.present()]


@dataclass(frozen=True, eq=False)
class _WoundMesh:
    """Faces without duplicates, and how they are wound."""

    faces: Ints
    halves: HalfEdges
    winding: Winding
    closed: bool


def validate_part(part: RawPart, *, solid: bool = True) -> tuple[RawPart, MeshDefects]:
    """Count the defects of a part and repair it.

    Parameters
    ----------
    part
        A part, lengths in metres.
    solid
        Whether it is a solid where it is closed: its solids are then united.

    Returns
    -------
    tuple[RawPart, MeshDefects]
        The part without duplicate faces; if it is closed, wound consistently and with its shells
        outward, and of solids that overlap or touch only the surface of their union. And the
        defects that it had.
    """
    mesh = _wound_mesh(part.faces[_first_copies(part.faces)])
    if not mesh.closed:
        without_walls = part.faces[_without_inner_walls(part.faces)]
        if len(without_walls) < len(mesh.faces):
            other = _wound_mesh(without_walls)
            mesh = other if other.closed else mesh
    if not mesh.closed:
        every = _wound_mesh(part.faces[_outer_copies(part.faces)])
        mesh = every if every.closed else mesh
    faces, shells = _oriented_faces(part, mesh)
    made = RawPart(part.name, part.vertices, faces)
    apart = 0
    if solid and mesh.closed:
        made, apart = united(made, shells)
    uses = mesh.halves.uses
    defects = MeshDefects(
        faces=len(part.faces),
        degenerate=int(degenerate_faces(part.vertices, part.faces).sum()),
        duplicate=len(part.faces) - len(faces),
        open_edges=int((uses == 1).sum()),
        crowded_edges=int((uses > 2).sum()),
        against=int(mesh.winding.against.sum()),
        one_sided=mesh.winding.one_sided,
        turned=shells.turned,
        cavities=shells.cavities,
        nested=shells.nested,
        crossing=shells.crossing,
        tangled=apart,
        closed=mesh.closed,
    )
    return made, defects


def _wound_mesh(faces: Ints) -> _WoundMesh:
    halves = half_edges(faces)
    winding = consistent_winding(len(faces), halves)
    return _WoundMesh(faces, halves, winding, is_closed(halves, winding.against))


def _oriented_faces(part: RawPart, mesh: _WoundMesh) -> tuple[Ints, OrientedShells]:
    """Turn the faces of a closed mesh outward; an open one stays as it is."""
    if not mesh.closed:
        return mesh.faces, one_shell(len(mesh.faces), inward=False)
    against = mesh.winding.against
    sense = np.where(against[mesh.halves.face], -mesh.halves.sense, mesh.halves.sense)
    faces = _flip(mesh.faces, against)
    labels = shell_labels(mesh.halves, mesh.winding.patch, sense)
    shells = orient_shells(part.vertices, faces, labels)
    return _flip(faces, shells.inward), shells


def _flip(faces: Ints, which: Bools) -> Ints:
    """Wind some faces the other way; each keeps its first corner."""
    flipped: Ints = np.where(which[:, None], faces[:, [0, 2, 1]], faces)
    return flipped


def _corner_sets(faces: Ints) -> Ints:
    """Number the sets of corners (T,) of faces, so that copies have one number.

    Faces collapsed to a line or a point have numbers of their own.
    """
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)
    differs = (np.diff(corners[order], axis=0) != 0).any(axis=1)
    label = np.empty(len(faces), dtype=np.int64)
    label[order] = np.cumsum(np.append(False, differs))[: len(faces)]
    collapsed = np.flatnonzero((np.diff(corners, axis=1) == 0).any(axis=1))
    label[collapsed] = len(faces) + np.arange(len(collapsed))
    return label


def _first_copies(faces: Ints) -> Bools:
    """Return which faces (T,) are the first on their three corners.

    A copy wound the other way is a copy too: the second side of a sheet, which has no thickness.
    Faces collapsed to a line are kept.
    """
    kept = np.zeros(len(faces), dtype=np.bool_)
    kept[np.unique(_corner_sets(faces), return_index=True)[1]] = True
    return kept


def _without_inner_walls(faces: Ints) -> Bools:
    """Return the first copies (T,), without faces that lie on each other as often one way round as
    the other.

    Such a pair is the wall between two shells that touch: without it they are one closed shell.
    """
    outer: Bools = _first_copies(faces) & _outer_copies(faces)
    return outer


def _outer_copies(faces: Ints) -> Bools:
    """Return all copies (T,), without inner walls: a face that two solids have, of which one lies
    in the other, is part of both."""
    sets, inverse = np.unique(_corner_sets(faces), return_inverse=True)
    total = np.bincount(inverse.reshape(-1), winding_sense(faces), len(sets))
    outer: Bools = (total != 0)[inverse.reshape(-1)]
    return outer
