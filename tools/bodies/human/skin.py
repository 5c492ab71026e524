"""The outer skin of the base mesh: one closed surface, mouth, eye sockets, nostrils and ears
sealed.

A face of the head that light from hardly any direction reaches lies in a cavity. Those faces go,
and each rim left over is closed by a fan around one new point, a mean of vertices; so the seal
moves with every shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from human.source import Source

__all__ = ["Skin"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
DARK = 0.02


@dataclass(frozen=True, eq=False)
class Skin:
    """faces (T, 3) into the points of `points(shape)`: those vertices `used` (n,) and the middles
    of `caps`."""

    faces: Ints
    used: Ints
    caps: tuple[Ints, ...]
    mirror: Ints

    @classmethod
    def of(cls, source: Source, head: Ints) -> Skin:
        """head: the vertices of the head, where cavities are."""
        quads = source.quads["body"]
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        triangles = triangles[triangles[:, 1] != triangles[:, 2]]
        near = np.isin(quads, head).all(axis=1)
        eyes = np.concatenate([source.quads[f"helper-{side}-eye"] for side in "lr"])
        light = _light(source.base, quads[near], eyes)
        light = np.minimum(light, _mirrored(source, quads[near], light))
        hidden = np.zeros(len(quads), dtype=bool)
        hidden[np.flatnonzero(near)[light < DARK]] = True
        hidden = _largest_outside(quads, hidden)
        kept = quads[~hidden]
        caps = []
        fans = []
        balls = [source.groups[f"helper-{side}-eye"] for side in "lr"]
        for rim in _rims(kept):
            middle = source.base[rim].mean(axis=0)
            eye = min(
                balls,
                key=lambda rows: float(np.linalg.norm(source.base[rows].mean(axis=0) - middle)),
            )
            ball = source.base[eye]
            if len(rim) > 24 and np.linalg.norm(ball.mean(axis=0) - middle) < 0.02:
                caps.append(eye[ball[:, 0] > ball[:, 0].max() - 0.001])  # the front of the eye ball
            else:
                caps.append(np.unique(rim))
            fans.append(
                np.column_stack([rim, np.roll(rim, -1), np.full(len(rim), -len(caps))])[
                    :, [1, 0, 2]
                ]
            )
        flat = np.concatenate([kept[:, [0, 1, 2]], kept[:, [0, 2, 3]], *fans])
        used = np.unique(flat[flat >= 0])
        number = np.full(len(source.base), -1)
        number[used] = np.arange(len(used))
        faces = np.where(flat >= 0, number[np.maximum(flat, 0)], len(used) - 1 - flat)
        skin = cls(faces, used, tuple(caps), np.zeros(0, np.int64))
        return cls(faces, used, tuple(caps), skin._mirror(source.base))

    def points(self, shape: Floats) -> Floats:
        """(P, k) of the skin, from rows (V, k) of the base mesh: places, or weights."""
        return np.concatenate([shape[self.used], [shape[rows].mean(axis=0) for rows in self.caps]])

    def _mirror(self, base: Floats) -> Ints:
        """The point of the skin on the other side of each."""
        from scipy.spatial import cKDTree

        points = self.points(base)
        gap, other = cKDTree(points).query(points * np.array([1.0, -1.0, 1.0]))
        if gap.max() > 1e-6:
            raise ValueError(f"the sealed skin is not symmetric by {gap.max():.6f} m")
        return np.asarray(other, dtype=np.int64)


def _mirrored(source: Source, quads: Ints, light: Floats) -> Floats:
    """The light of each face's mirror image."""
    key = {tuple(sorted(row)): k for k, row in enumerate(quads.tolist())}
    twin = [key[tuple(sorted(row))] for row in source.mirror[quads].tolist()]
    return light[np.array(twin)]


def _largest_outside(quads: Ints, hidden: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Hidden faces, and lit ones that hang together with nothing of the outer skin; specks of shade
    stay outside."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    result = hidden.copy()
    side = np.stack(
        [np.sort(quads[:, [k, (k + 1) % 4]], axis=1) for k in range(4)], axis=1
    ).reshape(-1, 2)
    _, edge = np.unique(side, axis=0, return_inverse=True)
    edge = edge.reshape(-1, 4)
    for _ in range(6):  # a face goes with three of its four neighbours: smooth rims
        dark = np.bincount(edge.ravel(), np.repeat(result, 4), minlength=edge.max() + 1)
        around = dark[edge].sum(axis=1) - 4 * result
        result = np.where(around >= 3, True, np.where(around <= 1, False, result))
    for state in (True, False):
        rows = np.flatnonzero(result == state)
        member = coo_matrix(
            (np.ones(4 * len(rows)), (np.repeat(np.arange(len(rows)), 4), quads[rows].ravel()))
        )
        _, label = connected_components(member.tocsr() @ member.T.tocsr(), directed=False)
        size = np.bincount(label)
        few = size < 12 if state else size < size.max()
        result[rows[few[label]]] = not state
    return result


def _rims(quads: Ints) -> list[Ints]:
    """The open edges of a mesh as closed chains of vertices, in the sense of the faces they
    border."""
    edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    edges = edges[edges[:, 0] != edges[:, 1]]
    there = set(map(tuple, edges.tolist()))
    onward: dict[int, list[int]] = {}
    for a, b in there:
        if (b, a) not in there:
            onward.setdefault(a, []).append(b)
    rims = []
    while onward:
        start = min(onward)
        chain = [start]
        while True:
            following = onward[chain[-1]]
            step = following.pop()
            if not following:
                del onward[chain[-1]]
            if step in chain:  # a rim that touches itself is two rims
                loop = chain[chain.index(step) :]
                rims.append(np.array(loop))
                chain = chain[: chain.index(step) + 1]
                if len(chain) == 1 and chain[0] not in onward:
                    break
                if chain[-1] not in onward:
                    break
            else:
                chain.append(step)
    return rims


def _light(points: Floats, quads: Ints, others: Ints) -> Floats:
    """(n,) share of the half sphere over each face from which light reaches it, past the faces
    themselves and others (m, 4)."""
    count = 160
    k = np.arange(count)
    height = 1 - (2 * k + 1) / count
    turn = k * np.pi * (3 - 5**0.5)
    flat = np.sqrt(1 - height**2)
    ways = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    split = [[0, 1, 2], [0, 2, 3]]
    corners = np.concatenate([points[rows[:, k]] for rows in (quads, others) for k in split])
    normal = np.cross(
        points[quads[:, 2]] - points[quads[:, 0]], points[quads[:, 3]] - points[quads[:, 1]]
    )
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-18)[:, None]
    middle = points[quads].mean(axis=1)
    found: Floats = _lit(middle + 1e-5 * normal, normal, ways, np.ascontiguousarray(corners))
    return found


@njit(cache=True)
def _lit(place, normal, ways, corners):  # type: ignore[no-untyped-def]
    low = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
    high = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
    share = np.zeros(len(place))
    last = 0
    for i in range(len(place)):
        tried = lit = 0
        for w in range(len(ways)):
            d = ways[w]
            if d[0] * normal[i, 0] + d[1] * normal[i, 1] + d[2] * normal[i, 2] < 0.05:
                continue
            tried += 1
            blocked = False
            for t in range(-1, len(corners)):
                f = last if t < 0 else t
                if f < 2 * len(place) and f % len(place) == i:  # a bent face would shade itself
                    continue
                # the box against the line, by its projection along each pair of axes, cheaply: the
                # slab test
                near = 0.0
                far = 1.0
                out = False
                for a in range(3):
                    if abs(d[a]) < 1e-12:
                        out = out or place[i, a] < low[f, a] or place[i, a] > high[f, a]
                    else:
                        p = (low[f, a] - place[i, a]) / d[a]
                        q = (high[f, a] - place[i, a]) / d[a]
                        near = max(near, min(p, q))
                        far = min(far, max(p, q))
                if out or near > far + 1e-9:
                    continue
                e = corners[f, 1] - corners[f, 0]
                g = corners[f, 2] - corners[f, 0]
                h = np.cross(d, g)
                det = e[0] * h[0] + e[1] * h[1] + e[2] * h[2]
                if abs(det) < 1e-18:
                    continue
                s = place[i] - corners[f, 0]
                u = (s[0] * h[0] + s[1] * h[1] + s[2] * h[2]) / det
                if u < 0 or u > 1:
                    continue
                k = np.cross(s, e)
                v = (d[0] * k[0] + d[1] * k[1] + d[2] * k[2]) / det
                if v < 0 or u + v > 1:
                    continue
                if (g[0] * k[0] + g[1] * k[1] + g[2] * k[2]) / det > 1e-6:
                    blocked = True
                    last = f
                    break
            lit += not blocked
        share[i] = lit / max(tried, 1)
    return share
