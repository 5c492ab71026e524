"""The meshes of an environment that is described: as they are in their files, and as they stand in
the world with the parts that they have there.

Every face has one number, through all parts of all meshes as they are in their files. It stays
whatever becomes of units, axes and parts.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_own import PartMeshes, Touching
from workbench.files.environment_parts import face_parts, pieces
from workbench.files.environment_schema import MeshFile
from workbench.files.environments import MeshFrame, mesh_frame, size_doubts
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.reading import (
    LARGEST,
    SMALLEST,
    SMALLEST_OF_SEVERAL,
    implausible,
    read_mesh,
)
from workbench.files.seat_figures import SeatFigures
from workbench.files.surface_planes import Surface, grown_faces, outline
from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Doubt

__all__ = ["MOST_FACES", "Hit", "Meshes", "PlacedMeshes", "Ray"]

MOST_FACES = 3_000_000
"""Triangles that are described: of more, each answer would take seconds."""
HIGHEST = 12.0
"""A place for people that is higher [m] is doubted."""
SAME_PLACE = 0.005
"""What is met so near [m] to where it was clicked is what was clicked."""
_PARALLEL = 1e-12
_KEPT = 4
"""Ways in which the meshes have stood that are kept: undo and redo go back to them."""


@dataclass(frozen=True)
class Ray:
    """Where a picture was clicked.

    Parameters
    ----------
    part
        The part that is seen there.
    start, way
        The eye [m], and the direction from it.
    far
        How far [m] along it the picture was met.
    """

    part: str
    start: tuple[float, float, float]
    way: tuple[float, float, float]
    far: float


@dataclass(frozen=True, eq=False)
class Hit:
    """A face, and the point (3,) [m] of it that was met."""

    face: int
    point: Floats


@dataclass(frozen=True, eq=False)
class PlacedMeshes:
    """The meshes in the world.

    Parameters
    ----------
    vertices
        (V, 3) [m] of all meshes.
    faces
        (T, 3) of all meshes, in their order.
    part
        (T,) index into `names`, -1 of faces that are left out.
    names
        The parts.
    """

    vertices: Floats
    faces: Ints
    part: Ints
    names: tuple[str, ...]
    figures: dict[Hashable, SeatFigures] = field(default_factory=dict)
    """Of seats that were computed, by what was pointed at."""

    @cached_property
    def boxes(self) -> Floats:
        """(K, 2, 3) [m] the least and the greatest corner of each part."""
        found = np.empty((len(self.names), 2, 3))
        order = np.argsort(self.part, kind="stable")
        first = np.searchsorted(self.part[order], np.arange(len(self.names) + 1))
        for k in range(len(self.names)):
            points = self.vertices[self.faces[order[first[k] : first[k + 1]]].ravel()]
            found[k] = points.min(axis=0), points.max(axis=0)
        return found

    @cached_property
    def touching(self) -> Touching:
        """Which parts touch one another."""

        def triangles(part: int) -> Floats:
            return self.part_corners(self.names[part])

        return Touching(PartMeshes(self.names, self.boxes, triangles))

    def points(self, part: int) -> Floats:
        """(V, 3) [m] the vertices of a part, each once."""
        return self.vertices[np.unique(self.faces[self.part == part])]

    @cached_property
    def ground(self) -> Ground:
        """All faces that are not left out, to be stood on from both sides."""
        there = np.flatnonzero(self.part >= 0)
        part = self.part[there]
        one_sided = np.zeros(len(there), dtype=np.bool_)
        return Ground(self.corners(there), part, self.names, one_sided)

    @property
    def bounds(self) -> Floats:
        """(2, 3) [m] the box of all parts."""
        return np.array([self.boxes[:, 0].min(axis=0), self.boxes[:, 1].max(axis=0)])

    def corners(self, faces: Ints) -> Floats:
        """(N, 3, 3) [m] of some faces."""
        return self.vertices[self.faces[faces]]

    def part_corners(self, part: str) -> Floats:
        """(N, 3, 3) [m] the faces of a part."""
        return self.corners(np.flatnonzero(self.part == self.names.index(part)))

    def hit(self, ray: Ray) -> Hit:
        """Find the face that a ray meets, the one nearest to where the picture was met: a picture
        may be coarser than the mesh, and a section may hide what stands before. A part that has
        another name since it was clicked is found by its place.

        Raises
        ------
        InputError
            If the ray meets no face of the part.
        """
        there = ray.part in self.names
        own = np.flatnonzero(self.part == self.names.index(ray.part) if there else self.part >= 0)
        start = np.array(ray.start)
        way = np.array(ray.way) / (np.linalg.norm(ray.way) or 1.0)
        far = _met(self.corners(own), start, way)
        off = np.abs(np.where(np.isfinite(far), far, np.inf) - ray.far)
        best = int(off.argmin())
        if not there and off[best] > SAME_PLACE:
            raise InputError(f"there is no part {ray.part!r} any more")
        if not np.isfinite(off[best]):
            raise InputError("nothing was picked: click on a part in the picture")
        return Hit(int(own[best]), start + far[best] * way)

    def nearest(
        self, point: Floats, within: float, *, parts: Collection[int] | None = None
    ) -> Hit | None:
        """Find the face of a part, or of some by number, that a point (3,) [m] lies on, None where
        none is so near [m].

        The point of a face is that of the barycentric coordinates of the projection, each clipped
        to the face: the nearest one where the projection is inside, near enough elsewhere.
        """
        low = self.vertices[self.faces].min(axis=1) - within
        high = self.vertices[self.faces].max(axis=1) + within
        there = self.part >= 0 if parts is None else np.isin(self.part, list(parts))
        own = np.flatnonzero(((low <= point) & (point <= high)).all(axis=1) & there)
        if not len(own):
            return None
        a, b, c = np.moveaxis(self.corners(own), 1, 0)
        one, two, way = b - a, c - a, point - a
        aa, ab, bb = (np.einsum("ij,ij->i", x, y) for x, y in ((one, one), (one, two), (two, two)))
        pa, pb = (np.einsum("ij,ij->i", way, x) for x in (one, two))
        det = aa * bb - ab * ab
        safe = np.where(det > 0.0, det, 1.0)
        v = np.clip((bb * pa - ab * pb) / safe, 0.0, 1.0)
        w = np.clip((aa * pb - ab * pa) / safe, 0.0, 1.0 - v)
        met = a + v[:, None] * one + w[:, None] * two
        far = np.where(det > 0.0, np.linalg.norm(met - point, axis=1), np.inf)
        best = int(far.argmin())
        return Hit(int(own[best]), met[best]) if far[best] <= within else None


def _met(corners: Floats, start: Floats, way: Floats) -> Floats:
    """(T,) how far along a ray triangles (T, 3, 3) are met, infinite where they are not.

    Moeller and Trumbore (1997), Fast, minimum storage ray/triangle intersection, both sides.
    """
    a = corners[:, 0]
    one = corners[:, 1] - a
    two = corners[:, 2] - a
    p = np.cross(way, two)
    det = np.einsum("ij,ij->i", one, p)
    flat = np.abs(det) <= _PARALLEL * np.abs(one).max(initial=1e-300) ** 2
    safe = np.where(flat, 1.0, det)
    s = start - a
    u = np.einsum("ij,ij->i", s, p) / safe
    q = np.cross(s, one)
    v = (q @ way) / safe
    far = np.einsum("ij,ij->i", two, q) / safe
    slack = 1e-9  # a click on the edge between two faces is on one of them
    inside = (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack) & (far > 0.0) & ~flat
    return np.where(inside, far, np.inf)


class Meshes:
    """The mesh files of an environment.

    Parameters
    ----------
    raws
        As they were read.
    """

    def __init__(self, raws: Sequence[RawMesh]) -> None:
        self.raws = tuple(raws)
        count = sum(len(part.faces) for raw in raws for part in raw.parts)
        if count > MOST_FACES:
            raise InputError(
                f"{raws[0].file}: has {count:,} triangles, and {MOST_FACES:,} are possible here: "
                f"simplify the mesh"
            )
        parts = [part for raw in raws for part in raw.parts]
        first = np.cumsum([0, *(len(part.vertices) for part in parts)])
        self.vertices: Floats = np.concatenate([part.vertices for part in parts])
        self.faces: Ints = np.concatenate(
            [part.faces + start for part, start in zip(parts, first, strict=False)]
        )
        self.owner: Ints = np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts])
        """(T,) the part of the files that each face is of."""
        row = np.repeat(np.arange(len(raws)), [len(raw.parts) for raw in raws])
        self.mesh: Ints = row[self.owner]
        """(T,) the mesh that each face is of."""
        self._vertex_mesh = np.repeat(row, [len(part.vertices) for part in parts])
        self._stood: dict[tuple[str, ...], PlacedMeshes] = {}
        self._sizes: dict[tuple[str, ...], list[Doubt]] = {}
        self._grown: dict[tuple[int, ...], Ints] = {}
        self._borders: dict[tuple[int, ...], Ints] = {}
        self._surfaces: dict[tuple[int, ...], Surface] = {}
        self._pieces: dict[int, int] = {}

    def piece_count(self, owner: int) -> int:
        """Connected pieces of a part of the files, by its number."""
        if owner not in self._pieces:
            parts = [part for raw in self.raws for part in raw.parts]
            self._pieces[owner] = int(pieces(parts[owner]).max()) + 1
        return self._pieces[owner]

    @classmethod
    def read(cls, folder: Path, files: Sequence[str]) -> Meshes:
        """Read the meshes of an environment. InputError as of `read_mesh`."""
        return cls([read_mesh(folder / file) for file in files])

    def standing(self, says: Sequence[MeshFile]) -> PlacedMeshes:
        """Return the meshes as an environment has them.

        Parameters
        ----------
        says
            What it says of each; files beyond are left out.

        Raises
        ------
        InputError
            If axes are not at right angles, or parts are named that are not there.
        """
        key = tuple(mesh.model_dump_json() for mesh in says)
        if key not in self._stood:
            while len(self._stood) >= _KEPT:
                del self._stood[next(iter(self._stood))]
            self._stood[key] = self._stand(says)
        return self._stood[key]

    def _stand(self, says: Sequence[MeshFile]) -> PlacedMeshes:
        vertices = np.empty_like(self.vertices)
        part = np.full(len(self.faces), -1, dtype=np.int64)
        names: list[str] = []
        for row, (raw, mesh) in enumerate(zip(self.raws, says, strict=False)):
            frame = mesh_frame(raw, mesh)
            own = self._vertex_mesh == row
            vertices[own] = _in_world(self.vertices[own], frame)
            found = face_parts(raw, mesh.split, mesh.drop, mesh.join)
            taken = [name for name in found.names if name in names]
            if taken:
                raise InputError(f"there is a part {taken[0]!r} in another mesh; take another name")
            part[self.mesh == row] = np.where(found.part >= 0, found.part + len(names), -1)
            names += found.names
        return PlacedMeshes(vertices, self.faces, part, tuple(names))

    def all_in_world(self, says: Sequence[MeshFile], row: int, points: Floats) -> Floats:
        """(N, 3) [m] where points of a mesh file stand."""
        return _in_world(points, mesh_frame(self.raws[row], says[row]))

    def frame(self, says: Sequence[MeshFile], row: int) -> MeshFrame:
        """How a mesh stands in the world."""
        return mesh_frame(self.raws[row], says[row])

    def in_file(self, says: Sequence[MeshFile], row: int, point: Floats) -> Floats:
        """(3,) where a point of the world [m] is in a mesh file, in its own unit and axes."""
        frame = mesh_frame(self.raws[row], says[row])
        return (point - frame.move) @ frame.rotation / (frame.metres or 1.0)

    def grown(self, faces: Sequence[int]) -> Ints:
        """Find the faces of the surface around faces that were pointed at. InputError as of
        `grown_faces`."""
        if not faces:
            raise InputError("no face was picked: pick one in the picture")
        key = tuple(sorted(set(faces)))
        if key not in self._grown:
            self._grown[key] = self._grown_from(key)
        return self._grown[key]

    def borders(self, faces: Sequence[int]) -> Ints:
        """(E, 2) vertices: the outline of the surface around faces that were pointed at."""
        key = tuple(sorted(set(faces)))
        if key not in self._borders:
            self._borders[key] = outline(self.faces[self.grown(key)])
        return self._borders[key]

    def _grown_from(self, faces: tuple[int, ...]) -> Ints:
        owners = tuple(sorted({int(self.owner[face]) for face in faces}))
        own = np.flatnonzero(np.isin(self.owner, owners))
        if owners not in self._surfaces:
            self._surfaces[owners] = self._surface_of(own)
        seeds = np.searchsorted(own, faces).tolist()
        return own[grown_faces(self._surfaces[owners], seeds)]

    def _surface_of(self, faces: Ints) -> Surface:
        used, index = np.unique(self.faces[faces], return_inverse=True)
        return Surface(self.vertices[used], index.reshape(-1, 3))

    def size_doubts(self, says: Sequence[MeshFile]) -> list[Doubt]:
        """What is doubted of sizes, as the reader of meshes doubts it."""
        key = tuple(mesh.model_dump_json() for mesh in says)
        if key not in self._sizes:
            self._sizes[key] = self._size_doubts(says)
        return self._sizes[key]

    def _size_doubts(self, says: Sequence[MeshFile]) -> list[Doubt]:
        stands = self.standing(says)
        doubts = []
        high = float(np.ptp(stands.bounds[:, 2]))
        if HIGHEST < high <= LARGEST:
            words = f"it is {high:.3g} m high: are the unit and the axes right?"
            doubts.append(Doubt("height", words))
        for row, (raw, mesh) in enumerate(zip(self.raws, says, strict=False)):
            frame = mesh_frame(raw, mesh)
            own = (self.mesh == row) & (stands.part >= 0)
            if not own.any():
                continue
            largest = float(np.ptp(self.vertices[self.faces[own].ravel()], axis=0).max())
            smallest = SMALLEST if len(says) == 1 else SMALLEST_OF_SEVERAL
            wrong = implausible(largest, frame.metres, smallest=smallest)
            if wrong:
                doubts.append(Doubt(f"size of {mesh.file}", f"{mesh.file}: {wrong}"))
                continue
            there = np.unique(stands.part[own])
            parts = [
                RawPart(stands.names[k], *_two_corners(stands.boxes[k])) for k in there.tolist()
            ]
            doubts += size_doubts(parts, frame.metres or 1.0, mesh)
        return doubts


def _two_corners(box: Floats) -> tuple[Floats, Ints]:
    """A box (2, 3) as the vertices and faces of a part of that size."""
    return box, np.array([[0, 1, 1]])


def _in_world(points: Floats, frame: MeshFrame) -> Floats:
    return points * (frame.metres or 1.0) @ frame.rotation.T + frame.move
