"""Spheres fitted to one shape, carried to any other: a similarity of each sphere's own patch of
skin, then polish.

Each sphere keeps the skin samples that it was nearest to; in another shape it moves with them by
the best similarity (Umeyama 1991) and is then fitted to them by damped least squares. The patches
never change, so centres and radii are smooth functions of the shape. A sphere at a joint stays on
the joint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from human.fit import Given, Spheres, shares_at
from human.skeleton import BETWEEN, JOINTS, SEGMENTS
from workbench.body.fitting.candidates import even_samples
from workbench.body.fitting.polish import union_field
from workbench.body.surface import Surface
from workbench.geometry.nearest import morton_order

__all__ = ["Rig", "rigged"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FLIP = np.array([1.0, -1.0, 1.0])
FEW = 24
STEPS = 7
HOLD = 0.06
GUARD = 1e-3


@dataclass(frozen=True, eq=False)
class Rig:
    """Patches of S spheres, left and middle. corner (n, 3), weight (n, 3): each sample among the
    skin's points; flip (n,): on the other side; sphere (n,) its owner; own (n,): whether it lies on
    the sphere or only near it."""

    spheres: Spheres
    given: Given
    corner: Ints
    weight: Floats
    flip: NDArray[np.bool_]
    sphere: Ints
    own: Floats
    place: Floats
    blend_joint: Ints
    blend_share: Floats

    def samples(self, skin: Floats) -> Floats:
        """(n, 3) the samples on a skin (P, 3)."""
        point: Floats = np.einsum("nk,nkc->nc", self.weight, skin[self.corner])
        return np.where(self.flip[:, None], point * FLIP, point)

    def carried(self, skin: Floats, joints: Floats) -> tuple[Floats, Floats]:
        """Centres (S, 3) and radii (S,) on another skin (P, 3) with joints (J, 3)."""
        point = self.samples(skin)
        centre, scale = self._similar(point)
        radius = self.spheres.radius * scale
        tied = np.flatnonzero(self.given.joint >= 0)
        centre[tied] = joints[self.given.joint[tied]]
        guess = centre.copy()
        size = radius.copy()
        for _ in range(STEPS):
            step = self._step(point, (centre, radius), (guess, size))
            step[tied, :3] = 0.0
            centre = centre + step[:, :3]
            radius = np.maximum(radius + step[:, 3], 0.3 * size)
        middle = ~self.spheres.sided
        centre[middle, 1] = 0.0
        return centre, radius

    def _similar(self, point: Floats) -> tuple[Floats, Floats]:
        """Centres moved by the similarity of each patch, and its scale."""
        count = len(self.spheres.radius)
        own = self.own
        total = np.bincount(self.sphere, own, minlength=count)

        def mean(values: Floats) -> Floats:
            return np.column_stack(
                [np.bincount(self.sphere, own * v, minlength=count) / total for v in values.T]
            )

        old = mean(self.place)
        new = mean(point)
        a = self.place - old[self.sphere]
        b = point - new[self.sphere]
        cross = mean((b[:, :, None] * a[:, None, :]).reshape(-1, 9)).reshape(-1, 3, 3)
        u, d, vt = np.linalg.svd(cross)
        sign = np.where(np.linalg.det(u) * np.linalg.det(vt) < 0, -1.0, 1.0)
        d[:, 2] *= sign
        u[:, :, 2] *= sign[:, None]
        spread = mean((a**2).sum(axis=1)[:, None])[:, 0]
        scale = d.sum(axis=1) / np.maximum(spread, 1e-18)
        offset = self.spheres.centre - old
        return new + scale[:, None] * np.einsum("sij,sj->si", u @ vt, offset), scale

    def _step(
        self, point: Floats, now: tuple[Floats, Floats], guess: tuple[Floats, Floats]
    ) -> Floats:
        """(S, 4) one damped Gauss-Newton step of centre and radius on each sphere's own samples."""
        count = len(self.spheres.radius)
        away = point - now[0][self.sphere]
        far = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
        gap = far - now[1][self.sphere]
        row = np.column_stack([away / far[:, None], np.ones(len(far))])
        # a sample that another sphere holds pushes this one back where it would come out of the
        # skin there
        weight = np.where(self.own > 0, self.own, np.clip(-(gap + GUARD) / GUARD, 0, 1))
        gap = np.where(self.own > 0, gap, gap + GUARD)
        held = np.bincount(self.sphere, self.own, minlength=count)
        normal = np.zeros((count, 4, 4))
        right = np.zeros((count, 4))
        for i in range(4):
            right[:, i] = np.bincount(self.sphere, weight * row[:, i] * gap, minlength=count)
            for j in range(4):
                normal[:, i, j] = np.bincount(
                    self.sphere, weight * row[:, i] * row[:, j], minlength=count
                )
        hold = HOLD * held + 1e-9
        normal += hold[:, None, None] * np.eye(4)
        pull = np.column_stack([guess[0] - now[0], guess[1] - now[1]])
        right += hold[:, None] * pull
        tied = np.flatnonzero(self.given.joint >= 0)
        right[tied, :3] = 0.0
        normal[tied, :3, 3] = 0.0
        normal[tied, 3, :3] = 0.0
        step: Floats = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
        return step


def rigged(
    surface: Surface, share: Floats, spheres: Spheres, given: Given, *, seed: int = 7
) -> Rig:
    """The patches of fitted spheres, found on the shape they were fitted to, and their blends
    between two segments."""
    count = len(spheres.radius)
    sided = spheres.sided
    wide = even_samples(surface, 0.0045, seed=seed)
    close = even_samples(surface, 0.0022, seed=seed + 1)
    parts = []
    for samples, fine in ((wide, False), (close, True)):
        label = shares_at(surface, share, samples).argmax(axis=1)
        wanted = np.isin(label, [SEGMENTS.index(n) for n in ("H", "LHN", "LF")]) == fine
        parts.append(samples.at(np.flatnonzero(wanted & (samples.point[:, 1] >= 0))))
    place = np.concatenate([s.point for s in parts])
    face = np.concatenate([s.face for s in parts])
    weight = _barycentric(surface, face, place)
    mix = np.concatenate([shares_at(surface, share, s) for s in parts])
    all_centre = np.concatenate([spheres.centre, spheres.centre[sided] * FLIP])
    all_radius = np.concatenate([spheres.radius, spheres.radius[sided]])
    owner = np.concatenate([np.arange(count), np.flatnonzero(sided)])
    order = morton_order(place)
    ball = np.empty(len(place), np.int64)
    ball[order] = union_field(place[order], all_centre, all_radius)[1]
    flip = ball >= count
    rows = [(np.arange(len(place)), flip, owner[ball], np.ones(len(place)))]
    # a sphere in the middle owns both halves of its patch
    both = np.flatnonzero(~sided[owner[ball]])
    rows.append((both, np.ones(len(both), bool), owner[ball][both], np.ones(len(both))))
    rows.append(_filled(place, mix, spheres, np.bincount(owner[ball], minlength=count)))
    rows.append(_guards(place, spheres, rows))
    index, turned, sphere, own = (np.concatenate([row[k] for row in rows]) for k in range(4))
    order = np.argsort(sphere, kind="stable")
    index = index[order]
    turned = turned[order].astype(bool)
    sphere = sphere[order]
    own = own[order]
    at = np.where(turned[:, None], place[index] * FLIP, place[index])
    blend = _blends(spheres, given, (sphere, own, mix[index]))
    return Rig(
        spheres,
        given,
        surface.faces[face][index],
        weight[index],
        turned,
        sphere,
        own.astype(float),
        at,
        *blend,
    )


def _barycentric(surface: Surface, face: Ints, place: Floats) -> Floats:
    corner = surface.vertices[surface.faces[face]]
    a = corner[:, 0]
    b = corner[:, 1]
    c = corner[:, 2]
    whole = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("nc,nc->n", whole, whole), 1e-30)
    u = np.einsum("nc,nc->n", np.cross(c - b, place - b), whole) / square
    v = np.einsum("nc,nc->n", np.cross(a - c, place - c), whole) / square
    return np.column_stack([u, v, 1 - u - v])


def _filled(
    place: Floats, mix: Floats, spheres: Spheres, held: Ints
) -> tuple[Ints, Ints, Ints, Floats]:
    """Samples near spheres that own few: of their own segment where it has some, weighing
    little."""
    tree = cKDTree(np.concatenate([place, place * FLIP]))
    rows = []
    for k in np.flatnonzero(held < FEW):
        _, near = tree.query(spheres.centre[k], k=400)
        mine = mix[near % len(place), spheres.segment[k]] > 0.25
        near = np.concatenate([near[mine], near[~mine]])[: 2 * FEW]
        if not spheres.sided[k]:
            near = np.unique(np.concatenate([near, (near + len(place)) % (2 * len(place))]))
        rows.append(
            (near % len(place), near >= len(place), np.full(len(near), k), np.full(len(near), 0.05))
        )
    return tuple(np.concatenate([row[i] for row in rows]) for i in range(4))  # type: ignore[return-value]


def _guards(
    place: Floats, spheres: Spheres, rows: list[tuple[Ints, ...]]
) -> tuple[Ints, Ints, Ints, Floats]:
    """Samples a sphere is near to without owning them; they weigh nothing until it comes out of the
    skin there."""
    owned = {
        (int(i), int(f), int(s))
        for index, flip, sphere, own in rows
        for i, f, s in zip(index, flip, sphere, strict=True)
    }
    both = np.concatenate([place, place * FLIP])
    tree = cKDTree(both)
    found = []
    for k, near in enumerate(tree.query_ball_point(spheres.centre, 1.35 * spheres.radius + 0.002)):
        few = np.array(near, dtype=np.int64)
        few = few[:: max(1, len(few) // 150)]
        fresh = [i for i in few.tolist() if (i % len(place), int(i >= len(place)), k) not in owned]
        found += [(i % len(place), i >= len(place), k, 0.0) for i in fresh]
    index, flip, sphere, own = (np.array(column) for column in zip(*found, strict=True))
    return index, flip, sphere, own


def _blends(
    spheres: Spheres, given: Given, patch: tuple[Ints, Floats, Floats]
) -> tuple[Ints, Floats]:
    """The joint across which each sphere is blended and its share of the other segment: mean skin
    weights."""
    sphere, own, mix = patch
    count = len(spheres.radius)
    total = np.bincount(sphere, own, minlength=count)
    mean = np.column_stack([np.bincount(sphere, own * m, minlength=count) / total for m in mix.T])
    joint = np.full(count, -1)
    share = np.zeros(count)
    pairs = [tuple(SEGMENTS.index(n) for n in BETWEEN[j].split()) for j in JOINTS]
    for k in range(count):
        n = spheres.segment[k]
        if k < spheres.given and given.joint[k] >= 0:
            continue
        best = [(mean[k, b if a == n else a], j) for j, (a, b) in enumerate(pairs) if n in (a, b)]
        other, j = max(best)
        w = other / max(other + mean[k, n], 1e-9)
        if w > 0.03:
            joint[k], share[k] = j, min(w, 0.95)
    return joint, share
