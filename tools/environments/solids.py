"""Closed solids from a few moves: loft, hull and sweep, placed by frames, joined and cut by
booleans. Lengths [mm]."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from manifold3d import Manifold, Mesh64, triangulate
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "box",
    "disc",
    "frame",
    "hull",
    "loft",
    "mirrored",
    "place",
    "prism",
    "shell",
    "sweep",
    "union",
    "write_obj",
]

Floats = NDArray[np.float64]
DIGITS = 7  # vertices are written in metres to 0.1 micrometre, so that what is planar stays planar
GRID = 10.0 ** (3 - DIGITS)  # [mm]
LEAST_HEIGHT = 0.1  # a triangle lower than this is a needle [mm]
AXES = {
    "x": [2, 0, 1],
    "y": [0, 2, 1],
    "z": [0, 1, 2],
}  # where x, y, z are found in (outline, height)


def loft(rings: ArrayLike) -> Manifold:
    """The solid between rings (M, N, 3) of N points each, closed by a flat cap at either end."""
    points = np.asarray(rings, dtype=np.float64)
    m, n = points.shape[:2]
    start = np.arange(m - 1)[:, None] * n
    here = np.arange(n)
    there = np.roll(np.arange(n), -1)
    a, b, c, d = (np.ravel(start + k) for k in (here, there, there + n, here + n))
    first = _cap(points[0])
    last = _cap(points[-1]) + (m - 1) * n
    flat = points.reshape(-1, 3)
    shorter = np.linalg.norm(flat[a] - flat[c], axis=1) <= np.linalg.norm(flat[b] - flat[d], axis=1)
    one = np.where(
        shorter, [a, b, c], [a, b, d]
    ).T  # cut along the shorter diagonal: the same on either side
    two = np.where(shorter, [a, c, d], [b, c, d]).T
    return _outward(flat, np.concatenate([one, two, first[:, ::-1], last]))


def _cap(ring: Floats) -> NDArray[np.int64]:
    """Triangles of a plane ring, wound like the ring."""
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(ring, drop, axis=1)
    x, y = flat.T
    backward = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) < 0.0
    flat = flat * [1.0, -1.0] if backward else flat  # now anticlockwise, in the same order
    triangles: NDArray[np.int64] = np.asarray(
        triangulate([np.ascontiguousarray(flat)]), dtype=np.int64
    )
    return triangles


def _outward(vertices: Floats, faces: NDArray[np.int64]) -> Manifold:
    """The solid with these faces, all turned to face outward."""
    corner = vertices[faces]
    volume = np.einsum("ij,ij->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
    turned = faces if volume > 0 else faces[:, ::-1]
    solid = Manifold(
        Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(turned, dtype=np.uint64))
    )
    if solid.is_empty():
        raise ValueError(f"not a closed surface: {solid.status()}")
    return solid


def prism(outline: ArrayLike, axis: str, low: float, high: float) -> Manifold:
    """A plane outline (N, 2), in the order x, y, z of the other two axes, extended along `axis`."""
    flat = np.asarray(outline, dtype=np.float64)
    rings = [np.column_stack([flat, np.full(len(flat), at)])[:, AXES[axis]] for at in (low, high)]
    return loft(rings)


def box(low: ArrayLike, high: ArrayLike) -> Manifold:
    """The axis-parallel box between two corners."""
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, float), np.asarray(high, float)
    return prism([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], "z", float(z0), float(z1))


def hull(points: ArrayLike) -> Manifold:
    """The convex hull of points (N, 3)."""
    return Manifold.hull_points(np.ascontiguousarray(points, dtype=np.float64))


def sweep(
    path: ArrayLike, radii: float | Sequence[float], *, sides: int = 12, flat: float = 1.0
) -> Manifold:
    """A round bar along a path (N, 3), mitred at its bends; flat < 1 presses it to an oval."""
    p = np.asarray(path, dtype=np.float64)
    r = np.broadcast_to(np.asarray(radii, dtype=np.float64), len(p))
    step = np.diff(p, axis=0)
    step /= np.linalg.norm(step, axis=1)[:, None]
    mean = np.vstack([step[:1], step[:-1] + step[1:], step[-1:]])
    mean /= np.linalg.norm(mean, axis=1)[:, None]
    side = np.cross(step[0], [0.0, 1.0, 0.0] if abs(step[0, 1]) < 0.9 else [1.0, 0.0, 0.0])
    turn = (np.arange(sides) + 0.5) * 2.0 * np.pi / sides
    rings = []
    for centre, radius, along in zip(p, r, mean, strict=True):
        across = side - along * (side @ along)
        across /= np.linalg.norm(across)
        other = np.cross(along, across)
        rings.append(
            centre
            + radius * (np.outer(np.cos(turn), across) + flat * np.outer(np.sin(turn), other))
        )
    return loft(rings)


def disc(
    centre: ArrayLike, axis: ArrayLike, radius: float, height: float, *, sides: int = 24
) -> Manifold:
    """A round disc standing on `centre`, `height` along `axis`."""
    base = np.asarray(centre, dtype=np.float64)
    along = np.asarray(axis, dtype=np.float64)
    return sweep([base, base + along / np.linalg.norm(along) * height], radius, sides=sides)


def shell(inner: Floats, outer: Floats) -> Manifold:
    """The solid between two open grids (M, N, 3)."""
    return loft(np.concatenate([inner, outer[:, ::-1]], axis=1))


def union(solids: Iterable[Manifold]) -> Manifold:
    """All in one."""
    total = Manifold()
    for solid in solids:
        total += solid
    return total


def frame(origin: ArrayLike, u: ArrayLike, v: ArrayLike) -> Floats:
    """The placement (3, 4) of a solid drawn with x along u, y along v and z along their cross
    product."""
    a = np.asarray(u, dtype=np.float64)
    b = np.asarray(v, dtype=np.float64)
    return np.column_stack([a, b, np.cross(a, b), np.asarray(origin, dtype=np.float64)])


def place(solid: Manifold, placement: Floats) -> Manifold:
    """A solid moved from its own axes by a frame."""
    return solid.transform(placement)


def mirrored(solid: Manifold) -> Manifold:
    """The same on the other side of the centre line."""
    return solid.mirror((0.0, 1.0, 0.0))


def write_obj(path: Path, parts: dict[str, Manifold], title: str) -> None:
    """Write every part as a block `o NAME` of vertices [m] and triangles."""
    lines, base = [f"# {title}", "# metres; x forward, y left, z up"], 1
    for name, solid in parts.items():
        vertices, faces = _gridded(name, solid)
        lines.append(f"o {name}")
        lines += [
            "v " + " ".join(f"{c / 10**DIGITS:.{DIGITS}f}" for c in row)
            for row in vertices.tolist()
        ]
        lines += [f"f {a + base} {b + base} {c + base}" for a, b, c in faces.tolist()]
        base += len(vertices)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _gridded(name: str, solid: Manifold) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vertices [GRID] and triangles of a solid in an order that depends on nothing but its
    shape."""
    mesh = solid.simplify(LEAST_HEIGHT).to_mesh64()
    whole = np.rint(np.asarray(mesh.vert_properties)[:, :3] / GRID).astype(np.int64)
    vertices, index = np.unique(whole, axis=0, return_inverse=True)
    faces = index.reshape(-1)[np.asarray(mesh.tri_verts).astype(np.int64)]
    faces = np.array([np.roll(f, -int(np.argmin(f))) for f in faces])
    faces = faces[np.lexsort(faces.T[::-1])]
    _check(name, vertices.astype(np.float64) * GRID, faces)
    return vertices, faces


def _check(name: str, vertices: Floats, faces: NDArray[np.int64]) -> None:
    """Refuse a part that the grid has opened, folded or sharpened to needles."""
    half = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forward = {(int(a), int(b)) for a, b in half}
    if len(forward) != len(half) or any((b, a) not in forward for a, b in forward):
        raise ValueError(f"{name}: the surface is not closed")
    corner = vertices[faces]
    edge = np.roll(corner, -1, axis=1) - corner
    area = np.linalg.norm(np.cross(edge[:, 0], edge[:, 1]), axis=1)
    height = area / np.linalg.norm(edge, axis=2).max(axis=1)
    if height.min() < LEAST_HEIGHT:
        raise ValueError(
            f"{name}: a triangle {height.min():.3f} mm high at {corner[int(np.argmin(height))].tolist()}"
        )
