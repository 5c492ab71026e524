"""Which spheres are this surface? A mesh or outlines, with or without a skeleton, to the text of a
body file."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.body.fitting.candidates import Limits
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
)
from workbench.body.forward import place
from workbench.body.outlines import outline_surface
from workbench.body.scaling.measure import measure
from workbench.body.skeleton import bones_of, named_rows, spheres_in_frames
from workbench.body.surface import Surface, sealed
from workbench.errors import UsageError
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.outlines import load_outlines
from workbench.files.body.writer import FittedSegment, SkeletonFile, fitted_text
from workbench.files.meshes.reading import axes_rotation, read_mesh, to_world
from workbench.files.meshes.sizes import implausible_sizes, person_size
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats
from workbench.model.body import DIRECTIONS, Body
from workbench.model.posing import angles_of, pose

__all__ = [
    "DENSITY",
    "Skeleton",
    "bound_of",
    "figures",
    "fit_body",
    "fitted_body_text",
    "placed_skeleton",
    "read_surface",
    "skeleton_of",
]

DENSITY = 1010.0
"""Of a body [kg/m3], lungs half full."""
ALONE = "BODY"
_LEAST_MARK = 0.001
"""Radius [m] of a landmark that would lie outside the surface."""
_TWISTED = 1e-3
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
    size = float(np.ptp(surface.vertices, axis=0).max())
    doubts = implausible_sizes(parts, metres, file=source.stem) or person_size(size, metres)
    return replace(surface, notes=(*surface.notes, *doubts)) if doubts else surface


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
    found = register(body, surface)
    placed = place(found.body, found.poses)
    owner = tuple(found.body.segments[n] for n in found.body.sphere_segment)
    flesh = Flesh(placed.centres[0], found.body.radius[0], owner)
    note = (
        f"the skeleton of {body.name} is sized and posed to the surface, {1e3 * found.gap:.1f} mm "
        f"from it in the mean: stature {1e3 * measure(found.body, ['stature'])['stature']:.0f} mm; "
        "--at and --posture state its place and posture instead"
    )
    return Skeleton(found.body, body_path(source), placed.world_from_segment[0], (note,), flesh)


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
    limits: Limits,
    *,
    count: int | None = None,
    seed: int = 0,
) -> SegmentedFit:
    """Spheres for each segment of a skeleton, or for one segment without one."""
    if skeleton is None:
        return fit_whole(surface, limits, name=ALONE, count=count, seed=seed)
    return fit_segments(
        surface,
        skeleton.bones,
        outward=limits.outward,
        inward=limits.inward,
        least_radius=limits.least,
        greatest_radius=limits.greatest,
        count=count,
        seed=seed,
    )


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


def bound_of(surface: Surface, skeleton: Skeleton | None, limits: Limits, *, seed: int = 0) -> int:
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
    middle: Floats = weight @ corner.sum(axis=1) / (4 * weight.sum())
    return middle
