"""The maps of a population: everybody where they are, who reaches the points of a part with the hands
that are asked for, and who sees them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from workbench.model.accommodation import MapTask, ReachMap
from workbench.model.arrays import Bools, Floats, pieces
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.joint_angles import join_poses
from workbench.model.poses import Poses
from workbench.model.units import plain
from workbench.model.workplace import Workplace
from workbench.posture.reaching.limbs import HANDS, limbs_there
from workbench.posture.seating.seating import leftward, middle
from workbench.sight.eyes import eyes_of
from workbench.sight.obscuration import lines_of_sight
from workbench.study.accommodation.checkpoints import PopulationQuestion, taken_places
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.executors import Shared, completed
from workbench.study.passes import MAP, Count, Passes
from workbench.study.reach_map import part_points, who_reaches
from workbench.study.situation import Occupants, Situation, TakenPlaces, in_place

__all__ = ["MapPlane", "map_plane", "map_points", "people_maps", "reached_points", "seen_points"]

MOUNTED = 0.06
"""How high [m] what is mounted on a part may stand out of it, and how far beside it."""
_SAMPLES = 2000
"""Points of a part's surface, from which it is measured what is mounted on it."""
TOGETHER = 128
"""People whose map is one piece of work."""
_SHOULDERS = 0.6
"""How far [m] over the seat reference point somebody looks at a part from, to tell which of its
sides count."""


def people_maps(
    question: PopulationQuestion,
    tasks: Sequence[MapTask],
    bodies: PopulationBodies,
    *,
    passes: Passes,
    executor: Executor | None = None,
) -> Iterator[ReachMap]:
    """The maps that a study asks for, over the sides of each part that face the people. Obstacles
    do not count for who reaches; all that stands before the eyes does for who sees."""
    for task in tasks:
        points, normals = map_points(question.place, task)
        tell = passes.begin(MAP, f"who {'sees' if task.sees else 'reaches'} {plain(task.part)}")
        if task.sees:
            share = _seen_share(question, bodies, task, points, normals, tell, executor)
        else:
            share = _reached_share(question, bodies, task, points, tell, executor)
        flat = map_plane(question.place, points).flat(points)
        yield ReachMap(task, points, normals, flat, share)


def _reached_share(
    question: PopulationQuestion,
    bodies: PopulationBodies,
    task: MapTask,
    points: Floats,
    tell: Count,
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
        waiting=lambda done: tell(len(poses) * done / len(parts), len(poses)),
    )
    reached = np.zeros((len(parts), len(points)))
    with closing(jobs):
        for number, found in jobs:
            reached[number] = found
    share: Floats = np.clip(reached.sum(axis=0) / weight.sum(), 0.0, 1.0)
    return share


def _seen_share(
    question: PopulationQuestion,
    bodies: PopulationBodies,
    task: MapTask,
    points: Floats,
    normals: Floats,
    tell: Count,
    executor: Executor | None,
) -> Floats:
    """(M,) the weighted share of everybody, where they sit, who see each point."""
    people = question.people
    chunks = taken_places(question.place, people, bodies, executor=executor)
    place = Shared(question.place)

    def arguments(number: int) -> tuple[object, ...]:
        rows = bodies.chunks[number]
        who = Occupants(bodies[rows], people, np.arange(rows.start, rows.stop))
        return place, task, who, chunks[number][task.case], points, normals

    jobs = completed(
        seen_weight,
        range(len(chunks)),
        arguments,
        executor=executor,
        waiting=lambda done: tell(len(people) * done / len(chunks), len(people)),
    )
    seen = np.zeros((len(chunks), len(points)))
    with closing(jobs):
        for number, found in jobs:
            seen[number] = found
    share: Floats = np.clip(seen.sum(axis=0) / people.weight.sum(), 0.0, 1.0)
    return share


def seen_weight(
    place: Shared[Workplace],
    task: MapTask,
    who: Occupants,
    taken: TakenPlaces,
    points: Floats,
    normals: Floats,
) -> Floats:
    """(M,) the weight of those of some people, in their places, who see each point."""
    situation = in_place(place.value, task.case, who, taken).held
    weight = who.people.weight[who.numbers]
    found: Floats = weight @ seen_points(situation, task.part, points, normals)
    return found


def seen_points(situation: Situation, part: str, points: Floats, normals: Floats) -> Bools:
    """(B, M) which points of a part, with their normals (M, 3), people see with either eye. What is
    mounted on the part, as gauges are, hides nothing of it."""
    scenery = situation.scenery
    passed = np.array(scenery.see_through)
    passed[: len(situation.environment.parts)] |= _mounted(situation.environment, part)
    scenery = replace(scenery, see_through=passed)
    item = situation.environment.part_index(part)
    moved = situation.displacement if scenery.moving[item] else np.zeros((len(situation), 3))
    ends = points + moved[:, None]
    eyes = eyes_of(situation.placed)
    seen = np.zeros(ends.shape[:2], dtype=np.bool_)
    for eye in (eyes.left, eyes.right):
        toward = np.einsum("bmi,mi->bm", eye[:, None] - ends, normals) > 0.0
        seen |= toward & (lines_of_sight(scenery, eye, ends, np.full(len(points), item)) < 0)
    return seen


@lru_cache(maxsize=8)
def _mounted(environment: Environment, part: str) -> Bools:
    """(K,) the other parts that stand nowhere higher over a part's surface than `MOUNTED`, nor farther
    beside it."""
    points, normals = part_points(environment, part, _SAMPLES)
    ends = np.cumsum([0, *(len(environment.part(name).vertices) for name in environment.parts)])
    corners = np.concatenate([environment.part(name).vertices for name in environment.parts])
    high = np.empty(len(corners), dtype=np.bool_)
    for some in pieces(len(corners), size=1024):
        away = corners[some, None] - points
        nearest = np.argmin(np.sum(away * away, axis=2), axis=1)
        offset = away[np.arange(len(nearest)), nearest]
        height = np.sum(offset * normals[nearest], axis=1)
        beside = np.linalg.norm(offset - height[:, None] * normals[nearest], axis=1)
        high[some] = (height > MOUNTED) | (beside > MOUNTED)
    mounted = [not high[first:last].any() for first, last in pairwise(ends.tolist())]
    mounted[environment.part_index(part)] = False
    return np.array(mounted, dtype=np.bool_)


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
