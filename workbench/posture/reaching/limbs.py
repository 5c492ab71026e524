"""Limbs that reach: a hand or foot, the point of it that arrives, and the joints that the harness
leaves free.

Zones after MIL-STD-1333: 1 shoulders against the seat back, harness locked, no stretch; 2 locked,
the shoulder stretched; 3 unlocked, the trunk leans and twists over a pelvis held by the lap belt.
Grip points are landmarks of the body, so that they follow its measures: the fingertip, the thumb's
tip as thumb-tip reach is measured, the centre of grip as forearm-grip length is measured, on the
surface of the palm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import DIRECTIONS, Body
from workbench.model.kept import kept_by_row

__all__ = [
    "FEET",
    "GRIPS",
    "HANDS",
    "ZONES",
    "Limb",
    "arm_alone",
    "limb",
    "limbs_there",
    "moves_arm_alone",
    "shoulder_held",
    "tighter",
    "with_fingers",
]

HANDS = ("left hand", "right hand")
FEET = ("left foot", "right foot")
GRIPS = {"hand": ("push", "pinch", "grasp"), "foot": ("ball", "heel")}
ZONES = (1, 2, 3)
_ARM = {1: ("S", "E", "W"), 2: ("C", "S", "E", "W"), 3: ("C", "S", "E", "W")}
_LEG = ("H", "K", "A")


@dataclass(frozen=True, eq=False)
class Limb:
    """A chain of the rows of a body that reaches: from a held segment out to the one that arrives.

    A limb is of the body that it was made for: its arrays have a row for each row of that body.
    """

    name: str
    """The limb and its grip in words: "right hand, push"."""
    base: int
    """The segment that is held."""
    end: int
    """The segment that arrives."""
    free: tuple[int, ...]
    """The joints that are free."""
    tip: Floats
    """(B, 3) [m] the point that arrives, in the frame of `end`."""
    pointing: Floats
    """(B, 3) unit vector of the direction that the limb points in, in the frame of `end`."""
    moving: tuple[int, ...]
    """The segments that go along."""
    solid: Bools
    """(B, S) the spheres that may meet obstacles. The fingers of a hand that reaches are not among
    them: the body holds them straight, where a person bends them out of the way."""
    zone: int = 1
    """The harness zone of a hand; 1 of what no harness holds."""

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name, dtype in (("tip", np.float64), ("pointing", np.float64), ("solid", np.bool_)):
            rows = np.atleast_2d(np.array(getattr(self, name), dtype=dtype))
            rows.flags.writeable = False
            object.__setattr__(self, name, rows)

    def __len__(self) -> int:
        return len(self.tip)

    def rows(self, keep: slice | Ints) -> Limb:
        """The limb of some of the rows of the body."""
        return replace(
            self, tip=self.tip[keep], pointing=self.pointing[keep], solid=self.solid[keep]
        )


def limb(body: Body, name: str, *, grip: str | None = None, zone: int = 1) -> Limb:
    """Describe a hand or foot of the rows of a human body.

    Parameters
    ----------
    body
        B rows; the limb is of these.
    name
        "left hand", "right hand", "left foot" or "right foot".
    grip
        "push", "pinch" or "grasp" of a hand, "ball" or "heel" of a foot; the first of them if None.
    zone
        Harness zone 1, 2 or 3 of a hand.

    Raises
    ------
    InputError
        If a name is unknown, or the body lacks the landmark.

    Examples
    --------
    >>> import workbench as wb
    >>> arm = wb.limb(wb.load_body("adult_male"), "right hand", grip="push", zone=2)
    >>> arm.name, len(arm.free)
    ('right hand, push', 4)
    """
    return _limb(body, name, grip, zone)


def limbs_there(body: Body, names: Sequence[str]) -> tuple[str, ...]:
    """Return those of some hands or feet that a body has; all where it has none, so that who asks
    is told which is missing."""
    ends = {"hand": "HN", "foot": "F"}
    there = [name for name in names if body.has(name[0].upper() + ends[name.split()[1]])]
    return tuple(there or names)


def tighter(body: Body, own: Limb) -> Limb | None:
    """Return a limb of a body as the next tighter harness zone leaves it; None in zone 1."""
    if own.zone == 1:
        return None
    name, grip = own.name.split(", ")
    held = limb(body, name, grip=grip, zone=own.zone - 1)
    same = np.array_equal(held.tip, own.tip) and np.array_equal(held.pointing, own.pointing)
    return held if same else replace(held, tip=own.tip, pointing=own.pointing)


def moves_arm_alone(own: Limb) -> bool:
    """Whether a limb is an arm that moves nothing of the trunk."""
    return "hand" in own.name and own.zone < max(ZONES)


def arm_alone(body: Body, own: Limb) -> Limb:
    """Return an arm of a body so that it moves nothing of the trunk."""
    return own if moves_arm_alone(own) else tighter(body, own) or own


def shoulder_held(body: Body, own: Limb) -> Limb:
    """Return an arm of a body so that it moves nothing of trunk and shoulder."""
    held = tighter(body, own)
    return own if held is None else shoulder_held(body, held)


@kept_by_row(Limb.rows)
def with_fingers(body: Body, own: Limb) -> Limb:
    """The same limb of a body with its fingers among the spheres that may meet obstacles."""
    moving = np.isin(body.sphere_segment, own.moving)
    return replace(own, solid=np.repeat(moving[None], len(body), axis=0))


@kept_by_row(Limb.rows)
def _limb(body: Body, name: str, grip: str | None, zone: int) -> Limb:
    """The limb, made once a body."""
    if name not in HANDS + FEET:
        raise InputError(f"no limb {name!r}; {one_of(name, HANDS + FEET)}")
    side = name[0].upper()
    kind = name.split()[1]
    grip = GRIPS[kind][0] if grip is None else grip
    if grip not in GRIPS[kind]:
        raise InputError(f"a {kind} has no grip {grip!r}; {one_of(grip, GRIPS[kind])}")
    if zone not in ZONES:
        raise InputError(f"no zone {zone}; it is 1, 2 or 3")
    if kind == "foot":
        end = body.segment(f"{side}F")
        base = body.segment("LT")
        joints = [side + letter for letter in _LEG]
        more: tuple[str, ...] = ()
    else:
        end = body.segment(f"{side}HN")
        base = body.segment("UT" if zone < 3 else "LT")
        joints = [*(("W", "SP") if zone == 3 else ()), *(side + letter for letter in _ARM[zone])]
        more = ("N", "H") if zone == 3 else ()
    free = tuple(body.joint(joint) for joint in joints)
    moving = tuple(
        sorted({joint + 1 for joint in free} | {body.segment(segment) for segment in more})
    )
    tip, pointing = _landmark(body, end, grip)
    solid = np.repeat(np.isin(body.sphere_segment, moving)[None], len(body), axis=0)
    if kind == "hand":
        hand = body.sphere_segment == end
        solid[:, hand] = ~_beyond_knuckle(body, end)[:, hand]
    held_by = zone if kind == "hand" else 1
    return Limb(f"{name}, {grip}", base, end, free, tip, pointing, moving, solid, held_by)


def _beyond_knuckle(body: Body, hand: int) -> Bools:
    """(B, S) the spheres that lie farther out than the index knuckle of a hand."""
    top = body.directions[hand, DIRECTIONS.index("top")]
    knuckle = body.centre[:, _row(body, hand, "index knuckle")]
    beyond: Bools = np.sum((body.centre - knuckle[:, None]) * top, axis=2) > 1e-6
    return beyond


def _landmark(body: Body, segment: int, grip: str) -> tuple[Floats, Floats]:
    """(B, 3) the point of a hand or foot that arrives by a grip, and the direction it points in."""

    def named(name: str) -> tuple[Floats, Floats]:
        row = _row(body, segment, name)
        return body.centre[:, row], body.radius[:, row : row + 1]

    turn = np.repeat(body.directions[segment][None], len(body), axis=0)
    top, front, down = (turn[:, DIRECTIONS.index(d)] for d in ("top", "front", "bottom"))
    if grip == "push":
        centre, radius = named("index fingertip")
        return centre + radius * top, top
    if grip == "pinch":
        thumb, radius = named("thumb tip")
        index, _ = named("index fingertip")
        between = 0.5 * (thumb + index)
        return between + (_along(thumb - between, top) + radius) * top, top
    if grip == "grasp":
        palm, radius = named("palm")
        knuckle, _ = named("index knuckle")
        between = 0.5 * (palm + knuckle)
        return between + (_along(palm - between, front) + radius) * front, front
    centre, radius = named("ball of foot" if grip == "ball" else "heel")
    return centre + radius * down, down


def _along(arm: Floats, way: Floats) -> Floats:
    along: Floats = np.sum(arm * way, axis=1, keepdims=True)
    return along


def _row(body: Body, segment: int, name: str) -> int:
    """Number of a named sphere of a segment; InputError where there is none."""
    names = body.sphere_names[body.spheres(segment)]
    if name not in names:
        if not names:
            raise InputError(
                f"body {body.name} has no {body.segment_names[segment]}: it is missing, so it can "
                "neither reach, hold nor push anything"
            )
        known = [known for known in names if known]
        raise InputError(
            f"body {body.name}: {body.segment_names[segment]} has no sphere {name!r}; {one_of(name, known)}"
        )
    return int(body.start[segment]) + names.index(name)
