"""Stretch the segments of known people until they measure and weigh what they should.

The components of the family alone do not reach every measure. What is left is closed by factors
along the three axes of each segment and a taper along it, alike left and right, as small as can be.
A rig's marker is no joint: joints move to the heights of their landmarks, and the flesh around knee,
ankle and elbow goes along by the stretch of its segments; fore and aft, joints lie within the flesh
where a sitter's lengths have them.
The change is carried into the family: an affine function of the coefficients that has each known
person's own change at that person.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from human.anchors import Family, density, heights
from human.basis import Basis, cells, mirrored, volumes
from human.known import Known
from human.skeleton import BETWEEN, JOINTS, OTHER_JOINT, SEGMENTS
from workbench.body.scaling.measure import lengths

__all__ = ["GROUPS", "Changed", "carried_into", "changed", "skin_change", "stretched"]

Floats = NDArray[np.float64]
GROUPS = ("LT", "CT", "UT", "N", "H", "SM", "UA", "LA", "HN", "UL", "LL", "F")
PER_GROUP = 4
"""Parameters of a group of segments: changes of the factors along x, y, z, and the taper."""
MOVED = {
    "LH": (0.014, 0.03),
    "LK": (0.03, 0.003),
    "LA": (0.002, 0.008),
    "LS": (0.002, 0.02),
    "LE": (0.002, 0.008),
    "LW": (0.002, 0.01),
    "NP": (0.002, 0.01),
}
"""Joints that move within the flesh, forward and up, with the standard deviations [m]; the pelvis's
joint goes with the hips. A knee hardly moves up: its cap is at its height."""
STRETCHES = len(GROUPS) * PER_GROUP
COUNT = STRETCHES + 2 * len(MOVED) + 1
"""Parameters of a person: those of the groups, the moves [m] of the joints, and how far [m] the
flesh below the knees lies further forward against that above them."""
SHIFT = 0.012
"""Standard deviation [m] of how far that flesh lies forward."""
STILL = 1e-5
"""All these standard deviations [m] for people of whom no landmarks are known."""
LEAST = 0.75
"""Share of its radius that a joint's sphere keeps where the joint moves."""
SPREAD = np.array([0.05, 0.05, 0.04, 0.05])
ROUND = 0.04
"""Standard deviations of the changes of a segment, and of the difference of the two across it."""
LEVELS = ("fine", "medium")
ROUNDS = 14
STEP = 1e-2
HIPS = 0.002
"""Tolerance [m] of how far the hip joints are apart."""
HEIGHT = 0.0005
"""Tolerance [m] of the height of a joint."""
WHOLE = 0.002
PART = 0.05
"""Tolerances of the mass of the whole body and of a segment, as shares."""


@dataclass(frozen=True, eq=False)
class Changed:
    """Sphere centres and radii by level, joints (J, 3) and origins (N, 3) of one person, in the
    world of the zero pose [m]."""

    spheres: dict[str, tuple[Floats, Floats]]
    joint: Floats
    origin: Floats


def _group(segment: int) -> int:
    name = SEGMENTS[segment]
    return GROUPS.index(name if name in GROUPS else name[1:]) if segment else 0


def _long_axis(segment: int) -> int:
    return 0 if SEGMENTS[segment] in ("LF", "RF") else 2


@dataclass(frozen=True, eq=False)
class _Frame:
    """The stretch of each segment about its origin: factors (N, 3), taper (N,), middle and half
    (N,) of its extent along its long axis [m]."""

    factor: Floats
    taper: Floats
    middle: Floats
    half: Floats

    @classmethod
    def of(cls, basis: Basis, z: Floats, values: Floats) -> _Frame:
        """values (COUNT,): the changes of each group first."""
        segment = basis.levels["fine"].segment
        centre = basis.at("fine_centre", z) - basis.at("origin", z)[segment]
        count = len(SEGMENTS)
        middle = np.zeros(count)
        half = np.ones(count)
        for n in range(1, count):
            along = centre[segment == n, _long_axis(n)]
            middle[n] = 0.5 * (along.max() + along.min())
            half[n] = max(0.5 * float(np.ptp(along)), 1e-3)
        group = np.array([_group(n) for n in range(count)])
        changes = values[:STRETCHES].reshape(-1, PER_GROUP)
        factor = 1.0 + changes[group, :3]
        taper = changes[group, 3].copy()
        factor[0] = 1.0
        taper[0] = 0.0
        return cls(factor, taper, middle, half)

    def points(self, local: Floats, segment: NDArray[np.int64]) -> Floats:
        """Points (n, 3) in their segments' frames (n,), stretched."""
        axis = np.array([_long_axis(n) for n in range(len(SEGMENTS))])[segment]
        rows = np.arange(len(local))
        along = (local[rows, axis] - self.middle[segment]) / self.half[segment]
        factor = self.factor[segment] + (self.taper[segment] * along)[:, None]
        factor[rows, axis] = self.factor[segment, axis]
        return local * factor

    def radii(self, local: Floats, radius: Floats, segment: NDArray[np.int64]) -> Floats:
        """Radii (n,) of spheres at places (n, 3): by the mean of the factors across."""
        axis = np.array([_long_axis(n) for n in range(len(SEGMENTS))])[segment]
        rows = np.arange(len(local))
        along = (local[rows, axis] - self.middle[segment]) / self.half[segment]
        across = 0.5 * (self.factor[segment].sum(axis=1) - self.factor[segment, axis])
        return radius * (across + self.taper[segment] * along)


def _moves(values: Floats) -> Floats:
    """(J, 3) [m] how far values (COUNT,) move the joints within the flesh, alike left and right."""
    moves = np.zeros((len(JOINTS), 3))
    for name, move in zip(MOVED, values[STRETCHES:-1].reshape(-1, 2), strict=True):
        joint = JOINTS.index(name)
        moves[[joint, OTHER_JOINT[joint]], ::2] = move
    moves[JOINTS.index("PV")] = moves[JOINTS.index("LH")]
    return moves


def changed(basis: Basis, z: Floats, values: Floats) -> Changed:
    """The person with coefficients z (K,), changed by values (COUNT,); the feet stay on the
    floor."""
    frame = _Frame.of(basis, z, values)
    joint = basis.at("joint", z)
    origin = basis.at("origin", z)
    place = origin.copy()
    moved = joint.copy()
    for j, name in enumerate(JOINTS):
        parent, child = (np.array([SEGMENTS.index(n)]) for n in BETWEEN[name].split())
        moved[j] = place[parent[0]] + frame.points(joint[j] - origin[parent], parent)[0]
        place[child[0]] = moved[j] - frame.points(joint[j] - origin[child], child)[0]
        if name[1:] == "K":
            place[child[0], 0] += values[-1]
    moves = _moves(values)
    moved = moved + moves
    spheres = {}
    for level, one in basis.levels.items():
        segment = one.segment
        local = basis.at(f"{level}_centre", z) - origin[segment]
        radius = basis.at(f"{level}_radius", z)
        centre = place[segment] + frame.points(local, segment)
        tied = np.flatnonzero(one.joint >= 0)
        centre[tied] = moved[one.joint[tied]]
        size = frame.radii(local, radius, segment)
        # a joint's sphere that moves within the flesh stays within where it was, or nearly
        away = np.linalg.norm(moves[one.joint[tied]], axis=1)
        size[tied] = np.maximum(size[tied] - away, LEAST * size[tied])
        spheres[level] = centre, size
    fall = _lowest(basis.at("fine_centre", z), basis.at("fine_radius", z)) - _lowest(
        *spheres["fine"]
    )
    up = np.array([0.0, 0.0, fall])
    place[1:] += up
    lifted = {level: (centre + up, radius) for level, (centre, radius) in spheres.items()}
    return Changed(lifted, moved + up, place)


def _lowest(centre: Floats, radius: Floats) -> float:
    return float((centre[:, 2] - radius).min())


def skin_change(basis: Basis, z: Floats, values: Floats, skin: tuple[Floats, Floats]) -> Floats:
    """(P, 3) how far the points of a skin (P, 3) with shares (P, N) move."""
    point, share = skin
    frame = _Frame.of(basis, z, values)
    origin = basis.at("origin", z)
    new = changed(basis, z, values).origin
    moved = np.zeros_like(point)
    for n in range(1, len(SEGMENTS)):
        segment = np.full(len(point), n)
        part = new[n] + frame.points(point - origin[n], segment)
        moved += share[:, n, None] * part
    moved += share[:, :1] * point
    change: Floats = moved - point
    return change


class _Person:
    """A known person at the levels whose mean is to measure right."""

    def __init__(self, basis: Basis, z: Floats, families: dict[str, Family], known: Known) -> None:
        self.basis = basis
        self.z = z
        self.families = families
        self.known = known
        self.heavy = np.array([density(n) if n != "STG" else 0.0 for n in SEGMENTS])

    def measured(self, values: Floats) -> Floats:
        """(m + H + 1,) the measures [m] and the heights of the known joints, means of the levels, and
        how far the hip joints are apart."""
        one = changed(self.basis, self.z, values)
        names = list(self.known.measures)
        rows = []
        for level, family in self.families.items():
            manikin = family.base.changed(family.shape(*one.spheres[level], one.joint, one.origin))
            found = lengths(manikin, names) | heights(manikin, list(self.known.heights))
            rows.append([manikin.value(length) for length in found.values()])
        apart = one.joint[JOINTS.index("LH"), 1] - one.joint[JOINTS.index("RH"), 1]
        return np.append(np.mean(rows, axis=0), apart)

    def masses(self, values: Floats) -> Floats:
        """(N,) [kg] volume times density of each segment: means of the levels."""
        one = changed(self.basis, self.z, values)
        rows = []
        for level in self.families:
            centre, radius = one.spheres[level]
            part = cells(centre, radius)
            rows.append(volumes(self.basis.levels[level], centre, radius, *part)[0])
        return np.mean(rows, axis=0) * self.heavy

    def wanted_masses(self) -> tuple[Floats, Floats, Floats]:
        """Rows (M, N) of sums of masses, what they should be (M,) [kg], tolerances (M,)."""
        rows = [np.ones(len(SEGMENTS))]
        wanted = [self.known.mass]
        give = [WHOLE * self.known.mass]
        for name, mass in self.known.masses.items():
            rows.append(np.eye(len(SEGMENTS))[SEGMENTS.index(name)])
            wanted.append(mass)
            give.append(PART * mass)
        return np.array(rows), np.array(wanted), np.array(give)


def stretched(basis: Basis, z: Floats, families: dict[str, Family], known: Known) -> Floats:
    """The changes (COUNT,) with which a person has the known measures, masses and joints, as nearly
    as the least change allows."""
    person = _Person(basis, z, families, known)
    values = np.zeros(COUNT)
    joints = list(known.heights.values())
    aims = np.array([*(value for value, _ in known.measures.values()), *joints, known.hips])
    give = [tolerance for _, tolerance in known.measures.values()]
    give = np.array([*give, *(HEIGHT for _ in joints), HIPS])
    sums, masses, mass_give = person.wanted_masses()
    unit = STEP * np.eye(COUNT)
    here = person.masses(values)
    heavier = np.array([(person.masses(row) - here) / STEP for row in unit]).T
    least = _price(moving=bool(joints))
    for turn in range(ROUNDS):
        now = person.measured(values)
        slope = np.array([(person.measured(values + row) - now) / STEP for row in unit]).T
        weight = person.masses(values)
        rows = [least, slope / give[:, None], (sums @ heavier) / mass_give[:, None]]
        gap = [
            -least @ values,
            (aims - now) / give,
            (masses - sums @ weight) / mass_give,
        ]
        step = np.linalg.lstsq(np.concatenate(rows), np.concatenate(gap), rcond=None)[0]
        values = values + (0.7 if turn < ROUNDS // 2 else 0.35) * step
    return values


def _price(*, moving: bool) -> Floats:
    """Rows whose squares are the cost of changes (COUNT,); joints stay in the flesh unless moving."""
    spread = np.concatenate([np.tile(SPREAD, len(GROUPS)), np.ravel(list(MOVED.values())), [SHIFT]])
    if not moving:
        spread[STRETCHES:] = STILL
    rows = list(np.eye(COUNT) / spread[:, None])
    for g, name in enumerate(GROUPS):
        axes = [1, 2] if name == "F" else [0, 1]
        row = np.zeros(COUNT)
        row[PER_GROUP * g + axes[0]] = 1.0 / ROUND
        row[PER_GROUP * g + axes[1]] = -1.0 / ROUND
        rows.append(row)
    return np.array(rows)


def carried_into(basis: Basis, anchors: Floats, changes: list[Changed]) -> Basis:
    """The basis that has each known person's change at that person's coefficients (A, K), and
    between and beyond them an affine function of the coefficients, the least that does."""
    rows = np.column_stack([np.ones(len(anchors)), anchors])
    weight = np.linalg.pinv(rows)
    table = dict(basis.table)

    def added(key: str, values: list[Floats]) -> None:
        mean, parts = table[key]
        stacked = np.array(
            [value - basis.at(key, z) for value, z in zip(values, anchors, strict=True)]
        )
        part = np.tensordot(weight, stacked, axes=1)
        table[key] = mean + part[0], parts + part[1:]

    added("joint", [one.joint for one in changes])
    added("origin", [one.origin for one in changes])
    for level in basis.levels:
        added(f"{level}_centre", [one.spheres[level][0] for one in changes])
        added(f"{level}_radius", [one.spheres[level][1] for one in changes])
    return Basis(mirrored(table, basis.levels), basis.levels, basis.share)
