"""A body's surface and a skeleton cut into segments, each with spheres of its own; joint spheres shared.

Each place of the surface belongs to its nearest bone; near a border also to the bone that is nearly as near, so the
spheres of either side may hold it and both meet smoothly. A sphere sits exactly at each joint and serves both segments.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints, frozen
from workbench.shape.candidates import Limits
from workbench.shape.decompose import SphereFit, fit_regions
from workbench.shape.fit_quality import exposed_points
from workbench.shape.polish import union_field
from workbench.shape.problem import Joints
from workbench.shape.regions import Regions
from workbench.shape.sampling import random_samples
from workbench.shape.surface import Surface

__all__ = ["Bones", "SegmentError", "SegmentedFit", "fit_segments"]

_SAME = 1e-3
_MOST = 60


@dataclass(frozen=True, eq=False)
class Bones:
    """B bones, each the middle line of a segment: names, head (B, 3) and tail (B, 3) [m].

    Ends of two bones within 1 mm of each other are a joint.
    """

    segments: tuple[str, ...]
    head: Floats
    tail: Floats

    def __post_init__(self) -> None:
        for field in ("head", "tail"):
            value = frozen(getattr(self, field), np.float64, (len(self.segments), 3), f"bones.{field}")
            object.__setattr__(self, field, value)
        if not 1 <= len(self.segments) <= _MOST:
            raise InputError(f"bones: 1 to {_MOST} are possible, got {len(self.segments)}")
        if not (np.all(np.isfinite(self.head)) and np.all(np.isfinite(self.tail))):
            raise InputError("bones: ends must be finite numbers [m]")

    def joints(self) -> tuple[Floats, Bools]:
        """Points (K, 3) where ends of two or more bones meet, and which bones (K, B)."""
        ends = np.concatenate([self.head, self.tail])
        owner = np.tile(np.arange(len(self.segments)), 2)
        places: list[Floats] = []
        served = []
        for end in ends:
            if any(np.linalg.norm(end - p) <= _SAME for p in places):
                continue
            bones = np.unique(owner[np.linalg.norm(ends - end, axis=1) <= _SAME])
            if len(bones) > 1:
                places.append(end)
                served.append(np.isin(np.arange(len(self.segments)), bones))
        return np.array(places).reshape(-1, 3), np.array(served, dtype=np.bool_).reshape(-1, len(self.segments))


@dataclass(frozen=True)
class SegmentError:
    """One segment's figures [m]: spheres (joint spheres included), mean and 95th percentile of the distance both ways,
    largest distance found from the surface to the spheres and back."""

    spheres: int
    mean: float
    p95: float
    to_spheres: float
    to_surface: float


@dataclass(frozen=True, eq=False)
class SegmentedFit:
    """The fit of the whole; member (S, B): which spheres each segment has; errors: one row for each segment."""

    fit: SphereFit
    segments: tuple[str, ...]
    member: Bools
    errors: tuple[SegmentError, ...]

    def spheres(self, segment: str) -> tuple[Floats, Floats]:
        """Centres (n, 3) and radii (n,) [m] of one segment, its joint spheres first."""
        rows = self.member[:, self.segments.index(segment)]
        return self.fit.centre[rows], self.fit.radius[rows]


def fit_segments(
    surface: Surface, bones: Bones, *, outward: float, inward: float, least_radius: float, greatest_radius: float,
    border: float = 0.35, joint_radius: ArrayLike | None = None, seed: int = 0,
) -> SegmentedFit:  # fmt: skip
    """Cut a closed body surface by the nearest bone and fit each segment within the tolerances [m] (`decompose`).

    border: a place counts for every bone at most 1 + border times as far as the nearest. joint_radius (K,) [m]: radii
    of the spheres at `bones.joints()`, those that touch the surface from inside where not given. InputError where a
    joint or a whole bone lies outside the surface.
    """
    limits = Limits(least_radius, greatest_radius, outward, inward)
    place, served = bones.joints()
    lost = surface.distance(0.5 * (bones.head + bones.tail)) > 0
    if lost.any():
        names = ", ".join(np.array(bones.segments)[lost])
        raise InputError(f"bones: the middle of {names} lies outside the surface: another unit, axes or pose?")
    depth = -surface.distance(place) if len(place) else np.zeros(0)
    if (depth <= 0).any():
        spot = ", ".join(f"{x:.3f}" for x in place[depth.argmin()])
        raise InputError(f"bones: the joint at ({spot}) m lies {-depth.min() * 1e3:.3g} mm outside the surface")
    tangent = np.minimum(depth, greatest_radius)
    radius = tangent if joint_radius is None else np.minimum(np.asarray(joint_radius, float), depth + outward)
    bit = np.int64(1) << np.arange(len(bones.segments))
    joints = Joints(place, radius, (served * bit).sum(axis=1).astype(np.int64))
    fit = fit_regions(surface, limits, joints, Regions(bones.head, bones.tail, border), seed=seed)
    member: Bools = (fit.region[:, None] & bit) != 0
    return SegmentedFit(fit, bones.segments, member, _errors(surface, bones, fit, member))


def _errors(surface: Surface, bones: Bones, fit: SphereFit, member: Bools) -> tuple[SegmentError, ...]:
    """Distances both ways between the surface and the union, told by the nearest bone."""
    regions = Regions(bones.head, bones.tail)
    there = random_samples(surface, 40_000, seed=5).point
    back = exposed_points(fit.centre, fit.radius, 40_000)
    out = np.abs(union_field(there, fit.centre, fit.radius)[0])
    into = np.abs(surface.distance(back))
    of_there, of_back = _bone(regions, there), _bone(regions, back)
    rows = []
    for k in range(len(bones.segments)):
        a, b = out[of_there == k], into[of_back == k]
        both = np.concatenate([a, b]) if len(a) + len(b) else np.zeros(1)
        rows.append(SegmentError(int(member[:, k].sum()), float(both.mean()), float(np.percentile(both, 95)),
                                 float(a.max(initial=0.0)), float(b.max(initial=0.0))))  # fmt: skip
    return tuple(rows)


def _bone(regions: Regions, points: Floats) -> Ints:
    number: Ints = np.log2(regions.own(points).astype(np.float64)).round().astype(np.int64)
    return number
