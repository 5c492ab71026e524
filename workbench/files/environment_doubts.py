"""What of an environment is probably a mistake: seats, controls and rules that do not fit the mesh.

Nothing of it is an error: an environment may be odd on purpose, and its key `accepted` puts doubts
away. Each sentence gives the distance, and the unit of length that would explain it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from workbench.errors import one_of
from workbench.files.environment_own import grippable
from workbench.files.schema import metres_in
from workbench.files.seat_doubts import (
    floor_doubts,
    place_of,
    point_doubts,
    rest_doubts,
    twice_doubts,
)
from workbench.geometry.entering import Entered, entered, travel_ways
from workbench.geometry.ground import ground_of
from workbench.geometry.polygon import winding_number
from workbench.geometry.surfaces import surface_gap
from workbench.model.arrays import Floats, xyz
from workbench.model.environment import Doubt, Environment, Seat

__all__ = [
    "NearPart",
    "box_gap",
    "environment_doubts",
    "near_part",
    "part_box",
    "unknown_segments",
]

_SEAT_AWAY = 0.3
"""A seat reference point farther [m] than this from the box of its cushion is not that seat's:
cushions are 0.1 m thick and their backs stand up to 0.2 m behind them."""
_NEAR = 0.1
"""A unit explains a place where it would be this near [m] to what it belongs to."""
_CONTROL_AWAY = 0.06
"""A control farther [m] than this from its part is not on it: a fist is 0.1 m thick, and its grip
centre may lie beside the part that it closes about."""
_ON = 0.01
"""A control as near [m] as this to a part is on it: it was put there by a click or by its figures."""
_FREE = {"hand": 0.3, "foot": 0.1}
"""What is farther [m] from every part is on nothing that hands, or feet, use: a pedal is as large as a
foot at most."""
_CUSHION = (0.2, 1.0)
"""Least and greatest depth [m] of what is sat on, its smaller extent from above: of a child's seat,
of a lounge with its back."""
_PEDALS = 1.5
"""A pedal farther [m] ahead of a seat or behind it is another seat's."""
_SHORT = 0.0002
"""A travel or a depth that is shorter [m] than this, and not 0, was typed in another unit."""


def environment_doubts(environment: Environment, *, moved: bool) -> list[Doubt]:
    """Return what is probably a mistake.

    Parameters
    ----------
    environment
        Complete, with seats, controls and rules.
    moved
        Whether meshes are moved to their places, so that no unit of length explains a distance.
    """
    odd = list(_seats_odd(environment))
    return [
        *_seats_away(environment, moved, {doubt.about for doubt in odd}),
        *_cushion_sizes(environment),
        *odd,
        *_seats_turned(environment),
        *point_doubts(environment.seats, ground_of(environment), environment.points),
        *_short_lengths(environment),
        *_travels_blocked(environment),
        *_controls_away(environment),
        *_controls_on_nothing(environment),
        *_gripped_panels(environment),
        *_shared_pieces(environment),
    ]


def unknown_segments(environment: Environment, segments: Iterable[str]) -> list[str]:
    """Return a sentence for each rule about a segment that none of some bodies has.

    segments: those of the bodies. What no body has is allowed to nobody.
    """
    known = list(dict.fromkeys(segments))
    doubts = []
    for rule in environment.allowances:
        for name in rule.segments:
            if name not in known and name != "all":
                doubts.append(
                    f"part {environment.parts[rule.part]!r}: contact is allowed to {name!r}, which "
                    f"is no segment of a body; {one_of(name, known)}"
                )
    for seat in environment.seats:
        doubts += _unknown_rests(seat, known)
    return list(dict.fromkeys(doubts))


def _unknown_rests(seat: Seat, known: Sequence[str]) -> Iterator[str]:
    """What rests on a seat and is no segment."""
    for what, rest in (("cushion", seat.cushion), ("back", seat.back)):
        for name in rest.segments:
            if name not in known and name != "all":
                yield (
                    f"seat {seat.name!r}: {name!r} rests on its {what}, which is no segment of a "
                    f"body; {one_of(name, known)}"
                )


def _corners(environment: Environment, part: str) -> Floats:
    """(T, 3, 3) [m] the triangles of a part."""
    return environment.triangle_corners(environment.part_index(part))


def part_box(environment: Environment, part: str) -> Floats:
    """Return the box (2, 3) [m] of a part: its least and its greatest corner."""
    corners = _corners(environment, part).reshape(-1, 3)
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def _seats_away(environment: Environment, moved: bool, told: Set[str]) -> Iterator[Doubt]:
    """Seats whose reference point is not at their cushion: a person is seated by the numbers of the
    YAML file, and must meet the mesh there. told: what is doubted already, with where they would be
    right."""
    for seat in environment.seats:
        box = part_box(environment, seat.cushion.part)
        gap = box_gap(box, seat.srp)
        if gap > _SEAT_AWAY:
            hint = ": a wrong unit of length, or a wrong place?"
            about = place_of(seat.name)
            if not moved and (units := _mistaken_units(box, seat.srp)):
                used, right = units
                hint = f": the mesh would be there if its unit were {right} where {used} is taken"
            elif about in told:
                continue
            yield Doubt(
                about,
                f"seat {seat.name!r}: its reference point is {gap:.3g} m away from its cushion "
                f"{seat.cushion.part!r}{hint}",
            )


def _cushion_sizes(environment: Environment) -> Iterator[Doubt]:
    """Cushions that nobody can sit on."""
    for seat in environment.seats:
        depth = np.ptp(part_box(environment, seat.cushion.part), axis=0)[:2].min()
        least, greatest = _CUSHION
        if not least <= depth <= greatest:
            yield Doubt(
                f"cushion of seat {seat.name}",
                f"seat {seat.name!r}: its cushion {seat.cushion.part!r} is {depth:.3g} m deep, and "
                f"{least:g} to {greatest:g} m is plausible: a wrong unit of length, or another "
                f"part?",
            )


def _seats_odd(environment: Environment) -> Iterator[Doubt]:
    """Seats whose cushion, back and floor do not go together."""
    if not environment.seats:
        return
    ground = ground_of(environment)
    for seat in environment.seats:
        cushion, back = (
            environment.triangle_corners(environment.part_index(rest.part))
            if rest.part
            else np.empty((0, 3, 3))
            for rest in (seat.cushion, seat.back)
        )
        found = list(rest_doubts(seat, cushion, back))
        yield from found
        if place_of(seat.name) not in [doubt.about for doubt in found]:
            yield from floor_doubts(seat, ground)  # of a seat in its place
    yield from twice_doubts(environment.seats)


def _seats_turned(environment: Environment) -> Iterator[Doubt]:
    """Seats that look the other way than their back, the pedals or the whole place says."""
    feet = [control for control in environment.controls if control.for_feet]
    aft = all(abs(seat.yaw) > 0.75 * np.pi for seat in environment.seats)
    for seat in environment.seats:
        ahead = np.array([np.cos(seat.yaw), np.sin(seat.yaw), 0.0])
        ways = {one.name: float((np.array(one.at) - seat.srp) @ ahead) for one in feet}
        near = {name: way for name, way in ways.items() if abs(way) < _PEDALS}
        said = ["all seats face backward"] if aft else []
        if near and max(near.values()) < 0.0:
            name = max(near, key=lambda name: near[name])
            said.append(
                f"the pedal {name!r} lies {-1e3 * near[name]:.0f} mm behind its reference point"
            )
        if seat.back.part not in ("", seat.cushion.part):
            middles = [part_box(environment, p).mean(axis=0) for p in seat.parts]
            before = float((middles[1] - middles[0]) @ ahead)
            if before > _NEAR:
                said.append(f"its back lies {1e3 * before:.0f} mm ahead of its cushion")
        if said:
            yield Doubt(
                f"heading of seat {seat.name}",
                f"seat {seat.name!r}: {', and '.join(said)}: is its yaw, or the forward axis of the "
                f"meshes, the other way?",
            )


def _short_lengths(environment: Environment) -> Iterator[Doubt]:
    """Lengths that were typed in metres where millimetres are meant."""
    for seat in environment.seats:
        for name, ends in (("forward", seat.travel_forward), ("up", seat.travel_up)):
            if 0 < ends[1] - ends[0] < _SHORT:
                yield Doubt(
                    f"travel of seat {seat.name}",
                    f"seat {seat.name!r}: its travel {name} is {1e3 * (ends[1] - ends[0]):.2g} mm "
                    f"long: a wrong unit of length?",
                )
    for one in environment.adjustments:
        long = one.travel[1] - one.travel[0]
        if not one.turns and long < _SHORT:
            yield Doubt(
                f"travel of adjustment {one.name}",
                f"adjustment {one.name!r}: its travel is {1e3 * long:.2g} mm long: a wrong unit of "
                f"length?",
            )
    for rule in environment.allowances:
        if 0 < rule.depth < _SHORT:
            part = environment.parts[rule.part]
            yield Doubt(
                f"contact with part {part}",
                f"part {part!r}: contact is allowed down to {1e3 * rule.depth:.2g} mm: a wrong "
                f"unit of length?",
            )


def _travels_blocked(environment: Environment) -> Iterator[Doubt]:
    """Seats whose parts enter others within their travel, deepest first."""
    for seat in environment.seats:
        worst: tuple[Entered, Floats] | None = None
        ways = travel_ways(seat, ((0.0, 0.0),) * 2, (seat.travel_forward, seat.travel_up))
        for start, by in ways:
            found = entered(environment, seat.moves, by, start=start)
            if found and (worst is None or found.depth > worst[0].depth):
                worst = found, start + by
        if worst is not None:
            one, at = worst
            forward = 1e3 * float(at[:2] @ (np.cos(seat.yaw), np.sin(seat.yaw)))
            more = "farther " if one.touched else ""
            yield Doubt(
                f"travel of seat {seat.name}",
                f"seat {seat.name!r}: {forward:.0f} mm forward and {1e3 * at[2]:.0f} mm up, which is "
                f"in its travel, put {one.part!r} {1e3 * one.depth:.0f} mm {more}into {one.other!r}: "
                f"is the travel right, or does {one.other!r} go along ('moves')?",
            )


def _controls_away(environment: Environment) -> Iterator[Doubt]:
    """Controls that are not on the part that they name."""
    shown = [name for k, name in enumerate(environment.parts) if not environment.hidden[k]]
    for control in environment.controls:
        own = near_part(environment, control.at, control.own_parts)
        if own is None or own.gap <= _CONTROL_AWAY:
            continue
        hint = _factor_hint(part_box(environment, control.part), control.at)
        near = near_part(environment, control.at, shown)
        if not hint:
            hint = f", which is nearest at {own.place}"
        if near is not None and near.gap < own.gap:
            hint += (
                f"; the nearest part is {near.name!r}, {1e3 * near.gap:.0f} mm away at {near.place}"
            )
        yield Doubt(
            f"place of control {control.name}",
            f"control {control.name!r} is {1e3 * own.gap:.0f} mm away from its part "
            f"{control.part!r}{hint}",
        )


def _controls_on_nothing(environment: Environment) -> Iterator[Doubt]:
    """Controls that name no part, and are at one that a hand would have to enter."""
    shown = [name for k, name in enumerate(environment.parts) if not environment.hidden[k]]
    bare = [control for control in environment.controls if not control.part]
    small = [name for name in shown if bare and grippable(_corners(environment, name))]
    for control in bare:
        near = near_part(environment, control.at, small)
        if near is not None and near.gap <= _ON:
            yield Doubt(
                f"part of control {control.name}",
                f"control {control.name!r} names no part and is at {near.name!r}, which nobody may "
                f"enter to use it: is that its 'part'?",
            )
            continue
        near = near_part(environment, control.at, shown)
        if near is not None and near.gap > _FREE["foot" if control.for_feet else "hand"]:
            yield Doubt(
                f"place of control {control.name}",
                f"control {control.name!r} is in free air: the nearest part, {near.name!r}, is "
                f"{1e3 * near.gap:.0f} mm away, at {near.place}: a wrong unit of length, or a wrong "
                f"place?",
            )


def _gripped_panels(environment: Environment) -> Iterator[Doubt]:
    """Controls that a hand closes about, on parts that are too large for that."""
    for control in environment.controls:
        if not control.part or control.grip not in ("grasp", "pinch"):
            continue
        if not grippable(_corners(environment, control.part)):
            size = float(np.ptp(part_box(environment, control.part), axis=0).max())
            yield Doubt(
                f"grip of control {control.name}",
                f"control {control.name!r} is gripped ({control.grip}) on {control.part!r}, which "
                f"is {size:.2g} m large and counts as a panel that no hand may enter: 'split' "
                f"makes parts of what is connected in it, and 'allow' says what may be entered",
            )


def _shared_pieces(environment: Environment) -> Iterator[Doubt]:
    """Controls on different parts that are both stated to have another one for their own."""
    for one, other in combinations(environment.controls, 2):
        both = [part for part in one.own_parts if part in other.own_parts]
        if both and one.part != other.part:
            yield Doubt(
                f"pieces of controls {one.name} and {other.name}",
                f"controls {one.name!r} and {other.name!r} stand on {one.part!r} and {other.part!r}, "
                f"and both have {both[0]!r} for their own: hands at either may be in it, and it "
                f"moves with neither; state it as the 'part' of the one that it moves with",
            )


def _factor_hint(box: Floats, point: Sequence[float]) -> str:
    """That a wrong unit explains a point, where it does and no other point would do; "" else, as where
    it is at the box (2, 3) [m] of its part already."""
    # a part at the origin, or larger than it is away from there, has points of most other units too
    telling = float(np.linalg.norm(box.mean(axis=0))) > float(np.linalg.norm(np.ptp(box, axis=0)))
    if box_gap(box, point) <= _NEAR or box_gap(box, (0.0, 0.0, 0.0)) <= _NEAR or not telling:
        return ""
    units = sorted(metres_in.values())
    factors = sorted({one / other for one in units for other in units if one != other})
    gaps = [float(np.linalg.norm(np.array(point) * f - box.mean(axis=0))) for f in factors]
    factor = factors[int(np.argmin(gaps))]
    if box_gap(box, np.array(point) * factor) > _NEAR:
        return ""
    return f": it would be there if its numbers were {factor:.4g} times as large"


@dataclass(frozen=True)
class NearPart:
    """A part: how far [m] it is from a point, 0 where the point is inside a solid, and its point
    [m] that is nearest."""

    name: str
    gap: float
    at: tuple[float, float, float]

    @property
    def place(self) -> str:
        """Its nearest point in words, in mm."""
        return f"({', '.join(f'{round(1e3 * value) + 0}' for value in self.at)}) mm"


def near_part(
    environment: Environment, at: Sequence[float], parts: Iterable[str]
) -> NearPart | None:
    """Find which of some parts is nearest to a point (3,) [m]; None where there are none.

    Parts are asked in the order of their boxes, until a box is farther than what was found.
    """
    point = np.array(at)
    boxes = sorted((box_gap(part_box(environment, name), at), name) for name in parts)
    best: NearPart | None = None
    for gap, name in boxes:
        if best is not None and gap >= best.gap:
            break
        triangles = _corners(environment, name)
        # a triangle whose box is farther than the nearest corner of all is not the nearest one
        corner = np.linalg.norm(triangles - point, axis=2).min()
        beside = np.maximum(triangles.min(axis=1) - point, point - triangles.max(axis=1))
        close = np.linalg.norm(np.maximum(beside, 0.0), axis=1) <= corner * (1.0 + 1e-9)
        found = surface_gap(np.tile(point, (1, 3, 1)), triangles[close])
        away = found.distance
        if environment.solid[environment.part_index(name)] and away > 0.0:
            inside = abs(winding_number(*at, triangles, 0, len(triangles))) > 0.5
            away = 0.0 if inside else away
        if best is None or away < best.gap:
            best = NearPart(name, away, xyz(found.end))
    return best


def _mistaken_units(box: Floats, point: Iterable[float]) -> tuple[str, str] | None:
    """The unit that was taken for the box (2, 3) [m] of a cushion, and the one in which it would be
    one, at a point; None where there is no such unit."""
    at = tuple(point)
    for used, taken in metres_in.items():
        for right, metres in metres_in.items():
            there = box * metres / taken
            plausible = _CUSHION[0] <= np.ptp(there, axis=0)[:2].min() <= _CUSHION[1]
            if used != right and plausible and box_gap(there, at) <= _NEAR:
                return used, right
    return None


def box_gap(box: Floats, point: Iterable[float]) -> float:
    """Return the distance [m] of a point to a box (2, 3)."""
    at = np.array(tuple(point))
    return float(np.linalg.norm(np.maximum(np.maximum(box[0] - at, at - box[1]), 0.0)))
