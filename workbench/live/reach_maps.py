"""The reach maps of a population beside the bench: on few of their points while something is dragged,
on all of them at rest.

People stand for the others as they do for the shares: those who are known of a state are counted.
What they reach is asked anew only where they sit otherwise, or the part has moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.draw.contours import median_spacing
from workbench.draw.reach_map import LEVELS, map_controls
from workbench.live.protocol import packed
from workbench.model.accommodation import MapTask, ReachMap
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.workplace import Workplace
from workbench.study.accommodation.people_maps import map_plane, map_points, reached_points
from workbench.study.reach_map import from_coarse_to_fine

__all__ = ["COARSE", "ReachMaps"]

COARSE = 16
"""Points of a map that are asked about while something is dragged."""


@dataclass(frozen=True, eq=False)
class _Reached:
    """Which points (M, 3) [m] of a map, from coarse to fine, some people reach (B, C) in their poses:
    C of them are known."""

    generation: int
    poses: Poses
    points: Floats
    reached: Bools

    def serves(self, poses: Poses, points: Floats, count: int) -> bool:
        """Whether this answers for people in poses, of so many points."""
        enough = self.reached.shape[1] >= count
        return enough and self.poses is poses and np.array_equal(self.points, points)


@dataclass(frozen=True, eq=False)
class _Surface:
    """A map's points (M, 3) [m] from coarse to fine, and the workplace that they are of."""

    place: Workplace
    points: Floats
    normals: Floats


class ReachMaps:
    """The maps that a study asks of its population.

    Parameters
    ----------
    tasks
        What is asked.
    pieces
        The rows of people who are asked together.
    """

    def __init__(self, tasks: Sequence[MapTask], pieces: Sequence[Ints]) -> None:
        self.tasks = tuple(tasks)
        self.pieces = pieces
        self._found: list[list[_Reached | None]] = [[None] * len(pieces) for _ in self.tasks]
        self._surfaces: list[_Surface | None] = [None] * len(self.tasks)

    def ask(
        self,
        number: int,
        body: Body,
        poses: Sequence[Poses],
        place: Workplace,
        generation: int,
        *,
        whole: bool,
    ) -> None:
        """Find what a piece of people reaches.

        Parameters
        ----------
        body, poses
            (B,) the people, and their postures in each case.
        place
            Where they are.
        whole
            Whether all points are asked about, or few.
        """
        for k, task in enumerate(self.tasks):
            surface = self._surface(k, place)
            mine = poses[task.case]
            count = len(surface.points) if whole else min(COARSE, len(surface.points))
            known = self._found[k][number]
            if known is not None and known.serves(mine, surface.points, count):
                found = known.reached
            else:
                found = reached_points(body, mine, surface.points[:count], task)
            self._found[k][number] = _Reached(generation, mine, surface.points, found)

    def _surface(self, k: int, place: Workplace) -> _Surface:
        """The points of a map in a workplace."""
        known = self._surfaces[k]
        if known is None or known.place is not place:
            points, normals = map_points(place, self.tasks[k])
            order, _ = from_coarse_to_fine(points)
            known = _Surface(place, points[order], normals[order])
            self._surfaces[k] = known
        return known

    def frames(self, weight: Floats, generation: int) -> list[bytes]:
        """Pack what is known of each map in a state.

        Parameters
        ----------
        weight
            (P,) of everybody.
        """
        frames = []
        for k, (task, surface) in enumerate(zip(self.tasks, self._surfaces, strict=True)):
            known = [
                (weight[rows], found.reached)
                for rows, found in zip(self.pieces, self._found[k], strict=True)
                if found is not None and found.generation == generation
            ]
            if known and surface is not None:
                head = _head(task, surface, known)
                frames.append(
                    packed({"kind": "reach_map", "map": k, "generation": generation, **head})
                )
        return frames


def _head(task: MapTask, surface: _Surface, known: list[tuple[Floats, Bools]]) -> dict[str, Any]:
    """A map as the page draws it: lengths in mm."""
    count = min(reached.shape[1] for _, reached in known)
    total = sum(float(weight.sum()) for weight, _ in known)
    reached = np.sum([weight @ some[:, :count] for weight, some in known], axis=0)
    share = np.clip(reached / total, 0.0, 1.0)
    plane = map_plane(surface.place, surface.points)
    flat = plane.flat(surface.points)
    whole = ReachMap(task, surface.points, surface.normals, flat, np.zeros(len(flat)))
    controls = map_controls(whole, surface.place.environment)
    marks = plane.flat(np.array([control.at for control in controls]).reshape(-1, 3))
    return {
        "part": task.part,
        "hand": "either hand" if task.hand == "either" else f"the {task.hand} hand",
        "grip": task.grip,
        "zone": task.zone,
        "people": sum(len(weight) for weight, _ in known),
        "whole": count == len(flat),
        "levels": list(LEVELS),
        "spacing": round(1e3 * float(median_spacing(flat[:count])), 1) if count > 1 else 50.0,
        "points": np.round(1e3 * flat[:count], 1).tolist(),
        "share": np.round(share, 4).tolist(),
        "controls": [
            [control.name, *np.round(1e3 * at, 1).tolist()]
            for control, at in zip(controls, marks, strict=True)
        ],
    }
