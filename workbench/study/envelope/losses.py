"""What obstacles take of rays: runs of stations that are reached only through them, their ends
found by halving; and how far reach is easy along a ray."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.ray_reach import Losses
from workbench.study.envelope.asking import rows_toward
from workbench.study.envelope.clearing import Room, cleared_from
from workbench.study.envelope.stations import Stations

__all__ = ["HALVINGS", "eased", "losses"]

HALVINGS = 4
"""How often the stretch between a clear station and one that is not is halved."""


def losses(at: Stations, room: Room) -> Losses:
    """The stretches of the rays that obstacles take, each known up to where the limb was found
    clear."""
    lost = at.reached & ~at.clear
    same = at.ray[1:] == at.ray[:-1]
    begins = lost & np.concatenate([[True], ~(same & lost[:-1])])
    ends = lost & np.concatenate([~(same & lost[1:]), [True]])
    head = np.flatnonzero(begins)
    tail = np.flatnonzero(ends)
    ray = at.ray[head]
    begin = at.radius[head].copy()
    end = at.radius[tail].copy()
    inner = at.place[head] == 0
    outer = at.place[tail] == at.count[ray] - 1
    for station, edge, way, whole in ((head, begin, -1, inner), (tail, end, 1, outer)):
        beside = np.clip(station + way, 0, len(at) - 1)
        clear = ~whole & at.clear[beside]
        # a stretch that nothing reaches, obstacles or not, shares the way with its neighbour
        middle = ~whole & ~clear
        edge[middle] = 0.5 * (at.radius[station] + at.radius[beside])[middle]
        rows = np.flatnonzero(clear)
        edge[rows] = _halved(at, room, beside[rows], station[rows])
    parts = [at.part[a : b + 1] for a, b in zip(head, tail, strict=True)]
    part = [int(np.bincount(p[p >= 0]).argmax()) if np.any(p >= 0) else -1 for p in parts]
    return Losses(ray, begin, end, np.array(part, dtype=np.int64).reshape(-1))


def _halved(at: Stations, room: Room, clear: Ints, blocked: Ints) -> Floats:
    """(P,) [m] how far from clear stations (P,) toward blocked ones the limb comes clear."""
    good = at.radius[clear].copy()
    bad = at.radius[blocked].copy()
    angles = at.angles[clear].copy()
    rays = at.rays.rows(at.ray[clear])
    for _ in range(HALVINGS):
        if not len(good):
            break
        middle = 0.5 * (good + bad)
        some = rows_toward(at.task, clear, rays.at(middle))
        found, fine = cleared_from(some, angles, room)
        good = np.where(fine, middle, good)
        bad = np.where(fine, bad, middle)
        angles[fine] = found.angles[fine]
    return good


def eased(at: Stations, most: float) -> tuple[Floats, Floats]:
    """(R,) [m] the outermost and the innermost radius of each ray at which discomfort is no more
    than `most`, between stations in proportion; nan where there is none."""
    outer = np.full(len(at.rays), np.nan)
    inner = np.full(len(at.rays), np.nan)
    easy = at.reached & (at.discomfort <= most)
    for found, way in ((outer, 1), (inner, -1)):
        rows = np.flatnonzero(easy)[::-way]
        ray, first = np.unique(at.ray[rows], return_index=True)
        station = rows[first]
        beside = np.clip(station + way, 0, len(at) - 1)
        on = (at.ray[beside] == ray) & (beside != station) & at.reached[beside]
        rise = np.where(on, at.discomfort[beside] - at.discomfort[station], 1.0)
        share = np.where(
            on, np.clip((most - at.discomfort[station]) / np.maximum(rise, 1e-9), 0.0, 1.0), 0.0
        )
        found[ray] = at.radius[station] + share * (at.radius[beside] - at.radius[station])
    return outer, inner
