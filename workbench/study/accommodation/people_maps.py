"""The reach maps of a population: everybody where they are, with the hands that are asked
for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from workbench.model.accommodation import MapTask, ReachMap
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.model.workplace import Workplace
from workbench.posture.reaching.limbs import HANDS, limbs_there
from workbench.posture.seating.sides import leftward, middle
from workbench.study.accommodation.chunks import Question, taken_places
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.executors import completed
from workbench.study.reach_map import part_points, who_reaches

__all__ = ["MapPlane", "map_plane", "map_points", "people_maps", "reached_points"]

TOGETHER = 128
"""People whose map is one piece of work."""
_SHOULDERS = 0.6
"""How far [m] over the seat reference point somebody looks at a part from, to tell which of its
sides count."""


def people_maps(
    question: Question,
    tasks: Sequence[MapTask],
    bodies: PopulationBodies,
    *,
    say: Callable[[str], None],
    executor: Executor | None = None,
) -> Iterator[ReachMap]:
    """The maps that a study asks for, over the sides of each part that face the people. Obstacles
    do not count."""
    for task in tasks:
        points, normals = map_points(question.place, task)
        share = _reached_share(question, bodies, task, points, say, executor)
        flat = map_plane(question.place, points).flat(points)
        yield ReachMap(task, points, normals, flat, share)


def _reached_share(
    question: Question,
    bodies: PopulationBodies,
    task: MapTask,
    points: Floats,
    say: Callable[[str], None],
    executor: Executor | None,
) -> Floats:
    """(M,) the weighted share of everybody, where they sit, who reach each point."""
    weight = question.people.weight
    chunks = taken_places(question.place, question.people, bodies, executor=executor)
    poses = join_poses([taken[task.case].poses for taken in chunks])
    body = bodies[: len(bodies)]
    parts = np.array_split(np.arange(len(poses)), max(1, -(-len(poses) // TOGETHER)))
    jobs = completed(
        reached_weight,
        range(len(parts)),
        lambda n: (body[parts[n]], poses.rows(parts[n]), weight[parts[n]], points, task),
        executor=executor,
    )
    reached = np.zeros((len(parts), len(points)))
    with closing(jobs):
        for done, (number, found) in enumerate(jobs, 1):
            reached[number] = found
            say(f"reach map of {task.part}: {100 * done // len(parts)} %")
    share: Floats = np.clip(reached.sum(axis=0) / weight.sum(), 0.0, 1.0)
    return share


def reached_weight(
    body: Body, poses: Poses, weight: Floats, points: Floats, task: MapTask
) -> Floats:
    """(M,) the weight (B,) of those of some people who reach each point."""
    found: Floats = weight @ reached_points(body, poses, points, task)
    return found


def reached_points(body: Body, poses: Poses, points: Floats, task: MapTask) -> Bools:
    """(B, M) which points (M, 3) [m] some people, rows of a body and of poses, reach with any of the
    hands that a map asks for."""
    reached = np.zeros((len(body), len(points)), dtype=np.bool_)
    for name in limbs_there(body, HANDS) if task.hand == "either" else (f"{task.hand} hand",):
        reached = who_reaches(
            body, poses, points, name, grip=task.grip, zone=task.zone, settled=reached
        )
    return reached


def map_points(place: Workplace, task: MapTask) -> tuple[Floats, Floats]:
    """About as many points (M, 3) [m] as are asked for on what of a part faces the sitter, all of its
    sides where nothing does, and the normals (M, 3) there."""
    viewer = middle(place) + np.array([0.0, 0.0, _SHOULDERS])
    points, normals = part_points(place.environment, task.part, task.points)
    share = float(np.mean(_faces(points, normals, viewer)))
    if share == 0:
        return points, normals
    points, normals = part_points(
        place.environment, task.part, round(task.points / max(share, 0.05))
    )
    kept = _faces(points, normals, viewer)
    return points[kept], normals[kept]


def _faces(points: Floats, normals: Floats, viewer: Floats) -> Bools:
    toward = viewer - points
    seen: Bools = np.sum(normals * toward, axis=1) > 0.2 * np.linalg.norm(toward, axis=1)
    return seen


@dataclass(frozen=True, eq=False)
class MapPlane:
    """The plane that a map is drawn in: its middle (3,) [m], and unit vectors (3,) to the sitter's
    right and up the part."""

    middle: Floats
    right: Floats
    up: Floats

    def flat(self, points: Floats) -> Floats:
        """(M, 2) [m] points (M, 3) to the right and up."""
        arm = points - self.middle
        return np.stack([arm @ self.right, arm @ self.up], axis=1)


def map_plane(place: Workplace, points: Floats) -> MapPlane:
    """The plane of the points (M, 3) [m] of a part: up along its steepest line where it lies, else
    straight up."""
    left = leftward(place)
    ahead = np.array([left[1], -left[0], 0.0])
    centre = points.mean(axis=0)
    thin = np.linalg.svd(points - centre, full_matrices=False)[2][-1]
    up = np.array([0.0, 0.0, 1.0]) if abs(thin[2]) < 0.8 else ahead
    right = np.cross(up, thin) if abs(thin @ up) < 0.95 else -left
    right = right / np.linalg.norm(right)
    right = right if right @ left < 0 or abs(right @ left) < 0.3 else -right
    across = np.cross(thin, right)
    across = across if across @ up > 0 else -across
    return MapPlane(centre, right, across)
