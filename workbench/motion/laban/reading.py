"""A motion of a body as a score of direction signs: what each part does from rest to rest, and
where it ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.laban import PARTS, Movement, Score, Sign, nearest_sign
from workbench.model.poses import Poses
from workbench.model.quaternions import conjugate, from_matrices, multiply, rotate, shortest
from workbench.motion.laban.strokes import Stroke, strokes

__all__ = ["read_motion_score"]

_GRID = 0.25
"""Beats are told in quarters."""
_LEAST = 2.0 * np.sin(np.radians(10.0))
"""Directions that change by less than 20 degrees do not move."""
_STRAIGHT = np.cos(np.radians(20.0))
_DRAWN_IN = 0.97
"""A hinge bent by this share of its range has drawn its limb in."""
_BENT = np.radians(25.0)
_RAISED = np.radians(-15.0)
_ON_GROUND = 0.03
_UNDER = 0.2
"""[m] A foot this low carries the body, where its ankle is this near below the hip."""
_DOWN = np.array([0.0, 0.0, -1.0])
_UP = np.array([0.0, 0.0, 1.0])


def read_motion_score(
    body: Body, motion: Poses, *, tempo: float, step: float = Score.step
) -> Score:
    """The score of a motion: parts that move by 20 degrees or more, to the sign nearest to where
    they end.

    Directions are those of the body's own cross of axes. Arms and legs that end straight are told
    as a whole, others by their parts. Legs that carry the body tell the level of the support, where
    the pelvis goes its direction. Beats are told in quarters, each no shorter than one. InputError
    where nothing moves so far, UsageError for a tempo that is not 1 to 1000 beats a minute.
    """
    if not 1 <= tempo <= 1000:
        raise UsageError(f"tempo {tempo:g}: 1 to 1000 beats a minute are possible")
    seen = _Seen(body, motion)
    found: list[tuple[str, Sign, Stroke]] = []
    for part, ends in (("trunk", ("LT", "UT")), ("head", ("UT", "H"))):
        way = seen.way(ends[0], ends[1], _UP)
        found += [
            (part, nearest_sign(way[s.last]), s) for s in strokes(way, seen.time, least=_LEAST)
        ]
    carried = []
    for side in ("left", "right"):
        found += _limb(seen, side, "arm")
        found += _limb(seen, side, "leg")
        carried += _carried(seen, side[0].upper())
    found += _support(seen, carried, step)
    beat = 60.0 / tempo
    rows = []
    for part, sign, stroke in found:
        begin, end = (
            _GRID * round((t - seen.time[0]) / beat / _GRID) for t in (stroke.begin, stroke.end)
        )
        rows.append(Movement(part, sign, 1.0 + begin, max(end - begin, _GRID)))
    if not rows:
        raise InputError(
            "nothing moves far enough for a score: 20 degrees or a quarter of a step are needed"
        )
    return Score(
        tuple(sorted(rows, key=lambda m: (m.begin, PARTS.index(m.part)))), float(tempo), step
    )


@dataclass(frozen=True, eq=False)
class _Carried:
    """A leg that bends or stretches under the body."""

    stroke: Stroke
    level: str


class _Seen:
    """A motion's segments: how they are turned, and which feet are on the ground."""

    def __init__(self, body: Body, motion: Poses) -> None:
        self.body = body
        self.time = motion.clock
        world = []
        lowest = []
        feet = []
        for first in range(0, len(motion), 1024):
            rows = slice(first, first + 1024)
            placed = place(
                body,
                Poses(motion.rotations[rows], motion.reference, motion.world_from_reference[rows]),
            )
            low = placed.centres[..., 2] - body.radius[0]
            world.append(placed.world_from_segment)
            lowest.append(low.min(axis=1))
            feet.append(
                np.stack(
                    [low[:, body.spheres(body.segment(f))].min(axis=1) for f in ("LF", "RF")],
                    axis=1,
                )
            )
        self.world = np.concatenate(world)
        near = np.stack([self._aside(side) for side in "LR"], axis=1) < _UNDER
        self.grounded: Bools = (
            np.concatenate(feet) - np.concatenate(lowest)[:, None] < _ON_GROUND
        ) & near

    def _aside(self, side: str) -> Floats:
        """(P,) [m] how far an ankle is from below its hip."""
        thigh, foot = (self.world[:, self.body.segment(side + name)] for name in ("UL", "F"))
        hip, ankle = (self.body.joint_in_child[0, self.body.joint(side + name)] for name in "HA")
        apart = thigh[:, :, :3] @ hip + thigh[:, :, 3] - foot[:, :, :3] @ ankle - foot[:, :, 3]
        return np.asarray(np.linalg.norm(apart[:, :2], axis=1))

    def turn(self, segment: str) -> Floats:
        """(P, 4) world from segment."""
        return from_matrices(self.world[:, self.body.segment(segment), :, :3])

    def relative(self, carrier: str, segment: str) -> Floats:
        """(P, 4) carrier from segment."""
        return multiply(conjugate(self.turn(carrier)), self.turn(segment))

    def way(self, carrier: str, segment: str, axis: Floats) -> Floats:
        """(P, 3) where a segment's axis points in its carrier's frame."""
        turn = self.relative(carrier, segment)
        return rotate(turn, np.broadcast_to(axis, (len(turn), 3)))


def _limb(seen: _Seen, side: str, limb: str) -> list[tuple[str, Sign, Stroke]]:
    """The movements of an arm or a leg that do not carry the body."""
    s = side[0].upper()
    carrier, upper, lower = (
        ("UT", s + "UA", s + "LA") if limb == "arm" else ("LT", s + "UL", s + "LL")
    )
    high = seen.way(carrier, upper, _DOWN)
    low = seen.way(carrier, lower, _DOWN)
    swing = shortest(np.broadcast_to(_DOWN, high.shape), high)
    bend = rotate(conjugate(swing), low)
    hinge = seen.body.joint(s + ("E" if limb == "arm" else "K"))
    drawn = np.cos(_DRAWN_IN * seen.body.stops.limits[hinge, 0, 0])
    parts = {f"{side} upper {limb}": (high, high), f"{side} lower {limb}": (bend, low)}
    if limb == "arm":
        tip = seen.way(lower, s + "HN", _DOWN)
        parts[f"{side} hand"] = (tip, seen.way(carrier, s + "HN", _DOWN))
    moves = {part: strokes(rows[0], seen.time, least=_LEAST) for part, rows in parts.items()}
    if limb == "leg":
        foot = seen.grounded[:, "LR".index(s)]
        moves = {
            part: [m for m in rows if not foot[m.first] or not foot[m.last]]
            for part, rows in moves.items()
        }
    inner = [rows[0] for rows in list(parts.values())[1:]]
    told: list[tuple[str, Sign, Stroke]] = []
    for group in _together(moves):
        stroke = next(iter(group.values()))
        at = stroke.last
        straight = all(float(way[at] @ _DOWN) > _STRAIGHT for way in inner)
        alone = not any(
            _overlap(stroke, m) for part, rows in moves.items() if part not in group for m in rows
        )
        first, second = list(parts)[:2]
        if limb == "leg" and foot[at]:
            told.append((f"{side} leg", Sign("place", "low"), stroke))
        elif straight and alone and (first in group or second in group):
            told.append((f"{side} {limb}", nearest_sign(high[at]), stroke))
        elif (
            alone
            and float(bend[at] @ _DOWN) < drawn
            and _drawn_in(limb, list(group) == [second], high[at])
        ):
            told.append((f"{side} {limb}", Sign("place", "middle"), stroke))
        else:
            told += [(part, nearest_sign(parts[part][1][m.last]), m) for part, m in group.items()]
    return told


def _drawn_in(limb: str, hinge_only: bool, upper: Floats) -> bool:
    """True where a bent limb is drawn in to its joint: an arm whose upper part stayed, a leg whose
    foot is below."""
    half = np.arctan2(upper[0], -upper[2])
    return hinge_only if limb == "arm" else bool(abs(half - np.radians(67.5)) < np.radians(10.0))


def _together(moves: dict[str, list[Stroke]]) -> list[dict[str, Stroke]]:
    """Strokes of the parts of a limb that begin and end together, as groups."""
    groups: list[dict[str, Stroke]] = []
    for part, rows in moves.items():
        for row in rows:
            same = next(
                (g for g in groups if part not in g and _same(next(iter(g.values())), row)), None
            )
            if same is None:
                groups.append({part: row})
            else:
                same[part] = row
    return groups


def _same(a: Stroke, b: Stroke) -> bool:
    near = 0.15 * max(a.end - a.begin, b.end - b.begin)
    return abs(a.begin - b.begin) <= near and abs(a.end - b.end) <= near


def _overlap(a: Stroke, b: Stroke) -> bool:
    return min(a.end, b.end) - max(a.begin, b.begin) > 0.1 * min(a.end - a.begin, b.end - b.begin)


def _carried(seen: _Seen, side: str) -> list[_Carried]:
    """How a leg that stands on the ground bends and stretches under the body."""
    thigh_from_shank = seen.way(side + "UL", side + "LL", _DOWN)
    shank_from_foot = seen.way(side + "LL", side + "F", _DOWN)
    knee = np.arccos(np.clip(thigh_from_shank @ _DOWN, -1.0, 1.0))
    ankle = np.arctan2(shank_from_foot[:, 0], -shank_from_foot[:, 2])
    foot = seen.grounded[:, "LR".index(side)]
    told = []
    for stroke in strokes(
        np.stack([knee, ankle], axis=1), seen.time, least=float(np.radians(10.0))
    ):
        if foot[stroke.first] and foot[stroke.last]:
            level = (
                "low"
                if knee[stroke.last] > _BENT
                else "high"
                if ankle[stroke.last] < _RAISED
                else "middle"
            )
            told.append(_Carried(stroke, level))
    return told


def _support(seen: _Seen, carried: list[_Carried], step: float) -> list[tuple[str, Sign, Stroke]]:
    """Where the pelvis goes, level by level."""
    place_ = seen.world[:, seen.body.segment("LT"), :, 3]
    facing = seen.world[0, seen.body.segment("LT"), :2, 0]
    facing = facing / max(float(np.linalg.norm(facing)), 1e-12)
    frame = np.array([facing, [-facing[1], facing[0]]])
    told: list[tuple[str, Sign, Stroke]] = []
    levels = sorted(carried, key=lambda c: (c.stroke.begin, c.stroke.end))
    for stroke in strokes(place_[:, :2], seen.time, least=0.25 * step):
        way = frame @ (place_[stroke.last, :2] - place_[stroke.first, :2])
        direction = nearest_sign(np.array([*way, 0.0])).direction
        before = [
            c.level
            for c in levels
            if c.stroke.end <= stroke.end + 0.1 * (stroke.end - stroke.begin)
        ]
        told.append(("support", Sign(direction, before[-1] if before else "middle"), stroke))
    for c in levels:
        if not any(_same(c.stroke, stroke) for _, _, stroke in told):
            told.append(("support", Sign("place", c.level), c.stroke))
    return told
