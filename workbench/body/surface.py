"""Surfaces: a closed one, checked and prepared for distances, that spheres are fitted to; the union of
a body's spheres as one; flat regions from their outlines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import manifold3d
import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError
from workbench.geometry.nearest import Solid, build_solid, mesh_distance, morton_order
from workbench.geometry.polygon import winding_number
from workbench.model.arrays import Floats, Ints, read_only
from workbench.model.poses import Placed

__all__ = ["FLATTEST", "Surface", "body_solid", "sealed", "sphere_segments", "triangulate_loops"]

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
            self, "vertices", read_only(self.vertices, np.float64, (None, 3), "surface.vertices")
        )
        object.__setattr__(
            self, "faces", read_only(self.faces, np.int64, (None, 3), "surface.faces")
        )
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
    given = manifold3d.Manifold(manifold3d.Mesh64(points.copy(), corners.astype(np.uint64)))
    if given.status() != manifold3d.Error.NoError:
        raise InputError(
            f"{what}: is not the surface of a solid ({str(given.status()).removeprefix('Error.')})"
        )
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
    points: Floats = read_only(vertices, np.float64, (None, 3), f"{what}: vertices")
    corners: Ints = read_only(faces, np.int64, (None, 3), f"{what}: faces")
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


def _refuse_crossing(surface: Surface, what: str) -> None:
    """Refuse a surface that crosses itself.

    A point just outside the surface has the winding number 0, unless another part of the surface
    encloses it. Up to 256 points are checked, spread over the area.
    """
    corner = np.ascontiguousarray(surface.vertices[surface.faces])
    place = _points_just_outside(surface, corner)
    winding = np.array([winding_number(*point, corner, 0, len(corner)) for point in place])
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


def triangulate_loops(loops: Sequence[Floats]) -> tuple[Floats, Ints]:
    """Triangulate what lies inside loops. A point is inside if an odd number of loops enclose it.

    Parameters
    ----------
    loops
        Closed curves (K, 2) [m], of any orientation.

    Returns
    -------
    tuple of Floats and Ints
        Corners (V, 2) [m] and anticlockwise triangles (T, 3); both are empty if nothing is inside.

    Raises
    ------
    InputError
        If a loop is not finite.
    """
    import manifold3d

    if not all(np.isfinite(loop).all() for loop in loops):
        raise InputError("faces: loops must be finite")
    region = manifold3d.CrossSection(
        [np.asarray(loop) for loop in loops], manifold3d.FillRule.EvenOdd
    )
    outlines = region.to_polygons()
    if not outlines:
        return np.empty((0, 2)), np.empty((0, 3), dtype=np.int64)
    triangles = np.asarray(manifold3d.triangulate(outlines), dtype=np.int64).reshape(-1, 3)
    return np.concatenate(outlines).astype(np.float64), triangles


FLATTEST = 13.5
"""Depth of a face below the surface of a unit sphere of n segments, at most, times n^2."""
_MIN_SEGMENTS = 8
_MAX_SEGMENTS = 512
"""Range of segments around a sphere."""
_GRID = 1e-3
"""Spacing [mm] of coordinates. A 32-bit coordinate of 2 m is exact to 1.2e-4 mm."""
_SHIFTS = (2e-3, 3e-3, 5e-3, 7e-3, 11e-3, 13e-3)
"""Shifts [mm] by which coincident corners are separated, one after the other."""


def body_solid(placed: Placed, pose: int = 0, *, tolerance: float = 5e-4) -> tuple[Floats, Ints]:
    """Compute the union of all spheres of one pose.

    The surface is closed and does not cross itself. Every face lies inside the spheres, by at most the
    tolerance, except for a few micrometres where folds touch. Spheres outside the logical window are
    left out.

    Parameters
    ----------
    placed, pose
        The placed body, and the number of the pose.
    tolerance
        [m], from 1e-6 to 0.1.

    Returns
    -------
    tuple of Floats and Ints
        Corners (V, 3) [m], and outward triangles (T, 3).

    Raises
    ------
    UsageError
        If the tolerance is out of its range.
    InputError
        If no sphere is placed.
    """
    import manifold3d

    if not (math.isfinite(tolerance) and 1e-6 <= tolerance <= 0.1):
        raise UsageError(
            f"solid: a tolerance of 0.001 to 100 mm is needed, got {1000 * tolerance:g} mm"
        )
    body = placed.body
    shown = placed.window[body.sphere_segment]
    centres = 1000.0 * placed.centres[pose][shown]
    radii = 1000.0 * body.radius[placed.person[pose], shown]
    if not len(radii) or not np.all(np.isfinite(centres)):
        raise InputError(
            f"body {body.name}, pose {pose}: no spheres are placed, or not at finite places"
        )
    balls = [
        manifold3d.Manifold.sphere(radius, sphere_segments(radius, 1000.0 * tolerance)).translate(
            centre
        )
        for centre, radius in zip(centres.tolist(), radii.tolist(), strict=True)
    ]
    mesh = manifold3d.Manifold.batch_boolean(balls, manifold3d.OpType.Add).to_mesh()
    points = np.array(mesh.vert_properties[:, :3], np.float64)
    triangles = np.asarray(mesh.tri_verts, np.int64)
    return _apart(points, triangles) / 1000.0, triangles


def _apart(points: Floats, triangles: Ints) -> Floats:
    """Round corners (V, 3) [mm] to a grid of micrometres, and separate those that coincide.

    The union has two corners at one place where two folds of the surface touch. A program that
    reads STL identifies corners by their coordinates. Merged, they would make an edge of four
    triangles, and the surface would not be closed. So one of them moves toward its neighbours.
    """
    points = np.round(points / _GRID) * _GRID
    for shift in _SHIFTS:
        coincident = _coincident(points)
        if not len(coincident):
            break
        for corner in coincident.tolist():
            around = triangles[np.any(triangles == corner, axis=1)].reshape(-1)
            offset = points[around].mean(axis=0) - points[corner]
            length = float(np.linalg.norm(offset))
            direction = offset / length if length > _GRID else np.array([0.0, 0.0, -1.0])
            points[corner] = np.round((points[corner] + shift * direction) / _GRID) * _GRID
    return points


def _coincident(points: Floats) -> Ints:
    """Indices of points (V, 3) that equal an earlier one in sorted order."""
    order = np.lexsort(points.T)
    gap = np.abs(points[order[1:]] - points[order[:-1]])
    return np.asarray(order[1:][np.all(gap < 0.5 * _GRID, axis=1)])


def sphere_segments(radius: float, tolerance: float) -> int:
    """Return the number of segments around a sphere, a multiple of four.

    It is enough for faces at most `tolerance` below the surface, in the unit of the radius.
    """
    wanted = 4 * math.ceil(math.sqrt(FLATTEST * radius / tolerance) / 4.0)
    return min(max(wanted, _MIN_SEGMENTS), _MAX_SEGMENTS)
