"""A closed surface as a union of spheres within a tolerance: the paper's data entry.

Samples of the surface are covered by few candidate spheres that protrude at most `outward` by
construction (set cover); the result is proved against the whole surface, what is not covered is
added, and the spheres are polished by least squares as far as the proof allows. Sources: O'Rourke &
Badler, PAMI 1(3), 1979 (spheres within a tolerance); Attali, Nguyen & Sivignon, 2019 (cover the
erosion, stay in the dilation); Dou et al., Coverage Axis, 2022 (set cover).
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.fitting.candidates import Limits
from workbench.body.fitting.count_search import covered_by_count
from workbench.body.fitting.fit_quality import FitQuality, fit_quality
from workbench.body.fitting.polish import polished_parts, within_bounds
from workbench.body.fitting.problem import Joints, Problem, density, prepared
from workbench.body.fitting.proof import (
    Spheres,
    parts_of,
    proved_cover,
    proved_polish,
    segment_triangles,
)
from workbench.body.fitting.regions import Regions
from workbench.body.surface import Surface
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats, Ints

__all__ = ["MOST_SPHERES", "SphereFit", "decompose", "fit_regions"]

MOST_SPHERES = 100_000


@dataclass(frozen=True, eq=False, repr=False)
class SphereFit:
    """Spheres of a surface: centre (S, 3), radius (S,) [m], joint spheres first and exactly where
    they were asked for.

    region (S,): the bits of the segments each serves; outward, inward: the two tolerances [m] that
    hold; quality: what was measured.
    """

    centre: Floats
    radius: Floats
    region: Ints
    joints: int
    outward: float
    inward: float
    quality: FitQuality

    def __repr__(self) -> str:
        q = self.quality
        told = f"mean {q.mean * 1e3:.2f} mm, largest {q.largest * 1e3:.1f} mm, IoU {q.iou:.3f}"
        return f"SphereFit({q.spheres} spheres, {told})"


def decompose(
    mesh: Surface,
    *,
    outward: float | None = None,
    inward: float | None = None,
    least_radius: float,
    greatest_radius: float,
    count: int | None = None,
    joints: ArrayLike = (),
    seed: int = 0,
) -> SphereFit:
    """Fit spheres to a closed surface.

    outward, inward [m]: no sphere leaves the surface by more than `outward`, no point of the
    surface lies more than `inward` outside the spheres: proved, not sampled. count: that many
    spheres instead, as near to the surface as can be; then the tolerances may be left out (given,
    they say only how much wider one may be than the other) and the result says which hold. joints:
    required spheres (K, 3), tangent to the surface inside, or (K, 4) with a radius. UsageError
    where options contradict each other, InputError where the radii make the tolerance impossible
    (it says what is reachable).
    """
    limits = _limits((outward, inward), least_radius, greatest_radius, count)
    required = _joints(mesh, joints, limits if count is None else None, greatest_radius)
    if count is not None and not 1 <= len(required.radius) + 1 <= count <= MOST_SPHERES:
        raise UsageError(
            f"count: {len(required.radius) + 1} to {MOST_SPHERES} spheres are possible here, got {count}"
        )
    return fit_regions(mesh, limits, required, Regions(), count=count, seed=seed)


def fit_regions(
    surface: Surface,
    limits: Limits,
    joints: Joints,
    regions: Regions,
    *,
    count: int | None = None,
    seed: int = 0,
) -> SphereFit:
    """Fit spheres to a surface in parts, those of each segment to its own; joint spheres serve
    several.

    Within the tolerances of `limits`, or with `count` spheres as near to the surface as can be.
    """
    if seed < 0:
        raise UsageError(f"seed: expected 0 or more, got {seed}")
    began = process_time()
    if count is None:
        problem, spheres, bits = _within(surface, limits, joints, regions, seed)
    else:
        problem, limits, chosen = covered_by_count(
            surface, limits, count, joints=joints, regions=regions, seed=seed
        )
        bits = problem.candidates.bits[chosen]
        safe = problem.candidates.centre[chosen], problem.radius(limits)[chosen]
        free = np.arange(len(chosen)) >= len(joints.radius)
        parts = parts_of(problem, bits)
        moved = polished_parts(problem.samples.point, safe, free=free, limits=limits, parts=parts)
        spheres = within_bounds(surface, moved, safe, limits.scaled(1.5))
        spheres[0][~free] = safe[0][~free]
        spheres[1][~free] = safe[1][~free]
    seconds = process_time() - began
    quality = fit_quality(
        surface, *spheres, seconds=seconds, proved=limits.inward if count is None else None
    )
    held = (limits.outward, limits.inward) if count is None else (quality.inside, quality.outside)
    return SphereFit(*spheres, bits, len(joints.radius), *held, quality)


def _within(
    surface: Surface, limits: Limits, joints: Joints, regions: Regions, seed: int
) -> tuple[Problem, Spheres, Ints]:
    """Fit spheres that keep the tolerances, with proof.

    Returns the problem, the spheres, and the bits (m,) of the segments that each serves.
    """
    spacing, sources = density(surface, limits)
    problem = prepared(
        surface,
        limits,
        spacing=spacing,
        sources=sources,
        joints=joints,
        regions=regions,
        seed=seed,
        eroded=True,
    )
    triangles = segment_triangles(problem, max(4 * limits.inward, 1e-4))
    problem, chosen = proved_cover(problem, limits, triangles, seed)
    bits = problem.candidates.bits[chosen]
    safe = problem.candidates.centre[chosen], problem.radius(limits)[chosen]
    return problem, proved_polish(problem, limits, triangles, safe, bits), bits


def _limits(
    tolerance: tuple[float | None, float | None], least: float, greatest: float, count: int | None
) -> Limits:
    outward, inward = tolerance
    if count is None and (outward is None or inward is None):
        raise UsageError("outward and inward are needed [m], or a count of spheres")
    out = outward if outward is not None else inward
    into = inward if inward is not None else outward
    out, into = (0.005 if x is None else float(x) for x in (out, into))
    return Limits.checked(
        least_radius=float(least), greatest_radius=float(greatest), outward=out, inward=into
    )


def _joints(surface: Surface, joints: ArrayLike, limits: Limits | None, greatest: float) -> Joints:
    """Required spheres, checked: inside, and not out of the surface by more than the tolerance."""
    rows = np.asarray(joints, dtype=np.float64)
    rows = rows if rows.size else np.zeros((0, 3))
    if rows.ndim != 2 or rows.shape[1] not in (3, 4) or not np.all(np.isfinite(rows)):
        wanted = "rows of three or four finite numbers, x, y, z and the radius [m]"
        raise UsageError(f"joints: expected {wanted}, got an array {rows.shape}")
    centre = np.ascontiguousarray(rows[:, :3])
    depth = -surface.distance(centre)
    radius = rows[:, 3].copy() if rows.shape[1] == 4 else np.minimum(depth, greatest)
    for k in range(len(rows)):
        spot = f"joint {k + 1} at ({', '.join(f'{x:.3f}' for x in centre[k])}) m"
        if depth[k] <= 0:
            raise InputError(
                f"{spot} lies {-depth[k] * 1e3:.3g} mm outside the surface; it must lie inside"
            )
        if radius[k] <= 0 or (limits is not None and radius[k] > depth[k] + limits.outward + 1e-9):
            most = depth[k] + (limits.outward if limits is not None else 0)
            raise InputError(
                f"{spot}: a radius of {radius[k] * 1e3:.3g} mm is not possible; above 0 and at most "
                f"{most * 1e3:.3g} mm (depth and outward tolerance) is"
            )
    return Joints(centre, radius, np.full(len(rows), np.int64(2**62 - 1)))
