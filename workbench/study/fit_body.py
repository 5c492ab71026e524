"""Which spheres are this surface? A mesh or outlines, with or without a skeleton, to the text of a
body file.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from workbench.body.fitting.candidates import FitBounds
from workbench.body.fitting.decompose import fewest_spheres
from workbench.body.fitting.problem import Joints, packed
from workbench.body.fitting.regions import Regions
from workbench.body.fitting.registration import register
from workbench.body.fitting.segmenting import (
    Bones,
    Flesh,
    SegmentedFit,
    fit_segments,
    fit_whole,
    regions_of,
    symmetric_fit,
)
from workbench.body.forward import place
from workbench.body.outlines import outline_surface
from workbench.body.scaling.measure import measure
from workbench.body.scaling.stretch import twins_of
from workbench.body.surface import Surface, sealed
from workbench.errors import InputError, UsageError
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.outlines import load_outlines
from workbench.files.body.writer import FittedSegment, SkeletonFile, fitted_text
from workbench.files.meshes.reading import axes_rotation, read_mesh, to_world
from workbench.files.meshes.sizes import implausible_sizes, person_size
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.schema import metres_in
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import DIRECTIONS, Body
from workbench.model.joint_angles import angles_of, pose
from workbench.model.poses import Poses
from workbench.model.quaternions import from_matrices, matrices

__all__ = [
    "DENSITY",
    "Skeleton",
    "bones_of",
    "bound_of",
    "figures",
    "fit_body",
    "fitted_body_text",
    "named_rows",
    "placed_skeleton",
    "read_surface",
    "skeleton_of",
    "spheres_in_frames",
]

_SAME_POINT = 1e-3
"""Distance [m] up to which a point and a joint are the same."""
_BEHIND = 0.3
"""Extent behind the joint, as a share of that ahead, from which on a segment has a bone there."""
_BESIDE = 3.0
"""A sphere whose centre is so many radii from the bones of its segment has one of its own, as a thumb
has."""
_MOST_BESIDE = 2
_SHORT_BONE = 0.02
"""Length [m] of the bone of a segment whose joint is at its origin."""


def bones_of(body: Body, world: Floats) -> Bones:
    """Return the bones of a placed body, in the order of its segments.

    A bone runs from the proximal joint of its segment (the stage: its origin) to each distal joint. A
    segment without a distal joint has a bone to the farthest of its spheres, one behind the joint
    if it reaches there, as a heel does, and one to what stands far beside these, as a thumb does. A segment without spheres has no bone: nothing of a surface
    is its own, as of the stage that a person stands on.

    Parameters
    ----------
    body
        One body.
    world
        (N, 3, 4) world-from-segment transforms [m].
    """
    names: list[str] = []
    ends: list[tuple[Floats, Floats]] = []
    for n in np.flatnonzero(_has_spheres(body)).tolist():
        name = body.segments[n]
        rotation = world[n, :, :3]
        origin = world[n, :, 3]
        start = body.joint_in_child[0, n - 1] if n else np.zeros(3)
        tips = [
            p for p in _distal_joints(body, n) if np.linalg.norm(p - start) > _SAME_POINT
        ] or _tips(body, n, start)
        for tip in tips:
            names.append(name)
            ends.append((rotation @ start + origin, rotation @ tip + origin))
    return Bones(tuple(names), np.array([e[0] for e in ends]), np.array([e[1] for e in ends]))


def _has_spheres(body: Body) -> Bools:
    """(N,) which segments have spheres."""
    return np.diff(body.start) > 0


def _distal_joints(body: Body, segment: int) -> list[Floats]:
    """Joints (3,) [m] at which other segments are attached to a segment, in its frame."""
    return [
        body.joint_in_parent[0, j] for j in range(len(body.joints)) if body.parent[j + 1] == segment
    ]


def _tips(body: Body, segment: int, start: Floats) -> list[Floats]:
    """Ends (3,) of the bones of a segment without distal joints: far sphere centres ahead and behind."""
    centre = body.centre[0, body.spheres(segment)]
    ahead_vector = -start  # from the joint to the origin, the centre of gravity
    length = float(np.linalg.norm(ahead_vector))
    if length < _SAME_POINT or not len(centre):
        short = np.array([0.0, 0.0, _SHORT_BONE])
        return [start + (ahead_vector if length >= _SAME_POINT else short)]
    reach = (centre - start) @ (ahead_vector / length)
    ahead = int(reach.argmax())
    back = int(reach.argmin())
    tips = [centre[ahead] if reach[ahead] > length else start + ahead_vector]
    if reach[back] < -_BEHIND * max(float(reach[ahead]), length):
        tips.append(centre[back])
    radius = body.radius[0, body.spheres(segment)]
    for _ in range(_MOST_BESIDE):
        beside = np.min([_from_bone(centre, start, tip) for tip in tips], axis=0) / radius
        if beside.max() <= _BESIDE:
            break
        tips.append(centre[int(beside.argmax())])
    return tips


def _from_bone(points: Floats, start: Floats, tip: Floats) -> Floats:
    """Distance (n,) [m] of points (n, 3) from a bone."""
    bone = tip - start
    share = np.clip((points - start) @ bone / (bone @ bone), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * bone, axis=1)


def spheres_in_frames(
    body: Body, world: Floats, cut: SegmentedFit
) -> dict[str, tuple[Floats, Floats]]:
    """Return the fitted spheres of each segment in its own frame.

    Parameters
    ----------
    body
        One body.
    world
        (N, 3, 4) world-from-segment transforms [m] in which the surface was cut.
    cut
        The fit.

    Returns
    -------
    dict
        Centres (n, 3) and radii (n,) [m] by segment that has spheres. A sphere at a joint has exactly
        its coordinates.

    Raises
    ------
    InputError
        If a joint has no sphere.
    """
    found = {}
    has_spheres = _has_spheres(body)
    for n in np.flatnonzero(has_spheres).tolist():
        name = body.segments[n]
        centre, radius = cut.spheres(name)
        local = (centre - world[n, :, 3]) @ world[n, :, :3]
        proximal = [body.joint_in_child[0, n - 1]] if n else []
        if n and not has_spheres[body.parent[n]]:  # no bone ends there: a sphere within the others
            within = float((radius - np.linalg.norm(local - proximal[0], axis=1)).max())
            local = np.concatenate([local, proximal])
            radius = np.append(radius, max(within, _SAME_POINT))
        for joint in [*_distal_joints(body, n), *proximal]:
            gap = np.linalg.norm(local - joint, axis=1)
            if not len(gap) or gap.min() > _SAME_POINT:
                raise InputError(f"segment {name}: no sphere at one of its joints")
            local[gap.argmin()] = joint
        found[name] = local, radius
    return found


def named_rows(
    body: Body, segment: int, centre: Floats, radius: Floats
) -> dict[int, tuple[str, ...]]:
    """Give the names of a segment's spheres to fitted spheres.

    A name goes to the sphere whose surface is nearest to the outermost point of the sphere that had
    it. No sphere gets two.

    Parameters
    ----------
    body, segment
        One body, and the number of a segment.
    centre, radius
        Fitted spheres (n, 3) and (n,) [m], in the segment's frame.

    Returns
    -------
    dict
        Name, and direction if it has one, by the index of the fitted sphere.
    """
    rows: dict[int, tuple[str, ...]] = {}
    free = np.ones(len(radius), dtype=np.bool_)
    for s in range(body.start[segment], body.start[segment + 1]):
        name = body.sphere_names[s]
        if not name or not free.any():
            continue
        gap = np.abs(np.linalg.norm(_outermost_point(body, segment, s) - centre, axis=1) - radius)
        gap[~free] = np.inf
        best = int(gap.argmin())
        free[best] = False
        direction = int(body.sphere_direction[s])
        rows[best] = (name, DIRECTIONS[direction]) if direction >= 0 else (name,)
    return rows


def _outermost_point(body: Body, segment: int, sphere: int) -> Floats:
    """(3,) [m] point of a sphere in its named direction, or away from the segment's origin."""
    centre = body.centre[0, sphere]
    direction = int(body.sphere_direction[sphere])
    outward = centre / max(float(np.linalg.norm(centre)), 1e-9)
    if direction >= 0:
        outward = body.directions[segment, direction]
    return np.asarray(centre + body.radius[0, sphere] * outward)


DENSITY = 1010.0
"""Of a body [kg/m3], lungs half full."""
ALONE = "BODY"
_LEAST_MARK = 0.001
"""Radius [m] of a landmark that would lie outside the surface."""
_MIDDLE = 1e-9
"""Distance [m] of a landmark from the plane of left and right up to which it is in it."""
_TWISTED = 1e-3
_SYMMETRIC = 1e-4
"""Distance [m] of a mesh or a skeleton from its mirror image up to which it is symmetric."""
_FLIP = np.array([1.0, -1.0, 1.0])
_IMAGE = np.array([[1.0, -1.0, 1.0, 1.0], [-1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, 1.0]])
"""Factors of a transform (3, 4) in the mirror y = 0."""
_MM = ("mean", "p95", "to_spheres", "to_surface", "outside", "inside")


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A body whose segments a surface is cut into: its file, and where its segments stand, world
    (N, 3, 4) [m]; what was found of its size and posture."""

    body: Body
    path: Path
    world: Floats
    notes: tuple[str, ...] = ()
    flesh: Flesh | None = None
    """Its spheres, where they are known to stand in the surface."""

    @property
    def bones(self) -> Bones:
        """The bones that a surface is cut by."""
        return replace(bones_of(self.body, self.world), flesh=self.flesh)


def read_surface(
    source: Path, *, length: str | None = None, up: str = "z", forward: str = "x"
) -> Surface:
    """The closed surface of a mesh file or of outlines (.yaml), x forward, y left, z up.

    length: the mesh's unit where its file does not say it. UsageError where nobody says it;
    InputError where the surface is not that of a solid of a plausible size.
    """
    if source.suffix.lower() in (".yaml", ".yml"):
        return outline_surface(load_outlines(source))
    units = ", ".join(metres_in)
    if length is not None and length not in metres_in:
        raise UsageError(f"length: one of {units} is needed, got {length!r}")
    raw = read_mesh(source)
    metres = metres_in[length] if length else raw.metres
    if metres is None:
        raise UsageError(
            f"{source}: the file does not say its unit of length: state it (--length {units})"
        )
    parts = to_world(raw, axes_rotation(up, forward), metres=metres)
    first = np.cumsum([0, *(len(p.vertices) for p in parts)])
    faces = np.concatenate([p.faces + n for p, n in zip(parts, first, strict=False)])
    surface = sealed(np.concatenate([p.vertices for p in parts]), faces, what=str(source))
    surface = _ordered(surface)
    size = float(np.ptp(surface.vertices, axis=0).max())
    doubts = implausible_sizes(parts, metres, file=source.stem) or person_size(size, metres)
    return replace(surface, notes=(*surface.notes, *doubts)) if doubts else surface


def _ordered(surface: Surface) -> Surface:
    """The surface with its vertices and faces sorted: what is fitted depends on no order in a file."""
    order = np.lexsort(surface.vertices.T)
    faces = np.argsort(order)[surface.faces]
    first = faces.argmin(axis=1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    faces = faces[np.lexsort(faces.T[::-1])]
    return Surface(surface.vertices[order], faces, surface.notes)


def skeleton_of(
    source: str | Path, surface: Surface, *, posture: str | None = None, at: Floats | None = None
) -> Skeleton:
    """A body as a skeleton for a surface: where it is stated to stand, else where it stands in the
    surface.

    Of a family of people the member and the standing posture are taken that come nearest to the
    surface, unless a posture or a place is stated. Errors as of `placed_skeleton` and `register`.
    """
    body = load_body(source)
    if body.basis is None or posture is not None or at is not None:
        return placed_skeleton(source, posture=posture, at=at)
    plane = _mirror_plane(surface)
    if plane is None and _left_handed(surface):
        return _skeleton_image(skeleton_of(source, _surface_image(surface)))
    found = register(body, surface)
    poses = found.poses if plane is None else _symmetric(found.body, found.poses, plane)
    placed = place(found.body, poses)
    owner = tuple(found.body.segments[n] for n in found.body.sphere_segment)
    flesh = Flesh(placed.centres[0], found.body.radius[0], owner)
    note = (
        f"the skeleton of {body.name} is sized and posed to the surface, {1e3 * found.gap:.1f} mm "
        f"from it in the mean: stature {1e3 * measure(found.body, ['stature'])['stature']:.0f} mm; "
        "--at and --posture state its place and posture instead"
    )
    return Skeleton(found.body, body_path(source), placed.world_from_segment[0], (note,), flesh)


@lru_cache(maxsize=4)
def _mirror_plane(surface: Surface) -> float | None:
    """The y [m] of the plane in which a surface is its own mirror image; None if it is not."""
    side = surface.vertices[:, 1]
    plane = 0.5 * float(side.min() + side.max())
    image = surface.vertices * _FLIP + [0.0, 2.0 * plane, 0.0]
    return plane if np.abs(surface.distance(image)).max() <= _SYMMETRIC else None


def _left_handed(surface: Surface) -> bool:
    """Whether a surface is the image of the one that is fitted in its place, so that both give images:
    the third moment about the middle of left and right tells which."""
    side = surface.vertices[:, 1]
    return bool(np.sum((side - side.mean()) ** 3) < 0.0)


def _surface_image(surface: Surface) -> Surface:
    """The surface in the mirror y = 0."""
    return _ordered(Surface(surface.vertices * _FLIP, surface.faces[:, ::-1], surface.notes))


def _skeleton_image(skeleton: Skeleton) -> Skeleton:
    """The skeleton of a symmetric body in the mirror y = 0."""
    body = skeleton.body
    twin = twins_of(body)
    world = skeleton.world[twin] * _IMAGE
    if skeleton.flesh is None:
        return replace(skeleton, world=world)
    owner = [body.segments[twin[body.segment(name)]] for name in skeleton.flesh.segments]
    flesh = Flesh(skeleton.flesh.centre * _FLIP, skeleton.flesh.radius, tuple(owner))
    return replace(skeleton, world=world, flesh=flesh)


def _fit_image(cut: SegmentedFit, twin: Ints) -> SegmentedFit:
    """A fit in the mirror y = 0. twin (N,): the segment on the other side of each."""
    member = cut.member[:, twin]
    fit = replace(cut.fit, centre=cut.fit.centre * _FLIP, region=packed(member))
    return SegmentedFit(fit, cut.segments, member, tuple(cut.parts[k] for k in twin))


def _symmetric(body: Body, poses: Poses, plane: float) -> Poses:
    """The mean of a pose and its mirror image in a plane y = `plane` [m]."""
    twin = twins_of(body)[1:] - 1
    image = np.array([1.0, -1.0, 1.0, -1.0])  # of a rotation (w, x, y, z)
    mean = poses.rotations + poses.rotations[:, twin] * image
    stage = from_matrices(poses.world_from_reference[:, :, :3]) * [1.0, 0.0, 1.0, 0.0]
    world = poses.world_from_reference.copy()
    world[:, :, :3] = matrices(stage / np.linalg.norm(stage))
    world[:, 1, 3] = plane
    return Poses(mean / np.linalg.norm(mean, axis=-1, keepdims=True), poses.reference, world)


def placed_skeleton(
    source: str | Path, *, posture: str | None = None, at: Floats | None = None
) -> Skeleton:
    """A body as a skeleton, in its zero pose or a posture of its own, its reference segment's
    origin at (3,) [m].

    UsageError where the posture twists what a segment shares: its spheres could not be turned back.
    """
    body = load_body(source)
    path = body_path(source)
    poses = pose(body, {})
    if posture is not None:
        file = posture_path(path)
        if file is None:
            raise UsageError(f"posture {posture!r}: {path} names no file of postures")
        poses = posture_pose(body, load_postures(file, body)[0], posture)
    shared = body.twist_joint[body.twist_joint >= 0]
    if np.abs(angles_of(body, poses)[0, shared, 2]).max(initial=0.0) > _TWISTED:
        turned = ", ".join(body.joints[j] for j in shared)
        raise UsageError(
            f"posture {posture!r}: the joints whose twist a segment shares ({turned}) must not be twisted"
        )
    world = place(body, poses).world_from_segment[0].copy()
    world[..., 3] += np.zeros(3) if at is None else np.asarray(at)
    return Skeleton(body, path, world)


def fit_body(
    surface: Surface,
    skeleton: Skeleton | None,
    limits: FitBounds,
    *,
    count: int | None = None,
    seed: int = 0,
) -> SegmentedFit:
    """Spheres for each segment of a skeleton, or for one segment without one.

    A surface that is its own mirror image in a plane y = constant gives segments that are each
    other's, if the skeleton's are and no `count` is asked for.
    """
    if skeleton is None:
        return fit_whole(surface, limits, name=ALONE, count=count, seed=seed)
    plane = _mirror_plane(surface)
    turned = plane is None and skeleton.flesh is not None and _left_handed(surface)
    stands = _skeleton_image(skeleton) if turned else skeleton
    cut = fit_segments(
        _surface_image(surface) if turned else surface,
        stands.bones,
        outward=limits.outward,
        inward=limits.inward,
        least_radius=limits.least,
        greatest_radius=limits.greatest,
        count=count,
        seed=seed,
    )
    segments = skeleton.body.segments
    other = dict(zip(segments, (segments[n] for n in twins_of(skeleton.body)), strict=True))
    twin = np.array([cut.segments.index(other[name]) for name in cut.segments])
    if turned:
        return _fit_image(cut, twin)
    if plane is None or count is not None:
        return cut
    image = _skeleton_image(skeleton).world
    image[:, 1, 3] += 2.0 * plane
    if np.abs(image - skeleton.world).max() > _SYMMETRIC:
        return cut
    return symmetric_fit(surface, regions_of(surface, skeleton.bones), cut, twin, plane)


def fitted_body_text(
    surface: Surface,
    cut: SegmentedFit,
    skeleton: Skeleton | None,
    *,
    name: str,
    description: str,
    source: str,
) -> str:
    """The body file of a fit. Masses are those of the parts' volumes at the density of a body."""
    errors = {
        n: (DENSITY * p.volume, p.outside, p.inside)
        for n, p in zip(cut.segments, cut.parts, strict=True)
    }
    if skeleton is None:
        middle = _centroid(surface)
        segments = {
            ALONE: FittedSegment(cut.fit.centre - middle, cut.fit.radius, {}, *errors[ALONE])
        }
        return fitted_text(segments, name=name, description=description, source=source)
    body = skeleton.body
    nothing = FittedSegment(np.zeros((0, 3)), np.zeros(0), {}, 0.0, 0.0, 0.0)
    segments = dict.fromkeys(body.segments, nothing)
    for segment, (centre, radius) in spheres_in_frames(body, skeleton.world, cut).items():
        n = body.segment(segment)
        if skeleton.flesh is None:
            names = named_rows(body, n, centre, radius)
        else:  # the landmarks of the skeleton are where they should be
            marks, sizes, rows = _landmarks(surface, skeleton, n)
            names = {len(radius) + k: name for k, name in enumerate(rows)}
            centre = np.concatenate([centre, marks])
            radius = np.append(radius, sizes)
        segments[segment] = FittedSegment(centre, radius, names, *errors[segment])
    file = SkeletonFile(body, skeleton.path)
    return fitted_text(segments, name=name, description=description, source=source, skeleton=file)


def _landmarks(
    surface: Surface, skeleton: Skeleton, segment: int
) -> tuple[Floats, Floats, list[tuple[str, ...]]]:
    """The named spheres of a segment of a skeleton, made so small, or moved so far, that they lie
    inside a surface: centres (n, 3) in the segment's frame, radii (n,) [m], names with directions."""
    body = skeleton.body
    own = range(body.start[segment], body.start[segment + 1])
    rows = [s for s in own if body.sphere_names[s]]
    rotation = skeleton.world[segment, :, :3]
    origin = skeleton.world[segment, :, 3]
    distance, _, foot = surface.nearest(body.centre[0, rows] @ rotation.T + origin)
    inside = (distance < -_LEAST_MARK)[:, None]
    centre = np.where(inside, body.centre[0, rows], (foot - origin) @ rotation)
    # of two points as near, left and right, neither: a mark of the middle stays there
    middle = np.abs(body.centre[0, rows, 1]) < _MIDDLE
    centre[middle, 1] = body.centre[0, rows, 1][middle]
    radius = np.minimum(body.radius[0, rows], np.maximum(-distance, _LEAST_MARK))
    names = [
        (
            body.sphere_names[s],
            *([DIRECTIONS[d]] if (d := int(body.sphere_direction[s])) >= 0 else []),
        )
        for s in rows
    ]
    return centre, radius, names


def figures(surface: Surface, cut: SegmentedFit) -> dict[str, Any]:
    """The figures of the whole and of each segment: distances in mm, volumes in litres."""
    q = cut.fit.quality
    whole = asdict(q) | {"volume": surface.volume}
    rows = {name: asdict(part) for name, part in zip(cut.segments, cut.parts, strict=True)}
    return {
        "whole": _in_millimetres(whole),
        "segments": {name: _in_millimetres(row) for name, row in rows.items()},
        "notes": list(surface.notes),
    }


def bound_of(
    surface: Surface, skeleton: Skeleton | None, limits: FitBounds, *, seed: int = 0
) -> int:
    """No union of candidates within the tolerances has fewer spheres than this
    (`fewest_spheres`)."""
    if skeleton is None:
        none = Joints(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))
        return fewest_spheres(surface, limits, none, Regions(), seed=seed)
    bones = skeleton.bones
    point, served = bones.joints()
    radius = np.minimum(-surface.distance(point), limits.greatest)
    return fewest_spheres(
        surface,
        limits,
        Joints(point, radius, packed(served)),
        regions_of(surface, bones),
        seed=seed,
    )


def _in_millimetres(row: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in row.items():
        if key in _MM:
            found[f"{key}_mm"] = round(1e3 * value, 3)
        elif key != "volume":
            found[key] = round(value, 4)
    return found | {"volume_l": round(1e3 * row["volume"], 4)}


def _centroid(surface: Surface) -> Floats:
    """(3,) centre of the volume: the mean of the tetrahedra from the origin to each face."""
    corner = surface.vertices[surface.faces]
    weight = np.einsum("tc,tc->t", corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
    return weight @ corner.sum(axis=1) / (4 * weight.sum())
