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
from workbench.model.arrays import Bools, Floats, Ints

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
    corners = split_triangles(surface.vertices[surface.faces], 0.02)
    measured = _Measured(
        to_spheres=distance_to_union(on_surface, exposed, *spheres),
        to_surface=np.abs(surface.distance(exposed)),
        part_of_sample=regions.number(on_surface),
        part_of_exposed=regions.number(exposed),
        corners=corners,
        part_of_corner=regions.number(corners.mean(axis=1)),
        protrusion=spheres[1] + surface.distance(spheres[0]),
        volumes=_volumes(surface, regions, spheres),
    )
    return tuple(_part_quality(measured, k, spheres, member[:, k]) for k in range(regions.count))


class _Measured(NamedTuple):
    """Distances [m] on the whole surface, and the part to which each place belongs."""

    to_spheres: Floats
    """(n,) from samples of the surface to that of the spheres."""
    to_surface: Floats
    """(k,) from exposed points of the spheres to the surface."""
    part_of_sample: Ints
    part_of_exposed: Ints
    corners: Floats
    """(T, 3, 3) small triangles of the surface."""
    part_of_corner: Ints
    protrusion: Floats
    """(S,) by which each sphere leaves the surface."""
    volumes: _Volumes


def _part_quality(
    measured: _Measured, part: int, spheres: tuple[Floats, Floats], own: Bools
) -> PartQuality:
    """Figures of one part; own (S,): its spheres."""
    there = measured.to_spheres[measured.part_of_sample == part]
    back = measured.to_surface[measured.part_of_exposed == part]
    both = np.concatenate([there, back]) if len(there) + len(back) else np.zeros(1)
    corners = measured.corners[measured.part_of_corner == part]
    volume, union, shared = (float(volumes[part]) for volumes in measured.volumes)
    return PartQuality(
        spheres=int(own.sum()),
        mean=float(both.mean()),
        p95=float(np.percentile(both, 95)),
        to_spheres=float(there.max(initial=0.0)),
        to_surface=float(back.max(initial=0.0)),
        outside=gap_bound(corners, spheres[0][own], spheres[1][own]),
        inside=max(0.0, float(measured.protrusion[own].max(initial=0.0))),
        volume=volume,
        volume_ratio=union / max(volume, 1e-12),
        iou=shared / max(volume + union - shared, 1e-12),
    )


class _Volumes(NamedTuple):
    """Volumes (N,) [m3] of the parts of segments."""

    mesh: Floats
    union: Floats
    """Of all spheres there."""
    shared: Floats


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
