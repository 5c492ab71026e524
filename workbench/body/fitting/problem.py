"""Prepare a fit: what must be held, and the spheres that could hold it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from workbench.body.fitting.candidates import (
    Candidates,
    FitBounds,
    Samples,
    bounded_radius,
    even_samples,
    inner_balls,
    joined_candidates,
)
from workbench.body.fitting.cover import Targets, joined_targets
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.regions import EVERYONE, Regions
from workbench.body.kernels.poisson_disk import sample_poisson_disk
from workbench.body.surface import Surface
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "Bare",
    "Joints",
    "SetCover",
    "density",
    "packed",
    "prepared",
    "refuse_bare",
    "with_more",
]

_MAX_SAMPLES = 700_000
"""Samples of a surface at most; twice as many took more than 12 GB."""
_SAMPLE_MARGIN = 0.97
"""Share of the inward tolerance that samples use; the rest covers the surface between them."""


@dataclass(frozen=True, eq=False)
class Joints:
    """K required spheres."""

    centre: Floats
    """(K, 3) [m]."""
    radius: Floats
    """(K,) [m]."""
    bits: Ints
    """(K,) bits of the segments that each serves."""


@dataclass(frozen=True, eq=False)
class Bare:
    """Places on the surface that the spheres of some segments do not hold."""

    samples: Samples
    """n places."""
    bits: Ints
    """(n,) bits of these segments."""

    def __len__(self) -> int:
        return len(self.bits)


@dataclass(frozen=True, eq=False)
class SetCover:
    """A set cover to solve."""

    surface: Surface
    regions: Regions
    joints: Joints
    samples: Samples
    """Points on the surface."""
    targets: Targets
    """Points on or under the surface, and points inside."""
    candidates: Candidates
    """Candidate spheres, those of joints first."""

    def radius(self, limits: FitBounds) -> Floats:
        """Return the radius (m,) [m] of each candidate under limits, 0 where it can have none."""
        radius = bounded_radius(self.candidates.depth, limits)
        radius[: len(self.joints.radius)] = self.joints.radius
        return radius


def density(surface: Surface, limits: FitBounds) -> tuple[float, int]:
    """Return a spacing [m] of samples and a number of candidates that suit the tolerances."""
    thickness = 2 * surface.volume / surface.area
    expected = surface.area / (8 * thickness * min(limits.outward + limits.inward, thickness))
    # the surface between samples is proved, and added where that fails, so that some 120 samples a
    # sphere are enough
    spacing = max(
        0.35 * (limits.outward + limits.inward),
        float(np.sqrt(0.7 * surface.area / (120 * expected + 500))),
    )
    return spacing, int(np.clip(60 * expected, 1_500, 60_000))


def prepared(
    surface: Surface,
    limits: FitBounds,
    *,
    spacing: float,
    sources: int,
    joints: Joints,
    regions: Regions,
    seed: int,
    eroded: bool = False,
) -> SetCover:
    """Prepare a set cover of a surface.

    Parameters
    ----------
    surface, limits
        The surface, and the bounds of radii and tolerances.
    spacing
        Distance of samples [m].
    sources
        Number of samples, about, with candidates under them.
    joints, regions
        Required spheres, and the parts of segments.
    seed
        0 or more.
    eroded
        Whether the target of a sample is the point at the inward tolerance below it, wherever the
        part is that thick. Then no void can be deeper than the tolerance.

    Raises
    ------
    InputError
        If the tolerance needs too many samples.
    """
    _check_sample_count(surface, limits, spacing)
    samples = even_samples(surface, spacing, seed=seed)
    balls = _candidates_under(samples, surface, limits, sources, regions, seed)
    first = Candidates(joints.centre, -surface.distance(joints.centre), joints.bits)
    on_surface = _surface_targets(samples, surface, limits, regions, eroded=eroded)
    return SetCover(
        surface,
        regions,
        joints,
        samples,
        targets=joined_targets([on_surface, _inner_targets(balls, limits)]),
        candidates=joined_candidates([first, balls]),
    )


def _check_sample_count(surface: Surface, limits: FitBounds, spacing: float) -> None:
    """Refuse a spacing [m] that needs too many samples."""
    needed = 0.7 * surface.area / spacing**2
    if needed > _MAX_SAMPLES:
        reach = np.sqrt(needed / _MAX_SAMPLES) * min(limits.outward, limits.inward) * 1e3
        raise InputError(
            f"the tolerance asks for {needed:.2g} samples of the surface, {_MAX_SAMPLES} are possible: "
            f"{reach:.2g} mm can be reached on a surface of this size"
        )


def _candidates_under(
    samples: Samples, surface: Surface, limits: FitBounds, sources: int, regions: Regions, seed: int
) -> Candidates:
    """Candidates under about `sources` samples, for each segment that must hold them."""
    under = samples
    if len(samples) > 1.3 * sources:
        under = even_samples(surface, float(np.sqrt(0.7 * surface.area / sources)), seed=seed + 2)
    row, bits = singles(packed(regions.shared(under.point)), regions.count)
    slack = np.random.default_rng(seed + 3).random(len(row)) * limits.outward
    return inner_balls(surface, under.at(row), limits, slack=slack, bits=bits, regions=regions)


def _surface_targets(
    samples: Samples, surface: Surface, limits: FitBounds, regions: Regions, *, eroded: bool
) -> Targets:
    """A target for each sample and each segment that must hold it; near a border there are two."""
    point = samples.point
    margin = np.full(len(samples), _SAMPLE_MARGIN * limits.inward)
    if eroded:
        below = samples.point - 0.99 * limits.inward * samples.normal
        thick = surface.distance(below) < -0.9 * limits.inward
        margin = np.where(thick, -0.01 * limits.inward, margin)
        point = np.where(thick[:, None], below, samples.point)
    row, bits = singles(packed(regions.shared(samples.point)), regions.count)
    return Targets(point[row], margin[row], bits)


def _inner_targets(balls: Candidates, limits: FitBounds) -> Targets:
    """Centres of candidates, thinned, that must lie inside the union: against voids in thick parts."""
    deep = np.flatnonzero((balls.depth > limits.inward) & (bounded_radius(balls.depth, limits) > 0))
    deep = deep[np.argsort(-balls.depth[deep], kind="stable")]
    if len(deep):
        spacing = max(2.0 * limits.inward, 0.25 * float(np.median(balls.depth[deep])))
        deep = deep[sample_poisson_disk(balls.centre[deep], spacing)]
    everyone = np.full(len(deep), EVERYONE)
    return Targets(balls.centre[deep], np.zeros(len(deep)), everyone)


def packed(member: Bools) -> Ints:
    """Return the bits (n,) of the segments that are True in each row (n, N)."""
    return (member * (np.int64(1) << np.arange(member.shape[1]))).sum(axis=1)


def singles(bits: Ints, count: int) -> tuple[Ints, Ints]:
    """Return the rows (k,) of bits (n,), each as often as it has bits, and the single bit (k,) of each."""
    row, segment = np.nonzero((bits[:, None] >> np.arange(count)) & 1)
    return row, np.int64(1) << segment


def with_more(problem: SetCover, limits: FitBounds, bare: Bare, hollow: Floats) -> SetCover:
    """Add places that were found uncovered, and spheres that hold them.

    Parameters
    ----------
    problem, limits
        The problem, and the bounds of the spheres.
    bare
        Places on the surface.
    hollow
        Places (k, 3) [m] inside.
    """
    targets = [problem.targets]
    balls = [problem.candidates]
    if len(bare):
        margin = np.full(len(bare), 0.9 * limits.inward)
        targets.append(Targets(bare.samples.point, margin, bare.bits))
        # Candidates under bare places, with a share of the outward tolerance as slack.
        balls += [
            inner_balls(
                problem.surface,
                bare.samples,
                limits,
                slack=np.full(len(bare), share * limits.outward),
                bits=bare.bits,
                regions=problem.regions,
            )
            for share in (0.0, 0.5)
        ]
    if len(hollow):
        # a hollow was found at the rim of a sphere; a new one must hold it well inside
        margin = np.full(len(hollow), -0.03 * limits.inward)
        targets.append(Targets(hollow, margin, np.full(len(hollow), EVERYONE)))
        depth = -problem.surface.distance(hollow)
        balls.append(Candidates(hollow, depth, problem.regions.own(hollow)))
    return replace(problem, targets=joined_targets(targets), candidates=joined_candidates(balls))


def refuse_bare(problem: SetCover, limits: FitBounds, bare: Ints) -> NoReturn:
    """Refuse targets that no allowed sphere holds, and say what is reachable.

    Parameters
    ----------
    problem, limits
        The problem, and the bounds of the spheres.
    bare
        (k,) indices of these targets.

    Raises
    ------
    InputError
        Always.
    """
    radius = problem.radius(limits)
    useful = radius > 0
    point = problem.targets.point[bare]
    spot = ", ".join(f"{x:.3f}" for x in point[0])
    problem_text = f"{len(bare)} places, one at ({spot}) m, are too thin for spheres of {limits.least * 1e3:.3g} mm and more"
    deep = -problem.surface.distance(point)
    own = inner_depth(problem, limits, bare)
    thinnest = max(0.0, float(own.min())) * 1e3
    remedy = f"a least radius of {max(thinnest + limits.outward * 1e3, 1e-3):.3g} mm"
    if useful.any():
        need = union_field(point, problem.candidates.centre[useful], radius[useful])[0]
        reached = max(float((need + np.maximum(deep, 0)).max()), limits.inward)
        remedy += f", or an inward tolerance of {reached * 1e3:.3g} mm"
    outward = max(limits.least * 1e3 - thinnest, limits.outward * 1e3)
    raise InputError(
        f"the tolerance cannot be kept: {problem_text} with {limits.outward * 1e3:.3g} mm outward; "
        f"it can be with {remedy}, or {outward:.3g} mm outward"
    )


def inner_depth(problem: SetCover, limits: FitBounds, bare: Ints) -> Floats:
    """Return the depth (k,) [m] of the largest ball that touches the surface nearest to each target."""
    _, face, foot = problem.surface.nearest(problem.targets.point[bare])
    solid = problem.surface.solid
    normal = np.empty((len(solid.face), 3))
    normal[solid.face] = solid.normal[:, 0]
    samples = Samples(foot, normal[face], face)
    bits = np.ones(len(face), np.int64)
    return inner_balls(
        problem.surface, samples, limits, slack=np.zeros(len(face)), bits=bits, regions=Regions()
    ).depth
