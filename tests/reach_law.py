"""How far misses by obstacles are from contradicting those of targets near by, and from what an
independent search finds.

A posture that misses a target t' by m misses t by m + |t - t'| at most. So no miss of t may exceed
that of t' by more than |t - t'|.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import workbench as wb
from tests.conftest import SHARED, box_part, environment_of
from tests.reach_truth import HANDS, Seats, seats_of, study_of
from workbench.model.joint_angles import angles_of, compose
from workbench.model.surroundings import move_parts

ASIDE = (1e-3, 5e-3, 20e-3)
"""[m] How far targets near by are, to both sides along three axes."""
GROB = SHARED.parent / "cases" / "grob" / "fit.yaml"
"""A cockpit that was not made for this project."""
NEAR_PARTS = 0.02
"""[m] How far targets lie from the polygons of parts (a standard deviation)."""
WITHIN = (0.25, 0.85)
"""[m] How far they lie from the middle of the upper trunks."""
GRIPS = (("push", 1), ("grasp", 2), ("pinch", 3))
CLEAR = 5e-4
"""[m] How far from parts the independent search keeps."""
WEIGHTS = (3.0, 30.0, 300.0)
"""What a metre within a part and 0.3 rad past a stop count, in turns, beside a metre of miss."""


@dataclass
class Broken:
    """How often the law is broken in one place."""

    place: str
    asked: int = 0
    missed: int = 0
    """Rows that miss their target by an obstacle."""
    excess: list[float] = field(default_factory=list)
    """[m] By how much each of them exceeds what a target near by allows, where it does."""

    def beyond(self, tolerance: float) -> int:
        """Rows that exceed it by more [m]."""
        return sum(one > tolerance for one in self.excess)

    def __str__(self) -> str:
        worst = max(self.excess, default=0.0)
        return (
            f"{self.place}: {self.asked} asked, {self.missed} missed by an obstacle, "
            f"{self.beyond(1e-3)} exceed a target near by by more than 1 mm, "
            f"{self.beyond(1e-2)} by more than 10 mm, the worst by {1e3 * worst:.1f} mm"
        )


def seats_in(place: str, folder: Path, people: int) -> Seats:
    """People seated in a place of `reach_truth`, or in the cockpit that is a stranger's."""
    study = GROB if place == "grob" else study_of(place, folder)
    return seats_of(place, study, "coarse", people)


def targets_near_parts(seats: Seats, count: int, seed: int) -> np.ndarray:
    """Points (n, 3) [m] near the polygons of parts, spread evenly over their area, within reach."""
    rng = np.random.default_rng(seed)
    environment = seats.environment
    corners = environment.vertices[environment.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    placed = wb.place(seats.body, seats.poses)
    middle = placed.world_from_segment[:, seats.body.segment("UT"), :, 3].mean(axis=0)
    found: list[np.ndarray] = []
    while len(found) < count:
        triangle = corners[rng.choice(len(corners), p=area / area.sum())]
        point = rng.dirichlet([1, 1, 1]) @ triangle + rng.normal(size=3) * NEAR_PARTS
        if WITHIN[0] < np.linalg.norm(point - middle) < WITHIN[1]:
            found.append(point)
    return np.array(found)


def controls_of(seats: Seats) -> list[tuple[str, int, np.ndarray]]:
    """The targets (n, 3) of the hands by grip and zone: the controls of a place."""
    groups: dict[tuple[str, int], list[tuple[float, ...]]] = {}
    for control in seats.environment.controls:
        if control.grip != "foot":
            groups.setdefault((control.grip, control.zone), []).append(control.at)
    return [(grip, zone, np.array(points)) for (grip, zone), points in groups.items()]


def asked(seats: Seats, hand: str, grip: str, zone: int, targets: np.ndarray) -> wb.Reach:
    """The reaches of everybody, told as `reach` tells them."""
    return wb.reach(
        seats.body,
        seats.poses,
        targets,
        limb=wb.limb(seats.body, hand, grip=grip, zone=zone),
        environment=seats.environment,
        moving_parts=seats.moving_parts,
        displacement=seats.displacement,
    )


def missed_by_obstacle(found: wb.Reach) -> np.ndarray:
    """(B, T) which targets are missed by an obstacle."""
    return np.asarray(~found.reached & ((found.doubt >= 3) | (found.part >= 0)))


def short(found: wb.Reach) -> np.ndarray:
    """(B, T) [m] what lacks: how far the tip stays away, and how deep the limb is in a part."""
    return np.where(found.reached, 0.0, found.miss + found.overlap)


def excess_over_neighbours(ask, targets: np.ndarray) -> tuple[wb.Reach, np.ndarray]:
    """The reaches to targets (T, 3), and (B, T) [m] by how much each exceeds what a target near by
    allows, negative where it does not. Only targets that somebody misses by an obstacle are asked
    about."""
    found = ask(targets)
    over = np.full(found.reached.shape, -np.inf)
    some = np.flatnonzero(missed_by_obstacle(found).any(axis=0))
    if len(some):
        ways = np.concatenate([np.eye(3), -np.eye(3)])
        aside = np.concatenate([far * ways for far in ASIDE])
        near = ask((targets[some, None] + aside).reshape(-1, 3))
        allowed = short(near).reshape(len(near), len(some), -1) + np.linalg.norm(aside, axis=1)
        over[:, some] = short(found)[:, some] - allowed.min(axis=2)
    return found, np.where(missed_by_obstacle(found), over, -np.inf)


def broken_law(seats: Seats, groups) -> Broken:
    """How often the law is broken in a place; groups: grip, zone and targets (n, 3)."""
    total = Broken(seats.name)
    for hand, (grip, zone, targets) in itertools.product(HANDS, groups):

        def ask(points, hand=hand, grip=grip, zone=zone):
            return asked(seats, hand, grip, zone, points)

        found, over = excess_over_neighbours(ask, targets)
        total.asked += found.reached.size
        total.missed += int(missed_by_obstacle(found).sum())
        total.excess += over[over > 0].tolist()
    return total


class Searcher:
    """A slow search of its own for the nearest clear posture of one limb of one person: random
    legal starts, and least squares with differences on the tip, what spheres enter, and the stops.
    Of the package it uses `place`, `contacts` and `stops`."""

    def __init__(self, body, arm, pose, environment):
        self.body = body
        self.arm = arm
        self.environment = environment
        base = wb.place(body, pose).world_from_segment[0, arm.base]
        self.base = base
        self.angles = angles_of(body, pose)[0]
        self.rotations = pose.rotations[0]
        limits = body.stops.limits
        self.turns = [(j, a) for j in arm.free for a in range(3) if limits[j, a].sum() > 0]
        rows, columns = (list(one) for one in zip(*self.turns, strict=True))
        self.low = -limits[rows, columns, 1]
        self.high = limits[rows, columns, 0]
        self.solid = np.flatnonzero(arm.solid[0])
        self.column = np.full(len(body.sphere_names), -1)
        self.column[self.solid] = np.arange(len(self.solid))

    def posed(self, values):
        """The poses at free angles (P, D)."""
        angles = np.repeat(self.angles[None], len(values), axis=0)
        for d, (joint, axis) in enumerate(self.turns):
            angles[:, joint, axis] = values[:, d]
        rotations = np.repeat(self.rotations[None], len(values), axis=0)
        free = list(self.arm.free)
        rotations[:, free] = compose(self.body, angles)[:, free]
        return wb.Poses(rotations, self.arm.base, np.repeat(self.base[None], len(values), axis=0))

    def seen(self, values):
        """Of free angles (P, D) the tips (P, 3), how deep each sphere enters (P, S) and how far each
        joint is past its stop (P, J)."""
        poses = self.posed(values)
        window = [self.body.segments[n] for n in self.arm.moving]
        placed = wb.place(self.body, poses, window=window)
        frame = placed.world_from_segment[:, self.arm.end]
        tips = frame[:, :, :3] @ self.arm.tip[0] + frame[:, :, 3]
        depth = np.zeros((len(values), len(self.solid)))
        met = wb.contacts(placed, self.environment, margin=CLEAR)
        met = met.rows(self.column[met.sphere] >= 0)
        np.maximum.at(depth, (met.pose, self.column[met.sphere]), met.excess + CLEAR)
        margin = wb.stops(self.body, poses).margin[:, list(self.arm.free)]
        return tips, np.maximum(depth, 0.0), np.maximum(-margin, 0.0)

    def nearest(self, target, *, starts, seed):
        """(miss [m], angles (D,)) of the nearest clear legal posture that is found; infinite where
        none is."""
        rng = np.random.default_rng(seed)
        drawn = rng.uniform(self.low, self.high, (40 * starts, len(self.low)))
        tips, depth, past = self.seen(drawn)
        lack = np.linalg.norm(tips - target, axis=1) + depth.sum(axis=1) + past.sum(axis=1)
        best = (np.inf, drawn[0])
        for values in drawn[np.argsort(lack, kind="stable")[:starts]]:
            for weight in WEIGHTS:
                values = least_squares(
                    lambda x, w=weight: self._lacks(x[None], target, w)[0],
                    np.clip(values, self.low + 1e-9, self.high - 1e-9),
                    jac=lambda x, w=weight: self._slope(x, target, w),
                    bounds=(self.low, self.high),
                    max_nfev=15,
                ).x
            best = min(best, (self.clear_miss(values, target), values), key=lambda one: one[0])
        return best

    def clear_miss(self, values, target):
        """[m] by how much a posture misses a target; infinite where it enters a part or breaks a
        stop."""
        tips, depth, past = self.seen(np.asarray(values)[None])
        clear = depth.max() < CLEAR and np.degrees(past.max()) < 0.1
        return float(np.linalg.norm(tips[0] - target)) if clear else np.inf

    def _lacks(self, values, target, weight):
        tips, depth, past = self.seen(values)
        return np.concatenate([tips - target, weight * depth, 0.3 * weight * past], axis=1)

    def _slope(self, values, target, weight):
        step = 1e-6
        rows = np.concatenate([values[None], values + step * np.eye(len(values))])
        lacks = self._lacks(rows, target, weight)
        return ((lacks[1:] - lacks[0]) / step).T


def searcher(seats: Seats, person: int, hand: str, grip: str, zone: int) -> Searcher:
    """The search for one limb of one person in a place."""
    one = seats.body[np.array([person])]
    arm = wb.limb(one, hand, grip=grip, zone=zone)
    room = move_parts(seats.environment, seats.moving_parts, seats.displacement[person])
    return Searcher(one, arm, seats.pose(person), room)


def longer_than_searched(seats: Seats, people: int, each: int, starts: int) -> list[float]:
    """[m] by how much misses without obstacles exceed what the search finds: of the first people,
    each hand and zone, for targets in all directions about their shoulders."""
    nowhere = environment_of(box_part("far away", [90.0, 90.0, 90.0], [91.0, 91.0, 91.0]))
    upper_arms = wb.place(seats.body, seats.poses).world_from_segment[:, :, :, 3]
    longer = []
    for seed, (hand, (grip, zone)) in enumerate(itertools.product(HANDS, GRIPS)):
        rng = np.random.default_rng(seed)
        shoulder = upper_arms[:people, seats.body.segment(hand[0].upper() + "UA")]
        way = rng.normal(size=(people, 4 * each, 3))
        away = rng.uniform(0.3, 1.3, (people, 4 * each, 1))
        targets = shoulder[:, None] + away * way / np.linalg.norm(way, axis=2, keepdims=True)
        for person in range(people):
            one = seats.body[np.array([person])]
            arm = wb.limb(one, hand, grip=grip, zone=zone)
            found = wb.reach(one, seats.pose(person), targets[person], limb=arm)
            search = Searcher(one, arm, seats.pose(person), nowhere)
            for target in np.flatnonzero(~found.reached[0])[:each].tolist():
                least, _ = search.nearest(targets[person, target], starts=starts, seed=target)
                longer.append(float(found.miss[0, target]) - least)
    return longer
