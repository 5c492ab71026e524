"""Leg strength: how hard people push with a foot before hip, knee or ankle gives way.

A force at the foot loads each joint with its moment, J^T F = T. The isometric moments that joints
exert are curves of the joint's angle [1]_:

    T = c1 m g h cos(c2 (q - c3))

with the body's mass m and stature h. The joint that bears the least force decides. The curve passes
zero within the range of motion; beyond that it is 0 here and told.

References
----------
.. [1] D. E. Anderson, M. L. Madigan and M. A. Nussbaum (2007), Maximum voluntary joint torque as a
   function of joint angle and angular velocity, Journal of Biomechanics 40, 3105-3113.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.files.study.rules import rule_set
from workbench.model.arrays import Bools, Floats, Ints, for_rows
from workbench.model.poses import Placed
from workbench.model.quaternions import cross
from workbench.model.rule_set import RuleSet
from workbench.strain.arm_strength import deviations_below, given_directions
from workbench.strain.working_angles import check_segments, joint_points

__all__ = ["AGES", "FootStrength", "foot_strength", "joint_moments", "largest_push"]

AGES = ("18-25", "55-65", "65+")
JOINTS = ("hip", "knee", "ankle")
_SENSE = (-1.0, 1.0, -1.0)
"""Flexion of hip, knee and ankle turns about minus, plus and minus the left axis of the parent."""
_UNLOADED = 1e-9
"""[m] Lever below which a force does not load a joint."""
_WIDEST, _HALVINGS = 9.0, 60
"""Deviations from the mean between which a share is looked for, and how often they are halved."""


@dataclass(frozen=True, eq=False)
class FootStrength:
    """The strength of one foot of P people in a direction.

    Parameters
    ----------
    mean
        (P,) [N] the force at which the first joint has its mean moment.
    limits
        The joint and its direction that decide, of each person: "knee extension".
    levers
        (P, 3, 2) [m] the levers about hip, knee and ankle of a force along the direction and of one
        across it, positive where it takes their flexors.
    moments, deviation
        (P, 3, 2) [Nm] what these joints exert in the mean in flexion and extension, and the standard
        deviations as shares of it.
    lean
        [rad] how far the push may be from the direction.
    beyond
        (P,) True where the angle of the joint that decides is beyond what its curve holds for.
    version, status
        The model; where its numbers are from, and how sure each is.
    assumed
        What was not stated, in words.
    """

    mean: Floats
    limits: tuple[str, ...]
    levers: Floats
    moments: Floats
    deviation: Floats
    lean: float
    beyond: Bools
    version: str
    status: str
    assumed: tuple[str, ...] = (
        "leg: its weight neither helps nor hinders (assumed)",
        "seat: it gives the reaction (assumed)",
    )

    def capable(self, force: ArrayLike) -> Floats:
        """(P,) the share of such people that exert a force [N], one or (P,).

        That of the weakest joint: who is strong in one is taken to be strong in all. Found by
        halving, since the best push leans otherwise for people of another strength.
        """
        from scipy.special import ndtr

        given = for_rows(force, np.float64, (), rows=len(self.mean), what="force")
        low, high = np.full(len(given), -_WIDEST), np.full(len(given), _WIDEST)
        for _ in range(_HALVINGS):
            score = 0.5 * (low + high)
            enough = self._at(score) >= given
            low, high = np.where(enough, score, low), np.where(enough, high, score)
        return ndtr(low)

    def strength(self, share: float) -> Floats:
        """(P,) [N] what a share of such people exerts at least; never below 0. InputError where that
        is not between 0 and 1."""
        return self._at(np.full(len(self.mean), deviations_below(share)))

    def _at(self, score: Floats) -> Floats:
        """(P,) [N] the force of people so many deviations (P,) below the mean."""
        shares = np.maximum(1.0 - score[:, None, None] * self.deviation, 0.0)
        return largest_push(self.levers, self.moments * shares, self.lean)[0]


def foot_strength(
    placed: Placed,
    side: Literal["left", "right"],
    direction: ArrayLike,
    *,
    male: ArrayLike,
    stature: ArrayLike,
    ages: Literal["18-25", "55-65", "65+"],
    foot: ArrayLike | None = None,
    lean: float = 0.0,
    rules: RuleSet | str = "strain_leg_strength",
) -> FootStrength:
    """Predict the strength of one foot in a direction.

    Parameters
    ----------
    placed
        P postures in the world.
    side
        Which leg.
    direction
        (3,) or (P, 3) in the world, of the force that the foot exerts.
    male
        Whether people are men, one truth value or (P,).
    stature
        [m], one or (P,).
    ages
        The people's ages in years. Those between were not measured.
    foot
        (3,) or (P, 3) [m] where it pushes; the foot's centre of gravity where None.
    lean
        [rad] how far from the direction the push may be in the plane of the leg: a pedal bears what
        presses across its way, and people push along the leg. Less than a quarter of a turn.
    rules
        The curves; a rule set, or the name or path of one.

    Raises
    ------
    InputError
        If the body lacks pelvis or legs, a direction is zero, a stature is not above 0, the lean is
        no part of a quarter of a turn, or a value of the rule set has another shape.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> posed = wb.pose(body, {"RH": {"flexion": 80}, "RK": {"flexion": 40}})
    >>> found = wb.foot_strength(wb.place(body, posed), "right", (0.85, 0, -0.53),
    ...     male=True, stature=1.75, ages="18-25")
    >>> found.mean.round(0), found.limits, found.capable(1500.0).round(2)
    (array([2304.]), ('knee extension',), array([0.92]))
    """
    values = rule_set(rules)
    count = len(placed)
    tall = for_rows(stature, np.float64, (), rows=count, what="stature")
    man = for_rows(male, np.bool_, (), rows=count, what="male")
    if not np.all(tall > 0.0):
        raise InputError("stature: expected more than 0 m")
    legs = "L" if side == "left" else "R"
    names = ("LT", legs + "UL", legs + "LL", legs + "F")
    check_segments(placed, names, "leg strength")
    size = placed.body.mass[placed.person].sum(axis=1) * tall
    rows = 3 * man.astype(np.int64) + AGES.index(ages)
    moment, share = joint_moments(_angles(placed, names), rows, size, rules=values)
    point = _foot_points(placed, names[3]) if foot is None else foot
    at = for_rows(point, np.float64, (3,), rows=count, what="leg strength: foot")
    if not 0.0 <= lean < 0.5 * np.pi:
        raise InputError(
            f"lean: expected 0 or more and less than a quarter of a turn, got {lean:g}"
        )
    way = given_directions(direction, count, "leg strength")
    across = cross(placed.world_from_segment[:, placed.body.segment(names[1]), :, 1], way)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), _UNLOADED)
    levers = np.stack([_levers(placed, names, at, one) for one in (way, across)], axis=2)
    mean, least = largest_push(levers, moment, lean)
    each = np.arange(count)
    joints, senses = least // 2, np.array(["flexion", "extension"])[least % 2]
    return FootStrength(
        mean=mean,
        limits=tuple(f"{JOINTS[j]} {sense}" for j, sense in zip(joints, senses, strict=True)),
        levers=levers,
        moments=moment,
        deviation=share,
        lean=lean,
        beyond=moment[each, joints, least % 2] <= 0.0,
        version=values.description,
        status=values.status(*values.values),
    )


def largest_push(levers: Floats, moments: Floats, lean: float) -> tuple[Floats, Ints]:
    """(P,) [N] the largest force along a direction, and the row (P,) of joint and sense that limits it.

    Who pushes with f along the way and u f across it, |u| <= tan(lean), loads joint j in a sense with
    +-(l_j + a_j u) f <= T_j. So 1 / f is the largest of six lines over u: it is least at an end or
    where two of them cross.

    Parameters
    ----------
    levers
        (P, 3, 2) [m] l and a.
    moments
        (P, 3, 2) [Nm] T in flexion and extension.
    """
    most = np.tan(lean)
    borne = np.maximum(moments, 1e-15)
    lines = (levers[:, :, None, :] * np.array([1.0, -1.0])[:, None] / borne[..., None]).reshape(
        -1, 6, 2
    )
    first, second = np.triu_indices(6, 1)
    apart = lines[:, first] - lines[:, second]
    tilt = np.where(np.abs(apart[..., 1]) > 0.0, apart[..., 1], np.inf)
    ends = np.broadcast_to([-most, 0.0, most], (len(lines), 3))
    across = np.clip(np.concatenate([ends, -apart[..., 0] / tilt], axis=1), -most, most)
    loads = lines[:, None, :, 0] + lines[:, None, :, 1] * across[..., None]
    best = loads.max(axis=2).argmin(axis=1)
    there = loads[np.arange(len(loads)), best]
    load = there.max(axis=1)
    force = np.divide(1.0, load, out=np.full(len(load), np.inf), where=load > _UNLOADED * 1e-9)
    return force, there.argmax(axis=1)


def _foot_points(placed: Placed, foot: str) -> Floats:
    """(P, 3) [m] the centres of gravity of feet."""
    return placed.world_from_segment[:, placed.body.segment(foot), :, 3]


def _levers(placed: Placed, names: tuple[str, ...], point: Floats, way: Floats) -> Floats:
    """(P, 3) [m] the levers of forces at points (P, 3) in unit directions (P, 3) that the foot exerts
    about hip, knee and ankle: axis . ((p - c) x d), positive where it takes their flexors."""
    body = placed.body
    joints = [body.joint(names[1][0] + name) for name in "HKA"]
    parents = [body.segment(name) for name in names[:3]]
    axes = placed.world_from_segment[..., 1][:, parents] * np.array(_SENSE)[:, None]
    arms = point[:, None] - joint_points(placed, joints)
    return np.einsum("pji,pji->pj", axes, cross(arms, way[:, None]))


def joint_moments(
    angles: Floats, rows: Ints, size: Floats, *, rules: RuleSet
) -> tuple[Floats, Floats]:
    """The moments of hip, knee and ankle, and their standard deviations as shares of them.

    Parameters
    ----------
    angles
        (P, 3) [rad] flexion, of the ankle dorsiflexion.
    rows
        (P,) of the tables: three age groups of women, then of men.
    size
        (P,) [kg m] mass times stature.

    Returns
    -------
    moments, shares
        (P, 3, 2) [Nm] in flexion and extension, 0 where the curve is below; (P, 3, 2).
    """
    moments = np.empty((*angles.shape, 2))
    shares = np.empty_like(moments)
    force = rules.number("gravity") * size
    for j, joint in enumerate(JOINTS):
        for way, sense in enumerate(("flexion", "extension")):
            c1, c2, c3, spread = rules.shaped(f"{joint}_{sense}", 6, 4)[rows].T
            curve = np.cos(c2 * (angles[:, j] - c3))
            moments[:, j, way] = c1 * force * np.maximum(curve, 0.0)
            shares[:, j, way] = spread / c1
    return moments, shares


def _angles(placed: Placed, names: tuple[str, ...]) -> Floats:
    """(P, 3) [rad] flexion of hip and knee, dorsiflexion of the ankle, in the parents' middle plane."""
    body = placed.body
    frames = [placed.world_from_segment[:, body.segment(name), :, :3] for name in names]
    found = np.empty((len(placed), 3))
    for j, sense in enumerate(_SENSE):
        between = frames[j].transpose(0, 2, 1) @ frames[j + 1]
        found[:, j] = sense * np.arctan2(between[:, 0, 2], between[:, 2, 2])
    return found
