"""Arm strength: how hard people push, pull and lift with one hand, by the Arm Force Field [1]_.

A small net gives the mean strength of women without gravity from the place of the hand in the frame
of the shoulder and the direction of the force; the weight of the arm then helps or hinders.
Strength is distributed normally with a stated variation, and men have a stated multiple. A left arm
is the mirror image of a right one, gravity included. Trunk, legs and seat are not in it: who is
pushed out of the seat is stopped earlier.

References
----------
.. [1] N. J. La Delfa and J. R. Potvin (2017), The 'Arm Force Field' method to predict manual arm
   strength based on only hand location and force direction, Applied Ergonomics 59A, 410-421.
   Coefficients: copyright N. La Delfa and J. Potvin 2025, CC BY 4.0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.files.study.rules import rule_set
from workbench.model.arguments import check_fields
from workbench.model.arrays import ArrayKind, Bools, Floats, for_rows, freeze_fields
from workbench.model.poses import Placed
from workbench.model.quaternions import cross
from workbench.model.rule_set import RuleSet
from workbench.strain.working_angles import check_segments, joint_points

__all__ = [
    "Arms",
    "HandStrength",
    "arm_net",
    "arms_of",
    "deviations_below",
    "given_directions",
    "hand_strength",
]

_ALONG = 1e-9
"""Part of a unit direction below which it counts as none, so that rounding gives no sign."""


@dataclass(frozen=True, eq=False)
class Arms:
    """One arm of P people: (P, 3) [m] points in the world, z upward, and the masses (P,) [kg] of the
    people.

    hand: where it holds; other_shoulder: the joint of the other side; neck, low_back: on the spine
    at the top and the bottom of the trunk (C7/T1 and L5/S1).
    """

    side: Literal["left", "right"]
    shoulder: Floats
    elbow: Floats
    wrist: Floats
    hand: Floats
    other_shoulder: Floats
    neck: Floats
    low_back: Floats
    mass: Floats

    def __post_init__(self) -> None:
        check_fields(self)
        count = len(self.shoulder)
        points = ("shoulder", "elbow", "wrist", "hand", "other_shoulder", "neck", "low_back")
        arrays: dict[str, ArrayKind] = dict.fromkeys(points, (np.float64, (count, 3)))
        freeze_fields(self, arrays | {"mass": (np.float64, (count,))}, "arms")

    def __len__(self) -> int:
        return len(self.shoulder)


@dataclass(frozen=True, eq=False)
class HandStrength:
    """The strength of the hands of P people in a direction.

    Parameters
    ----------
    mean
        (P,) [N] of people of that sex, without gravity.
    deviation
        (P,) [N] the standard deviation.
    gravity
        (P,) [N] what the weight of the arm adds, negative where it hinders.
    extrapolated
        (P,) True where the hand is outside the places that the net was made from.
    version, status
        The model; where its numbers are from, how sure each is, and the credit that travels with
        every figure made from it.
    """

    mean: Floats
    deviation: Floats
    gravity: Floats
    extrapolated: Bools
    version: str
    status: str

    def capable(self, force: ArrayLike) -> Floats:
        """(P,) the share of such people that exert a force [N], one or (P,): 1 - Phi((F - g - m) / s)."""
        from scipy.special import ndtr

        given = for_rows(force, np.float64, (), rows=len(self.mean), what="force")
        return ndtr((self.mean + self.gravity - given) / self.deviation)

    def strength(self, share: float) -> Floats:
        """(P,) [N] what a share of such people exerts at least; never below 0. InputError where that
        is not between 0 and 1."""
        force: Floats = self.mean - deviations_below(share) * self.deviation + self.gravity
        return np.maximum(force, 0.0)


def arms_of(
    placed: Placed, side: Literal["left", "right"], *, hand: ArrayLike | None = None
) -> Arms:
    """Find the points of an arm that its strength depends on.

    The top of the trunk is the pivot of the neck, its bottom the joint of the waist: nearest to
    C7/T1 and L5/S1 of the joints there are.

    Parameters
    ----------
    placed
        P postures in the world.
    side
        Which arm.
    hand
        (3,) or (P, 3) [m] where it holds; the hand's centre of gravity, near its knuckles, where
        None.

    Raises
    ------
    InputError
        If the body lacks trunk or arms, or has no mass.
    """
    check_segments(
        placed,
        ("LT", "CT", "UT", "N", "LSM", "RSM", "LUA", "RUA", "LLA", "RLA", "LHN", "RHN"),
        "arms",
    )
    body = placed.body
    own, other = ("L", "R") if side == "left" else ("R", "L")
    names = (own + "S", own + "E", own + "W", other + "S", "NP", "W")
    shoulder, elbow, wrist, opposite, neck, back = (
        joint_points(placed, [body.joint(name)])[:, 0] for name in names
    )
    mass = body.mass[placed.person].sum(axis=1)
    if not np.all(mass > 0.0):
        raise InputError(f"body {body.name} has no mass, so the weight of its arms is not known")
    held = placed.world_from_segment[:, body.segment(own + "HN"), :, 3] if hand is None else hand
    point = for_rows(held, np.float64, (3,), rows=len(placed), what="arms: hand")
    return Arms(side, shoulder, elbow, wrist, point, opposite, neck, back, mass)


def hand_strength(
    arms: Arms,
    direction: ArrayLike,
    *,
    male: ArrayLike,
    rules: RuleSet | str = "strain_arm_force_field",
) -> HandStrength:
    """Predict the strength of one hand in a direction.

    Parameters
    ----------
    arms
        The arms of P people, see `arms_of`.
    direction
        (3,) or (P, 3) in the world, of the force that the hand exerts.
    male
        Whether people are men, one truth value or (P,).
    rules
        The net; a rule set, or the name or path of one.

    Raises
    ------
    InputError
        If a direction is zero, shoulders or spine are in one place, or a value of the rule set has
        another shape.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> posed = wb.pose(body, {"RS": {"flexion": 40}, "RE": {"flexion": 80}})
    >>> found = wb.hand_strength(wb.arms_of(wb.place(body, posed), "right"), (1, 0, 0), male=False)
    >>> found.mean.round(0), found.capable(80.0).round(2), found.extrapolated
    (array([176.]), array([0.97]), array([False]))
    """
    values = rule_set(rules)
    way = given_directions(direction, len(arms), "hand strength")
    man = for_rows(male, np.bool_, (), rows=len(arms), what="male")
    frame = _shoulder_frame(arms)
    place = np.einsum("pij,pj->pi", frame, arms.hand - arms.shoulder)
    local = np.einsum("pij,pj->pi", frame, way)
    local = np.where(np.abs(local) < _ALONG, 0.0, local)
    mean = arm_net(place, local, values) * np.where(man, values.number("men"), 1.0)
    box = values.shaped("trained_least", 3), values.shaped("trained_most", 3)
    return HandStrength(
        mean=mean,
        deviation=values.number("variation") * mean,
        gravity=_gravity(arms, way, values),
        extrapolated=np.any((place < box[0]) | (place > box[1]), axis=1),
        version=values.description,
        status=values.status(*values.values),
    )


def deviations_below(share: float) -> float:
    """How many standard deviations below the mean is what a share of people have at least; InputError
    where that is not between 0 and 1."""
    from scipy.special import ndtri

    if not 0.0 < share < 1.0:
        raise InputError(f"share: expected more than 0 and less than 1, got {share:g}")
    return float(ndtri(share))


def given_directions(direction: ArrayLike, count: int, what: str) -> Floats:
    """(P, 3) unit vectors of one direction or of (P, 3); InputError for one that is zero."""
    way = for_rows(direction, np.float64, (3,), rows=count, what=f"{what}: direction")
    length = np.linalg.norm(way, axis=1, keepdims=True)
    if not np.all(length > 0.0):
        raise InputError(f"{what}: a force needs a direction, got (0, 0, 0)")
    return way / length


def _shoulder_frame(arms: Arms) -> Floats:
    """(P, 3, 3) rows up, forward and outward.

    Outward along both shoulders; forward = trunk x right, up = right x forward, for either side: a
    left arm's frame is the mirror image of a right one's.
    """
    outward = _unit(arms.shoulder - arms.other_shoulder)
    right = outward if arms.side == "right" else -outward
    forward = _unit(cross(arms.neck - arms.low_back, right))
    return np.stack([cross(right, forward), forward, outward], axis=1)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    if not np.all(length > 1e-9):
        raise InputError("arms: shoulders, neck and low back must be at different places")
    return vectors / length


def arm_net(place: Floats, force: Floats, rules: RuleSet) -> Floats:
    """(P,) [N] the mean strength of women without gravity.

    Parameters
    ----------
    place
        (P, 3) [m] of the hand up, forward and outward of the shoulder.
    force
        (P, 3) its unit direction in the same frame.
    """
    u, a, o = place.T
    fu, fa, fo = force.T
    level, side, ahead = np.hypot(a, o), np.hypot(u, o), np.hypot(u, a)
    turns = [a * fo - o * fa, o * fu - u * fo, u * fa - a * fu]
    arm = np.sqrt(turns[0] ** 2 + turns[1] ** 2 + turns[2] ** 2)
    first = [u, a, o, level, side, ahead, fu, fa, fo, *turns, arm, arm**2, arm**3]
    inputs = np.stack([*first, level * fu, side * fa, ahead * fo], axis=1)
    scaled = rules.shaped("gain", 18) * (inputs - rules.shaped("offset", 18)) - 1.0
    hidden = np.tanh(rules.shaped("b1", 13) + scaled @ rules.shaped("w1", 13, 18).T)
    out = rules.number("b2") + hidden @ rules.shaped("w2", 13)
    newton = (out + 1.0) / rules.number("out_gain") + rules.number("out_offset")
    height = np.where(np.abs(u) <= rules.number("level"), 0.0, np.sign(u))
    signs = 27 * (height + 1) + 9 * (np.sign(fa) + 1) + 3 * (np.sign(fu) + 1) + np.sign(fo) + 1
    code = signs.astype(np.int64)
    least, most = rules.shaped("clip_least", 81)[code], rules.shaped("clip_most", 81)[code]
    return np.clip(newton, least, most)


def _gravity(arms: Arms, way: Floats, rules: RuleSet) -> Floats:
    """(P,) [N] what the weight of the arm adds in directions (P, 3).

    The moment M of the weights about the shoulder acts at the hand r as a force of |M| / |r| along
    M x r.
    """
    upper, lower, hand = rules.shaped("centre_shares", 3)
    starts = (arms.shoulder, arms.elbow, arms.wrist)
    ends = (arms.elbow, arms.wrist, arms.hand)
    shares = zip(starts, ends, (upper, lower, hand), strict=True)
    centres = np.stack([a + share * (b - a) for a, b, share in shares], axis=1)
    weight = np.zeros((len(arms), 3, 3))
    weight[..., 2] = -rules.number("gravity") * arms.mass[:, None] * rules.shaped("mass_shares", 3)
    moment = cross(centres - arms.shoulder[:, None], weight).sum(axis=1)
    reach = arms.hand - arms.shoulder
    toward = cross(moment, reach)
    length = np.linalg.norm(toward, axis=1, keepdims=True)
    unit = np.divide(toward, length, out=np.zeros_like(toward), where=length > 0.0)
    size = np.linalg.norm(moment, axis=1) / np.maximum(np.linalg.norm(reach, axis=1), 1e-9)
    return size * np.sum(unit * way, axis=1)
