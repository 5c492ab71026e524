"""A closed surface as a union of spheres within a tolerance: the paper's data entry.

Samples of the surface are covered by few candidate spheres that protrude at most `outward` by construction (set
cover); the result is proved against the whole surface, what is not covered is added, and the spheres are polished by
least squares as far as the proof allows. Sources: O'Rourke & Badler, PAMI 1(3), 1979 (spheres within a tolerance);
Attali, Nguyen & Sivignon, 2019 (cover the erosion, stay in the dilation); Dou et al., Coverage Axis, 2022 (set cover).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.shape.candidates import Limits
from workbench.shape.count_search import covered_by_count
from workbench.shape.cover import cover
from workbench.shape.fit_quality import FitQuality, fit_quality
from workbench.shape.polish import polished, within_bounds
from workbench.shape.problem import Joints, Problem, prepared, refuse_bare, with_more
from workbench.shape.regions import Regions
from workbench.shape.sampling import Samples
from workbench.shape.surface import Surface
from workbench.shape.verify import bare_places, hollow_places, split_triangles

__all__ = ["SphereFit", "decompose", "fit_regions"]

_ROUNDS = 40
_POLISH_ROUNDS = 30


@dataclass(frozen=True, eq=False, repr=False)
class SphereFit:
    """Spheres of a surface: centre (S, 3), radius (S,) [m], joint spheres first and exactly where they were asked for.

    region (S,): the bits of the segments each serves; outward, inward: the two tolerances [m] that hold; quality: what
    was measured.
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
    mesh: Surface, *, outward: float | None = None, inward: float | None = None, least_radius: float,
    greatest_radius: float, count: int | None = None, joints: ArrayLike = (), seed: int = 0,
) -> SphereFit:  # fmt: skip
    """Fit spheres to a closed surface.

    outward, inward [m]: no sphere leaves the surface by more than `outward`, no point of the surface lies more than
    `inward` outside the spheres: proved, not sampled. count: that many spheres instead, as near to the surface as can
    be; then the tolerances may be left out (given, they say only how much wider one may be than the other) and the
    result says which hold. joints: required spheres (K, 3), tangent to the surface inside, or (K, 4) with a radius.
    UsageError where options contradict each other, InputError where the radii make the tolerance impossible (it says
    what is reachable).
    """
    began = process_time()
    limits = _limits((outward, inward), least_radius, greatest_radius, count)
    required = _joints(mesh, joints, limits if count is None else None, greatest_radius)
    if count is None:
        return fit_regions(mesh, limits, required, Regions(), seed=seed)
    if not 1 <= len(required.radius) + 1 <= count <= 100_000:
        raise UsageError(f"count: {len(required.radius) + 1} to 100000 spheres are possible here, got {count}")
    problem, limits, chosen = covered_by_count(mesh, limits, count, joints=required, seed=seed)
    safe = problem.candidates.centre[chosen], problem.radius(limits)[chosen]
    free = np.arange(len(chosen)) >= len(required.radius)
    moved = polished(problem.samples.point, *safe, free=free, limits=limits)
    loose = limits.scaled(1.5)
    centre, radius = within_bounds(mesh, moved, safe, loose)
    quality = fit_quality(mesh, centre, radius, seconds=process_time() - began)
    bits, joined = problem.candidates.bits[chosen], len(required.radius)
    return SphereFit(centre, radius, bits, joined, quality.inside, quality.outside, quality)


def fit_regions(surface: Surface, limits: Limits, joints: Joints, regions: Regions, *, seed: int) -> SphereFit:
    """Fit spheres within limits, those of each region to its own part of the surface, the joints shared."""
    began = process_time()
    thickness = 2 * surface.volume / surface.area
    expected = surface.area / (8 * thickness * min(limits.outward + limits.inward, thickness))
    # what lies between the samples is proved, and added where it fails: no need of hundreds to a sphere
    spacing = max(0.35 * (limits.outward + limits.inward), float(np.sqrt(0.7 * surface.area / (120 * expected + 500))))
    sources = int(np.clip(60 * expected, 1_500, 60_000))
    problem = prepared(surface, limits, spacing=spacing, sources=sources, joints=joints, regions=regions, seed=seed,
                       eroded=True)  # fmt: skip
    corners = split_triangles(surface.vertices[surface.faces], max(4 * limits.inward, 1e-4))
    problem, chosen = _proved_cover(problem, limits, corners, seed)
    safe = problem.candidates.centre[chosen], problem.radius(limits)[chosen]
    centre, radius = _proved_polish(problem, limits, corners, safe)
    quality = fit_quality(surface, centre, radius, seconds=process_time() - began, proved=limits.inward)
    bits, joined = problem.candidates.bits[chosen], len(joints.radius)
    return SphereFit(centre, radius, bits, joined, limits.outward, limits.inward, quality)


def _proved_cover(problem: Problem, limits: Limits, corners: Floats, seed: int) -> tuple[Problem, Ints]:
    """Cover, prove, add what is bare, again until all is proved. The first rounds improve, the later only add."""
    chosen: Ints | None = None
    for turn in range(_ROUNDS):
        usable = problem.radius(limits) > 0
        problem, chosen = _only(problem, usable, chosen)
        moves = 16 if turn == 0 else 3 if turn < 4 else 0
        found = cover(problem.targets, problem.candidates, problem.radius(limits), required=len(problem.joints.radius),
                      begun=chosen, moves=moves, seed=seed + turn)  # fmt: skip
        if len(found.bare):
            problem = _retried(problem, limits, found.bare)
        chosen = found.chosen
        centre, radius = problem.candidates.centre[chosen], problem.radius(limits)[chosen]
        bare, hollow = _faults(problem, limits, corners, (centre, radius))
        if not len(bare) and not len(hollow) and not len(found.bare):
            return problem, chosen
        problem = with_more(problem, limits, bare, hollow)
    raise InputError(f"the tolerance could not be proved in {_ROUNDS} rounds; widen it or let smaller spheres in")


def _only(problem: Problem, usable: Bools, chosen: Ints | None) -> tuple[Problem, Ints | None]:
    """The problem without the candidates that the limits forbid, and the chosen ones under their new numbers."""
    if usable.all():
        return problem, chosen
    number = np.cumsum(usable) - 1
    kept = number[chosen[usable[chosen]]] if chosen is not None else None
    return replace(problem, candidates=problem.candidates.at(usable)), kept


def _retried(problem: Problem, limits: Limits, bare: Ints) -> Problem:
    """The problem with a sphere of its own for each bare target; refused where that is too small to be allowed."""
    point = problem.targets.point[bare]
    more = with_more(problem, limits, _foot(problem.surface, point), np.zeros((0, 3)))
    more = replace(more, targets=problem.targets)
    fresh = cover(problem.targets.at(bare), more.candidates, more.radius(limits))
    if len(fresh.bare):
        refuse_bare(more, limits, bare[fresh.bare])
    return more


def _faults(
    problem: Problem, limits: Limits, corners: Floats, spheres: tuple[Floats, Floats]
) -> tuple[Samples, Floats]:  # fmt: skip
    """Places on the surface and inside that the spheres leave open."""
    bare = bare_places(corners, *spheres, limits.inward)
    return _foot(problem.surface, bare), hollow_places(problem.surface, *spheres, limits.inward)


def _foot(surface: Surface, points: Floats) -> Samples:
    """Points (n, 3) at or near the surface as samples, with the normals of their faces."""
    _, face, foot = surface.nearest(points)
    normal = np.empty((len(surface.faces), 3))
    normal[surface.solid.face] = surface.solid.normal[:, 0]
    return Samples(foot, normal[face], face)


def _proved_polish(
    problem: Problem, limits: Limits, corners: Floats, safe: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Polish, then take back, sphere by sphere, what breaks the proof: halfway first, then wholly, then all near it."""
    free = np.arange(len(safe[1])) >= len(problem.joints.radius)
    moved = polished(problem.samples.point, *safe, free=free, limits=limits)
    share = np.ones(len(safe[1]))
    for turn in range(_POLISH_ROUNDS):
        mixed = (safe[0] + share[:, None] * (moved[0] - safe[0]), safe[1] + share * (moved[1] - safe[1]))
        mixed = within_bounds(problem.surface, mixed, safe, limits)
        mixed[0][~free], mixed[1][~free] = safe[0][~free], safe[1][~free]
        bare, hollow = _faults(problem, limits, corners, mixed)
        wrong = np.concatenate([bare.point, hollow])
        if not len(wrong):
            return mixed
        share[_near(wrong, safe, limits.inward if turn > 4 else 0.0)] *= 0.5 if turn < 2 else 0.0
        if turn > 4:
            share[_near(wrong, mixed, limits.inward)] = 0.0
    return safe


def _near(points: Floats, spheres: tuple[Floats, Floats], margin: float) -> Bools:
    """(m,) True for the spheres that hold these points best, and those within `margin` [m] of holding them."""
    near = np.zeros(len(spheres[1]), dtype=np.bool_)
    for point in points:
        gap = np.linalg.norm(point - spheres[0], axis=1) - spheres[1]
        near[gap.argmin()] = True
        near |= gap < (margin if margin else -np.inf)
    return near


def _limits(
    tolerance: tuple[float | None, float | None], least: float, greatest: float, count: int | None
) -> Limits:  # fmt: skip
    outward, inward = tolerance
    if count is None and (outward is None or inward is None):
        raise UsageError("outward and inward are needed [m], or a count of spheres")
    out, into = outward if outward is not None else inward, inward if inward is not None else outward
    out, into = (0.005 if x is None else float(x) for x in (out, into))
    for name, value in (("outward", out), ("inward", into), ("least_radius", least), ("greatest_radius", greatest)):
        if not (np.isfinite(value) and 0 < value < 100):
            raise UsageError(f"{name}: a length above 0 is needed [m], got {value!r}")
    if least > greatest:
        raise UsageError(f"least_radius ({least:g} m) is greater than greatest_radius ({greatest:g} m)")
    return Limits(float(least), float(greatest), out, into)


def _joints(surface: Surface, joints: ArrayLike, limits: Limits | None, greatest: float) -> Joints:
    """Required spheres, checked: inside, and not out of the surface by more than the tolerance."""
    rows = np.asarray(joints, dtype=np.float64)
    rows = rows.reshape(len(rows), -1) if rows.size else np.zeros((0, 3))
    if rows.shape[1] not in (3, 4) or not np.all(np.isfinite(rows)):
        raise UsageError("joints: rows of three or four finite numbers are needed, x, y, z and the radius [m]")
    centre = np.ascontiguousarray(rows[:, :3])
    depth = -surface.distance(centre)
    radius = rows[:, 3].copy() if rows.shape[1] == 4 else np.minimum(depth, greatest)
    for k in range(len(rows)):
        spot = f"joint {k + 1} at ({', '.join(f'{x:.3f}' for x in centre[k])}) m"
        if depth[k] <= 0:
            raise InputError(f"{spot} lies {-depth[k] * 1e3:.3g} mm outside the surface; it must lie inside")
        if radius[k] <= 0 or (limits is not None and radius[k] > depth[k] + limits.outward + 1e-9):
            most = depth[k] + (limits.outward if limits is not None else 0)
            raise InputError(f"{spot}: a radius of {radius[k] * 1e3:.3g} mm is not possible; above 0 and at most "
                             f"{most * 1e3:.3g} mm (depth and outward tolerance) is")  # fmt: skip
    return Joints(centre, radius, np.full(len(rows), np.int64(2**62 - 1)))
