"""Check a closed surface and prepare it for distances: spheres are fitted to it."""

from __future__ import annotations

from dataclasses import dataclass, field

import manifold3d
import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.geometry.nearest import Solid, build_solid, mesh_distance, morton_order
from workbench.geometry.polygon import point_winding
from workbench.model.arrays import Floats, Ints, frozen

__all__ = ["Surface", "sealed"]

_MIN_EXTENT = 0.005
_MAX_EXTENT = 10.0
"""Range of extents [m] of a body or a part of one, from a fingertip to a large animal."""
_PROBES = 256
"""Points at most at which a surface is checked for crossing itself."""
_MAX_CROSSING = 0.02
"""Share of the area that may lie inside the surface, such as a lip or an eyelid."""


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """A closed mesh, wound outward, that does not cross itself. Made by `sealed`."""

    vertices: Floats
    """(V, 3) [m]."""
    faces: Ints
    """(T, 3)."""
    notes: tuple[str, ...] = ()
    """What was mended, in words."""
    solid: Solid = field(init=False)
    """The faces in a tree, for distances."""
    volume: float = field(init=False)
    """[m3]."""
    area: float = field(init=False)
    """[m2]."""

    def __repr__(self) -> str:
        return (
            f"Surface({len(self.faces)} triangles, {self.area:.4g} m2, {self.volume * 1e3:.4g} l)"
        )

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "vertices", frozen(self.vertices, np.float64, (None, 3), "surface.vertices")
        )
        object.__setattr__(self, "faces", frozen(self.faces, np.int64, (None, 3), "surface.faces"))
        corner = self.vertices[self.faces]
        cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        object.__setattr__(self, "volume", float(np.einsum("tc,tc->", corner[:, 0], cross)) / 6)
        object.__setattr__(self, "area", float(np.linalg.norm(cross, axis=1).sum()) / 2)
        object.__setattr__(self, "solid", build_solid(self.vertices, self.faces))

    def distance(self, points: ArrayLike) -> Floats:
        """Return the exact signed distance (n,) [m] of points (n, 3) to the surface, negative inside."""
        return self.nearest(points)[0]

    def nearest(self, points: ArrayLike, *, ordered: bool = False) -> tuple[Floats, Ints, Floats]:
        """Find the nearest point of the surface.

        Parameters
        ----------
        points
            (n, 3) [m].
        ordered
            True if near points are together, so that they need not be sorted.

        Returns
        -------
        tuple of Floats, Ints and Floats
            Signed distance (n,) [m], face (n,), and nearest point (n, 3) [m].
        """
        at = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        count = len(at)
        distance = np.empty(count)
        face = np.empty(count, dtype=np.int64)
        foot = np.empty((count, 3))
        if count:
            order = np.arange(count) if ordered else morton_order(at)
            found = np.empty(count), np.empty(count, dtype=np.int64), np.empty((count, 3))
            mesh_distance(at[order], self.solid, *found)
            distance[order], face[order], foot[order] = found
        return distance, face, foot


def sealed(vertices: ArrayLike, faces: ArrayLike, *, what: str = "mesh") -> Surface:
    """Make one closed surface of a closed mesh.

    Overlapping shells are joined, and enclosed cavities are filled.

    Parameters
    ----------
    vertices
        (V, 3) [m].
    faces
        (T, 3), wound outward.
    what
        Name of the mesh in messages.

    Raises
    ------
    InputError
        If the mesh is open, wound inward, crosses itself, or has the size of no body.

    Examples
    --------
    >>> import trimesh
    >>> import workbench as wb
    >>> cube = trimesh.creation.box((0.3, 0.3, 0.3))
    >>> wb.sealed(cube.vertices, cube.faces)
    Surface(12 triangles, 0.54 m2, 27 l)
    """
    points, corners = _checked(vertices, faces, what)
    given = _manifold(points, corners, what)
    if given.volume() <= 0:
        raise InputError(
            f"{what}: is inside out (its volume is {given.volume() * 1e3:.4g} l): turn its faces round"
        )
    whole, notes = _outer_shells(given)
    if notes:
        mesh = whole.to_mesh64()
        points = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
        corners = np.asarray(mesh.tri_verts, dtype=np.int64)
    surface = Surface(points, corners, tuple(notes))
    _refuse_crossing(surface, what)
    return surface


def _outer_shells(given: manifold3d.Manifold) -> tuple[manifold3d.Manifold, list[str]]:
    """The union of all shells that enclose something, without cavities; and what was changed."""
    shells = given.decompose()
    outer = [shell for shell in shells if shell.volume() > 0]
    whole = outer[0]
    if len(outer) > 1:
        whole = manifold3d.Manifold.batch_boolean(outer, manifold3d.OpType.Add)
    shells_left = whole.decompose()
    kept = [shell for shell in shells_left if shell.volume() > 0]
    notes = []
    if len(outer) > len(kept):
        notes.append(f"{len(outer)} shells are joined to {len(kept)}")
    voids = len(shells) - len(outer) + len(shells_left) - len(kept)
    if voids:
        notes.append(f"{voids} enclosed {'cavity is' if voids == 1 else 'cavities are'} filled")
    return manifold3d.Manifold.compose(kept) if len(kept) > 1 else kept[0], notes


def _checked(vertices: ArrayLike, faces: ArrayLike, what: str) -> tuple[Floats, Ints]:
    """The mesh as arrays, with its numbers, size and edges checked."""
    points: Floats = frozen(vertices, np.float64, (None, 3), f"{what}: vertices")
    corners: Ints = frozen(faces, np.int64, (None, 3), f"{what}: faces")
    if len(corners) < 4 or corners.min() < 0 or corners.max() >= len(points):
        raise InputError(
            f"{what}: a closed mesh of at least 4 faces is needed, of vertices that are there"
        )
    if not np.all(np.isfinite(points)):
        raise InputError(f"{what}: has vertices that are not finite numbers")
    size = float(np.ptp(points[corners.ravel()], axis=0).max())
    if not _MIN_EXTENT <= size <= _MAX_EXTENT:
        raise InputError(
            f"{what}: is {size:.4g} m large, and {_MIN_EXTENT:g} to {_MAX_EXTENT:g} m is plausible for a body or "
            "a part of one: a wrong unit of length?"
        )
    _check_edges(points, corners, what)
    return points, corners


def _check_edges(points: Floats, corners: Ints, what: str) -> None:
    """Refuse a mesh in which an edge does not occur exactly once in each direction."""
    tail = corners.ravel()
    head = np.roll(corners, -1, axis=1).ravel()
    forward = np.sort(tail * len(points) + head)
    backward = np.sort(head * len(points) + tail)
    repeated = int((forward[1:] == forward[:-1]).sum())
    if repeated:
        raise InputError(
            f"{what}: {repeated} edges are shared by more than two faces, or faces are wound against each "
            "other: not the surface of a solid"
        )
    if np.array_equal(forward, backward):
        return
    lone = forward[~np.isin(forward, backward, assume_unique=True)]
    if len(lone):
        spot = ", ".join(f"{x:.3f}" for x in points[lone[0] // len(points)])
        raise InputError(
            f"{what}: is open: {len(lone)} edges have a face on one side only, one at ({spot}) m; "
            "close the holes first"
        )


def _manifold(points: Floats, corners: Ints, what: str) -> manifold3d.Manifold:
    made = manifold3d.Manifold(manifold3d.Mesh64(points.copy(), corners.astype(np.uint64)))
    if made.status() != manifold3d.Error.NoError:
        raise InputError(
            f"{what}: is not the surface of a solid ({str(made.status()).removeprefix('Error.')})"
        )
    return made


def _refuse_crossing(surface: Surface, what: str) -> None:
    """Refuse a surface that crosses itself.

    A point just outside the surface has the winding number 0, unless another part of the surface
    encloses it. Up to 256 points are checked, spread over the area.
    """
    corner = np.ascontiguousarray(surface.vertices[surface.faces])
    place = _points_just_outside(surface, corner)
    winding = np.array([point_winding(*point, corner, 0, len(corner)) for point in place])
    wrong = np.abs(winding) > 0.5
    if wrong.mean() > _MAX_CROSSING:
        spot = ", ".join(f"{x:.3f}" for x in place[wrong][0])
        raise InputError(
            f"{what}: crosses itself: about {wrong.mean():.0%} of its area lies inside itself, for "
            f"instance at ({spot}) m"
        )


def _points_just_outside(surface: Surface, corner: Floats) -> Floats:
    """(n, 3) points above the middles of faces, spread over the area; corner (T, 3, 3)."""
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.cumsum(np.linalg.norm(cross, axis=1))
    count = int(np.clip(8e6 / len(corner), 64, _PROBES))  # a winding number takes O(T)
    face = np.searchsorted(area, (np.arange(count) + 0.5) / count * area[-1])
    height = 1e-5 * float(np.ptp(surface.vertices, axis=0).max())
    normal = cross[face] / np.maximum(np.linalg.norm(cross[face], axis=1), 1e-300)[:, None]
    return np.asarray(corner[face].mean(axis=1) + height * normal)
