"""Exact signed distance of points to a closed triangle mesh, and largest balls inside it.

Nearest triangle by a tree of boxes; inside or outside by the pseudo-normal of the nearest face,
edge or vertex, which is exact for a closed mesh that does not cross itself (Baerentzen & Aanaes,
IEEE TVCG 11(3), 2005, DOI
10.1109/TVCG.2005.49). Nearest point on a triangle: Ericson, Real-Time Collision Detection, 2005,
5.1.5.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.geometry.bvh import box_gap, build_sah_bvh

__all__ = [
    "Solid",
    "build_solid",
    "medial_balls",
    "mesh_distance",
    "morton_order",
    "nearest_triangle",
]


class Solid(NamedTuple):
    """Triangles in the order of the tree's leaves. corner (T, 3, 3); normal (T, 7, 3): of the face,
    of corners 0, 1, 2 and of edges 01, 12, 20; face (T,): each one's number in the mesh; low, high,
    child, first, last: the tree."""

    corner: NDArray[np.float64]
    normal: NDArray[np.float64]
    face: NDArray[np.int64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    child: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]


def build_solid(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Solid:
    """Pack a closed mesh, vertices (V, 3) and outward faces (T, 3), for `mesh_distance`."""
    corner = vertices[faces]
    boxes = np.concatenate([corner.min(axis=1), corner.max(axis=1)], axis=1)
    box, link, item, _ = build_sah_bvh(boxes, np.array([0, len(faces)], dtype=np.int64))
    side = np.roll(corner, -1, axis=1) - corner
    flat = np.cross(side[:, 0], side[:, 1])
    flat /= np.maximum(np.linalg.norm(flat, axis=1), 1e-300)[:, None]
    long = np.maximum(np.linalg.norm(side, axis=2), 1e-300)
    cosine = -np.einsum("tkc,tkc->tk", side, np.roll(side, 1, axis=1)) / (
        long * np.roll(long, 1, axis=1)
    )
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    # pseudo-normal of a corner: the normals of its faces, each weighted by the face's angle there
    at_corner = np.zeros_like(vertices)
    for k in range(3):
        for axis in range(3):
            at_corner[:, axis] += np.bincount(
                faces[:, k], angle[:, k] * flat[:, axis], minlength=len(vertices)
            )
    # pseudo-normal of an edge: the sum of the normals of the faces that meet there
    tail = faces.ravel()
    head = np.roll(faces, -1, axis=1).ravel()
    key = np.minimum(tail, head) * len(vertices) + np.maximum(tail, head)
    edge = np.unique(key, return_inverse=True)[1]
    spread = np.repeat(flat, 3, axis=0)
    at_edge = np.stack([np.bincount(edge, spread[:, axis]) for axis in range(3)], axis=1)
    normal = np.concatenate(
        [flat[:, None], at_corner[faces], at_edge[edge].reshape(-1, 3, 3)], axis=1
    )
    low, high = (np.ascontiguousarray(ends) for ends in (box[:, :3], box[:, 3:]))
    child, first, last = np.ascontiguousarray(link.T)
    return Solid(corner[item], normal[item], item, low, high, child, first, last)


def morton_order(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """An order of points (n, 3) in which neighbours in the list are near in space (Z curve, 2^16
    cells a side)."""
    low = points.min(axis=0)
    size = max(float((points.max(axis=0) - low).max()), 1e-300)
    cell = np.minimum((points - low) * (65535.0 / size), 65535.0).astype(np.uint64)
    key = np.zeros(len(points), dtype=np.uint64)
    for axis in range(3):
        bits = cell[:, axis]
        for shift, mask in (  # spread 16 bits so that two places stay free after each
            (16, 0x0000FF0000FF),
            (8, 0x00F00F00F00F),
            (4, 0x0C30C30C30C3),
            (2, 0x249249249249),
        ):
            bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
        key |= bits << np.uint64(axis)
    return np.argsort(key, kind="stable")


@njit(cache=True)
def _on_edge(x, y, z, a, b):  # type: ignore[no-untyped-def]
    """Nearest point of an edge: squared distance, end (0, 1; 2 between), point."""
    u = b[0] - a[0]
    v = b[1] - a[1]
    w = b[2] - a[2]
    square = u * u + v * v + w * w
    t = ((x - a[0]) * u + (y - a[1]) * v + (z - a[2]) * w) / square if square > 0.0 else 0.0
    end = 2
    if t <= 0.0:
        t = 0.0
        end = 0
    elif t >= 1.0:
        t = 1.0
        end = 1
    qx = a[0] + t * u
    qy = a[1] + t * v
    qz = a[2] + t * w
    return (x - qx) ** 2 + (y - qy) ** 2 + (z - qz) ** 2, end, qx, qy, qz


@njit(cache=True)
def _on_triangle(x, y, z, c, n):  # type: ignore[no-untyped-def]
    """Nearest point of a triangle with unit normal n: squared distance, feature (index into
    Solid.normal), point."""
    a0 = x - c[0, 0]
    a1 = y - c[0, 1]
    a2 = z - c[0, 2]
    h = a0 * n[0] + a1 * n[1] + a2 * n[2]
    crossed = 0
    best = np.inf
    feature = 0
    bx = x
    by = y
    bz = z
    for k in range(3):
        i = (k + 1) % 3
        u = c[i, 0] - c[k, 0]
        v = c[i, 1] - c[k, 1]
        w = c[i, 2] - c[k, 2]
        p = x - c[k, 0]
        q = y - c[k, 1]
        r = z - c[k, 2]
        # left of the edge, seen from outside: n . ((c_i - c_k) x (x - c_k)) >= 0
        side = n[0] * (v * r - w * q) + n[1] * (w * p - u * r) + n[2] * (u * q - v * p)
        if side >= 0.0 and (n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0):
            crossed += 1
            continue
        gap, end, qx, qy, qz = _on_edge(x, y, z, c[k], c[i])
        if gap < best:
            best = gap
            bx = qx
            by = qy
            bz = qz
            feature = 1 + k if end == 0 else (1 + i if end == 1 else 4 + k)
    if crossed == 3:
        return h * h, 0, x - h * n[0], y - h * n[1], z - h * n[2]
    return best, feature, bx, by, bz


@njit(cache=True)
def nearest_triangle(x, y, z, solid, hint, limit, any_will_do):  # type: ignore[no-untyped-def]
    """Nearest triangle: squared distance, triangle (-1: none within sqrt(limit)), feature, point;
    `hint` tried first.

    any_will_do: the first one found within the limit is enough.
    """
    best = limit
    found = -1
    feature = 0
    bx = x
    by = y
    bz = z
    if hint >= 0:
        gap, part, qx, qy, qz = _on_triangle(x, y, z, solid.corner[hint], solid.normal[hint, 0])
        if gap < best:
            best = gap
            found = hint
            feature = part
            bx = qx
            by = qy
            bz = qz
            if any_will_do:
                return best, found, feature, bx, by, bz
    stack = np.empty(64, np.int64)
    gaps = np.empty(64)
    stack[0], gaps[0], size = 0, box_gap(x, y, z, solid.low, solid.high, 0), 1
    while size > 0:
        size -= 1
        m = stack[size]
        if gaps[size] >= best:
            continue
        near = solid.child[m]
        if near < 0:
            for t in range(solid.first[m], solid.last[m]):
                gap, part, qx, qy, qz = _on_triangle(x, y, z, solid.corner[t], solid.normal[t, 0])
                if gap < best:
                    best = gap
                    found = t
                    feature = part
                    bx = qx
                    by = qy
                    bz = qz
                    if any_will_do:
                        return best, found, feature, bx, by, bz
            continue
        far = near + 1
        a = box_gap(x, y, z, solid.low, solid.high, near)
        b = box_gap(x, y, z, solid.low, solid.high, far)
        if b < a:
            near, far, a, b = far, near, b, a
        if b < best:
            stack[size] = far
            gaps[size] = b
            size += 1
        if a < best:
            stack[size] = near
            gaps[size] = a
            size += 1
    return best, found, feature, bx, by, bz


@njit(cache=True)
def mesh_distance(points, solid, distance, face, foot):  # type: ignore[no-untyped-def]
    """Signed distance of points (n, 3) to a closed mesh, negative inside; fills distance (n,), face
    (n,), foot (n, 3).

    Fastest when points stand in an order in which neighbours are near (`morton_order`).
    """
    hint = -1
    for i in range(len(points)):
        x = points[i, 0]
        y = points[i, 1]
        z = points[i, 2]
        square, hint, feature, qx, qy, qz = nearest_triangle(x, y, z, solid, hint, np.inf, False)
        n = solid.normal[hint, feature]
        outside = (x - qx) * n[0] + (y - qy) * n[1] + (z - qz) * n[2] >= 0.0
        distance[i] = math.sqrt(square) if outside else -math.sqrt(square)
        face[i] = solid.face[hint]
        foot[i, 0] = qx
        foot[i, 1] = qy
        foot[i, 2] = qz


@njit(cache=True)
def medial_balls(points, normals, greatest, slack, solid, centre):  # type: ignore[no-untyped-def]
    """Balls under the surface points (n, 3): from radius `greatest` shrunk until no surface is
    deeper than slack.

    greatest, slack (n,) [m]. Source of the step: Ma, Bae & Choi, Visual Computer 28, 2012, DOI
    10.1007/s00371-011-0594-7. Fills centre (n, 3).
    """
    for i in range(len(points)):
        x = points[i, 0]
        y = points[i, 1]
        z = points[i, 2]
        u = normals[i, 0]
        v = normals[i, 1]
        w = normals[i, 2]
        r = greatest[i]
        hint = -1
        for _ in range(40):
            cx = x - r * u
            cy = y - r * v
            cz = z - r * w
            empty = max(r - slack[i], 0.25 * r)
            _, hint, _, qx, qy, qz = nearest_triangle(cx, cy, cz, solid, hint, empty * empty, False)
            if hint < 0:
                break
            a = x - qx
            b = y - qy
            c = z - qz
            # the ball that touches the surface at x and passes q has |x - q|^2 = 2 r (x - q) . n
            along = a * u + b * v + c * w
            touching = (a * a + b * b + c * c) / (2.0 * along) if along > 0.0 else 0.0
            r = min(0.95 * r, max(touching, 0.3 * r))
        centre[i, 0] = x - r * u
        centre[i, 1] = y - r * v
        centre[i, 2] = z - r * w
