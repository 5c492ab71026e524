"""Guides: reaches of a standard limb, solved once, from which the reaches of all people start.

A solution near by, with its multipliers, saves most of the steps of inverse kinematics. It must not
be the solution of another person who is asked at the same time, or an answer would depend on the
company. So a reach starts from a guide, which depends on the topology and on a cube of space only:

1. The target is expressed in the frame that carries the first free joint, and scaled from the
   length of the person's limb to that of the standard limb.
2. The standard limb reaches for the middle of the cube in which that point lies. This is solved
   once for a topology, from the comfort modes, and kept.
3. The person's reach starts at the angles of that solution. The multipliers of the target are
   turned and scaled back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.forward import segment_frames
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.kept import kept_with_topology
from workbench.model.poses import Poses, people_of
from workbench.posture.kernels.chain_kinematics import Linkage
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between, linkage
from workbench.posture.reaching.outward import Lead, no_lead, outward
from workbench.posture.reaching.reach_solver import (
    AGAIN,
    REACHED,
    LimbTask,
    ReachSolution,
    apply,
    cold,
    goals_of,
    root_joint,
    solve_reaches,
)
from workbench.posture.reaching.seeds import new_seeds, seed_angles

__all__ = ["Guides", "Guiding", "guides_of"]

CUBE = 0.06
"""Edge [m] of the cubes of targets that share a guide, at the size of the standard limb."""
FARTHEST = 1.5
"""Lengths of the limb beyond which all targets in one direction share a guide."""
MIDDLE = 1 << 20
"""Number of the cube about the first free joint, along each axis."""

_STEPS: Mapping[str, tuple[float, float, float]] = {
    "SP": (-0.027, 0.0, 0.183),
    "LC": (0.123, 0.023, 0.130),
    "LS": (-0.065, 0.150, -0.010),
    "LE": (0.0, 0.058, -0.266),
    "LW": (0.0, 0.0, -0.258),
    "LK": (0.0, 0.0, -0.430),
    "LA": (0.0, 0.0, -0.395),
}
"""From each joint's predecessor to the joint [m] in the zero pose: the mean of the bodies of an
average man and an average woman. A joint that is not here stands where its predecessor does."""
_NO_STEP = (0.0, 0.0, 0.0)
_TIPS: Mapping[str, tuple[float, float, float]] = {
    "push": (0.036, -0.031, -0.178),
    "pinch": (0.054, -0.043, -0.102),
    "grasp": (0.011, -0.016, -0.080),
    "ball": (0.118, -0.020, -0.070),
    "heel": (-0.040, 0.001, -0.062),
}
"""From the wrist or ankle of a left limb to the point that arrives [m], by grip."""


@dataclass(frozen=True, eq=False)
class Guiding:
    """How people stand to the standard limb, and which of them reaches in each row of a task."""

    frame: Floats
    """(B, 3, 3) attitude of the segment that carries the first free joint."""
    pivot: Floats
    """(B, 3) [m] the first free joint."""
    scale: Floats
    """(B,) length of the standard limb by that of the person's."""
    whose: Ints
    """(P,) the row of poses of each reach."""

    def own(self, points: Floats) -> Floats:
        """Points (P, 3) [m] from the first free joint, as the standard limb has them."""
        arm = points - self.pivot[self.whose]
        return apply(self.frame[self.whose].transpose(0, 2, 1), arm) * self.scale[self.whose, None]

    def back(self, held: Floats) -> Floats:
        """Multipliers (P, 6 + R) of the standard limb as those of people: a force on the tip turns
        with the frame and goes with one by length."""
        carried = held.copy()
        carried[:, :3] = apply(self.frame[self.whose], held[:, :3]) * self.scale[self.whose, None]
        return carried

    def rows(self, rows: Ints) -> Guiding:
        """The same for some rows of the task."""
        return replace(self, whose=self.whose[rows])


class Guides:
    """The guides of one limb of a topology. Cubes are solved when they are first asked for."""

    def __init__(self, body: Body, limb: Limb, link: Linkage) -> None:
        self.body = body
        self.limb = limb
        self.link = link
        self.joints = joints_between(body, limb.base, limb.end)
        self.length = float(_lengths(link)[0])
        self.known: tuple[Ints, ReachSolution | None] = (np.zeros(0, np.int64), None)
        self.led: dict[float, tuple[Ints, Lead | None]] = {}

    def guiding(self, task: LimbTask, poses: Poses, whose: Ints) -> Guiding:
        """How the people of a task stand, in poses (B,); whose (P,): the pose of each reach."""
        link = task.link
        first = int(link.free_joint.min())
        person = people_of(task.body, poses)
        frame = segment_frames(task.body, poses, int(task.body.parent[task.joints[first] + 1]))
        pivot = apply(frame[:, :, :3], link.at_parent[person, first]) + frame[:, :, 3]
        return Guiding(frame[:, :, :3], pivot, self.length / _lengths(link)[person], whose)

    def cubes(self, targets: Floats, how: Guiding) -> Ints:
        """(P,) the numbers of the cubes in which targets (P, 3) [m] lie."""
        own = how.own(targets)
        far = np.sqrt(own[:, 0] ** 2 + own[:, 1] ** 2 + own[:, 2] ** 2)
        own *= np.minimum(1.0, FARTHEST * self.length / np.maximum(far, 1e-9))[:, None]
        number = np.rint(own / CUBE).astype(np.int64) + MIDDLE
        cubes: Ints = (number[:, 0] << 42) + (number[:, 1] << 21) + number[:, 2]
        return cubes

    def near(self, cubes: Ints, how: Guiding, start: Floats) -> ReachSolution:
        """The solutions of cubes (P,), for reaches that start at (P, K, 3) where joints are held."""
        known, row = np.unique(cubes, return_inverse=True)
        found = self._solved(known).rows(row)
        return replace(found, angles=self._held(found.angles, start), held=how.back(found.held))

    def beyond(self, cubes: Ints, how: Guiding, start: Floats, most: float) -> Lead:
        """How far outward the solutions of cubes (P,) get, up to `most` [m]; arguments as `near`."""
        known, row = np.unique(cubes, return_inverse=True)
        lead = self._led(known, most).rows(row)
        return replace(lead, angles=self._held(lead.angles, start), held=how.back(lead.held))

    def _held(self, angles: Floats, start: Floats) -> Floats:
        """The angles (P, K, 3), those of joints that are held as at the start."""
        return np.where(self.link.free_of >= 0, angles, start)

    def _task(self, cubes: Ints) -> LimbTask:
        """The standard limb reaching for the middles of cubes (G,), its base at the origin."""
        mask = (1 << 21) - 1
        number = np.stack([cubes >> 42, (cubes >> 21) & mask, cubes & mask], axis=1) - MIDDLE
        count = len(cubes)
        angles = seed_angles(self.body, self.limb.base, self.limb.end, self.limb.free)
        return LimbTask(
            body=self.body,
            limb=self.limb,
            link=self.link,
            seeds=new_seeds(angles, 1),
            joints=self.joints,
            who=np.zeros(count, np.int64),
            pose=np.zeros(count, np.int64),
            held=np.zeros((count, len(self.body.joints), 4)),
            base=np.repeat(np.eye(3, 4)[None], count, axis=0),
            goal=goals_of(CUBE * number),
        )

    def _solved(self, cubes: Ints) -> ReachSolution:
        """The solutions of cubes (G,), which rise; those that are not known are solved."""
        known, found = self.known
        new = np.setdiff1d(cubes, known)
        if len(new):
            task = self._task(new)
            more = solve_reaches(task, cold(task, np.zeros((len(new), len(self.joints), 3))), AGAIN)
            found = more if found is None else found.joined(more)
            known = np.concatenate([known, new])
            order = np.argsort(known)
            known, found = known[order], found.rows(order)
            self.known = known, found
        assert found is not None
        return found.rows(np.searchsorted(known, cubes))

    def _led(self, cubes: Ints, most: float) -> Lead:
        """The solutions of cubes (G,), which rise, led outward up to `most` [m]."""
        known, lead = self.led.get(most, (np.zeros(0, np.int64), None))
        new = np.setdiff1d(cubes, known)
        if len(new):
            task = self._task(new)
            found = self._solved(new)
            ways = task.goal[:, :3] - self._root()
            more = outward(task, found, ways, no_lead(task), most=most)
            reached = found.numbers[:, 0] <= REACHED
            more = replace(more, ways=np.where(reached, more.ways, -np.inf))
            lead = more if lead is None else lead.joined(more)
            known = np.concatenate([known, new])
            order = np.argsort(known)
            known, lead = known[order], lead.rows(order)
            self.led[most] = known, lead
        assert lead is not None
        return lead.rows(np.searchsorted(known, cubes))

    def _root(self) -> Floats:
        """(3,) [m] the shoulder or hip of the standard limb."""
        place = self.joints.index(root_joint(self.body, self.limb))
        root: Floats = self.link.at_parent[0, : place + 1].sum(axis=0)
        return root


def guides_of(body: Body, limb: Limb) -> Guides | None:
    """The guides of a limb; None for one that is not of a human body's hand or foot."""
    return _guides(body, limb.name, limb.base, limb.end, limb.free)


@kept_with_topology
def _guides(body: Body, name: str, base: int, end: int, free: tuple[int, ...]) -> Guides | None:
    side, _, grip = name.partition(" ")[0], "", name.rpartition(", ")[2]
    if side not in ("left", "right") or grip not in _TIPS:
        return None
    mirror = np.array([1.0, 1.0 if side == "left" else -1.0, 1.0])
    joints = joints_between(body, base, end)
    names = [body.joints[joint] for joint in joints]
    steps = np.array([_STEPS.get("L" + n[1:] if n[0] in "LR" else n, _NO_STEP) for n in names])
    steps *= mirror
    first = min(joints.index(joint) for joint in free)
    steps[: first + 1] = 0.0
    tip = (np.array(_TIPS[grip]) * mirror)[None]
    aside = np.zeros((1, len(body.sphere_names)), dtype=np.bool_)
    standard = Limb(name, base, end, free, tip, np.zeros((1, 3)), (), aside)
    link = linkage(body[0], base, end, free, tip, standard.pointing)
    link = link._replace(at_parent=steps[None].copy(), at_child=np.zeros((1, len(joints), 3)))
    return Guides(body[0], standard, link)


def _lengths(link: Linkage) -> Floats:
    """(B,) [m] the length of a chain in one line, from its first free joint to the tip."""
    first = int(link.free_joint.min())
    length = np.zeros(len(link.tip))
    for k in range(first + 1, len(link.axes)):
        length += _size(link.at_parent[:, k] - link.at_child[:, k - 1])
    return length + _size(link.tip - link.at_child[:, -1])


def _size(vectors: Floats) -> Floats:
    """(B,) lengths of vectors (B, 3), to the last bit as of each alone."""
    size: Floats = np.sqrt(vectors[:, 0] ** 2 + vectors[:, 1] ** 2 + vectors[:, 2] ** 2)
    return size
