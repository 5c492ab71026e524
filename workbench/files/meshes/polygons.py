"""Merge coplanar neighbouring triangles into planar polygons: concave, with holes, in many pieces.

Two triangles belong together if they share an edge that no third face has, are wound alike, and lie
in one plane. A region of them becomes a polygon if all of its corners lie within `PLANE_TOLERANCE`
of its plane. A region that fails is cut up and tried again, if need be down to single triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from workbench.files.meshes.winding import edge_keys
from workbench.geometry.components import component_labels
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "PLANE_TOLERANCE",
    "FacePlanes",
    "Polygons",
    "degenerate_faces",
    "enclosing_circles",
    "face_planes",
    "merge_coplanar",
    "perpendicular",
]

PLANE_TOLERANCE = 1e-6
"""Largest distance [m] of a corner from its polygon's plane."""
_PLANE_STEPS = 4
"""Attempts to find the largest planes in a region that bends, before it is halved and halved
again."""
_MAX_STEPS = 64
"""Far more halvings than a region of any size needs."""


@dataclass(frozen=True)
class Polygons:
    """F polygons over given vertices, in the order of their first triangles."""

    edges: Ints
    edge_start: Ints
    normal: Floats
    offset: Floats
    circle_centre: Floats
    circle_radius: Floats
    triangles: Ints
    triangle_start: Ints
    """The arrays up to here are those of `Environment`."""
    face_polygon: Ints
    """(T,) the polygon of each triangle."""


def merge_coplanar(vertices: Floats, faces: Ints) -> Polygons:
    """Merge triangles into planar polygons.

    No face is dropped: a degenerate one becomes a polygon of three edges in some plane through its
    longest edge.

    Parameters
    ----------
    vertices
        (V, 3) [m].
    faces
        (T, 3). Triangles are neighbours if they share vertex indices: weld equal positions first.
    """
    mesh = face_planes(vertices, faces)
    neighbour = _neighbours(faces)
    half = np.flatnonzero(neighbour > np.arange(len(neighbour)) // 3)
    pairs = np.column_stack([half // 3, neighbour[half]])
    label = _flat_regions(mesh, pairs[_are_coplanar(mesh, pairs)])
    polygons = int(label.max(initial=-1)) + 1
    normal, offset = _region_planes(mesh, label, polygons)
    edges, edge_start = _outlines(mesh, label, neighbour)
    centre, radius = enclosing_circles(vertices, edges, edge_start, normal)
    centre += (offset - np.einsum("ij,ij->i", centre, normal))[:, None] * normal
    order = np.argsort(label, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(label, minlength=polygons))])
    return Polygons(edges, edge_start, normal, offset, centre, radius, faces[order], start, label)


def _neighbours(faces: Ints) -> Ints:
    """Return the face (3 T,) across each half-edge, k of face t at 3 t + k; -1 for none.

    Two faces are neighbours if they alone share an edge and run along it in opposite senses.
    """
    tail = faces.ravel()
    head = np.roll(faces, -1, axis=1).ravel()
    key = edge_keys(tail, head, int(faces.max(initial=0)) + 1)
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1) != 0)
    pair = first[np.diff(first, append=len(key)) == 2]
    one = order[pair]
    other = order[pair + 1]
    opposite = (tail[one] == head[other]) & (tail[one] != head[one]) & (one // 3 != other // 3)
    across = np.full(len(key), -1, dtype=np.int64)
    across[one[opposite]] = other[opposite] // 3
    across[other[opposite]] = one[opposite] // 3
    return across


def _are_coplanar(mesh: FacePlanes, pairs: Ints) -> Bools:
    """Return for which neighbours (N, 2) the smaller lies in the plane of the larger, facing alike.

    The test is one-sided: the plane of a sliver is rounding noise, that of its large neighbour is
    not.
    """
    larger = np.where(mesh.area[pairs[:, 0]] >= mesh.area[pairs[:, 1]], pairs[:, 0], pairs[:, 1])
    smaller = pairs.sum(axis=1) - larger
    normal = mesh.normal[larger]
    base = np.einsum("nc,nc->n", mesh.vertices[mesh.faces[larger, 0]], normal)
    height = np.abs(mesh.heights(smaller, normal) - base[:, None]).max(axis=1, initial=0)
    alike = np.einsum("nc,nc->n", normal, mesh.normal[smaller]) > 0
    have_planes = ~mesh.flat[larger] & ~mesh.flat[smaller]
    return (height <= PLANE_TOLERANCE) & alike & have_planes


def _flat_regions(mesh: FacePlanes, links: Ints) -> Ints:
    """Divide the faces into connected regions that are flat to the tolerance.

    Parameters
    ----------
    mesh
        T faces.
    links
        (N, 2) neighbours that are coplanar.

    Returns
    -------
    Ints
        (T,) region of each face, numbered in the order of their first faces.
    """
    region = np.zeros(len(mesh.faces), dtype=np.int64)
    count = 0
    left = np.arange(len(mesh.faces))
    for step in range(_MAX_STEPS):
        label = component_labels(links[:, 0], links[:, 1], len(left))
        bent = _is_bent(mesh, label)
        region[left[~bent]] = label[~bent] + count
        count += int(label.max(initial=-1)) + 1
        if not bent.any():
            break
        position = np.cumsum(bent) - 1  # among the faces that are left
        left = left[bent]
        mesh = mesh.only(bent)
        links = position[links[bent[links[:, 0]]]]
        label = np.unique(label[bent], return_inverse=True)[1]
        side = _near_largest_plane(mesh, label) if step < _PLANE_STEPS else _half(mesh, label)
        links = links[side[links[:, 0]] == side[links[:, 1]]]
    _, first, inverse = np.unique(region, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[inverse]


def _is_bent(mesh: FacePlanes, label: Ints) -> Bools:
    """Return which faces (T,) belong to a region that is not flat.

    A region with a face that faces backward is not flat either: a grain smaller than the tolerance,
    closed on itself, has no outline at all.
    """
    polygons = int(label.max(initial=-1)) + 1
    normal = _mean_normals(mesh, label, polygons)
    low, high = _height_range(mesh, label, normal)
    faces_back = np.einsum("nc,nc->n", mesh.normal, normal[label]) <= 0
    backward = np.bincount(label, faces_back, polygons) > 0
    wrong = (high - low > 2 * PLANE_TOLERANCE) | backward
    return (wrong & (np.bincount(label, minlength=polygons) > 1))[label]


def _near_largest_plane(mesh: FacePlanes, label: Ints) -> Bools:
    """Return which faces (T,) lie in the plane of the largest triangle of their region.

    The plane is fitted twice, since that of one triangle is too uncertain far away from it.
    """
    polygons = int(label.max()) + 1
    order = np.lexsort((mesh.area, label))
    largest = order[np.cumsum(np.bincount(label, minlength=polygons)) - 1]
    normal = mesh.normal[largest]
    base = np.einsum("nc,nc->n", mesh.vertices[mesh.faces[largest, 0]], normal)
    for _ in range(2):
        height = mesh.heights(np.arange(len(label)), normal[label]) - base[label, None]
        inside: Bools = np.abs(height).max(axis=1) <= PLANE_TOLERANCE
        kept = np.where(inside, label, polygons)
        normal = _mean_normals(mesh, kept, polygons + 1)
        low, high = _height_range(mesh, kept, normal)
        base = (low + high) / 2
    return inside


def _half(mesh: FacePlanes, label: Ints) -> Bools:
    """Return which faces (T,) lie in the upper half of their region along its longest extent."""
    polygons = int(label.max()) + 1
    centroid = mesh.vertices[mesh.faces].mean(axis=1)
    total = _region_sums(label, centroid, polygons)
    offset = centroid - (total / np.bincount(label, minlength=polygons)[:, None])[label]
    axis = _region_sums(label, offset**2, polygons).argmax(axis=1)
    return offset[np.arange(len(offset)), axis[label]] > 0


def _region_sums(label: Ints, rows: Floats, polygons: int) -> Floats:
    """Return the sums (F, 3) of the rows (T, 3) of each region."""
    return np.column_stack([np.bincount(label, rows[:, k], polygons) for k in range(3)])


def _mean_normals(mesh: FacePlanes, label: Ints, polygons: int) -> Floats:
    """Return the unit normal (F, 3) of each region: of the sum of its area vectors, which depends
    on the outline of the region only."""
    total = _region_sums(label, mesh.vector, polygons)
    length = np.linalg.norm(total, axis=1)
    return total / np.where(length == 0, 1, length)[:, None]


def _height_range(mesh: FacePlanes, label: Ints, normal: Floats) -> tuple[Floats, Floats]:
    """Return the least and greatest height (F,) [m] of the corners of each region along its normal
    (F, 3); 0 for an empty region."""
    height = mesh.heights(np.arange(len(label)), normal[label])
    low = np.zeros(len(normal))
    high = np.zeros(len(normal))
    order = np.argsort(label, kind="stable")
    present, first = np.unique(label[order], return_index=True)
    if len(present):
        low[present] = np.minimum.reduceat(height.min(axis=1)[order], first)
        high[present] = np.maximum.reduceat(height.max(axis=1)[order], first)
    return low, high


def _region_planes(mesh: FacePlanes, label: Ints, polygons: int) -> tuple[Floats, Floats]:
    """Return the unit normal (F, 3) and the offset (F,) [m] of the plane of each region."""
    normal = _mean_normals(mesh, label, polygons)
    alone = np.flatnonzero(mesh.flat)
    normal[label[alone]] = mesh.normal[alone]
    low, high = _height_range(mesh, label, normal)
    return normal, (low + high) / 2


def _outlines(mesh: FacePlanes, label: Ints, neighbour: Ints) -> tuple[Ints, Ints]:
    """Return the edges of all regions, without those between two faces of one region.

    Returns
    -------
    tuple[Ints, Ints]
        Directed edges (E, 2), and where (F + 1,) those of each region start.
    """
    owner = np.repeat(label, 3)
    inner = (neighbour >= 0) & (label[neighbour] == owner)
    tail = mesh.faces.ravel()
    head = np.roll(mesh.faces, -1, axis=1).ravel()
    kept = np.flatnonzero(~inner)
    kept = kept[np.argsort(owner[kept], kind="stable")]
    count = np.bincount(owner[kept], minlength=int(label.max(initial=-1)) + 1)
    return np.column_stack([tail[kept], head[kept]]), np.concatenate([[0], np.cumsum(count)])


# Compute the minimum enclosing circles of many polygons at once.
#
# Two or three points determine the smallest circle about a set of points. The method solves this as
# an LP-type problem [1]_:
#
# 1. Start with the circle about two far points.
# 2. Add the farthest point outside to the determining points.
# 3. Find the smallest circle of these, at most four, by trying every pair and triple.
# 4. Repeat. The radius grows with each step, so the method ends at the exact circle.
#
# All polygons step together, and those that are done drop out.
#
# References
# ----------
# .. [1] J. Matousek, M. Sharir, E. Welzl (1996), A subexponential bound for linear programming,
#    Algorithmica 16, 498-516.

_TOLERANCE = 1e-12
"""Share of its radius by which a point may lie outside a circle."""
_CIRCLE_STEPS = 200
_SUBSETS = [(i, j, j) for i, j in combinations(range(4), 2)] + list(combinations(range(4), 3))
"""Pairs, with the second one repeated, and triples of four points."""


def enclosing_circles(
    vertices: Floats, edges: Ints, start: Ints, normal: Floats
) -> tuple[Floats, Floats]:
    """Compute the smallest circles about planar polygons.

    Parameters
    ----------
    vertices
        (V, 3) [m].
    edges, start
        (E, 2) directed edges, and where (F + 1,) those of each polygon start.
    normal
        (F, 3) unit normals.

    Returns
    -------
    tuple[Floats, Floats]
        Centres (F, 3) [m] and radii (F,) [m]. A radius reaches the farthest corner in space, so
        nothing of the polygon is outside the sphere of the same centre and radius.
    """
    if not len(normal):
        return np.zeros((0, 3)), np.zeros(0)
    owner = np.repeat(np.arange(len(normal)), np.diff(start))
    points = vertices[edges[:, 0]]
    origin = points[start[:-1]]
    first = perpendicular(normal)
    second = np.cross(normal, first)
    local = points - origin[owner]
    flat = np.column_stack([np.einsum("nc,nc->n", local, axis[owner]) for axis in (first, second)])
    flat_centre = _circle_centres(_PointSets(flat, owner, start))
    centre: Floats = origin + flat_centre[:, :1] * first + flat_centre[:, 1:] * second
    distance = np.linalg.norm(points - centre[owner], axis=1)
    return centre, np.maximum.reduceat(distance, start[:-1])


@dataclass(frozen=True, eq=False)
class _PointSets:
    """F sets of points in a plane, one after the other."""

    points: Floats
    """(E, 2)."""
    owner: Ints
    """(E,) the set of each point."""
    start: Ints
    """(F + 1,) where each set starts."""

    def farthest(self, origin: Floats) -> Ints:
        """Return the index (F,) of the point of each set that is farthest from its origin (E, 2)."""
        squared = ((self.points - origin) ** 2).sum(axis=1)
        most = np.maximum.reduceat(squared, self.start[:-1])
        hit = np.flatnonzero(squared == np.repeat(most, np.diff(self.start)))
        return hit[np.searchsorted(hit, self.start[:-1])]

    def only(self, sets: Ints) -> tuple[_PointSets, Ints]:
        """Return some sets, with their own numbers as owners, and the indices of their points."""
        count = np.diff(self.start)[sets]
        begin = np.concatenate([[0], np.cumsum(count)])
        index = np.arange(begin[-1]) + np.repeat(self.start[sets] - begin[:-1], count)
        return _PointSets(self.points[index], np.repeat(sets, count), begin), index


def _circle_centres(sets: _PointSets) -> Floats:
    """Return the centre (F, 2) of the smallest circle about each set."""
    points = sets.points
    a = sets.farthest(points[sets.start[:-1]][sets.owner])
    b = sets.farthest(points[a][sets.owner])
    determining = np.column_stack([a, b, b, b])
    centre = (points[a] + points[b]) / 2
    radius = np.linalg.norm(points[a] - points[b], axis=1) / 2
    active = np.arange(len(radius))
    remaining = sets
    index = np.arange(len(points))
    for _ in range(_CIRCLE_STEPS):
        far = remaining.farthest(centre[remaining.owner])
        distance = np.linalg.norm(remaining.points[far] - centre[active], axis=1)
        outside = distance > radius[active] * (1 + _TOLERANCE) + 1e-15
        active = active[outside]
        determining[active, 3] = index[far[outside]]
        determining[active, :3], centre[active], grown = _smallest_circle(
            points, determining[active]
        )
        stuck = grown <= radius[active] * (1 + 1e-15)  # by rounding
        radius[active] = np.maximum(grown, radius[active])
        active = active[~stuck]
        if not len(active):
            break
        remaining, index = sets.only(active)
    return centre


def _smallest_circle(points: Floats, indices: Ints) -> tuple[Ints, Floats, Floats]:
    """Find the smallest circle about each of N times four points.

    Parameters
    ----------
    points
        (E, 2).
    indices
        (N, 4) points.

    Returns
    -------
    tuple[Ints, Floats, Floats]
        The points (N, 3) that determine the circle, its centre (N, 2) and its radius (N,).
    """
    best = indices[:, :3].copy()
    best_centre = np.zeros((len(indices), 2))
    best_radius = np.full(len(indices), np.inf)
    corner = points[indices]
    for subset in _SUBSETS:
        chosen = corner[:, subset]
        is_pair = subset[1] == subset[2]
        centre = (chosen[:, 0] + chosen[:, 1]) / 2 if is_pair else _circumcentres(chosen)
        distance = np.linalg.norm(corner - centre[:, None], axis=2)
        radius = distance[:, subset].max(axis=1)
        holds_all = distance.max(axis=1) <= radius * (1 + _TOLERANCE)
        better: Bools = holds_all & (radius < best_radius)
        best_centre[better] = centre[better]
        best_radius[better] = radius[better]
        best[better] = indices[better][:, subset]
    return best, best_centre, best_radius


def _circumcentres(corner: Floats) -> Floats:
    """Return the centre (N, 2) of the circle through three points (N, 3, 2); NaN if they are
    collinear."""
    # With u, v the sides from the first corner: c = (|u|^2 v - |v|^2 u) turned by 90 degrees / 2 u x v
    u = corner[:, 1] - corner[:, 0]
    v = corner[:, 2] - corner[:, 0]
    twice = 2 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    twice = np.where(twice == 0, np.nan, twice)
    uu = (u**2).sum(axis=1)
    vv = (v**2).sum(axis=1)
    x = (v[:, 1] * uu - u[:, 1] * vv) / twice
    y = (u[:, 0] * vv - v[:, 0] * uu) / twice
    return corner[:, 0] + np.column_stack([x, y])


_MIN_HEIGHT = 1e-9
"""Height [m] of a face above its longest edge below which it is degenerate: its normal is rounding
noise."""


@dataclass(frozen=True)
class FacePlanes:
    """Triangles with their planes."""

    vertices: Floats
    """(V, 3) [m]."""
    faces: Ints
    """(T, 3)."""
    vector: Floats
    """(T, 3) area vectors."""
    normal: Floats
    """(T, 3) unit normals; across the longest edge for degenerate faces."""
    area: Floats
    """(T,) [m^2]."""
    flat: Bools
    """(T,) whether a face is degenerate."""

    def only(self, kept: Bools) -> FacePlanes:
        """Return the same mesh with the faces (T,) that are kept."""
        return FacePlanes(
            self.vertices,
            self.faces[kept],
            self.vector[kept],
            self.normal[kept],
            self.area[kept],
            self.flat[kept],
        )

    def heights(self, faces: Ints, normal: Floats) -> Floats:
        """Return the heights (N, 3) [m] of the corners of faces (N,) along normals (N, 3)."""
        return np.einsum("nkc,nc->nk", self.vertices[self.faces[faces]], normal)


def degenerate_faces(vertices: Floats, faces: Ints) -> Bools:
    """Return which triangles (T,) have no area: two corners coincide, or all lie on one line."""
    return face_planes(vertices, faces).flat


def face_planes(vertices: Floats, faces: Ints) -> FacePlanes:
    """Compute the planes of triangles (T, 3) over vertices (V, 3) [m]."""
    corner = vertices[faces]
    side = np.roll(corner, -1, axis=1) - corner
    vector = np.cross(side[:, 0], side[:, 1]) / 2
    length = np.sqrt(np.einsum("nkc,nkc->nk", side, side))
    area = np.sqrt(np.einsum("nc,nc->n", vector, vector))
    flat = 2 * area <= _MIN_HEIGHT * length.max(axis=1, initial=0)
    normal = vector / np.where(flat, 1, area)[:, None]
    degenerate = np.flatnonzero(flat)
    if len(degenerate):
        longest = side[degenerate, length[degenerate].argmax(axis=1)]
        normal[degenerate] = perpendicular(longest)
    return FacePlanes(vertices, faces, vector, normal, area, flat)


def perpendicular(direction: Floats) -> Floats:
    """Return some unit vector (N, 3) at right angles to each direction; z for a zero vector."""
    smallest = np.eye(3)[np.abs(direction).argmin(axis=1)]
    normal = np.cross(direction, smallest)
    length = np.linalg.norm(normal, axis=1)
    normal[length == 0] = (0, 0, 1)
    return normal / np.where(length == 0, 1, length)[:, None]
