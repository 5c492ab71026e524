"""What every mesh reader hands over: named parts in the file's own numbers, and what the file says about itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["RawMesh", "RawPart", "triangulated", "unique_names", "welded"]


@dataclass(frozen=True, eq=False)
class RawPart:
    """A named part: vertices (V, 3), triangles (T, 3)."""

    name: str
    vertices: Floats
    faces: Ints


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A mesh file as read. metres: what one file unit is in metres, None where the file does not say; up: the
    axis the file or its format says is up, forward: the same for forward, None where neither does; notes: sentences
    about what the file holds besides surfaces."""

    file: str
    format: str
    parts: tuple[RawPart, ...]
    metres: float | None = None
    up: str | None = None
    notes: tuple[str, ...] = ()
    forward: str | None = None


def unique_names(names: Iterable[str], otherwise: str) -> list[str]:
    """Names in the same order, none twice: `seat`, `seat_2`, `seat_3`; an empty one becomes `otherwise`."""
    wanted = [" ".join(name.split()) or otherwise for name in names]
    taken = set(wanted)
    last: dict[str, int] = {}
    given: list[str] = []
    for name in wanted:
        count = last.get(name, 0) + 1
        candidate = name
        if count > 1:
            while (candidate := f"{name}_{count}") in taken:
                count += 1
        last[name] = count
        taken.add(candidate)
        given.append(candidate)
    return given


def welded(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Vertices of exactly equal position become one, unused ones go; faces keep their order and count.

    No tolerance: what lies a hair apart stays apart, and shows as open edges.
    """
    points = vertices[faces.ravel()] + 0.0  # -0.0 and 0.0 are one place
    mixed = np.zeros(len(points), dtype=np.uint64)
    for column, factor in zip(points.T, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9), strict=True):
        mixed = (mixed ^ column.copy().view(np.uint64)) * np.uint64(factor)
        mixed ^= mixed >> np.uint64(29)
    first, inverse = np.unique(mixed, return_index=True, return_inverse=True)[1:]
    if not np.array_equal(points[first[inverse]], points):  # two places with one hash: sort the rows themselves
        first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)[1:]
    order = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int64)
    rank[order] = np.arange(len(first))
    return points[first[order]], rank[inverse.ravel()].reshape(-1, 3)


def triangulated(vertices: Floats, corners: Ints, counts: Ints) -> Ints:
    """Triangles (T, 3) of faces with any number of corners; `corners` holds the faces one after the other.

    A quadrilateral is cut along the diagonal that does not fold it; larger faces by clipping ears, so that concave
    ones come out right.
    """
    start = np.cumsum(counts) - counts
    three = start[counts == 3][:, None] + np.arange(3)
    quads = corners[start[counts == 4][:, None] + np.arange(4)]
    cut = np.where(_folds(vertices, quads)[:, None], np.roll(quads, -1, axis=1), quads)
    pieces = [corners[three], cut[:, [0, 1, 2]], cut[:, [0, 2, 3]]]
    origin = [np.flatnonzero(counts == 3), np.flatnonzero(counts == 4), np.flatnonzero(counts == 4)]
    for face in np.flatnonzero(counts > 4):
        ring = corners[start[face] : start[face] + counts[face]]
        pieces.append(_clipped(vertices[ring], ring))
        origin.append(np.full(len(pieces[-1]), face))
    order = np.argsort(np.concatenate(origin), kind="stable")
    faces: Ints = np.concatenate(pieces)[order]
    return faces


def _folds(vertices: Floats, quads: Ints) -> Bools:
    """(n,) whether cutting from corner 0 to corner 2 makes two triangles that face opposite ways."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    folds: Bools = (np.cross(b - a, c - a) * np.cross(c - a, d - a)).sum(axis=1) < 0
    return folds


def _clipped(points: Floats, ring: Ints) -> Ints:
    """Triangles of one polygon (n corners): a corner that points outward and has no other corner in its triangle is
    cut off, until three are left; where rounding leaves no such corner, the first is cut off."""
    normal = np.cross(points - points[0], np.roll(points, -1, axis=0) - points[0]).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    flat = np.delete(points, axis, axis=1) * (1 if (normal[axis] > 0) == (axis != 1) else -1, 1)
    left, faces = list(range(len(ring))), []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(flat, left, k)), 0)
        faces.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    faces.append((left[0], left[1], left[2]))
    clipped: Ints = ring[np.array(faces)]
    return clipped


def _is_ear(flat: Floats, left: list[int], k: int) -> bool:
    a, b, c = flat[left[k - 1]], flat[left[k]], flat[left[(k + 1) % len(left)]]
    if _turn(a, b, c) <= 0:
        return False
    rest = flat[[n for n in left if n not in (left[k - 1], left[k], left[(k + 1) % len(left)])]]
    inside = (_turn(a, b, rest) >= 0) & (_turn(b, c, rest) >= 0) & (_turn(c, a, rest) >= 0)
    return not bool(np.any(inside))


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed area of the triangle a, b, c in the plane; c may be many points (n, 2)."""
    area: Floats = (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])
    return area
