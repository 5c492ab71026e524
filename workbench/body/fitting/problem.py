"""A fit being prepared: what must be held, and the spheres that could hold it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.body.fitting.candidates import (
    Candidates,
    Limits,
    bounded_radius,
    inner_balls,
    joined_candidates,
)
from workbench.body.fitting.cover import Targets, joined_targets
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.regions import EVERYONE, Regions
from workbench.body.fitting.sampling import Samples, even_samples
from workbench.body.kernels.spacing import thin_points
from workbench.body.surface import Surface
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Bare", "Joints", "Problem", "density", "packed", "prepared", "refuse_bare", "with_more"]

_MOST_SAMPLES = 700_000
"""Samples of a surface at most: twice as many were seen to take more than 12 GB."""


@dataclass(frozen=True, eq=False)
class Joints:
    """Required spheres: centre (K, 3), radius (K,) [m], bits (K,) of the segments they serve."""

    centre: Floats
    radius: Floats
    bits: Ints


@dataclass(frozen=True, eq=False)
class Bare:
    """Places on the surface that the spheres of some segments leave open: samples (n), bits (n,) of
    those segments."""

    samples: Samples
    bits: Ints

    def __len__(self) -> int:
        return len(self.bits)


@dataclass(frozen=True, eq=False)
class Problem:
    """samples: points on the surface; targets: those and points inside; candidates: the joints
    first."""

    surface: Surface
    regions: Regions
    joints: Joints
    samples: Samples
    targets: Targets
    candidates: Candidates

    def radius(self, limits: Limits) -> Floats:
        """(m,) the radius each candidate has under these limits; 0 where it can have none."""
        radius = bounded_radius(self.candidates.depth, limits)
        radius[: len(self.joints.radius)] = self.joints.radius
        return radius


def density(surface: Surface, limits: Limits) -> tuple[float, int]:
    """Spacing [m] of samples and number of candidates that suit these tolerances."""
    thickness = 2 * surface.volume / surface.area
    expected = surface.area / (8 * thickness * min(limits.outward + limits.inward, thickness))
    # what lies between the samples is proved, and added where it fails: no need of hundreds to a
    # sphere
    spacing = max(
        0.35 * (limits.outward + limits.inward),
        float(np.sqrt(0.7 * surface.area / (120 * expected + 500))),
    )
    return spacing, int(np.clip(60 * expected, 1_500, 60_000))


def prepared(
    surface: Surface,
    limits: Limits,
    *,
    spacing: float,
    sources: int,
    joints: Joints,
    regions: Regions,
    seed: int,
    eroded: bool = False,
) -> Problem:
    """Samples `spacing` [m] apart, candidates under about `sources` of them, and inner points
    against voids.

    eroded: hold, in place of a sample, the point limits.inward below it wherever the part is that
    thick: no void can then reach deeper than the tolerance.
    """
    most = 0.7 * surface.area / spacing**2
    if most > _MOST_SAMPLES:
        reach = np.sqrt(most / _MOST_SAMPLES) * min(limits.outward, limits.inward) * 1e3
        raise InputError(
            f"the tolerance asks for {most:.2g} samples of the surface, {_MOST_SAMPLES} are possible: "
            f"{reach:.2g} mm can be reached on a surface of this size"
        )
    samples = even_samples(surface, spacing, seed=seed)
    under = samples
    if len(samples) > 1.3 * sources:
        under = even_samples(surface, float(np.sqrt(0.7 * surface.area / sources)), seed=seed + 2)
    row, bits = singles(packed(regions.shared(under.point)), regions.count)
    slack = np.random.default_rng(seed + 3).random(len(row)) * limits.outward
    balls = inner_balls(surface, under.at(row), limits, slack=slack, bits=bits, regions=regions)
    inner = _inner_targets(balls, limits)
    first = Candidates(joints.centre, -surface.distance(joints.centre), joints.bits)
    margin = np.full(len(samples), 0.97 * limits.inward)
    on_surface = Targets(samples.point, margin, packed(regions.shared(samples.point)))
    if eroded:
        below = samples.point - 0.99 * limits.inward * samples.normal
        thick = surface.distance(below) < -0.9 * limits.inward
        margin = np.where(thick, -0.01 * limits.inward, margin)
        on_surface = Targets(np.where(thick[:, None], below, samples.point), margin, on_surface.may)
    # near a border both segments must hold a place by themselves
    row, bits = singles(on_surface.may, regions.count)
    on_surface = replace(on_surface.at(row), may=bits)
    targets = joined_targets([on_surface, inner])
    candidates = joined_candidates([first, balls])
    return Problem(surface, regions, joints, samples, targets, candidates)


def _inner_targets(balls: Candidates, limits: Limits) -> Targets:
    """Centres of candidates, thinned, that must lie inside the union: against voids in thick
    parts."""
    deep = np.flatnonzero((balls.depth > limits.inward) & (bounded_radius(balls.depth, limits) > 0))
    deep = deep[np.argsort(-balls.depth[deep], kind="stable")]
    if len(deep):
        spacing = max(2.0 * limits.inward, 0.25 * float(np.median(balls.depth[deep])))
        deep = deep[thin_points(balls.centre[deep], spacing)]
    everyone = np.full(len(deep), EVERYONE)
    return Targets(balls.centre[deep], np.zeros(len(deep)), everyone)


def packed(member: Bools) -> Ints:
    """(n,) the bits of the segments that are True in each row (n, N)."""
    bits: Ints = (member * (np.int64(1) << np.arange(member.shape[1]))).sum(axis=1)
    return bits


def singles(bits: Ints, count: int) -> tuple[Ints, Ints]:
    """Row numbers (k,) of bits (n,), as often as each row has bits, and the one bit (k,) each
    stands for."""
    row, segment = np.nonzero((bits[:, None] >> np.arange(count)) & 1)
    return row, np.int64(1) << segment


def with_more(problem: Problem, limits: Limits, bare: Bare, hollow: Floats) -> Problem:
    """The problem with places found uncovered, on the surface and inside (k, 3), and spheres that
    hold them."""
    targets = [problem.targets]
    balls = [problem.candidates]
    if len(bare):
        margin = np.full(len(bare), 0.9 * limits.inward)
        targets.append(Targets(bare.samples.point, margin, bare.bits))
        for share in (0.0, 0.5):
            slack = np.full(len(bare), share * limits.outward)
            balls.append(
                inner_balls(
                    problem.surface,
                    bare.samples,
                    limits,
                    slack=slack,
                    bits=bare.bits,
                    regions=problem.regions,
                )
            )
    if len(hollow):
        everyone = np.full(len(hollow), EVERYONE)
        # not at the rim of a sphere, where it was found, but well inside one
        targets.append(Targets(hollow, np.full(len(hollow), -0.03 * limits.inward), everyone))
        balls.append(
            Candidates(hollow, -problem.surface.distance(hollow), problem.regions.own(hollow))
        )
    return replace(problem, targets=joined_targets(targets), candidates=joined_candidates(balls))


def refuse_bare(problem: Problem, limits: Limits, bare: Ints) -> None:
    """InputError that says what is reachable, where targets are held by no sphere the limits
    allow."""
    radius = problem.radius(limits)
    useful = radius > 0
    point = problem.targets.point[bare]
    spot = ", ".join(f"{x:.3f}" for x in point[0])
    said = f"{len(bare)} places, one at ({spot}) m, are too thin for spheres of {limits.least * 1e3:.3g} mm and more"
    deep = -problem.surface.distance(point)
    own = inner_depth(problem, limits, bare)
    thinnest = max(0.0, float(own.min())) * 1e3
    way = f"a least radius of {max(thinnest + limits.outward * 1e3, 1e-3):.3g} mm"
    if useful.any():
        need = union_field(point, problem.candidates.centre[useful], radius[useful])[0]
        reached = max(float((need + np.maximum(deep, 0)).max()), limits.inward)
        way += f", or an inward tolerance of {reached * 1e3:.3g} mm"
    outward = max(limits.least * 1e3 - thinnest, limits.outward * 1e3)
    raise InputError(
        f"the tolerance cannot be kept: {said} with {limits.outward * 1e3:.3g} mm outward; "
        f"it can be with {way}, or {outward:.3g} mm outward"
    )


def inner_depth(problem: Problem, limits: Limits, bare: Ints) -> Floats:
    """(k,) depth [m] of the largest ball that touches the surface nearest to each of these
    targets."""
    _, face, foot = problem.surface.nearest(problem.targets.point[bare])
    solid = problem.surface.solid
    normal = np.empty((len(solid.face), 3))
    normal[solid.face] = solid.normal[:, 0]
    samples = Samples(foot, normal[face], face)
    bits = np.ones(len(face), np.int64)
    return inner_balls(
        problem.surface, samples, limits, slack=np.zeros(len(face)), bits=bits, regions=Regions()
    ).depth
