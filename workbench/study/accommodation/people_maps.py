"""The reach maps of an accommodation study: everybody where they sit, with the hands that are asked
for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing

import numpy as np

from workbench.model.accommodation import AccommodationStudy, MapTask, ReachMap
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, stack_bodies
from workbench.model.poses import Poses
from workbench.posture.reaching.limbs import HANDS
from workbench.posture.seating.seat import Seated
from workbench.posture.seating.seating import seat_planes
from workbench.study.accommodation.chunks import seat_key, seated_chunk
from workbench.study.accommodation.crew import Crew
from workbench.study.accommodation.forks import shared
from workbench.study.accommodation.sitters import Sitters
from workbench.study.reach_map import groups, part_points, who_reaches

__all__ = ["people_maps"]

_SHOULDERS = 0.6
"""How far [m] over the seat reference point somebody looks at a part from, to tell which of its
sides count."""


def people_maps(
    study: AccommodationStudy, crew: Crew, *, say: Callable[[str], None]
) -> Iterator[ReachMap]:
    """The maps a study asks for, over the sides of each part that face the sitter. Obstacles do not
    count."""
    weight = study.people.weight
    for task in study.maps:
        points, normals = _facing(study, task)
        names = HANDS if task.hand == "either" else (f"{task.hand} hand",)
        limbs = [(name, task.grip, task.zone) for name in names]
        body, poses = _everybody(study, crew)
        some = groups(body, poses, points, names[0])

        def work(number: int) -> Floats:
            return _reached(study, (body, poses), points, (limbs, some[number]))  # noqa: B023

        parts = np.zeros((len(some), len(points)))
        with closing(shared(work, range(len(some)))) as ready:
            for done, (number, found) in enumerate(ready):
                parts[number] = found
                say(f"reach map of {task.part}: {100 * (done + 1) // len(some)} %")
        share = parts.sum(axis=0) / weight.sum()
        yield ReachMap(task, points, normals, _flat(study, points), np.clip(share, 0.0, 1.0))


def _everybody(study: AccommodationStudy, crew: Crew) -> tuple[Body, Poses]:
    """Everybody in the seat; who has not been seated yet is, by all processes."""
    key = seat_key(study)
    missing = [chunk for chunk in range(len(crew)) if (key, chunk) not in crew.sitting]

    def work(chunk: int) -> tuple[Seated, Poses]:
        found = seated_chunk(study, crew, chunk)
        return found.seat, found.held

    with closing(shared(work, missing)) as ready:
        for chunk, (seat, held) in ready:
            crew.sitting[key, chunk] = Sitters(crew.bodies(chunk), seat, held)
    sitters = [crew.sitting[key, chunk] for chunk in range(len(crew))]
    poses = [one.seat.poses for one in sitters]
    rotations, world = (
        np.concatenate([getattr(p, n) for p in poses])
        for n in ("rotations", "world_from_reference")
    )
    body = stack_bodies([one.body for one in sitters])
    return body, Poses(rotations, poses[0].reference, world)


def _reached(
    study: AccommodationStudy,
    people: tuple[Body, Poses],
    points: Floats,
    what: tuple[Sequence[tuple[str, str, int]], Ints],
) -> Floats:
    """(M,) the weight of those of some people (numbers) who reach each point with any of the
    limbs."""
    (body, poses), (limbs, rows) = people, what
    own = Poses(poses.rotations[rows], poses.reference, poses.world_from_reference[rows])
    reached = np.zeros((len(rows), len(points)), dtype=np.bool_)
    for limb in limbs:
        reached = who_reaches(body[rows], own, points, chain=limb, settled=reached)
    found: Floats = study.people.weight[rows] @ reached
    return found


def _facing(study: AccommodationStudy, task: MapTask) -> tuple[Floats, Floats]:
    """About as many points as are asked for on what of a part faces the sitter, all of its sides
    where nothing does."""
    viewer = np.array(study.environment.seat(study.seat).srp) + np.array([0.0, 0.0, _SHOULDERS])
    points, normals = part_points(study.environment, task.part, task.points)
    share = float(np.mean(_faces(points, normals, viewer)))
    if share == 0:
        return points, normals
    points, normals = part_points(
        study.environment, task.part, round(task.points / max(share, 0.05))
    )
    kept = _faces(points, normals, viewer)
    return points[kept], normals[kept]


def _faces(points: Floats, normals: Floats, viewer: Floats) -> Bools:
    toward = viewer - points
    seen: Bools = np.sum(normals * toward, axis=1) > 0.2 * np.linalg.norm(toward, axis=1)
    return seen


def _flat(study: AccommodationStudy, points: Floats) -> Floats:
    """(M, 2) [m] to the sitter's right and up the part: along its steepest line where it lies, else
    straight up."""
    left = seat_planes(study.environment.seat(study.seat))[2]
    ahead = np.array([left[1], -left[0], 0.0])
    arm = points - points.mean(axis=0)
    thin = np.linalg.svd(arm, full_matrices=False)[2][-1]
    up = np.array([0.0, 0.0, 1.0]) if abs(thin[2]) < 0.8 else ahead
    right = np.cross(up, thin) if abs(thin @ up) < 0.95 else -left
    right = right / np.linalg.norm(right)
    right = right if right @ left < 0 or abs(right @ left) < 0.3 else -right
    across = np.cross(thin, right)
    across = across if across @ up > 0 else -across
    return np.stack([arm @ right, arm @ across], axis=1)
