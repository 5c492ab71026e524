"""An independent search for clear reaches: random restarts of SciPy's least squares over the joint
angles, with forward kinematics and distances of its own.

Of the package it takes data, `place` for where the skin carries the spheres of a posture, and
`stops`. What it finds is judged by `place`, `contacts` and `stops`. It is slow and shares no code
with the search of the package.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

import workbench as wb
from tests.oracles import forward, winding
from workbench.model.posing import angles_of, compose

STEP = 1e-6
OFF = 4e-4
"""How far [m] spheres are kept off."""
TIP = 1e-4
PAST = np.radians(0.1)
RADIAN = 0.3
"""What a radian past a stop counts [m]."""
STEPS = 40


class Reacher:
    """One limb of one person in one posture, among the parts of an environment."""

    def __init__(self, body, arm, pose, environment):
        self.body = body
        self.arm = arm
        self.pose = pose
        self.environment = environment
        self.angles = angles_of(body, pose)[0]
        self.base = forward(body, pose)[0, arm.base]
        turns = [
            (j, axis) for j in arm.free for axis in range(3) if body.stops.limits[j, axis].sum() > 0
        ]
        self.joint, self.axis = (np.array(column) for column in zip(*turns, strict=True))
        limits = body.stops.limits[self.joint, self.axis]
        self.low = -limits[:, 1]
        self.high = limits[:, 0]
        self.sphere = np.flatnonzero(arm.solid[0])
        self.corners = environment.vertices[environment.triangles]
        self.part = np.repeat(
            np.arange(len(environment.parts)),
            [
                np.diff(environment.triangle_start)[environment.polygons(k)].sum()
                for k in range(len(environment.parts))
            ],
        )
        shown = ~environment.hidden[self.part]
        self.corners = self.corners[shown]
        self.part = self.part[shown]
        self.middle = self.corners.mean(axis=1)
        self.size = np.linalg.norm(self.corners - self.middle[:, None], axis=2).max(axis=1)
        self.allowed = np.zeros((len(body.segments), len(environment.parts)))
        for rule in environment.allowances:
            for n, name in enumerate(body.segments):
                if name in rule.segments or "all" in rule.segments:
                    self.allowed[n, rule.part] = max(self.allowed[n, rule.part], rule.depth)

    def frames(self, turns):
        """World transforms (P, N, 3, 4) of the moving segments with the free angles at turns (P,
        n), outward from the base."""
        angles = np.repeat(self.angles[None], len(turns), axis=0)
        angles[:, self.joint, self.axis] = turns
        world = np.full((len(turns), len(self.body.segments), 3, 4), np.nan)
        world[:, self.arm.base] = self.base
        for n in sorted(self.arm.moving):
            if n == self.arm.base:
                continue
            j = n - 1
            axes = self.body.stops.axes[j]
            swing = turned(angles[:, j, :2] @ axes[:2])
            turn = swing @ turned(angles[:, j, 2:] @ axes[2:])
            if j not in self.arm.free:
                turn = np.repeat(turned_as(self.pose.rotations[0, j])[None], len(turns), axis=0)
            above = world[:, self.body.parent[n]]
            world[:, n, :, :3] = above[..., :3] @ turn
            at = self.body.joint_in_parent[0, j] - turn @ self.body.joint_in_child[0, j]
            world[:, n, :, 3] = (above[..., :3] @ at[..., None])[..., 0] + above[..., 3]
        return world

    def posed(self, turns):
        """Poses of turns (P, n)."""
        angles = np.repeat(self.angles[None], len(turns), axis=0)
        angles[:, self.joint, self.axis] = turns
        world = np.repeat(self.pose.world_from_reference[:1], len(turns), axis=0)
        return wb.Poses(compose(self.body, angles), self.pose.reference, world)

    def breach(self, turns):
        """(P,) [rad] how far turns (P, n) are past the stops."""
        margin = wb.stops(self.body, self.posed(turns)).margin[:, list(self.arm.free)]
        return np.maximum(0.0, -margin.min(axis=1))

    def tips(self, world):
        """(P, 3) [m] where frames bring the tip."""
        end = world[:, self.arm.end]
        return end[..., :3] @ self.arm.tip[0] + end[..., 3]

    def deepest(self, centres):
        """For the limb's spheres at centres (S, 3): how deep [m] each is in some part beyond what is
        allowed, and the way out (S, 3)."""
        depth = np.full(len(centres), -np.inf)
        out = np.zeros((len(centres), 3))
        radius = self.body.radius[0, self.sphere]
        segment = self.body.sphere_segment[self.sphere]
        gap = np.linalg.norm(centres[:, None] - self.middle, axis=2) - self.size
        inside = self._inside(centres)
        for s, centre in enumerate(centres):
            for part in np.unique(
                np.concatenate([self.part[gap[s] < radius[s] + OFF], np.flatnonzero(inside[s])])
            ):
                rows = np.flatnonzero(self.part == part)
                rows = rows[gap[s, rows] <= (gap[s, rows] + 2.0 * self.size[rows]).min()]
                foot = nearest_points(centre, self.corners[rows])
                way = centre - foot
                far = np.linalg.norm(way, axis=1)
                at = far.argmin()
                sign = -1.0 if inside[s, part] else 1.0
                excess = radius[s] - sign * far[at] - self.allowed[segment[s], part]
                if excess > depth[s] and far[at] > 0:
                    depth[s] = excess
                    out[s] = sign * way[at] / far[at]
        return depth, out

    def _inside(self, centres):
        """(S, parts) whether each centre is inside a solid part, by the winding number."""
        inside = np.zeros((len(centres), len(self.environment.parts)), bool)
        for part in np.flatnonzero(self.environment.solid & ~self.environment.hidden):
            corners = self.corners[self.part == part]
            if not len(corners):
                continue
            low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
            for s in np.flatnonzero(np.all((centres > low) & (centres < high), axis=1)):
                inside[s, part] = abs(winding(centres[s], corners)) > 0.5
        return inside

    def violated(self, turns, target):
        """What is violated at turns (n,), and its slopes: tip (3), stops (1), spheres (S) [m]."""
        nudged = np.concatenate([turns[None], turns + STEP * np.eye(len(turns))])
        world = self.frames(nudged)
        tips = self.tips(world)
        breach = self.breach(nudged)
        centres = wb.place(self.body, self.posed(turns[None])).centres[0, self.sphere]
        segment = self.body.sphere_segment[self.sphere]
        first = world[0, segment]
        local = np.einsum("sji,sj->si", first[..., :3], centres - first[..., 3])
        every = world[:, segment]
        moved = np.einsum("psij,sj->psi", every[..., :3], local) + every[..., 3]
        depth, out = self.deepest(centres)
        left = np.concatenate(
            [tips[0] - target, [RADIAN * breach[0]], np.maximum(0.0, depth + OFF)]
        )
        slope = np.zeros((len(left), len(turns)))
        slope[:3] = (tips[1:] - tips[0]).T / STEP
        slope[3] = RADIAN * (breach[1:] - breach[0]) / STEP
        pushed = np.einsum("psi,si->ps", (moved[1:] - moved[0]) / STEP, out).T
        slope[4:] = np.where(left[4:, None] > 0, -pushed, 0.0)
        return left, slope

    def is_clear(self, turns, target):
        """Whether turns (n,) reach a target within the stops and enter nothing, as the package sees
        it."""
        poses = self.posed(turns[None])
        placed = wb.place(self.body, poses)
        end = placed.world_from_segment[0, self.arm.end]
        tip = end[:, :3] @ self.arm.tip[0] + end[:, 3]
        if np.linalg.norm(tip - target) > TIP or self.breach(turns[None])[0] > PAST:
            return False
        met = wb.contacts(placed, self.environment)
        return not np.any(self.arm.solid[0, met.sphere] & (met.excess > 0))


def clear_way(body, arm, pose, target, environment, *, restarts, seed=0, draws=40):
    """Turns (n,) that reach a target within the stops and clear of all parts, or None where
    `restarts` random starts find none; each is the nearest of some random postures."""
    reacher = Reacher(body, arm, pose, environment)
    rng = np.random.default_rng(seed)
    for _ in range(restarts):
        many = rng.uniform(reacher.low, reacher.high, (draws, len(reacher.low)))
        start = many[np.linalg.norm(reacher.tips(reacher.frames(many)) - target, axis=1).argmin()]
        known = {}

        def both(turns, known=known):
            key = turns.tobytes()
            if key not in known:
                known.clear()
                known[key] = reacher.violated(turns, target)
            return known[key]

        found = least_squares(
            lambda turns, both=both: both(turns)[0],
            start,
            lambda turns, both=both: both(turns)[1],
            bounds=(reacher.low - 1e-9, reacher.high + 1e-9),
            max_nfev=STEPS,
            xtol=1e-9,
            ftol=1e-9,
        )
        if reacher.is_clear(found.x, target):
            return found.x
    return None


def turned(vectors):
    """Rotation matrices (P, 3, 3) of rotation vectors (P, 3): Rodrigues' formula."""
    size = np.linalg.norm(vectors, axis=1)[:, None, None]
    unit = vectors / np.maximum(size[:, 0], 1e-300)
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -unit[:, 2], unit[:, 1], -unit[:, 0]
    cross -= cross.transpose(0, 2, 1)
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross


def turned_as(q):
    """Rotation matrix of a unit quaternion, by its rotation vector."""
    size = np.linalg.norm(q[1:])
    angle = 2.0 * np.arctan2(size, q[0])
    return turned((q[1:] * (angle / size if size > 1e-12 else 2.0))[None])[0]


def nearest_points(point, corners):
    """The nearest points (T, 3) of triangles (T, 3, 3) to a point: of the plane's foot where it is
    inside, else of the edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    best = np.zeros((len(corners), 3))
    least = np.full(len(corners), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        d = v - u
        share = np.einsum("ti,ti->t", point - u, d) / np.maximum(
            np.einsum("ti,ti->t", d, d), 1e-300
        )
        foot = u + np.clip(share, 0.0, 1.0)[:, None] * d
        far = np.linalg.norm(point - foot, axis=1)
        best = np.where((far < least)[:, None], foot, best)
        least = np.minimum(far, least)
    n = np.cross(b - a, c - a)
    square = np.einsum("ti,ti->t", n, n)
    foot = point - n * (np.einsum("ti,ti->t", point - a, n) / np.maximum(square, 1e-300))[:, None]
    inside = square > 1e-30
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ti,ti->t", np.cross(v - u, foot - u), n) >= 0
    return np.where(inside[:, None], foot, best)
