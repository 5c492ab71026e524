"""Validate the mesh of a part: count its defects, and repair what its edges determine.

Four things are repaired, and each is reported: faces that lie exactly on others are removed, faces
wound against their neighbours are turned, closed shells that are inside out are turned, and solids
that overlap are united. All but the first only if the part comes out closed: what stays open is a
surface, whose winding decides nothing. The order of the faces stays, those of unions come last.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import manifold3d
import numpy as np

from workbench.files.meshes.parts import RawPart, weld
from workbench.files.meshes.polygons import degenerate_faces, face_planes
from workbench.files.meshes.shells import OrientedShells, one_shell, orient_shells, shell_labels
from workbench.files.meshes.winding import (
    HalfEdges,
    Winding,
    consistent_winding,
    half_edges,
    is_closed,
    winding_sense,
)
from workbench.geometry.box_pairs import box_pairs
from workbench.geometry.components import component_labels
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import HARMLESS

__all__ = ["Defect", "MeshDefects", "united", "validate_part"]


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
        else:
            crowded += HARMLESS
        turned = (": turned" if self.closed else "") + HARMLESS
        shell = "closed shell"
        kinds = [
            Defect(self.degenerate, "degenerate face", f" kept (without area){HARMLESS}"),
            Defect(self.duplicate, "duplicate face", f" left out (exactly on others){HARMLESS}"),
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
    return np.where(which[:, None], faces[:, [0, 2, 1]], faces)


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
    return _first_copies(faces) & _outer_copies(faces)


def _outer_copies(faces: Ints) -> Bools:
    """Return all copies (T,), without inner walls: a face that two solids have, of which one lies
    in the other, is part of both."""
    sets, inverse = np.unique(_corner_sets(faces), return_inverse=True)
    total = np.bincount(inverse.reshape(-1), winding_sense(faces), len(sets))
    return (total != 0)[inverse.reshape(-1)]


# Unite the solids of a part: the depth of a point counts only faces of their union's surface.
#
# A face of one solid that lies inside another bounds nothing, but would be nearest to a point beside
# it: in a block modelled as two boxes that overlap, a point 166 mm deep would read 28 mm.

_BLOCK = 1_000
"""Boxes of solids that are compared with all others at a time."""
_GRID = 2.0**-34
"""Spacing [m] of the grid onto which corners of united solids are rounded, 0.06 nm: walls that touch
but for rounding shall leave no gap."""
_GAP = 2e-4
"""Gap [m] between solids of one part up to which they touch: a wall that both have is cut into other
triangles in each, and corners are written with some digits, 0.1 mm in a file in metres with four."""
_LEAST = 1e-6
"""Least growth [m] of solids that closes a gap: less is lost in the rounding of a union."""
_SHARPEST = 0.2
"""Least cosine between the way of a corner that grows and the normals of its faces."""
_FEW = 100
"""Faces that are compared with all others at a time."""
_FACING = -0.999
"""Greatest cosine between the normals of faces that face each other."""


def united(part: RawPart, shells: OrientedShells) -> tuple[RawPart, int]:
    """Replace solids of a part that overlap, touch or lie in each other by their union.

    Solids that are apart keep their faces. So do those whose own shells cross, since a union takes
    solids that don't.

    Parameters
    ----------
    part
        Closed, with its shells outward and its cavities inward.
    shells
        Which solid each face bounds.

    Returns
    -------
    tuple[RawPart, int]
        The part, and the number of solids that could not be united.
    """
    number, body = np.unique(shells.body, return_inverse=True)
    body = body.reshape(-1)
    left_out = shells.tangled[number].copy()
    faces = [part.faces]
    vertices = [part.vertices]
    gone = np.zeros(len(number), dtype=np.bool_)
    rounded = RawPart(part.name, np.round(part.vertices / _GRID) * _GRID, part.faces)
    of_solid = np.split(np.argsort(body, kind="stable"), np.cumsum(np.bincount(body))[:-1])
    for cluster in _clusters(part, body, len(number)):
        made = {k: _solid(rounded, of_solid[k]) for k in cluster[~left_out[cluster]]}
        sound = [k for k, one in made.items() if one.status() == manifold3d.Error.NoError]
        left_out[np.setdiff1d(cluster, sound)] = True
        whole = manifold3d.Manifold.batch_boolean([made[k] for k in sound], manifold3d.OpType.Add)
        gap = _widest_gap(whole)
        if gap > 0:
            grown = [_solid(rounded, of_solid[k], grown=max(0.75 * gap, _LEAST)) for k in sound]
            whole = manifold3d.Manifold.batch_boolean(grown, manifold3d.OpType.Add)
        if sum(one.volume() > 0 for one in whole.decompose()) == len(sound):
            continue  # all of them are apart
        mesh = whole.to_mesh64()
        faces.append(np.asarray(mesh.tri_verts, dtype=np.int64) + sum(map(len, vertices)))
        vertices.append(np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3])
        gone[sound] = True
    if not gone.any():
        return part, int(left_out.sum())
    faces[0] = part.faces[~gone[body]]
    mended = RawPart(part.name, *weld(np.concatenate(vertices), np.concatenate(faces)))
    return mended, int(left_out.sum())


def _solid(part: RawPart, chosen: Ints, *, grown: float = 0.0) -> manifold3d.Manifold:
    """The solid that some faces of a part bound, with each corner so far out that every plane at it
    has moved by `grown` [m] at least."""
    points, corners = weld(part.vertices, part.faces[chosen])
    planes = face_planes(points, corners)
    normal = np.repeat(planes.normal * ~planes.flat[:, None], 3, axis=0)
    of = corners.reshape(-1)
    out = np.zeros_like(points)
    np.add.at(out, of, normal)
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), _LEAST)
    along = np.ones(len(points))
    np.minimum.at(along, of, np.einsum("nc,nc->n", normal, out[of]))
    points = points + grown * out / np.maximum(along, _SHARPEST)[:, None]
    return manifold3d.Manifold(manifold3d.Mesh64(points, corners.astype(np.uint64)))


def _widest_gap(whole: manifold3d.Manifold) -> float:
    """The widest gap [m] up to `_GAP` between faces of a solid that face each other; 0 without any."""
    mesh = whole.to_mesh64()
    vertices = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
    planes = face_planes(vertices, np.asarray(mesh.tri_verts, dtype=np.int64))
    corner = vertices[planes.faces[~planes.flat]]
    normal = planes.normal[~planes.flat]
    box = np.hstack([corner.min(axis=1) - _GAP, corner.max(axis=1) + _GAP])
    axes = np.argsort(np.ptp(vertices, axis=0))[[-2, -1, -2, -1]] + [0, 0, 3, 3]
    widest = 0.0
    for first in range(0, len(box), _FEW):
        one, other = box_pairs(box[first : first + _FEW, axes], box[:, axes])
        one += first
        near = np.einsum("nc,nc->n", normal[one], normal[other]) < _FACING
        one, other = one[near], other[near]
        near = (box[one, :3] <= box[other, 3:]).all(axis=1)
        near &= (box[other, :3] <= box[one, 3:]).all(axis=1)
        one, other = one[near], other[near]
        ahead = np.einsum("nkc,nc->nk", corner[other] - corner[one, :1], normal[one])
        between = ahead.max(axis=1)[(ahead.min(axis=1) < _GAP) & (ahead.max(axis=1) > 0)]
        widest = max(widest, min(float(between.max(initial=0.0)), _GAP))
    return widest


def _clusters(part: RawPart, body: Ints, count: int) -> Iterator[Ints]:
    """The solids of each group whose boxes touch, where it has more than one; body (T,): the solid
    of each face, from 0. Solids that are flat enclose nothing and belong to none."""
    if count < 2:
        return
    corner = part.vertices[part.faces]
    low = _by_solid(np.minimum, corner.min(axis=1), body)
    high = _by_solid(np.maximum, corner.max(axis=1), body)
    thick = np.flatnonzero((high > low).all(axis=1))
    pairs = []
    for first in range(0, len(thick), _BLOCK):
        some = thick[first : first + _BLOCK]
        near = (low[some, None] <= high[thick] + _GAP) & (high[some, None] >= low[thick] - _GAP)
        pairs.append(np.argwhere(near.all(axis=2)) + np.array([first, 0]))
    one, other = np.concatenate([np.zeros((0, 2), dtype=np.int64), *pairs]).T
    label = component_labels(one, other, len(thick))
    order = np.argsort(label, kind="stable")
    for members in np.split(thick[order], np.flatnonzero(np.diff(label[order])) + 1):
        if len(members) > 1:
            yield members


def _by_solid(which: np.ufunc, rows: Floats, body: Ints) -> Floats:
    """The least or greatest (M, 3) of the rows (T, 3) of each solid."""
    order = np.argsort(body, kind="stable")
    start = np.flatnonzero(np.diff(body[order], prepend=-1))
    return which.reduceat(rows[order], start, axis=0)
