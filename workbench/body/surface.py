"""A closed surface, checked and ready to be measured against: what spheres are fitted to."""

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

SMALLEST = 0.005
LARGEST = 10.0
"""Extents [m] that a body or a part of one may have, from a fingertip to a large animal."""

_LOOKS = 256


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """A closed mesh wound outward that does not cross itself: vertices (V, 3) [m], faces (T, 3).

    volume [m3], area [m2]; notes: what was mended, in words. Made by `sealed`.
    """

    vertices: Floats
    faces: Ints
    notes: tuple[str, ...] = ()
    solid: Solid = field(init=False)
    volume: float = field(init=False)
    area: float = field(init=False)

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
        """Exact signed distance [m] of points (n, 3) to the surface, negative inside; (n,)."""
        return self.nearest(points)[0]

    def nearest(self, points: ArrayLike, *, ordered: bool = False) -> tuple[Floats, Ints, Floats]:
        """Signed distance (n,) [m], face (n,) and nearest point (n, 3) of the surface for points
        (n, 3).

        ordered: near points stand together already and need not be sorted.
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
    """One closed surface of a closed mesh: overlapping shells become one, enclosed cavities are
    filled.

    vertices (V, 3) [m], faces (T, 3) wound outward; `what` names the mesh in messages. InputError
    where the mesh is open, wound inward, crosses itself, or has the size of no body (a wrong
    unit?).
    """
    points, corners = _checked(vertices, faces, what)
    given = _manifold(points, corners, what)
    shells = given.decompose()
    outer = [shell for shell in shells if shell.volume() > 0]
    if not outer or given.volume() <= 0:
        raise InputError(
            f"{what}: is inside out (its volume is {given.volume() * 1e3:.4g} l): turn its faces round"
        )
    whole = (
        manifold3d.Manifold.batch_boolean(outer, manifold3d.OpType.Add)
        if len(outer) > 1
        else outer[0]
    )
    shells_left = whole.decompose()
    kept = [shell for shell in shells_left if shell.volume() > 0]
    notes = []
    if len(outer) > len(kept):
        notes.append(f"{len(outer)} shells are joined to {len(kept)}")
    voids = len(shells) - len(outer) + len(shells_left) - len(kept)
    if voids:
        notes.append(f"{voids} enclosed {'cavity is' if voids == 1 else 'cavities are'} filled")
    whole = manifold3d.Manifold.compose(kept) if len(kept) > 1 else kept[0]
    if notes:
        mesh = whole.to_mesh64()
        points = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
        corners = np.asarray(mesh.tri_verts, dtype=np.int64)
    surface = Surface(points, corners, tuple(notes))
    _refuse_crossing(surface, what)
    return surface


def _checked(vertices: ArrayLike, faces: ArrayLike, what: str) -> tuple[Floats, Ints]:
    """The mesh as arrays, its numbers, its size and its edges looked at."""
    points: Floats = frozen(vertices, np.float64, (None, 3), f"{what}: vertices")
    corners: Ints = frozen(faces, np.int64, (None, 3), f"{what}: faces")
    if len(corners) < 4 or corners.min() < 0 or corners.max() >= len(points):
        raise InputError(
            f"{what}: a closed mesh of at least 4 faces is needed, of vertices that are there"
        )
    if not np.all(np.isfinite(points)):
        raise InputError(f"{what}: has vertices that are not finite numbers")
    size = float(np.ptp(points[corners.ravel()], axis=0).max())
    if not SMALLEST <= size <= LARGEST:
        raise InputError(
            f"{what}: is {size:.4g} m large, and {SMALLEST:g} to {LARGEST:g} m is plausible for a body or "
            "a part of one: a wrong unit of length?"
        )
    tail = corners.ravel()
    head = np.roll(corners, -1, axis=1).ravel()
    way = np.sort(tail * len(points) + head)
    back = np.sort(head * len(points) + tail)
    if (way[1:] == way[:-1]).any():
        many = int((way[1:] == way[:-1]).sum())
        raise InputError(
            f"{what}: {many} edges are shared by more than two faces, or faces are wound against each "
            "other: not the surface of a solid"
        )
    lone = (
        way[~np.isin(way, back, assume_unique=True)] if not np.array_equal(way, back) else way[:0]
    )
    if len(lone):
        spot = ", ".join(f"{x:.3f}" for x in points[lone[0] // len(points)])
        raise InputError(
            f"{what}: is open: {len(lone)} edges have a face on one side only, one at ({spot}) m; "
            "close the holes first"
        )
    return points, corners


def _manifold(points: Floats, corners: Ints, what: str) -> manifold3d.Manifold:
    made = manifold3d.Manifold(manifold3d.Mesh64(points.copy(), corners.astype(np.uint64)))
    if made.status() != manifold3d.Error.NoError:
        raise InputError(
            f"{what}: is not the surface of a solid ({str(made.status()).removeprefix('Error.')})"
        )
    return made


def _refuse_crossing(surface: Surface, what: str) -> None:
    """Look a hair outside of places on the surface: none of it may lie inside, or the surface
    crosses itself.

    Up to 256 places, spread over the area; a few such ones (a lip, an eyelid) do no harm to a fit,
    more than 2 % do.
    """
    corner = np.ascontiguousarray(surface.vertices[surface.faces])
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.cumsum(np.linalg.norm(cross, axis=1))
    looks = int(np.clip(8e6 / len(corner), 64, _LOOKS))
    face = np.searchsorted(area, (np.arange(looks) + 0.5) / looks * area[-1])
    hair = 1e-5 * float(np.ptp(surface.vertices, axis=0).max())
    out = cross[face] / np.maximum(np.linalg.norm(cross[face], axis=1), 1e-300)[:, None]
    place = corner[face].mean(axis=1) + hair * out
    turns = np.array([point_winding(*point, corner, 0, len(corner)) for point in place])
    wrong = np.abs(turns) > 0.5
    if wrong.mean() > 0.02:
        spot = ", ".join(f"{x:.3f}" for x in place[wrong][0])
        raise InputError(
            f"{what}: crosses itself: about {wrong.mean():.0%} of its area lies inside itself, for "
            f"instance at ({spot}) m"
        )
