"""Cut a body's surface into segments along a skeleton, and fit spheres to each.

Each place of the surface belongs to its nearest bone, in thicknesses of the part (`regions`). Every
segment holds its own places by itself, and those of its neighbour near the border. A sphere sits
exactly at each joint and serves both segments, so that no notch opens when the joint bends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.fitting.candidates import FitBounds, random_samples
from workbench.body.fitting.decompose import MAX_SPHERES, SphereFit, fit_regions
from workbench.body.fitting.fit_quality import distance_to_union, exposed_points, fit_quality
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.problem import Joints, packed
from workbench.body.fitting.proof import gap_bound, split_triangles
from workbench.body.fitting.regions import Regions
from workbench.body.surface import Surface
from workbench.errors import InputError, UsageError
from workbench.model.arguments import check_fields, given_words
from workbench.model.arrays import Bools, Floats, Ints, read_only

__all__ = [
    "Bones",
    "Flesh",
    "PartQuality",
    "SegmentedFit",
    "fit_segments",
    "fit_whole",
    "part_qualities",
    "regions_of",
    "symmetric_fit",
]

_SAME_POINT = 1e-3
"""Distance [m] up to which ends of bones are one joint."""
_ROUNDING = 1e-9
"""Distance [m] up to which a sphere and the image of another are one."""
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
            value = read_only(
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
    limits = FitBounds.checked(
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
    surface: Surface, limits: FitBounds, *, name: str, count: int | None = None, seed: int = 0
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


def symmetric_fit(
    surface: Surface, regions: Regions, cut: SegmentedFit, twin: Ints, plane: float
) -> SegmentedFit:
    """Replace the spheres fitted to a symmetric surface by those of its left half and their images.

    A sphere of the right half that reaches over the plane counts as its image on the left. A point
    on the left is at most as far from that image as from the sphere, so that what was proved holds.

    Parameters
    ----------
    surface, regions
        The surface, its own image in the plane y = `plane` [m], and the parts of its segments.
    cut
        A fit.
    twin
        (N,) the segment on the other side of each.
    """
    flip = np.array([1.0, -1.0, 1.0, 1.0])
    moved = np.array([0.0, 2.0 * plane, 0.0, 0.0])
    balls = np.column_stack([cut.fit.centre, cut.fit.radius])
    left = balls[:, 1] >= plane
    over = ~left & (balls[:, 1] + balls[:, 3] > plane)
    half = np.concatenate([balls[left], balls[over] * flip + moved])
    member = np.concatenate([cut.member[left], cut.member[over][:, twin]])
    same = np.abs(half[:, None] - half).max(axis=2) < _ROUNDING
    first = same.argmax(axis=1) == np.arange(len(half))
    half, member = half[first], member[first]
    middle = half[:, 1] < plane + _ROUNDING
    half[middle, 1] = plane
    member[middle] |= member[middle][:, twin]
    balls = np.concatenate([half, half[~middle] * flip + moved])
    member = np.concatenate([member, member[~middle][:, twin]])
    spheres = balls[:, :3], balls[:, 3]
    fit = replace(
        cut.fit,
        centre=spheres[0],
        radius=spheres[1],
        region=packed(member),
        quality=fit_quality(
            surface, *spheres, seconds=cut.fit.quality.seconds, proved=cut.fit.inward
        ),
    )
    parts = part_qualities(surface, regions, spheres, member)
    return SegmentedFit(fit, cut.segments, member, _alike(parts, twin))


def _alike(parts: tuple[PartQuality, ...], twin: Ints) -> tuple[PartQuality, ...]:
    """The figures of segments with the volume and the bounds that they share with their twins."""
    return tuple(
        replace(
            part,
            volume=0.5 * (part.volume + parts[k].volume),
            outside=max(part.outside, parts[k].outside),
            inside=max(part.inside, parts[k].inside),
        )
        for part, k in zip(parts, twin.tolist(), strict=True)
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
