"""Measure how well a union of spheres fits a surface: distances, volumes, and proved bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from workbench.body.fitting.candidates import Samples, random_samples
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.proof import deepest_hollow, gap_bound, split_triangles
from workbench.body.kernels.volume_integration import shared_volume
from workbench.body.surface import Surface
from workbench.geometry.box_pairs import in_ranges
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Floats

__all__ = ["FitQuality", "exposed_points", "fit_quality"]


@dataclass(frozen=True)
class FitQuality:
    """Figures of one fit; distances [m]. `spheres` counts them."""

    spheres: int
    mean: float
    """Mean distance between the two surfaces, both directions together."""
    p95: float
    """95th percentile of the same."""
    to_spheres: float
    """Largest distance found from the surface to that of the spheres."""
    to_surface: float
    """Largest distance found from the spheres' surface to the surface. A crease narrower than the
    tolerance that the spheres close counts with its depth."""
    outside: float
    """Proved bound: how far the surface lies outside the spheres, hollows between them included."""
    inside: float
    """Proved bound: how far the spheres leave the surface."""
    volume_ratio: float
    """Volume of the spheres by that of the surface."""
    iou: float
    """Shared volume by joined volume (intersection over union)."""
    seconds: float
    """Processor time of the fit, without measuring."""

    @property
    def largest(self) -> float:
        """The two-sided Hausdorff distance of the samples [m]."""
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
    """Measure spheres against a surface.

    Parameters
    ----------
    surface
        The closed surface.
    centre, radius
        (m, 3) and (m,) [m].
    samples
        Samples of the surface; random ones if None.
    seconds
        Processor time of the fit.
    count
        Number of samples in each direction.
    seed
        Of the random samples.
    proved
        Bound of `outside` [m] that is known already, so that it need not be found.
    """
    on_surface = (samples or random_samples(surface, count, seed=seed)).point
    on_surface = on_surface[morton_order(on_surface)]
    exposed = exposed_points(centre, radius, count)
    signed = surface.distance(exposed)
    to_spheres = distance_to_union(on_surface, exposed, centre, radius)
    to_surface = np.abs(signed)
    mean, p95 = _two_way_statistics(to_spheres, to_surface)
    if proved is None:
        proved = _proved_outside(surface, centre, radius, signed)
    pitch = max(float(np.ptp(surface.vertices, axis=0).max()) / 400, 1e-4)
    corners = surface.vertices[surface.faces]
    mesh, union, shared = shared_volume(corners, centre, radius, pitch)
    return FitQuality(
        spheres=len(radius),
        mean=mean,
        p95=p95,
        to_spheres=float(to_spheres.max()),
        to_surface=float(to_surface.max(initial=0.0)),
        outside=proved,
        inside=max(0.0, float((radius + surface.distance(centre)).max())),
        volume_ratio=union / mesh,
        iou=shared / (mesh + union - shared),
        seconds=seconds,
    )


def _two_way_statistics(there: Floats, back: Floats) -> tuple[float, float]:
    """Mean and 95th percentile of distances in two directions, which weigh the same."""
    both = np.concatenate([there, back])
    weight = np.concatenate(
        [np.full(len(there), 0.5 / len(there)), np.full(len(back), 0.5 / max(len(back), 1))]
    )
    order = np.argsort(both)
    rank = np.searchsorted(np.cumsum(weight[order]), 0.95 * weight.sum())
    return float(weight @ both), float(both[order][rank])


def _proved_outside(surface: Surface, centre: Floats, radius: Floats, signed: Floats) -> float:
    """Proved bound [m] of how far the surface lies outside the spheres.

    signed: distances [m] of samples of the spheres' surface, a lower bound of its depth.
    """
    corners = split_triangles(surface.vertices[surface.faces], 0.02)
    gap = gap_bound(corners, centre, radius)
    return deepest_hollow(surface, centre, radius, max(gap, -float(signed.min(initial=0.0))))


def distance_to_union(points: Floats, exposed: Floats, centre: Floats, radius: Floats) -> Floats:
    """Compute the distance of points to the surface of a union of spheres.

    It is exact outside, and inside where the way straight out of the deepest sphere ends on the surface
    of the union. Elsewhere it is the distance to the nearest exposed point, too long by no more than
    their spacing.

    Parameters
    ----------
    points
        (n, 3) [m].
    exposed
        Points (k, 3) [m] on the surface of the union, see `exposed_points`.
    centre, radius
        (m, 3) and (m,) [m].

    Returns
    -------
    Floats
        (n,) [m].
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
    """Return about `count` points (k, 3) [m], uniform over the surface of a union of spheres.

    Each sphere carries points on a spiral [1]_ in proportion to its area; those inside other spheres
    are left out.

    References
    ----------
    .. [1] E. B. Saff & A. B. J. Kuijlaars (1997), Distributing many points on a sphere, Mathematical
       Intelligencer 19, 5-11.
    """
    share = radius**2 / (radius**2).sum()
    # about a third of the spheres' area is exposed in a fitted body
    each = np.maximum(12, np.ceil(3 * count * share)).astype(np.int64)
    step, owner = in_ranges(np.zeros_like(each), each)
    height = 1 - (2 * step + 1) / each[owner]
    turn = step * (np.pi * (3 - np.sqrt(5))) + owner
    flat = np.sqrt(1 - height**2)
    unit = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    point: Floats = centre[owner] + radius[owner][:, None] * unit
    point = point[morton_order(point)]
    return point[union_field(point, centre, radius)[0] > -1e-9]
