"""Cut a body's surface into segments along a skeleton, and fit spheres to each.

Each place of the surface belongs to its nearest bone, in thicknesses of the part (`regions`). Every
segment holds its own places by itself, and those of its neighbour near the border. A sphere sits
exactly at each joint and serves both segments, so that no notch opens when the joint bends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.fitting.candidates import Limits
from workbench.body.fitting.decompose import MAX_SPHERES, SphereFit, fit_regions
from workbench.body.fitting.part_quality import PartQuality, part_qualities
from workbench.body.fitting.problem import Joints, packed
from workbench.body.fitting.regions import Regions
from workbench.body.surface import Surface
from workbench.errors import InputError, UsageError
from workbench.model.arguments import check_fields, given_words
from workbench.model.arrays import Bools, Floats, Ints, frozen

__all__ = ["Bones", "Flesh", "SegmentedFit", "fit_segments", "fit_whole", "regions_of"]

_SAME_POINT = 1e-3
"""Distance [m] up to which ends of bones are one joint."""
_MAX_SEGMENTS = 60
"""Segments at most, since they are bits of one number."""
_STEPS = 8
"""Intervals along a bone at which its depth is measured."""


@dataclass(frozen=True, eq=False)
class Flesh:
    """S spheres in the world: centre (S, 3), radius (S,) [m], and the segment of each."""

    centre: Floats
    radius: Floats
    segments: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Bones:
    """B bones, the middle lines of segments. A segment may have several.

    Ends of bones of different segments within 1 mm of each other are a joint.
    """

    segments: tuple[str, ...]
    """Segment of each bone."""
    head: Floats
    """(B, 3) [m] where each bone begins."""
    tail: Floats
    """(B, 3) [m] where it ends."""
    flesh: Flesh | None = None
    """The spheres of the segments where they are known to stand in the surface."""

    def __post_init__(self) -> None:
        check_fields(self)
        for field in ("head", "tail"):
            value = frozen(
                getattr(self, field), np.float64, (len(self.segments), 3), f"bones.{field}"
            )
            object.__setattr__(self, field, value)
        if not 1 <= len(self.names) <= _MAX_SEGMENTS:
            raise InputError(
                f"bones: 1 to {_MAX_SEGMENTS} segments are possible, got {len(self.names)}"
            )
        if not (np.all(np.isfinite(self.head)) and np.all(np.isfinite(self.tail))):
            raise InputError("bones: ends must be finite numbers [m]")

    @property
    def names(self) -> tuple[str, ...]:
        """The N segments, each once, in their first order."""
        return tuple(dict.fromkeys(self.segments))

    @property
    def owner(self) -> Ints:
        """(B,) number of each bone's segment in `names`."""
        return np.array([self.names.index(s) for s in self.segments], dtype=np.int64)

    def joints(self) -> tuple[Floats, Bools]:
        """Return the points (K, 3) [m] where bones of two or more segments end, and these segments (K, N)."""
        ends = np.concatenate([self.head, self.tail])
        owner = np.tile(self.owner, 2)
        places: list[Floats] = []
        served = []
        for end in ends:
            if any(np.linalg.norm(end - p) <= _SAME_POINT for p in places):
                continue
            met = np.isin(
                np.arange(len(self.names)), owner[np.linalg.norm(ends - end, axis=1) <= _SAME_POINT]
            )
            if met.sum() > 1:
                places.append(end)
                served.append(met)
        return np.array(places).reshape(-1, 3), np.array(served, dtype=np.bool_).reshape(
            -1, len(self.names)
        )


@dataclass(frozen=True, eq=False)
class SegmentedFit:
    """Spheres fitted to a surface in segments."""

    fit: SphereFit
    """The fit of the whole."""
    segments: tuple[str, ...]
    """N names."""
    member: Bools
    """(S, N) which spheres each segment has; joint spheres belong to several."""
    parts: tuple[PartQuality, ...]
    """Figures of each segment."""

    def spheres(self, segment: str) -> tuple[Floats, Floats]:
        """Return the centres (n, 3) and radii (n,) [m] of one segment, its joint spheres first."""
        rows = self.member[:, self.segments.index(segment)]
        return self.fit.centre[rows], self.fit.radius[rows]


def fit_segments(
    surface: Surface,
    bones: Bones,
    *,
    outward: float = 0.005,
    inward: float = 0.005,
    least_radius: float,
    greatest_radius: float,
    count: int | None = None,
    border: float = 0.08,
    joint_radius: ArrayLike | None = None,
    seed: int = 0,
) -> SegmentedFit:
    """Cut a closed body surface by the nearest bone, and fit each segment within the tolerances.

    Each segment's own spheres, joint spheres included, keep the inward tolerance on its own part of the
    surface and on the neighbour's part near the border. Bent by 90 degrees, such a lap stands out at
    the bend by `border` times the thickness at most.

    Parameters
    ----------
    surface, bones
        The closed surface, and its skeleton.
    outward, inward, least_radius, greatest_radius
        Tolerances and range of radii [m], see `decompose`.
    count
        Number of spheres in all, in place of the tolerances.
    border
        Width of the border, see `Regions`.
    joint_radius
        (K,) [m] radii of the spheres at `bones.joints()`; those that touch the surface from inside if
        None.
    seed
        0 or more.

    Raises
    ------
    UsageError
        If an option is not valid.
    InputError
        If a joint or a bone lies outside the surface, or the tolerance is impossible.
    """
    limits = Limits.checked(
        least_radius=least_radius, greatest_radius=greatest_radius, outward=outward, inward=inward
    )
    place, served = bones.joints()
    least = len(place) + len(bones.names)
    if count is not None and not least <= count <= MAX_SPHERES:
        what = f"{len(place)} joints and {len(bones.names)} segments need {least} spheres, {MAX_SPHERES} are most"
        raise UsageError(f"count: {what}, got {count}")
    if not 0 <= border <= 1:
        raise UsageError(f"border: expected a share from 0 to 1, got {border:g}")
    given_radius = _joint_radii(joint_radius, len(place))
    depth = _joint_depths(surface, bones, place)
    if given_radius is None:
        radius = np.minimum(depth, greatest_radius)
    else:
        radius = np.minimum(given_radius, depth + outward)
    joints = Joints(place, radius, packed(served))
    regions = regions_of(surface, bones, border=border)
    fit = fit_regions(surface, limits, joints, regions, count=count, seed=seed)
    member: Bools = (fit.region[:, None] >> np.arange(len(bones.names))) & 1 == 1
    parts = part_qualities(surface, regions, (fit.centre, fit.radius), member)
    return SegmentedFit(fit, bones.names, member, parts)


def _joint_radii(given: ArrayLike | None, joints: int) -> Floats | None:
    """Given radii of joint spheres [m], one or (K,), checked; None if none are given."""
    if given is None:
        return None
    radius = np.asarray(given, dtype=np.float64)
    if radius.shape not in ((), (joints,)) or not np.all(radius > 0):
        words = f"one positive radius [m] for each of {joints} joints"
        raise UsageError(f"joint_radius: expected {words}, got {given_words(given)}")
    return radius


def fit_whole(
    surface: Surface, limits: Limits, *, name: str, count: int | None = None, seed: int = 0
) -> SegmentedFit:
    """Fit a surface as one segment without joints, with the same figures as `fit_segments`.

    name: of the segment; other arguments as for `decompose`.
    """
    none = Joints(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))
    fit = fit_regions(surface, limits, none, Regions(), count=count, seed=seed)
    member = np.ones((len(fit.radius), 1), dtype=np.bool_)
    return SegmentedFit(
        fit, (name,), member, part_qualities(surface, Regions(), (fit.centre, fit.radius), member)
    )


def regions_of(surface: Surface, bones: Bones, *, border: float = 0.08) -> Regions:
    """Return the regions of a surface around its bones, with the thickness along each."""
    share = np.linspace(0.0, 1.0, _STEPS + 1)[None, :, None]
    along = bones.head[:, None] + share * (bones.tail - bones.head)[:, None]
    depth = -surface.distance(along.reshape(-1, 3)).reshape(len(bones.head), -1)
    # a bone that grazes the skin, or runs in an ear or a finger, counts as a quarter of the median
    # thickness
    thickness = np.maximum(depth, 0.25 * max(float(np.median(depth)), 1e-3))
    served = bones.joints()[1]
    beside = np.eye(len(bones.names), dtype=np.bool_) | (served.T.astype(np.int64) @ served > 0)
    regions = Regions(bones.head, bones.tail, bones.owner, thickness, beside, border)
    if bones.flesh is None:
        return regions
    owner = [bones.names.index(name) for name in bones.flesh.segments]
    return replace(
        regions,
        centre=bones.flesh.centre,
        radius=bones.flesh.radius,
        sphere_owner=np.array(owner, dtype=np.int64),
    )


def _joint_depths(surface: Surface, bones: Bones, place: Floats) -> Floats:
    """(K,) depth [m] of the joints under the surface; joints, and the middle of a bone of
    each segment, must lie inside."""
    inside = surface.distance(0.5 * (bones.head + bones.tail)) <= 0
    lost = np.bincount(bones.owner, inside, len(bones.names)) == 0
    depth = -surface.distance(place) if len(place) else np.zeros(0)
    low = surface.vertices.min(axis=0)
    high = surface.vertices.max(axis=0)
    box = " to ".join("({})".format(", ".join(f"{x:.3f}" for x in p)) for p in (low, high))
    hint = f"the surface reaches from {box} m: another unit, axes, place or pose?"
    if lost.any():
        names = ", ".join(np.array(bones.names)[lost])
        raise InputError(f"skeleton: the middle of {names} lies outside the surface; {hint}")
    if (depth <= 0).any():
        spot = ", ".join(f"{x:.3f}" for x in place[depth.argmin()])
        raise InputError(
            f"skeleton: the joint at ({spot}) m lies {-depth.min() * 1e3:.3g} mm outside; {hint}"
        )
    return depth
