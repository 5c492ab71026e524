"""Movement in words: which limbs reached where, how far joints turned and when, where hands, feet
and head went."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.forward import place
from workbench.model.arrays import Floats, pieces
from workbench.model.body import Body
from workbench.model.joint_angles import ContinuousAngles, angles_of
from workbench.model.laban import nearest_sign, sign_words
from workbench.model.poses import Poses
from workbench.model.units import plain
from workbench.report.motions.turning_points import Turning

__all__ = ["movement_sentences"]

_LEAST_TURN = 15.0
_LEAST_WAY = 0.08
_STILL = 0.1
_FASTEST = 1500.0
"""[degrees/s] Mean speed of a turn from which on it is remarked on. Throwers' forearms and wrists reach
about as much by their own muscles; whatever is faster was struck or flung."""
_DRAWN_IN = 0.08
"""[m] A limb whose end comes so much nearer to its first joint does not reach but is drawn in."""
_VERBS = {
    "flexion": "flexes",
    "extension": "extends",
    "abduction": "moves outward",
    "adduction": "moves inward",
    "bend_left": "bends left",
    "bend_right": "bends right",
    "turn_left": "turns left",
    "turn_right": "turns right",
    "medial_rotation": "rotates inward",
    "lateral_rotation": "rotates outward",
    "pronation": "pronates",
    "supination": "supinates",
    "elevation": "rises",
    "depression": "sinks",
    "protraction": "comes forward",
    "retraction": "goes back",
    "dorsiflexion": "lifts the toes",
    "plantarflexion": "points the toes",
    "radial_deviation": "bends toward the thumb",
    "ulnar_deviation": "bends toward the little finger",
    "eversion": "turns the sole outward",
    "inversion": "turns the sole inward",
}
_ENDS = ("H", "LHN", "RHN", "LF", "RF")
_WAYS = (("forward", "back"), ("to the left", "to the right"), ("up", "down"))
# joints of a limb, the segment that sees it, the segment at its end, its first joint, what it does
_LIMBS = {"arm": ("CSEW", "UT", "HN", "S", "reaches"), "leg": ("HKA", "LT", "F", "H", "swings")}
_FRAME = (
    "Directions of arms are relative to the upper torso, those of legs to the lower torso; where head, hands and "
    "feet end up is relative to the surroundings."
)


@dataclass(frozen=True)
class _Turn:
    """A turn of a joint about an axis by a pair of motions, between two frames, from one angle to
    another [degrees]."""

    joint: int
    axis: int
    motions: tuple[str, str]
    first: int
    last: int
    begin: float
    end: float


def movement_sentences(body: Body, motion: Poses, *, most: int = 8) -> list[str]:
    """The largest movements of a motion in the order of time, then where head, hands and feet end
    up.

    "The right arm reaches forward and up; the elbow extends from 95 to 20 degrees in 0.4 s." Turns
    are those between turning points of each joint's angle, of 15 degrees or more, the `most`
    largest of them. Turns of one limb at one time are one sentence, with the way of its hand or
    foot as the torso sees it, by the 26 directions of the direction signs, where that is 80 mm or
    more.
    """
    largest = [
        _trimmed(body, motion, turn) for turn in sorted(_turns(body, motion), key=_size)[:most]
    ]
    chosen = sorted(largest, key=lambda t: (t.first, body.joint_names[t.joint]))
    groups = [(group, _reach(body, motion, group)) for group in _together(body, chosen)]
    sentences = [
        _limb_sentence(body, motion, reach, group)
        if reach
        else _turn_sentence(body, motion, group[0])
        for group, reach in groups
    ]
    sentences += _ways(body, motion)
    return sentences + ([_FRAME] if any(reach for _, reach in groups) else [])


def _size(turn: _Turn) -> tuple[float, int, int]:
    return -abs(turn.end - turn.begin), turn.first, turn.joint


def _turns(body: Body, motion: Poses) -> list[_Turn]:
    """Every turn of 15 degrees or more."""
    inner = [j for j in range(len(body.joints)) if body.segments[int(body.parent[j + 1])] != "STG"]
    tracks = [(j, axis, Turning(_LEAST_TURN)) for j in inner for axis in range(3)]
    continuous = ContinuousAngles()
    for rows in pieces(len(motion)):
        angles = continuous.take(angles_of(body, motion.rows(rows))[:, inner])
        columns = np.ascontiguousarray(np.degrees(angles.reshape(len(angles), -1)).T)
        for (_, _, track), values in zip(tracks, columns, strict=True):
            track.take(values)
    return [
        _Turn(j, axis, body.stops.motions[j][axis], a[0], b[0], a[1], b[1])
        for j, axis, track in tracks
        for a, b in track.spells()
    ]


def _trimmed(body: Body, motion: Poses, turn: _Turn) -> _Turn:
    """A turn without the frames before and after in which the joint stands still."""
    start = 0.0
    first = turn.last
    last = turn.first
    for begin, track in _tracked(body, motion, turn):
        start = track[0] if begin == turn.first else start
        left = np.flatnonzero(np.abs(track - start) > _STILL)
        short = np.flatnonzero(np.abs(track - start - (turn.end - turn.begin)) > _STILL)
        if len(left):
            first = min(first, begin + int(left[0]) - 1)
        if len(short):
            last = max(last, begin + int(short[-1]) + 1)
    return replace(turn, first=max(first, turn.first), last=min(last, turn.last))


def _tracked(body: Body, motion: Poses, turn: _Turn) -> Iterator[tuple[int, Floats]]:
    """The angle of a turn [degrees] in pieces of its frames, with the first frame of each."""
    continuous = ContinuousAngles()
    for rows in pieces(turn.last + 1 - turn.first):
        begin = turn.first + rows.start
        angles = angles_of(body, motion.rows(slice(begin, turn.first + rows.stop)))
        one = continuous.take(angles[:, turn.joint, None])
        yield begin, np.degrees(one[:, 0, turn.axis])


def _limb(body: Body, joint: int) -> str:
    """ "right arm" of a joint of it; "" for a joint of no limb."""
    name = body.joints[joint]
    sides = {"L": "left", "R": "right"}
    for limb, (joints, *_) in _LIMBS.items():
        if len(name) == 2 and name[0] in sides and name[1] in joints:
            return f"{sides[name[0]]} {limb}"
    return ""


def _together(body: Body, turns: list[_Turn]) -> list[list[_Turn]]:
    """Turns of one limb that are at the same time for half of the shorter one, as groups; others
    alone."""
    groups: list[list[_Turn]] = []
    for turn in turns:
        limb = _limb(body, turn.joint)
        same = next(
            (g for g in groups if limb and _limb(body, g[0].joint) == limb and _shared(g[0], turn)),
            None,
        )
        if same is None:
            groups.append([turn])
        else:
            same.append(turn)
    return groups


def _shared(a: _Turn, b: _Turn) -> bool:
    shorter = min(a.last - a.first, b.last - b.first)
    return min(a.last, b.last) - max(a.first, b.first) >= 0.5 * shorter


def _reach(body: Body, motion: Poses, group: list[_Turn]) -> str:
    """ "reaches forward and up": the way of a limb's end as the torso sees it; "" where there is
    none."""
    limb = _limb(body, group[0].joint)
    if not limb:
        return ""
    side = body.joints[group[0].joint][0]
    _, carrier, end, ball, verb = _LIMBS[limb.split()[1]]
    if not {carrier, side + end} <= set(body.segments) or side + ball not in body.joints:
        return ""
    world = _world(body, motion, min(t.first for t in group), max(t.last for t in group))
    tip = world[:, body.segment(side + end), :, 3]
    way = _way_seen(world[:, body.segment(carrier)], tip)
    if np.linalg.norm(way) < _LEAST_WAY:
        return ""
    length = np.linalg.norm(tip - _joint_place(body, world, body.joint(side + ball)), axis=1)
    drawn = length[1] < length[0] - _DRAWN_IN
    return f"{'is drawn in,' if drawn else verb} {sign_words(nearest_sign(way))}"


def _way_seen(frame: Floats, point: Floats) -> Floats:
    """(3,) [m] the way between two places (2, 3) of a point, as two places (2, 3, 4) of a segment
    see it."""
    own = np.einsum("pji,pj->pi", frame[:, :, :3], point - frame[:, :, 3])
    return own[1] - own[0]


def _joint_place(body: Body, world: Floats, joint: int) -> Floats:
    """(P, 3) [m] where a joint is, from the places (P, N, 3, 4) of the segments."""
    child = world[:, joint + 1]
    return np.einsum("pij,j->pi", child[:, :, :3], body.joint_in_child[0, joint]) + child[:, :, 3]


def _limb_sentence(body: Body, motion: Poses, reach: str, group: list[_Turn]) -> str:
    time = motion.clock
    limb = _limb(body, group[0].joint)
    side = limb.split()[0] + " "
    parts = [
        f"the {body.joint_names[t.joint].removeprefix(side)} {_turned(t)} in "
        f"{1000 * (time[t.last] - time[t.first]):.0f} ms{_flung(t, time)}"
        for t in group
    ]
    first = min(t.first for t in group)
    when = f"From {1000 * time[first]:.0f} ms on the" if first else "The"
    return f"{when} {limb} {reach}; {', '.join(parts)}."


def _turn_sentence(body: Body, motion: Poses, turn: _Turn) -> str:
    time = motion.clock
    return (
        f"The {body.joint_names[turn.joint]} {_turned(turn)} between {1000 * time[turn.first]:.0f} and "
        f"{1000 * time[turn.last]:.0f} ms{_flung(turn, time)}."
    )


def _flung(turn: _Turn, time: Floats) -> str:
    """ " (2,010 degrees a second: faster than muscles turn a joint)" of a turn that is; else ""."""
    rate = abs(turn.end - turn.begin) / max(float(time[turn.last] - time[turn.first]), 1e-9)
    return (
        ""
        if rate <= _FASTEST
        else f" ({rate:,.0f} degrees a second: faster than muscles turn a joint)"
    )


def _turned(turn: _Turn) -> str:
    """ "extends from 95 to 20 degrees"."""
    motion = turn.motions[0] if turn.end > turn.begin else turn.motions[1]
    verb = _VERBS.get(motion, f"moves in {plain(motion)}")
    sense = 1.0 if motion == turn.motions[0] or min(turn.begin, turn.end) >= 0 else -1.0
    return f"{verb} from {sense * turn.begin + 0.0:.0f} to {sense * turn.end + 0.0:.0f} degrees"


def _world(body: Body, motion: Poses, first: int, last: int) -> Floats:
    """(2, N, 3, 4) world from segment in two frames."""
    keep = [first, last]
    return place(
        body, Poses(motion.rotations[keep], motion.reference, motion.world_from_reference[keep])
    ).world_from_segment


def _ways(body: Body, motion: Poses) -> list[str]:
    """A sentence for each of head, hands and feet that ends up elsewhere than it began."""
    at = _world(body, motion, 0, len(motion) - 1)[..., 3]
    span = 1000 * (motion.clock[-1] - motion.clock[0])
    sentences = []
    for segment in _ENDS:
        if segment not in body.segments:
            continue
        n = body.segment(segment)
        parts = [
            f"{1000 * abs(w):.0f} mm {words[0] if w > 0 else words[1]}"
            for w, words in zip(at[-1, n] - at[0, n], _WAYS, strict=True)
            if abs(w) >= _LEAST_WAY
        ]
        if parts:
            sentences.append(
                f"After {span:.0f} ms the {body.segment_names[n]} is away from where it was: "
                f"{', '.join(parts)}."
            )
    return sentences
