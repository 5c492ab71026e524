"""Limbs that reach: a hand or foot, the point of it that arrives, and the joints that the harness
leaves free.

Zones after MIL-STD-1333: 1 shoulders against the seat back, harness locked, no stretch; 2 locked,
the shoulder stretched; 3 unlocked, the trunk leans and twists over a pelvis held by the lap belt.
Grip points are landmarks of the body, so that they follow its measures: the fingertip, the thumb's
tip as thumb-tip reach is measured, the centre of grip as forearm-grip length is measured, on the
surface of the palm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.kept import kept_with_body
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["FEET", "GRIPS", "HANDS", "ZONES", "Limb", "landmarks", "limb", "solids"]

HANDS = ("left hand", "right hand")
FEET = ("left foot", "right foot")
GRIPS = {"hand": ("push", "pinch", "grasp"), "foot": ("ball", "heel")}
ZONES = (1, 2, 3)
_ARM = {1: ("S", "E", "W"), 2: ("C", "S", "E", "W"), 3: ("C", "S", "E", "W")}
_LEG = ("H", "K", "A")


@dataclass(frozen=True, eq=False)
class Limb:
    """A chain of a body that reaches: from segment `base` (held) to segment `end`, the joints
    `free` free.

    tip (3,) [m]: the point that reaches of the first row of a body, pointing (3,): the direction it reaches in, both in the
    frame of `end`. moving: the segments that go along; solid (S,): the spheres that may meet
    obstacles. The fingers of a hand that reaches are not among them: the body holds them straight,
    where a person bends them out of the way.
    """

    name: str
    base: int
    end: int
    free: tuple[int, ...]
    tip: Floats
    pointing: Floats
    moving: tuple[int, ...]
    solid: Bools


def limb(body: Body, name: str, *, grip: str | None = None, zone: int = 1) -> Limb:
    """A hand or foot of a human body.

    name: left hand, right hand, left foot or right foot; grip: push, pinch or grasp of a hand, ball
    or heel of a foot (the first of them where None); zone: 1, 2 or 3 (of a hand). InputError for
    unknown names, and where the body lacks the landmark.
    """
    return _limb(body, name, grip, zone)


@kept_with_body
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
    tip, pointing = _landmark(body[0], (end, grip))
    solid = np.isin(body.sphere_segment, moving)
    if kind == "hand":
        solid &= ~(_beyond_knuckle(body[0], end)[0] & (body.sphere_segment == end))
    return Limb(f"{name}, {grip}", base, end, free, tip[0], pointing[0], moving, solid)


def solids(body: Body, limb: Limb) -> Bools:
    """(B, S) the spheres that may meet obstacles: those of the limb, but of a hand that reaches not
    those farther out than the index knuckle."""
    found = np.repeat(limb.solid[None], len(body), axis=0)
    if len(body) == 1 or limb.name.split()[1].rstrip(",") != "hand":
        return found
    hand = body.sphere_segment == limb.end
    found[:, hand] = ~_beyond_knuckle(body, limb.end)[:, hand]
    return found


def _beyond_knuckle(body: Body, hand: int) -> Bools:
    """(B, S) the spheres that lie farther out than the index knuckle of a hand."""
    top = body.directions[hand, DIRECTIONS.index("top")]
    knuckle = body.centre[:, _row(body, hand, "index knuckle")]
    beyond: Bools = np.einsum("bsi,i->bs", body.centre - knuckle[:, None], top) > 1e-6
    return beyond


def landmarks(body: Body, limb: Limb) -> tuple[Floats, Floats]:
    """(B, 3) the points of a limb that arrive and the ways they point, of all rows of a body."""
    tip, pointing = _landmark(body, (limb.end, limb.name.split(", ")[1]))
    return np.ascontiguousarray(tip), np.ascontiguousarray(pointing)


def _landmark(body: Body, which: tuple[int, str]) -> tuple[Floats, Floats]:
    """(B, 3) the point of a hand or foot (a segment) that arrives, and the way it points, by
    grip."""
    segment, grip = which

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
        known = [known for known in names if known]
        raise InputError(
            f"body {body.name}: {body.segment_names[segment]} has no sphere {name!r}; {one_of(name, known)}"
        )
    return int(body.start[segment]) + names.index(name)
