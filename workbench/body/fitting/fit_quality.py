"""How well a union of spheres fits a surface: distances both ways, volumes, and proved bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from workbench.body.fitting.polish import union_field
from workbench.body.fitting.sampling import Samples, random_samples
from workbench.body.fitting.verify import deepest_hollow, gap_bound, split_triangles
from workbench.body.kernels.scanlines import shared_volume
from workbench.body.surface import Surface
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Floats

__all__ = ["FitQuality", "exposed_points", "fit_quality"]


@dataclass(frozen=True)
class FitQuality:
    """Figures of one fit; distances [m].

    mean, p95: of the distance between the two surfaces, both ways together; to_spheres, to_surface:
    the largest found from the surface to that of the spheres and back (a crease narrower than the
    tolerance that the spheres close counts with its depth); outside: how far the true surface lies
    outside the spheres at most, hollows between the spheres included; inside: how far the spheres
    reach out of the surface at most, both proved; volume_ratio: spheres to surface; iou: shared
    volume by joined volume; seconds: processor time of the fit, this measuring not counted.
    """

    spheres: int
    mean: float
    p95: float
    to_spheres: float
    to_surface: float
    outside: float
    inside: float
    volume_ratio: float
    iou: float
    seconds: float

    @property
    def largest(self) -> float:
        """The larger of both ways (two-sided Hausdorff distance of the samples) [m]."""
        return max(self.to_spheres, self.to_surface)


def fit_quality(
    surface: Surface,
    centre: Floats,
    radius: Floats,
    *,
    samples: Samples | None = None,
    seconds: float = 0.0,
    count: int = 40_000,
    seed: int = 1,
    proved: float | None = None,
) -> FitQuality:
    """Measure spheres (m, 3), (m,) against a surface with `count` samples each way (or the given
    ones).

    proved [m]: a bound of `outside` that is known already, so that it need not be found.
    """
    on_surface = (samples or random_samples(surface, count, seed=seed)).point
    on_surface = on_surface[morton_order(on_surface)]
    exposed = exposed_points(centre, radius, count)
    there = distance_to_union(on_surface, exposed, centre, radius)
    depth = -surface.distance(centre)
    signed = surface.distance(exposed)
    back = np.abs(signed)
    both = np.concatenate([there, back])
    weight = np.concatenate(
        [np.full(len(there), 0.5 / len(there)), np.full(len(back), 0.5 / max(len(back), 1))]
    )
    order = np.argsort(both)
    p95 = both[order][np.searchsorted(np.cumsum(weight[order]), 0.95 * weight.sum())]
    pitch = max(float(np.ptp(surface.vertices, axis=0).max()) / 400, 1e-4)
    if proved is None:
        found = max(
            gap_bound(split_triangles(surface.vertices[surface.faces], 0.02), centre, radius),
            -float(signed.min(initial=0.0)),
        )
        proved = deepest_hollow(surface, centre, radius, found)
    mesh, union, shared = shared_volume(surface.vertices[surface.faces], centre, radius, pitch)
    return FitQuality(
        spheres=len(radius),
        mean=float(weight @ both),
        p95=float(p95),
        to_spheres=float(there.max()),
        to_surface=float(back.max(initial=0.0)),
        outside=proved,
        inside=max(0.0, float((radius - depth).max())),
        volume_ratio=union / mesh,
        iou=shared / (mesh + union - shared),
        seconds=seconds,
    )


def distance_to_union(points: Floats, exposed: Floats, centre: Floats, radius: Floats) -> Floats:
    """Distance (n,) [m] of points (n, 3) to the surface of the union.

    Exact outside, and inside wherever the way straight out of the deepest sphere ends on the
    surface of the union; elsewhere the nearest of the sampled `exposed` points, at most their
    spacing too long.
    """
    field, ball = union_field(points, centre, radius)
    away = points - centre[ball]
    away /= np.maximum(np.linalg.norm(away, axis=1), 1e-12)[:, None]
    out = centre[ball] + radius[ball][:, None] * away
    hidden = (field < 0) & (union_field(out, centre, radius)[0] < -1e-9)
    distance: Floats = np.abs(field)
    if hidden.any() and len(exposed):
        distance[hidden] = np.maximum(cKDTree(exposed).query(points[hidden])[0], distance[hidden])
    return distance


def exposed_points(centre: Floats, radius: Floats, count: int) -> Floats:
    """About `count` points, uniform over the spheres' surface, less those inside other spheres.

    Each sphere carries points on a spiral (Saff & Kuijlaars, Math. Intelligencer 19, 1997), in
    number as its area.
    """
    share = radius**2 / (radius**2).sum()
    # about a third of the spheres' area is exposed in a fitted body
    each = np.maximum(12, np.ceil(3 * count * share)).astype(np.int64)
    owner = np.repeat(np.arange(len(radius)), each)
    step = np.arange(len(owner)) - np.repeat(np.cumsum(each) - each, each)
    height = 1 - (2 * step + 1) / each[owner]
    turn = step * (np.pi * (3 - np.sqrt(5))) + owner
    flat = np.sqrt(1 - height**2)
    unit = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    point: Floats = centre[owner] + radius[owner][:, None] * unit
    point = point[morton_order(point)]
    shown: Floats = point[union_field(point, centre, radius)[0] > -1e-9]
    return shown
