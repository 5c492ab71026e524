"""Hands of spheres whose fingers close on what they hold.

A hand has a palm and five digits: thumb, index, middle, ring and little finger. A digit is a chain of
three links that bend in one plane; that plane turns sideways and, of the thumb, rolls. The links are
shares of the hand's length, the radii and the knuckles' places shares of its breadth: people of one
length differ in breadth. Numbers and ranges: rule set hand_greiner [1]_.

Axes of a hand: the origin at the middle of the wrist crease, x along the middle finger, z out of the
back of the hand, y to the left. So the thumb of a right hand is on the side of +y, and a left hand
is its mirror image to the last bit.

A grasp closes digit by digit and joint by joint by conservative advancement: a joint turns by the
least of (distance of a sphere) / (the greatest speed of that sphere), which can't pass through
anything, until a sphere touches or the joint is at its limit.

References
----------
.. [1] T. M. Greiner (1991), Hand anthropometry of U.S. Army personnel, NATICK/TR-92/011.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.study.rules import load_rule_set
from workbench.model.arrays import Bools, Floats
from workbench.model.population import check_plausible
from workbench.model.quaternions import cross
from workbench.model.rule_set import RuleSet

__all__ = [
    "DIGITS",
    "TOUCH",
    "ClosedHand",
    "Gap",
    "Grasp",
    "Hand",
    "close_hand",
    "close_on_cylinder",
    "grasp",
    "grasps",
    "thickest_cylinder",
]

DIGITS = ("thumb", "index", "middle", "ring", "little")
"""The digits, in the order of all arrays."""
Gap = Callable[[Floats], Floats]
"""Signed distances (M,) [m] of points (M, 3) [m] in the hand's axes to what is held, negative in it."""
TOUCH = 1e-4
"""A sphere nearer than this [m] touches."""
_THICKEST = 0.02
"""[m] Thickest glove."""
_AT = np.array([0, 0, 0, 1, 1, 2, 2, 2])
"""The link that each of the eight spheres of a digit is on."""
_ALONG = np.array([0, 1 / 3, 2 / 3, 0, 1 / 2, 0, 1 / 2, 1])
"""How far along that link."""
_SIDE = np.array([0.0, 1.0, 1.0, -1.0, -1.0])
"""The side to which a finger spreads: the thumb's, or the other."""
_OPENINGS = 5
"""Postures in which a digit that begins within what is held is tried, more and more open."""
_MOST_STEPS = 60
"""Steps in which a joint closes at most; where it is not done then, a gap is told."""
_BARS = 0.2
"""A sphere nearer to a bar than this share of the hand's breadth bars its way: a thumb may lie on the
fingers around it."""
_HALVINGS = 8
"""Halvings of a step in which the thickest cylinder is found: to 0.01 mm."""


@dataclass(frozen=True, eq=False)
class Grasp:
    """What a hand does with a control.

    Parameters
    ----------
    name
        As in the rule set hand_grasps.
    begin, end
        (5, 5) [rad] by digit: flexion of the three joints, sideways, roll; where closing begins, and
        where it ends at the latest.
    meets
        (6,) shares of the palm and of the tips of the five digits in the grip point.
    way
        (3,) unit vector, in the axes of a right hand, of the way the hand is brought there.
    words
        What it is and the strength that its force takes.
    """

    name: str
    begin: Floats
    end: Floats
    meets: Floats
    way: Floats
    words: str


@cache
def _rules() -> RuleSet:
    return load_rule_set("hand_greiner")


@cache
def _grasp_rules() -> RuleSet:
    return load_rule_set("hand_grasps")


def grasps() -> tuple[str, ...]:
    """Name the grasps there are."""
    known = _grasp_rules().values
    return tuple(name for name in known if f"{name}_at" in known)


def grasp(name: str) -> Grasp:
    """Read a grasp of the rule set hand_grasps.

    Raises
    ------
    InputError
        If there is none of this name.
    """
    if name not in grasps():
        raise InputError(f"no grasp {name!r}; {one_of(name, grasps())}")
    rules = _grasp_rules()
    angles = rules.shaped(name, 5, 10)
    way = rules.shaped(f"{name}_way", 3)
    meets = rules.shaped(f"{name}_at", 6)
    words = rules.values[name].called
    return Grasp(name, angles[:, :5], angles[:, 5:], meets, way / np.linalg.norm(way), words)


@dataclass(frozen=True)
class Hand:
    """A hand by its size.

    Parameters
    ----------
    length
        [m] wrist crease to the tip of the middle finger.
    breadth
        [m] across the knuckles, without the thumb.
    glove
        [m] thickness of what is worn on it.
    side
        "right" or "left".

    Raises
    ------
    InputError
        If no hand is so long or broad, or a glove is no thickness.
    """

    length: float
    breadth: float
    glove: float = 0.0
    side: str = "right"

    def __post_init__(self) -> None:
        check_plausible({"hand_length": self.length, "hand_breadth": self.breadth})
        if not 0.0 <= self.glove <= _THICKEST:
            given = 1000 * self.glove
            raise InputError(f"hand.glove: expected 0 to {1000 * _THICKEST:g} mm, got {given:g} mm")
        if self.side not in ("left", "right"):
            raise InputError(f"hand.side: expected 'left' or 'right', got {self.side!r}")

    @property
    def mirror(self) -> Floats:
        """(3,) what brings a right hand's points to this hand."""
        return np.array([1.0, 1.0 if self.side == "right" else -1.0, 1.0])

    @cached_property
    def radius(self) -> Floats:
        """(S,) [m] of the 40 spheres of the digits, then of those of the palm."""
        share = _rules()["radii"]
        ends = share[:, _AT] + _ALONG * (share[:, _AT + 1] - share[:, _AT])
        return np.concatenate([ends.ravel(), _rules()["palm"][:, 3]]) * self.breadth + self.glove

    def joints(self, angles: Floats) -> Floats:
        """Place the joints and the tips of the digits.

        Parameters
        ----------
        angles
            (..., 5, 5) [rad] flexion of three joints, sideways (fingers: away from the middle
            finger, less as the knuckle bends; thumb: out of the palm) and roll.

        Returns
        -------
        Floats
            (..., 5, 4, 3) [m].
        """
        return self._joints(angles) * self.mirror

    def centres(self, angles: Floats) -> Floats:
        """Place the spheres (..., S, 3) [m], in the order of `radius`; angles: as of `joints`."""
        digits = self._spheres(self._joints(angles))
        flat = digits.reshape(*digits.shape[:-3], 40, 3)
        palm = self._palm
        palm = np.broadcast_to(palm, (*flat.shape[:-2], *palm.shape))
        return np.concatenate([flat, palm], axis=-2) * self.mirror

    def grip_point(self, chosen: Grasp) -> Floats:
        """(3,) [m] where a hand meets a control before it closes."""
        tips = self._joints(chosen.begin)[:, 3] * self.mirror
        point: Floats = chosen.meets @ np.concatenate([self.palm_point[None], tips])
        return point

    @property
    def palm_point(self) -> Floats:
        """(3,) [m] the point of the palm's skin at the middle of what is gripped: .39 of the length
        from the wrist, as wrist to centre of grip is of men and women."""
        radius = _rules()["radii"][2, 0] * self.breadth + self.glove
        return np.array([0.39 * self.length, 0.0, -radius])

    def _joints(self, angles: Floats, planes: _Planes | None = None) -> Floats:
        """(..., 5, 4, 3) [m] of a right hand; planes: as of `_planes`, where they are known."""
        plane = _planes(angles) if planes is None else planes
        bent = np.cumsum(angles[..., :3], axis=-1)[..., None]
        palmward = np.sin(bent) * plane.palmward[..., None, :]
        links = np.cos(bent) * plane.ahead[..., None, :] + palmward
        joints = np.empty((*links.shape[:-2], 4, 3))
        joints[..., 0, :] = _rules()["roots"] * self._size
        joints[..., 1:, :] = links * (_rules()["links"] * self.length)[..., None]
        found: Floats = np.cumsum(joints, axis=-2)
        return found

    @cached_property
    def _size(self) -> Floats:
        """(3,) [m] what shares along the axes are of."""
        return np.array([self.length, self.breadth, self.breadth])

    @cached_property
    def _palm(self) -> Floats:
        """(K, 3) [m] the spheres of the palm of a right hand."""
        return np.asarray(_rules()["palm"][:, :3] * self._size)

    def _spheres(self, joints: Floats) -> Floats:
        """(..., 5, 8, 3) [m] the spheres of the digits between their joints (..., 5, 4, 3)."""
        begin = joints[..., _AT, :]
        found: Floats = begin + self._share * (joints[..., _AT + 1, :] - begin)
        return found

    @cached_property
    def _share(self) -> Floats:
        """(5, 8, 1) how far along its link each sphere of a digit is; the last one ends at the tip."""
        share = np.tile(_ALONG, (5, 1))
        last = _rules()["links"][:, 2] * self.length
        share[:, 7] -= _rules()["radii"][:, 3] * self.breadth / last
        return share[..., None]


class _Planes(NamedTuple):
    """Unit vectors (..., 5, 3) in which straight digits of a right hand point, and in which they bend."""

    ahead: Floats
    palmward: Floats


def _planes(angles: Floats) -> _Planes:
    """The planes in which each digit bends, of angles (..., 5, 5) [rad]."""
    spread = _SIDE * angles[..., 3] * np.maximum(0.0, 1.0 - angles[..., 0] / (np.pi / 2))
    ahead = np.stack([np.cos(spread), np.sin(spread), np.zeros_like(spread)], axis=-1)
    palmward = np.zeros_like(ahead)
    palmward[..., 2] = -1.0
    # The thumb: raised out of the plane of the palm, its pad as nearly as can be toward the fingers,
    # then rolled about itself: cos(r) p + sin(r) a x p.
    rest = _rules().number("thumb_rest")
    faces = _rules()["thumb_pad"]
    raised = angles[..., 0, 3, None]
    flat = np.array([np.cos(rest), np.sin(rest), 0.0])
    thumb = np.cos(raised) * flat + np.sin(raised) * np.array([0.0, 0.0, -1.0])
    pad = faces - np.sum(faces * thumb, axis=-1, keepdims=True) * thumb
    pad = pad / np.linalg.norm(pad, axis=-1, keepdims=True)
    roll = angles[..., 0, 4, None]
    ahead[..., 0, :] = thumb
    palmward[..., 0, :] = np.cos(roll) * pad + np.sin(roll) * cross(thumb, pad)
    return _Planes(ahead, palmward)


@dataclass(frozen=True, eq=False)
class ClosedHand:
    """A hand that has closed.

    Parameters
    ----------
    hand, grasp
        Of these.
    angles
        (5, 5) [rad], as of `Hand.joints`.
    gap
        (5,) [m] how far the nearest sphere of each digit is from what is held.
    depth
        [m] how deep the deepest sphere of the hand is in it, 0 where none is.
    """

    hand: Hand
    grasp: Grasp
    angles: Floats
    gap: Floats
    depth: float

    @property
    def touching(self) -> Bools:
        """(5,) the digits that touch."""
        return np.asarray(self.gap <= 2 * TOUCH)

    @property
    def centres(self) -> Floats:
        """(S, 3) [m] the spheres, in the order of `Hand.radius`."""
        return self.hand.centres(self.angles)


def close_hand(hand: Hand, chosen: Grasp, gap: Gap) -> ClosedHand:
    """Close a hand on something.

    The fingers close first, then the thumb, which keeps clear of them. Of each the first joint turns,
    then the middle one, which takes the last along, then the last.

    Parameters
    ----------
    hand
        The hand.
    chosen
        What it does.
    gap
        How far points in the hand's axes are from what is held.

    Returns
    -------
    ClosedHand
        Where the digits have come to. Neither the thumb nor the deepest finger is deeper than where
        the grasp begins, or than a touch.

    Raises
    ------
    InputError
        If a grasp is beyond the ranges of the joints.
    """
    _check(chosen)
    rules = _rules()
    coupled = rules.number("last_joint")
    closing = _Closing(hand, gap, _opened(hand, chosen, gap))
    angles = closing.angles
    fingers = slice(1, 5)
    end = chosen.end
    closing.turn(fingers, 0, end[fingers, 0])
    angles[fingers, 0] = _near_neighbours(angles[fingers, 0], rules["knuckles_apart"])
    closing.turn(fingers, 1, end[fingers, 1], last=coupled)
    more = angles[fingers, 2] - coupled * angles[fingers, 1]
    angles[fingers, 1] = _near_neighbours(angles[fingers, 1], rules["middles_apart"])
    angles[fingers, 2] = more + coupled * angles[fingers, 1]
    most = np.minimum(
        end[fingers, 2], coupled * angles[fingers, 1] + rules.number("last_joint_free")
    )
    closing.turn(fingers, 2, most)
    for joint in range(3):
        closing.turn(slice(0, 1), joint, end[:1, joint])
    away = gap(hand.centres(angles)) - hand.radius
    digits = away[:40].reshape(5, 8)
    return ClosedHand(hand, chosen, angles, digits.min(axis=1), max(0.0, -float(away.min())))


def _opened(hand: Hand, chosen: Grasp, gap: Gap) -> Floats:
    """(5, 5) [rad] where closing begins. Digits that move and would begin within what is held are
    opened first, the thumb into the plane of the palm and the fingers backward, together and as far
    as those allow that stay: the least that is clear, or else where the worst is least deep."""
    still = np.all(chosen.begin == chosen.end, axis=1)
    tied = np.where(still[1:], chosen.begin[1:, 0], -np.pi)
    back = np.array(chosen.begin)
    back[1:, 0] = np.maximum(
        _rules()["least"][1:, 0], -_near_neighbours(-tied, _rules()["knuckles_apart"])
    )
    back[0, 3] = 0.0
    back[still] = chosen.begin[still]
    ways = chosen.begin + np.linspace(0.0, 1.0, _OPENINGS)[:, None, None] * (back - chosen.begin)
    centres = hand.centres(ways)
    away = gap(centres.reshape(-1, 3)).reshape(centres.shape[:2]) - hand.radius
    room = np.minimum(away[:, :40].reshape(-1, 5, 8).min(axis=2), TOUCH)
    room[:, still] = TOUCH
    found = np.array(ways[room[:, 1:].min(axis=1).argmax()])
    found[0] = ways[room[:, 0].argmax(), 0]
    return found


def _near_neighbours(bent: Floats, apart: Floats) -> Floats:
    """(4,) [rad] flexion of the fingers, less where a neighbour's is less by more than `apart` (3,)."""
    place = np.concatenate([[0.0], np.cumsum(apart)])
    most = bent[None] + np.abs(place[:, None] - place[None])
    return np.asarray(most.min(axis=1))


@dataclass(frozen=True, eq=False)
class _Closing:
    """A hand that is closing: its angles (5, 5) [rad] are changed in place."""

    hand: Hand
    gap: Gap
    angles: Floats

    def turn(self, digits: slice, joint: int, end: Floats, *, last: float = 0.0) -> None:
        """Turn a joint of some digits (N) on to `end` (N,) [rad] at most, until they touch; the joint
        after it by the share `last` of that."""
        rate = np.zeros(5)
        rate[joint : joint + 1 + bool(last)] = (1.0, last)[: 1 + bool(last)]
        left = np.maximum(end - self.angles[digits, joint], 0.0)
        planes = _planes(self.angles)
        for _ in range(_MOST_STEPS):
            step = np.minimum(self._free(digits, joint, rate, planes), left)
            if not step.any():
                return
            self.angles[digits] += step[:, None] * rate
            left = left - step
            if joint == 0:
                planes = _planes(self.angles)

    def _free(
        self,
        digits: slice,
        joint: int,
        rate: Floats,
        planes: _Planes,
    ) -> Floats:
        """(N,) [rad] how far some digits surely can turn before a sphere touches, 0 where one does.

        A sphere moves by sum_k rate_k |c - j_k| at most for each radian, c its middle and j_k the
        joints that turn; a finger that spreads by s comes back by s / 90 degrees as its knuckle
        bends.
        """
        hand = self.hand
        joints = hand._joints(self.angles, planes)
        centres = hand._spheres(joints)
        radius = hand.radius
        own = centres[digits]
        arm = np.linalg.norm(own[:, :, None] - joints[digits, None, :3], axis=-1)
        spread = rate[0] * np.abs(self.angles[digits, 3]) / (np.pi / 2)
        speed = arm @ rate[:3] + spread[:, None] * arm[:, :, 0]
        away = self.gap((own * hand.mirror).reshape(-1, 3)).reshape(own.shape[:2])
        away = np.minimum(away, _own_hand(hand, centres, radius, digits))
        away = away - radius[:40].reshape(5, 8)[digits]
        moves = (joint <= _AT) & (speed > 1e-9)
        turn = np.where(moves, (away - 0.5 * TOUCH) / np.where(moves, speed, 1.0), np.inf)
        touches = np.any(moves & (away <= TOUCH), axis=1)
        return np.where(touches, 0.0, turn.min(axis=1))


def _own_hand(hand: Hand, centres: Floats, radius: Floats, digits: slice) -> Floats:
    """(N, 8) [m] how far the middles of spheres of some digits are from the hand's other spheres: of
    fingers, beyond the knuckle, from the palm; of the thumb, beyond its metacarpal, from fingers."""
    own = centres[digits]
    if digits.start:
        other = hand._palm
        size = radius[40:]
        beyond = _AT > 0
    else:
        other = centres[1:, 1:].reshape(-1, 3)
        size = radius[:40].reshape(5, 8)[1:, 1:].ravel()
        beyond = np.arange(8) > 3
    away = np.linalg.norm(own[:, :, None] - other, axis=-1) - size
    return np.where(beyond, away.min(axis=2), np.inf)


def _check(chosen: Grasp) -> None:
    """InputError where a grasp is beyond the ranges of the joints."""
    rules = _rules()
    low, high = rules["least"], rules["most"]
    for angles in (chosen.begin, chosen.end):
        beyond = np.argwhere((angles < low - 1e-9) | (angles > high + 1e-9))
        if len(beyond):
            at = tuple(beyond[0].tolist())
            least, most, got = np.degrees([low[at], high[at], angles[at]]).round().tolist()
            raise InputError(
                f"grasp {chosen.name}: {DIGITS[at[0]]}, angle {at[1] + 1}: expected {least:g} to "
                f"{most:g} degrees, got {got:g}"
            )


def close_on_cylinder(hand: Hand, diameter: float, *, chosen: str = "power") -> ClosedHand:
    """Close a hand on a round bar across the palm.

    Parameters
    ----------
    hand
        The hand.
    diameter
        [m] of the bar.
    chosen
        The grasp.

    Returns
    -------
    ClosedHand
        Closed as far as the bar lets it.

    Raises
    ------
    InputError
        If the bar is too thick: palm, fingers and thumb leave a half of its round free, so that it
        could be pulled out. The message names the thickest bar that is held.
    """
    if not 0.0 < diameter < 1.0:
        raise InputError(f"diameter: expected 0 to 1 m, got {diameter:g}")
    most = thickest_cylinder(hand, chosen)
    found = _around(hand, grasp(chosen), diameter)
    if diameter > most or found is None:
        raise InputError(
            f"a cylinder of {1000 * diameter:.0f} mm is too thick for a hand "
            f"{1000 * hand.length:.0f} mm long and {1000 * hand.breadth:.0f} mm broad: palm, fingers "
            f"and thumb do not reach around half of it; {np.floor(1000 * most):.0f} mm at most"
        )
    return found


@lru_cache(maxsize=64)
def thickest_cylinder(hand: Hand, chosen: str = "power") -> float:
    """Find the diameter [m] of the thickest round bar that a hand reaches around by more than a half,
    as of `close_on_cylinder`: all thinner ones are held too."""
    doing = grasp(chosen)
    low, step = 0.0, hand.breadth / 32
    while _around(hand, doing, low + step) is not None:
        low += step
    for _ in range(_HALVINGS):
        step *= 0.5
        if _around(hand, doing, low + step) is not None:
            low += step
    return low


def _around(hand: Hand, doing: Grasp, diameter: float) -> ClosedHand | None:
    """A hand closed on a bar across the palm, None where it leaves a half of its round free.

    The bar touches the palm at its middle, or, thicker, nearer to the fingers, where the open thumb
    has room beside it.
    """
    axis = hand.palm_point - (0.0, 0.0, 0.5 * diameter)

    def gap(points: Floats) -> Floats:
        away = points - axis
        return np.asarray(np.hypot(away[:, 0], away[:, 2]) - 0.5 * diameter)

    begin = hand.centres(doing.begin)
    most = hand.joints(doing.begin)[2, 0, 0] + 0.5 * _rules()["links"][2, 0] * hand.length
    for _ in range(_MOST_STEPS):
        away = gap(begin) - hand.radius
        thumb, palm = max(TOUCH - away[:8].min(), 0.0), max(-away[40:].min(), 0.0)
        if thumb + palm < 1e-9:
            break
        axis += (thumb, 0.0, -palm)
    if axis[0] > most:
        return None
    found = close_hand(hand, doing, gap)
    barring = gap(found.centres[:40]) - hand.radius[:40] < _BARS * hand.breadth
    across = found.centres[:40][barring] - axis
    around = np.sort(np.append(np.arctan2(across[:, 0], across[:, 2]), 0.0))  # the palm is at 0
    free = np.diff(np.append(around, around[0] + 2 * np.pi))
    return found if free.max() < np.pi else None
