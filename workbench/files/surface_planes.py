"""Planes of a mesh from faces that were pointed at: the surface around them, and the plane of least
squares through it.

A surface grows from the faces over edges that bend little, as long as faces lie within a cone about
the normal of the plane. The plane is fitted, the surface grown anew about its normal, and so on
until both agree. So it hardly matters which face of a cushion was pointed at.

Upholstery in ribs ends such a surface at the next seam. Where the faces around it that lie near its
plane, over seams of any bend, are several times as large, they are the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.errors import InputError
from workbench.geometry.components import component_labels
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["PlaneFit", "Surface", "fitted_plane", "grown_faces", "outline"]

BEND = np.radians(15.0)
"""Angle [rad] between neighbouring faces of one surface, at most: cushions are curved, edges are
not."""
CONE = np.radians(15.0)
"""Angle [rad] between a face and the plane of its surface, at most: what slopes more is the front
lip of a cushion, or its bolster."""
RIB_CONE = np.radians(60.0)
"""Angle [rad] between a face of a rib and the plane of all ribs, at most."""
RIB_DEPTH = 0.05
"""Distance of a rib's face from the plane of all ribs, as a share of their extent, at most."""
RIBBED = 2.0
"""The ribs together are larger than the first of them at least so many times."""
ROUNDS = 8
RIB_ROUNDS = 32
"""How often a surface is grown at most, and one of ribs, rib by rib."""
_NO_AREA = 1e-12
"""Twice the area of a face, as a share of the square of the mesh's size, that is none."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Faces of a mesh, to be grown over.

    Parameters
    ----------
    vertices
        (V, 3), of any unit.
    faces
        (T, 3), wound either way.
    """

    vertices: Floats
    faces: Ints

    @cached_property
    def corners(self) -> Floats:
        """(T, 3, 3)."""
        return self.vertices[self.faces]

    @cached_property
    def _crosses(self) -> Floats:
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return np.cross(b - a, c - a)

    @cached_property
    def area(self) -> Floats:
        """(T,) of each face, 0 where it has next to none."""
        twice = np.linalg.norm(self._crosses, axis=1)
        size = float(np.ptp(self.vertices, axis=0).max(initial=0.0))
        return np.where(twice > _NO_AREA * size * size, 0.5 * twice, 0.0)

    @cached_property
    def normal(self) -> Floats:
        """(T, 3) unit normals, 0 where a face has no area."""
        area = self.area[:, None]
        return np.where(area > 0.0, self._crosses / np.where(area > 0.0, 2.0 * area, 1.0), 0.0)

    @cached_property
    def edges(self) -> Ints:
        """(N, 2) pairs of faces that share an edge."""
        a, b, c = self.faces.T
        ends = np.sort(np.concatenate([np.stack(pair, 1) for pair in ((a, b), (b, c), (c, a))]), 1)
        face = np.tile(np.arange(len(self.faces)), 3)
        order = np.lexsort((face, ends[:, 1], ends[:, 0]))
        ends = ends[order]
        face = face[order]
        shared = (ends[1:] == ends[:-1]).all(axis=1)
        return np.stack([face[:-1][shared], face[1:][shared]], axis=1)

    @cached_property
    def neighbours(self) -> Ints:
        """(N, 2) pairs of faces that share an edge over which a smooth surface goes on."""
        one, other = self.normal[self.edges.T]
        bend = np.abs(np.einsum("ij,ij->i", one, other))
        return self.edges[bend >= np.cos(BEND)]

    @cached_property
    def _regions(self) -> dict[int, Ints]:
        return {}

    def region(self, face: int) -> Ints:
        """Find the faces of the surface that a face is of. InputError as of `grown_faces`."""
        if face not in self._regions:
            self._regions[face] = grown_faces(self, [face])
        return self._regions[face]


@dataclass(frozen=True, eq=False)
class PlaneFit:
    """A plane through faces.

    Parameters
    ----------
    normal
        (3,) unit normal, of either sense.
    centre
        (3,) the centre of area of the faces, which lies on the plane.
    off
        Root mean square distance of the faces from it, over their area.
    """

    normal: Floats
    centre: Floats
    off: float


def fitted_plane(corners: Floats) -> PlaneFit:
    """Fit the plane of least squared distance to the area of faces.

    The second moment of a triangle with corners v and centre c about the origin is
    area / 12 (v1 v1' + v2 v2' + v3 v3' + 9 c c'); the normal is the eigenvector of least value.

    Parameters
    ----------
    corners
        (T, 3, 3), T >= 1.

    Raises
    ------
    InputError
        If the faces have no area.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    whole = float(area.sum())
    if not whole > 0.0:
        raise InputError("the faces that were picked have no area: pick others")
    centre: Floats = np.einsum("t,tij->j", area, corners) / (3.0 * whole)
    local = corners - centre
    total = local.sum(axis=1)
    moment = np.einsum("t,tki,tkj->ij", area, local, local)
    moment += np.einsum("t,ti,tj->ij", area, total, total)
    values, vectors = np.linalg.eigh(moment / (12.0 * whole))
    return PlaneFit(vectors[:, 0], centre, float(np.sqrt(max(values[0], 0.0))))


def grown_faces(surface: Surface, seeds: Sequence[int]) -> Ints:
    """Find the faces of the surface that was pointed at.

    Parameters
    ----------
    surface
        The mesh.
    seeds
        The faces that were pointed at.

    Returns
    -------
    Ints
        Faces in ascending order, the seeds that have an area among them.

    Raises
    ------
    InputError
        If there are no seeds, or none has an area.
    """
    first = [face for face in seeds if surface.area[face] > 0.0]
    if not first:
        raise InputError("no face with an area was picked: pick one in the picture")
    picked = np.array(sorted(set(first)), dtype=np.int64)
    smooth = _grown(surface, picked, surface.neighbours, cone=CONE, rounds=ROUNDS)
    ribs = _grown(surface, smooth, surface.edges, cone=RIB_CONE, depth=RIB_DEPTH, rounds=RIB_ROUNDS)
    return ribs if surface.area[ribs].sum() >= RIBBED * surface.area[smooth].sum() else smooth


def _grown(
    surface: Surface, first: Ints, pairs: Ints, *, cone: float, rounds: int, depth: float = np.inf
) -> Ints:
    """The faces that hang together with the first ones by pairs of faces, at most so oblique [rad] to
    their plane and so far from it, as a share of their extent; the plane is fitted and they are grown
    anew until both agree."""
    middle = surface.corners.mean(axis=1)
    region = first
    for _ in range(rounds):
        corners = surface.corners[region]
        plane = fitted_plane(corners)
        extent = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        inside = np.abs(surface.normal @ plane.normal) >= np.cos(cone)
        inside &= np.abs((middle - plane.centre) @ plane.normal) <= depth * extent
        found = _connected(surface, pairs, inside, first)
        if np.array_equal(found, region):
            break
        region = found
    return region


def _connected(surface: Surface, pairs: Ints, inside: Bools, seeds: Ints) -> Ints:
    """The faces that hang together with the seeds by pairs of faces inside, and the seeds."""
    one, other = pairs[inside[pairs].all(axis=1)].T
    label = component_labels(one, other, len(surface.faces))
    found = inside & np.isin(label, label[seeds])
    found[seeds] = True
    return np.flatnonzero(found)


def outline(faces: Ints) -> Ints:
    """Find the edges at which faces (T, 3) end.

    Returns
    -------
    Ints
        (E, 2) vertices of the edges that one of the faces has and no other.
    """
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    low = ends.min(axis=1)
    high = ends.max(axis=1)
    wide = int(faces.max(initial=0)) + 1
    key, count = np.unique(low * wide + high, return_counts=True)
    alone = key[count == 1]
    return np.stack([alone // wide, alone % wide], axis=1)
