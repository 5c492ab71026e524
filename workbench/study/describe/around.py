"""What is about the occupant of a seat: above the head, before the knees, under the feet.

Rays go from where head and knees of a median man are. The parts that they meet first are those
that a clearance is asked from.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.files.environment_doubts import part_box
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment
from workbench.sight.rays import first_hits
from workbench.study.describe.at_controls import SeatFrame, Sitter
from workbench.study.describe.control_words import words_of
from workbench.study.feet_on_floor import BROAD

__all__ = ["Around", "around", "floor_below"]

HEAD = (-0.09, 0.04)
"""The middle of the head is so far [m] ahead of and above the eyes."""
ROOF = 0.6
"""What is farther [m] from the middle of the head is not asked about."""
KNEES = ((0.50, 0.16, 0.22), (0.50, -0.16, 0.22), (0.62, 0.14, 0.0), (0.62, -0.14, 0.0))
"""Knees and shins, ahead, to the left and above the seat reference point [m]."""
PANEL = 0.4
"""What is farther [m] from knees and shins is not asked about."""
FEET = ((0.50, 0.1), (0.50, -0.1), (0.65, 0.1), (0.65, -0.1), (0.80, 0.1), (0.80, -0.1))
"""Where feet may stand, ahead and to the left [m]."""
DROP = 0.8
"""A floor that is farther [m] below the seat is none to stand on."""
UNEVEN = 0.1
"""What is higher [m] than the middle of the floor is a step, not a slope."""
COAMING = {
    "panel",
    "dash",
    "dashboard",
    "glareshield",
    "glare",
    "coaming",
    "cowl",
    "cowling",
    "hood",
    "bonnet",
    "fascia",
    "instrumententafel",
    "armaturenbrett",
    "haube",
    "tableau",
    "capot",
    "cruscotto",
    "cofano",
    "tablero",
}
"""What one looks out over is called so."""
AHEAD = 2.5
"""A coaming is no farther [m] ahead of the eyes."""


@dataclass(frozen=True, eq=False)
class Around:
    """What is about an occupant.

    above, before, over: the parts above the head, before the knees, and that one looks out over.
    rests: those parts of `above` and `before` that the occupant also sits or stands on. floor:
    height [m], None where nothing is under the feet.
    """

    above: tuple[str, ...]
    before: tuple[str, ...]
    over: tuple[str, ...]
    rests: frozenset[str]
    floor: float | None


def around(environment: Environment, sitter: Sitter) -> Around:
    """Find what is about the occupant of a seat."""
    frame = sitter.frame
    seat = frame.seat
    eye = np.array(environment.points[sitter.eyes] if sitter.eyes else seat.nominal_eye)
    held = {*sitter.hands.values(), *sitter.feet.values()}
    touched = {one.part for one in environment.controls if one.name in held or one.for_feet}
    fixed = _visible(environment, seat.moves)
    stood_on, floor = floor_below(environment, frame, fixed)
    rests = {*seat.parts, *stood_on}
    head = eye + HEAD[0] * frame.ahead + np.array([0.0, 0.0, HEAD[1]])
    steep = _upright_fan(frame.ahead, np.radians([35.0, 55.0, 75.0, 90.0]), _turns(180.0))
    low = _upright_fan(frame.ahead, np.radians([15.0]), _turns(90.0))
    above = _met(environment, head[None], np.concatenate([steep, low]), ROOF, fixed)
    knees = np.array([frame.world(*place) for place in KNEES])
    fan = _upright_fan(frame.ahead, np.radians([-10.0, 10.0, 40.0, 70.0]), _turns(60.0))
    hittable = fixed & ~np.isin(environment.parts, list(touched | set(sitter.wheels)))
    before = _met(environment, knees, fan, PANEL, hittable)
    return Around(
        tuple(above),
        tuple(before),
        tuple(_looked_over(environment, frame, eye)) if sitter.eyes else (),
        frozenset(rests & {*above, *before}),
        environment.points[sitter.heels][2] if sitter.heels else floor,
    )


def _upright_fan(ahead: Floats, rises: Floats, turns: Floats) -> Floats:
    """(R, 3) unit directions at angles of elevation, each at all angles [rad] about the vertical
    from straight `ahead` (3,)."""
    aside = np.array([-ahead[1], ahead[0], 0.0])
    rise, turn = (axis.ravel() for axis in np.meshgrid(rises, turns, indexing="ij"))
    level = np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * aside
    found: Floats = np.cos(rise)[:, None] * level
    found[:, 2] = np.sin(rise)
    return found


def _turns(most: float) -> Floats:
    """Angles [rad] from straight ahead to both sides, 30 degrees apart, the greatest in degrees."""
    found: Floats = np.radians(np.arange(-most, most + 1.0, 30.0))
    return found


def _visible(environment: Environment, without: Iterable[str]) -> Bools:
    """(K,) the shown parts without some."""
    found: Bools = ~environment.hidden & ~np.isin(environment.parts, list(without))
    return found


def _met(
    environment: Environment, origins: Floats, ways: Floats, length: float, among: Bools
) -> list[str]:
    """The parts that rays from each origin meet first."""
    starts = np.repeat(origins, len(ways), axis=0)
    hits = first_hits(
        environment, starts, np.tile(ways, (len(origins), 1)), length=length, among=among
    )
    return [environment.parts[part] for part in hits.parts]


def floor_below(
    environment: Environment, frame: SeatFrame, among: Bools
) -> tuple[list[str], float | None]:
    """What is under the feet of an occupant: parts, and the height [m] of the highest place there;
    None where nothing is."""
    starts = np.array([frame.world(ahead, left, 0.1) for ahead, left in FEET])
    down = np.tile([0.0, 0.0, -1.0], (len(starts), 1))
    pedals = {one.part for one in environment.controls if one.for_feet and one.part}
    pedals = {part for part in pedals if _breadth(environment, part) <= BROAD}
    hits = first_hits(
        environment,
        starts,
        down,
        length=DROP + 0.1,
        among=among & ~np.isin(environment.parts, list(pedals)),
    )
    met = np.isfinite(hits.distance)
    if not met.any():
        return [], None
    heights = starts[met, 2] - hits.distance[met]
    low = heights < frame.srp[2] - 0.03  # else it is the cushion's own front
    if not low.any():
        return [], None
    parts = [environment.parts[part] for part in np.unique(hits.part[met][low])]
    middle = float(np.median(heights[low]))
    return parts, float(heights[low & (heights <= middle + UNEVEN)].max())


def _breadth(environment: Environment, part: str) -> float:
    """The smaller extent [m] of a part as seen from above."""
    return float(np.ptp(part_box(environment, part), axis=0)[:2].min())


def _looked_over(environment: Environment, frame: SeatFrame, eye: Floats) -> list[str]:
    """The parts by name that lie before the eyes and below them, in the seat's upright plane."""
    found = []
    for part, name in enumerate(environment.parts):
        if environment.hidden[part] or COAMING.isdisjoint(words_of(name)):
            continue
        way = environment.triangle_corners(part).reshape(-1, 3) - eye
        ahead = way @ frame.ahead
        left = way @ frame.left
        if (
            len(way)
            and 0.1 < ahead.max() < AHEAD
            and left.min() < 0 < left.max()
            and way[:, 2].max() < 0.05
        ):
            found.append(name)
    return found
