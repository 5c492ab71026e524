"""Read a motion as a score of direction signs.

1. The direction of each part in the frame of its carrier is segmented into strokes, movements from
   rest to rest.
2. Strokes of a limb's parts that begin and end together are one group. A limb that ends straight
   gets one sign as a whole; otherwise each part gets its own.
3. Legs that carry the body give the level of the support, and the pelvis its direction.
4. Times are rounded to quarters of a beat.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.laban import PARTS, Movement, Score, Sign, nearest_sign
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import conjugate, from_matrices, multiply, rotate, shortest
from workbench.motion.laban.laban import BATCH_SIZE

__all__ = ["Stroke", "read_motion_score", "strokes"]

_GRID = 0.25
"""Spacing [beats] of beginnings and ends."""
_MIN_CHORD = 2.0 * np.sin(np.radians(10.0))
"""Least distance between the ends of a movement on the unit sphere: 20 degrees."""
_MIN_FLEXION = float(np.radians(10.0))
"""Least change [rad] of knee and ankle of a leg that carries the body."""
_MIN_STEP_SHARE = 0.25
"""Least way of a support, as a share of a step."""
_STRAIGHT = np.cos(np.radians(20.0))
"""Cosine of the angle between two parts of a limb up to which it is straight."""
_DRAWN_IN = 0.97
"""Share of its range from which on a bent hinge has drawn its limb in."""
_DRAWN_IN_THIGH = np.radians(67.5)
"""Flexion of the hip of a leg drawn in with its foot below the hip, half the knee's range."""
_DRAWN_IN_SPREAD = np.radians(10.0)
_LOW_KNEE = np.radians(25.0)
"""Flexion of the knee from which on a support is low."""
_HIGH_ANKLE = np.radians(-15.0)
"""Dorsiflexion of the ankle below which a support is high: the heel is up."""
_MAX_GROUND_GAP = 0.03
"""Height [m] above the lowest sphere up to which a foot is on the ground."""
_MAX_HIP_OFFSET = 0.2
"""Horizontal distance [m] of the ankle from its hip up to which a foot can carry the body."""
_SAME_TIME = 0.15
"""Differences of two strokes' beginnings and ends, as a share of the longer, that count as none."""
_OVERLAP = 0.1
"""Share of the shorter of two strokes up to which they may overlap and still follow each other."""
_LIMB_SEGMENTS = {"arm": ("UT", "UA", "LA"), "leg": ("LT", "UL", "LL")}
"""The segment that carries a limb, and the limb's upper and lower segment without their side."""
_DOWN = np.array([0.0, 0.0, -1.0])
_UP = np.array([0.0, 0.0, 1.0])


def read_motion_score(
    body: Body, motion: Poses, *, tempo: float, step: float = Score.step
) -> Score:
    """Transcribe a motion into a score.

    Parts move if their direction changes by 20 degrees or more. A movement gets the sign nearest to
    where it ends, in the body's own cross of axes.

    Parameters
    ----------
    body
        A body with the paper's joints.
    motion
        P poses with times.
    tempo
        Beats per minute, 1 to 1000.
    step
        Length [m] of a step of the support.

    Returns
    -------
    Score
        Movements in quarters of a beat, each a quarter or longer, in the order of time.

    Raises
    ------
    UsageError
        If the tempo is out of its range.
    InputError
        If nothing moves far enough.
    """
    if not 1 <= tempo <= 1000:
        raise UsageError(f"tempo {tempo:g}: 1 to 1000 beats a minute are possible")
    segments = _SegmentMotion.of(body, motion)
    signed = [*_spine_movements(segments)]
    support_levels = []
    for side in ("left", "right"):
        signed += _limb_movements(segments, side, "arm")
        signed += _limb_movements(segments, side, "leg")
        support_levels += _support_levels(segments, side[0].upper())
    signed += _support_movements(segments, support_levels, step)
    if not signed:
        raise InputError(
            "nothing moves far enough for a score: 20 degrees or a quarter of a step are needed"
        )
    start = float(segments.time[0])
    movements = [_on_grid(movement, start, 60.0 / tempo) for movement in signed]
    movements.sort(key=lambda m: (m.begin, PARTS.index(m.part)))
    return Score(tuple(movements), float(tempo), step)


class _SignedStroke(NamedTuple):
    """A stroke of a part, and the sign of where it ends."""

    part: str
    sign: Sign
    stroke: Stroke


def _on_grid(movement: _SignedStroke, start: float, beat: float) -> Movement:
    """The movement in beats, of `beat` seconds each; the first beat, number 1, is at `start` [s]."""
    stroke = movement.stroke
    begin, end = (_GRID * round((t - start) / beat / _GRID) for t in (stroke.begin, stroke.end))
    return Movement(movement.part, movement.sign, 1.0 + begin, max(end - begin, _GRID))


@dataclass(frozen=True, eq=False)
class _SegmentMotion:
    """The segments of a body in a motion of P frames."""

    body: Body
    time: Floats
    """(P,) [s]."""
    world: Floats
    """(P, N, 3, 4) world from segment."""
    grounded: Bools
    """(P, 2) True where the left or right foot carries the body."""

    @classmethod
    def of(cls, body: Body, motion: Poses) -> _SegmentMotion:
        """Place the body in every frame."""
        world = []
        height = []
        for first in range(0, len(motion), BATCH_SIZE):
            placed = place(body, motion.rows(slice(first, first + BATCH_SIZE)))
            world.append(placed.world_from_segment)
            height.append(_foot_heights(placed))
        whole = np.concatenate(world)
        low = np.concatenate(height) < _MAX_GROUND_GAP
        offsets = np.stack([_hip_offset(body, whole, side) for side in "LR"], axis=1)
        return cls(body, motion.clock, whole, low & (offsets < _MAX_HIP_OFFSET))

    def attitude(self, segment: str) -> Floats:
        """(P, 4) world from segment, as quaternions."""
        return from_matrices(self.world[:, self.body.segment(segment), :, :3])

    def direction(self, carrier: str, segment: str, axis: Floats) -> Floats:
        """(P, 3) direction of a segment's axis (3,) in the frame of its carrier."""
        relative = multiply(conjugate(self.attitude(carrier)), self.attitude(segment))
        return rotate(relative, np.broadcast_to(axis, (len(relative), 3)))


def _foot_heights(placed: Placed) -> Floats:
    """(P, 2) [m] of the left and right foot above the lowest sphere of the body, inf of one that
    is missing."""
    body = placed.body
    low = placed.centres[..., 2] - body.radius[0]
    feet = [
        low[:, body.spheres(body.segment(foot))].min(axis=1, initial=np.inf)
        for foot in ("LF", "RF")
    ]
    return np.asarray(np.stack(feet, axis=1) - low.min(axis=1)[:, None])


def _hip_offset(body: Body, world: Floats, side: str) -> Floats:
    """(P,) [m] horizontal distance of an ankle from its hip."""
    thigh, foot = (world[:, body.segment(side + name)] for name in ("UL", "F"))
    hip, ankle = (body.joint_in_child[0, body.joint(side + name)] for name in "HA")
    gap = thigh[:, :, :3] @ hip + thigh[:, :, 3] - foot[:, :, :3] @ ankle - foot[:, :, 3]
    return np.asarray(np.linalg.norm(gap[:, :2], axis=1))


def _spine_movements(segments: _SegmentMotion) -> Iterator[_SignedStroke]:
    for part, carrier, segment in (("trunk", "LT", "UT"), ("head", "UT", "H")):
        direction = segments.direction(carrier, segment, _UP)
        for stroke in strokes(direction, segments.time, least=_MIN_CHORD):
            yield _SignedStroke(part, nearest_sign(direction[stroke.last]), stroke)


@dataclass(frozen=True, eq=False)
class _PartMotion:
    """One part of a limb over P frames."""

    relative: Floats
    """(P, 3) direction against the part before it: `_DOWN` where the limb is straight."""
    carried: Floats
    """(P, 3) direction in the frame of the trunk, which the sign gives."""


@dataclass(frozen=True, eq=False)
class _LimbMotion:
    """An arm or a leg over P frames."""

    segments: _SegmentMotion
    side: str
    """ "left" or "right"."""
    limb: str
    """ "arm" or "leg"."""
    parts: dict[str, _PartMotion]
    """Upper part, lower part, and an arm's hand, by their names in a score."""

    @classmethod
    def of(cls, segments: _SegmentMotion, side: str, limb: str) -> _LimbMotion:
        """Compute the directions of a limb's parts."""
        letter = side[0].upper()
        trunk, upper_segment, lower_segment = _LIMB_SEGMENTS[limb]
        lower_segment = letter + lower_segment
        upper = segments.direction(trunk, letter + upper_segment, _DOWN)
        lower = segments.direction(trunk, lower_segment, _DOWN)
        swing = shortest(np.broadcast_to(_DOWN, upper.shape), upper)
        parts = {
            f"{side} upper {limb}": _PartMotion(upper, upper),
            f"{side} lower {limb}": _PartMotion(rotate(conjugate(swing), lower), lower),
        }
        if limb == "arm":
            parts[f"{side} hand"] = _PartMotion(
                segments.direction(lower_segment, letter + "HN", _DOWN),
                segments.direction(trunk, letter + "HN", _DOWN),
            )
        return cls(segments, side, limb, parts)

    @property
    def upper(self) -> _PartMotion:
        """Upper arm or thigh."""
        return self.parts[f"{self.side} upper {self.limb}"]

    @property
    def lower(self) -> _PartMotion:
        """Lower arm or shank."""
        return self.parts[f"{self.side} lower {self.limb}"]

    def on_ground(self, frame: int) -> bool:
        """True where the foot of a leg carries the body."""
        letter = self.side[0].upper()
        return self.limb == "leg" and bool(self.segments.grounded[frame, "LR".index(letter)])

    def is_straight(self, frame: int) -> bool:
        """True where no part is bent against the one before it."""
        inner = list(self.parts.values())[1:]
        return all(float(part.relative[frame] @ _DOWN) > _STRAIGHT for part in inner)

    def is_bent_fully(self, frame: int) -> bool:
        """True where elbow or knee are at the end of their range."""
        hinge = self.segments.body.joint(
            self.side[0].upper() + ("E" if self.limb == "arm" else "K")
        )
        limit = np.cos(_DRAWN_IN * self.segments.body.stops.limits[hinge, 0, 0])
        return bool(self.lower.relative[frame] @ _DOWN < limit)


def _limb_movements(segments: _SegmentMotion, side: str, limb: str) -> Iterator[_SignedStroke]:
    """The movements of an arm or a leg that does not carry the body."""
    motion = _LimbMotion.of(segments, side, limb)
    moves = _part_strokes(motion)
    for group in _simultaneous(moves):
        stroke = next(iter(group.values()))
        others = [m for part, rows in moves.items() if part not in group for m in rows]
        alone = not any(_overlap(stroke, other) for other in others)
        sign = _whole_limb_sign(motion, group, stroke.last, alone)
        if sign is not None:
            yield _SignedStroke(f"{side} {limb}", sign, stroke)
            continue
        for part, own in group.items():
            yield _SignedStroke(part, nearest_sign(motion.parts[part].carried[own.last]), own)


def _part_strokes(motion: _LimbMotion) -> dict[str, list[Stroke]]:
    """Strokes of each part; those of a leg only where its foot is in the air at either end."""
    found = {}
    for name, part in motion.parts.items():
        rows = strokes(part.relative, motion.segments.time, least=_MIN_CHORD)
        found[name] = [
            row for row in rows if not (motion.on_ground(row.first) and motion.on_ground(row.last))
        ]
    return found


def _whole_limb_sign(
    motion: _LimbMotion, group: dict[str, Stroke], frame: int, alone: bool
) -> Sign | None:
    """The sign of the limb as a whole after the movement of a group of parts, None if it has none.

    frame: where the movement ends; alone: True where no other part moves meanwhile.
    """
    upper, lower = list(motion.parts)[:2]
    if motion.on_ground(frame):
        return Sign("place", "low")
    if not alone:
        return None
    if motion.is_straight(frame) and (upper in group or lower in group):
        return nearest_sign(motion.upper.carried[frame])
    if motion.is_bent_fully(frame) and _is_drawn_in(motion, list(group), frame):
        return Sign("place", "middle")
    return None


def _is_drawn_in(motion: _LimbMotion, group: list[str], frame: int) -> bool:
    """True where a fully bent limb is drawn in to its joint.

    An arm is drawn in if its elbow alone has moved, a leg if its foot is below the hip.
    """
    if motion.limb == "arm":
        return group == [f"{motion.side} lower arm"]
    thigh = motion.upper.carried[frame]
    flexion = np.arctan2(thigh[0], -thigh[2])
    return bool(abs(flexion - _DRAWN_IN_THIGH) < _DRAWN_IN_SPREAD)


def _simultaneous(moves: dict[str, list[Stroke]]) -> list[dict[str, Stroke]]:
    """Group the strokes of a limb's parts that begin and end together."""
    groups: list[dict[str, Stroke]] = []
    for part, rows in moves.items():
        for row in rows:
            group = next(
                (g for g in groups if part not in g and _same_time(next(iter(g.values())), row)),
                None,
            )
            if group is None:
                groups.append({part: row})
            else:
                group[part] = row
    return groups


def _same_time(a: Stroke, b: Stroke) -> bool:
    near = _SAME_TIME * max(a.end - a.begin, b.end - b.begin)
    return abs(a.begin - b.begin) <= near and abs(a.end - b.end) <= near


def _overlap(a: Stroke, b: Stroke) -> bool:
    shared = min(a.end, b.end) - max(a.begin, b.begin)
    return shared > _OVERLAP * min(a.end - a.begin, b.end - b.begin)


class _LevelChange(NamedTuple):
    """A leg that bends or stretches under the body, and the level of the support after it."""

    stroke: Stroke
    level: str


def _support_levels(segments: _SegmentMotion, side: str) -> list[_LevelChange]:
    """How a leg that stands on the ground bends and stretches; side is "L" or "R"."""
    shank = segments.direction(side + "UL", side + "LL", _DOWN)
    foot = segments.direction(side + "LL", side + "F", _DOWN)
    knee = np.arccos(np.clip(shank @ _DOWN, -1.0, 1.0))
    ankle = np.arctan2(foot[:, 0], -foot[:, 2])
    grounded = segments.grounded[:, "LR".index(side)]
    bends = strokes(np.stack([knee, ankle], axis=1), segments.time, least=_MIN_FLEXION)
    return [
        _LevelChange(bend, _level(knee[bend.last], ankle[bend.last]))
        for bend in bends
        if grounded[bend.first] and grounded[bend.last]
    ]


def _level(knee: float, ankle: float) -> str:
    """The level of a support by flexion of the knee and dorsiflexion of the ankle [rad]."""
    if knee > _LOW_KNEE:
        return "low"
    return "high" if ankle < _HIGH_ANKLE else "middle"


def _support_movements(
    segments: _SegmentMotion, changes: list[_LevelChange], step: float
) -> list[_SignedStroke]:
    """The movements of the support: steps of the pelvis, and changes of level in place."""
    changes = sorted(changes, key=lambda c: (c.stroke.begin, c.stroke.end))
    pelvis = segments.world[:, segments.body.segment("LT"), :2, 3]
    start_from_world = _facing_axes(segments)
    found = []
    for stroke in strokes(pelvis, segments.time, least=_MIN_STEP_SHARE * step):
        way = start_from_world @ (pelvis[stroke.last] - pelvis[stroke.first])
        direction = nearest_sign(np.array([*way, 0.0])).direction
        level = _level_after(stroke, changes)
        found.append(_SignedStroke("support", Sign(direction, level), stroke))
    for change in changes:
        if not any(_same_time(change.stroke, movement.stroke) for movement in found):
            found.append(_SignedStroke("support", Sign("place", change.level), change.stroke))
    return found


def _facing_axes(segments: _SegmentMotion) -> Floats:
    """(2, 2) horizontal axes, forward and left, of the pelvis in the first frame."""
    forward = segments.world[0, segments.body.segment("LT"), :2, 0]
    forward = forward / max(float(np.linalg.norm(forward)), 1e-12)
    return np.array([forward, [-forward[1], forward[0]]])


def _level_after(step: Stroke, changes: list[_LevelChange]) -> str:
    """The level at the end of a step: that of the last change up to then, else middle."""
    latest = step.end + _OVERLAP * (step.end - step.begin)
    before = [change.level for change in changes if change.stroke.end <= latest]
    return before[-1] if before else "middle"


_REST_SHARE = 0.002
"""Share of the greatest speed up to which something rests."""
_REST_SPEED = 1e-3
"""Speed up to which something rests in any case, in units of the path per second."""
_DIP_SHARE = 0.1
"""A speed below this share of the peaks before and after it separates two strokes."""
_TENTH = 0.246636
"""Share u of its time after which a minimum-jerk movement has done a tenth of its way, the root of
10 u^3 - 15 u^4 + 6 u^5 = 0.1."""


class Stroke(NamedTuple):
    """A movement from rest to rest."""

    begin: float
    """Time [s] at which it begins; it may lie between frames."""
    end: float
    """Time [s] at which it ends."""
    first: int
    """Frame at rest before it."""
    last: int
    """Frame at rest after it."""


def strokes(path: Floats, time: Floats, *, least: float) -> list[Stroke]:
    """Find the strokes of a path.

    A stroke lies between rests or dips of the speed. Its beginning and end are those of the
    minimum-jerk movement that does a tenth and nine tenths of the way at the same times. They never
    lie outside the rests.

    Parameters
    ----------
    path
        (P, k) positions, in any unit.
    time
        (P,) times [s], increasing.
    least
        Least distance between the ends of a stroke, in the unit of the path.

    Returns
    -------
    list of Stroke
        In the order of time.
    """
    if len(path) < 2:
        return []
    length = np.linalg.norm(np.diff(path, axis=0), axis=1)
    speed = length / np.diff(time)
    travelled = np.concatenate([[0.0], np.cumsum(length)])
    found = []
    for first, last in _moving_intervals(speed):
        cuts = [first, *(first + k for k in _dips(speed[first:last])), last]
        for a, b in pairwise(cuts):
            if np.linalg.norm(path[b] - path[a]) >= least:
                begin, end = _minimum_jerk_ends(travelled[a : b + 1], time[a : b + 1])
                found.append(Stroke(begin, end, a, b))
    return found


def _moving_intervals(speed: Floats) -> list[tuple[int, int]]:
    """First and last frames of the intervals without rest; speed (P - 1,) is that after a frame."""
    moving = speed > max(_REST_SHARE * float(speed.max()), _REST_SPEED)
    change = np.diff(np.concatenate([[False], moving, [False]]).astype(np.int64))
    edges = np.flatnonzero(change).tolist()
    return list(zip(edges[0::2], edges[1::2], strict=True))


def _dips(speed: Floats) -> list[int]:
    """The steps at which a speed (n,) dips below a tenth of the peaks before and after."""
    dips = []
    peak = 0.0
    low = np.inf
    low_step = 0
    for step, value in enumerate(speed.tolist()):
        if value < low:
            low = value
            low_step = step
        if low < _DIP_SHARE * peak and value > low / _DIP_SHARE and value > _DIP_SHARE * peak:
            dips.append(low_step)
            peak = value
            low = np.inf
        elif value > peak:
            peak = value
            low = np.inf
    return dips


def _minimum_jerk_ends(travelled: Floats, time: Floats) -> tuple[float, float]:
    """Beginning and end [s] of the minimum-jerk movement with the same tenth and nine tenths.

    travelled (n,) is the length of the path up to each of the times (n,) [s]. With tenths at t1 and
    t9 the movement takes (t9 - t1) / (1 - 2 u), u being the share of time of the first tenth.
    """
    share = (travelled - travelled[0]) / (travelled[-1] - travelled[0])
    early = float(np.interp(0.1, share, time))
    late = float(np.interp(0.9, share, time))
    lead = _TENTH * (late - early) / (1.0 - 2.0 * _TENTH)
    return max(early - lead, float(time[0])), min(late + lead, float(time[-1]))
