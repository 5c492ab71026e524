"""Measure how well each segment's spheres fit its own part of a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

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
"""Samples in each direction."""
_LATTICE = 400_000
"""Points of the lattice that volumes are counted on."""


@dataclass(frozen=True)
class PartQuality:
    """Figures of one segment; distances [m]. `spheres` counts joint spheres too."""

    spheres: int
    mean: float
    """Mean distance in both directions on the segment's part."""
    p95: float
    """95th percentile of the same."""
    to_spheres: float
    """Largest distance found from the surface to that of the spheres."""
    to_surface: float
    """Largest distance found from the spheres' surface to the surface."""
    outside: float
    """Proved bound: how far its part of the surface lies outside its own spheres."""
    inside: float
    """Proved bound: how far its spheres leave the surface."""
    volume: float
    """Volume [m3] of its part of the surface."""
    volume_ratio: float
    """Volume of the spheres there by that of the part."""
    iou: float
    """Shared volume by joined volume (intersection over union)."""


def part_qualities(
    surface: Surface, regions: Regions, spheres: tuple[Floats, Floats], member: Bools
) -> tuple[PartQuality, ...]:
    """Measure the spheres of each segment.

    Parameters
    ----------
    surface, regions
        The surface, and the parts of N segments.
    spheres
        Centres (S, 3) and radii (S,) [m].
    member
        (S, N) which spheres each segment has.
    """
    on_surface = random_samples(surface, _SAMPLES, seed=5).point
    exposed = exposed_points(*spheres, _SAMPLES)
    to_spheres = distance_to_union(on_surface, exposed, *spheres)
    to_surface = np.abs(surface.distance(exposed))
    part_of_sample = regions.number(on_surface)
    part_of_exposed = regions.number(exposed)
    corners = split_triangles(surface.vertices[surface.faces], 0.02)
    part_of_corner = regions.number(corners.mean(axis=1))
    protrusion = spheres[1] + surface.distance(spheres[0])
    volumes = _volumes(surface, regions, spheres)
    rows = []
    for k in range(regions.count):
        own = member[:, k]
        there = to_spheres[part_of_sample == k]
        back = to_surface[part_of_exposed == k]
        both = np.concatenate([there, back]) if len(there) + len(back) else np.zeros(1)
        rows.append(
            PartQuality(
                spheres=int(own.sum()),
                mean=float(both.mean()),
                p95=float(np.percentile(both, 95)),
                to_spheres=float(there.max(initial=0.0)),
                to_surface=float(back.max(initial=0.0)),
                outside=gap_bound(corners[part_of_corner == k], spheres[0][own], spheres[1][own]),
                inside=max(0.0, float(protrusion[own].max(initial=0.0))),
                volume=float(volumes.mesh[k]),
                volume_ratio=float(volumes.union[k] / max(volumes.mesh[k], 1e-12)),
                iou=float(volumes.shared[k] / volumes.joined(k)),
            )
        )
    return tuple(rows)


class _Volumes(NamedTuple):
    """Volumes (N,) [m3] of the parts of segments."""

    mesh: Floats
    union: Floats
    """Of all spheres there."""
    shared: Floats

    def joined(self, part: int) -> float:
        """Volume [m3] of the surface and the spheres together."""
        return max(float(self.mesh[part] + self.union[part] - self.shared[part]), 1e-12)


def _volumes(surface: Surface, regions: Regions, spheres: tuple[Floats, Floats]) -> _Volumes:
    """Count the points of a lattice in each part, which belong to the nearest bones."""
    centre, radius = spheres
    low = np.minimum(surface.vertices.min(axis=0), (centre - radius[:, None]).min(axis=0))
    high = np.maximum(surface.vertices.max(axis=0), (centre + radius[:, None]).max(axis=0))
    pitch = float(np.cbrt(np.prod(high - low) / _LATTICE))
    axes = [np.arange(a + 0.5 * pitch, b, pitch) for a, b in zip(low, high, strict=True)]
    point = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    in_mesh = surface.distance(point) < 0
    in_union = union_field(point, centre, radius)[0] < 0
    part = regions.number(point)
    mesh, union, shared = (
        np.bincount(part, inside, minlength=regions.count) * pitch**3
        for inside in (in_mesh, in_union, in_mesh & in_union)
    )
    # the lattice gives the parts' shares; the volume of the whole is known exactly
    exact = surface.volume / max(float(mesh.sum()), 1e-12)
    return _Volumes(*(np.asarray(count * exact) for count in (mesh, union, shared)))
