"""How well each segment's spheres fit its own part of a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.fitting.fit_quality import distance_to_union, exposed_points
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.regions import Regions
from workbench.body.fitting.sampling import random_samples
from workbench.body.fitting.verify import gap_bound, split_triangles
from workbench.body.surface import Surface
from workbench.model.arrays import Bools, Floats

__all__ = ["PartQuality", "part_qualities"]

_SAMPLES = 40_000
_LATTICE = 400_000


@dataclass(frozen=True)
class PartQuality:
    """One segment's figures; distances [m], volumes [m3].

    spheres: joint spheres included; mean, p95: of the distance both ways on its part; to_spheres,
    to_surface: largest found from the surface to that of the spheres and back; outside: how far its
    part of the true surface may lie outside its own spheres, inside: how far these reach out of the
    surface, both proved; volume: of its part of the surface; volume_ratio, iou: of the spheres
    there to it, by counting a lattice.
    """

    spheres: int
    mean: float
    p95: float
    to_spheres: float
    to_surface: float
    outside: float
    inside: float
    volume: float
    volume_ratio: float
    iou: float


def part_qualities(
    surface: Surface, regions: Regions, spheres: tuple[Floats, Floats], member: Bools
) -> tuple[PartQuality, ...]:
    """The figures of each segment: spheres (S, 3), (S,), and which of them it has, member (S,
    N)."""
    there = random_samples(surface, _SAMPLES, seed=5).point
    back = exposed_points(*spheres, _SAMPLES)
    out = distance_to_union(there, back, *spheres)
    into = np.abs(surface.distance(back))
    of_there = regions.number(there)
    of_back = regions.number(back)
    corners = split_triangles(surface.vertices[surface.faces], 0.02)
    of_corner = regions.number(corners.mean(axis=1))
    depth = -surface.distance(spheres[0])
    volume, union, shared = _volumes(surface, regions, spheres)
    rows = []
    for k in range(regions.count):
        a = out[of_there == k]
        b = into[of_back == k]
        mine = member[:, k]
        both = np.concatenate([a, b]) if len(a) + len(b) else np.zeros(1)
        outside = gap_bound(corners[of_corner == k], spheres[0][mine], spheres[1][mine])
        joined = max(volume[k] + union[k] - shared[k], 1e-12)
        rows.append(
            PartQuality(
                spheres=int(mine.sum()),
                mean=float(both.mean()),
                p95=float(np.percentile(both, 95)),
                to_spheres=float(a.max(initial=0.0)),
                to_surface=float(b.max(initial=0.0)),
                outside=outside,
                inside=max(0.0, float((spheres[1] - depth)[mine].max(initial=0.0))),
                volume=float(volume[k]),
                volume_ratio=float(union[k] / max(volume[k], 1e-12)),
                iou=float(shared[k] / joined),
            )
        )
    return tuple(rows)


def _volumes(
    surface: Surface, regions: Regions, spheres: tuple[Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """(N,) volumes [m3] of the surface, of the spheres and of both, each where it is nearest to a
    segment's bones."""
    low = np.minimum(surface.vertices.min(axis=0), (spheres[0] - spheres[1][:, None]).min(axis=0))
    high = np.maximum(surface.vertices.max(axis=0), (spheres[0] + spheres[1][:, None]).max(axis=0))
    pitch = float(np.cbrt(np.prod(high - low) / _LATTICE))
    axes = [np.arange(a + 0.5 * pitch, b, pitch) for a, b in zip(low, high, strict=True)]
    point = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    within = surface.distance(point) < 0
    held = union_field(point, *spheres)[0] < 0
    number = regions.number(point)
    cell = pitch**3
    count = np.stack(
        [np.bincount(number, w, minlength=regions.count) for w in (within, held, within & held)]
    )
    mesh, union, both = count.astype(np.float64) * cell
    # the lattice knows the shares; the whole is known exactly
    exact = surface.volume / max(float(mesh.sum()), 1e-12)
    return mesh * exact, union * exact, both * exact
