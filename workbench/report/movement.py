"""Movement in words: which joints turned how far and when, where hands, feet and head went."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import angles_of
from workbench.solve.forward import place

__all__ = ["movement_sentences", "spells"]

_LEAST_TURN = 15.0
_LEAST_WAY = 0.08
_VERBS = {
    "flexion": "flexes", "extension": "extends", "abduction": "moves outward", "adduction": "moves inward",
    "bend_left": "bends left", "bend_right": "bends right", "turn_left": "turns left", "turn_right": "turns right",
    "medial_rotation": "rotates inward", "lateral_rotation": "rotates outward", "pronation": "pronates",
    "supination": "supinates", "elevation": "rises", "depression": "sinks", "protraction": "comes forward",
    "retraction": "goes back", "dorsiflexion": "lifts the toes", "plantarflexion": "points the toes",
    "radial_deviation": "bends toward the thumb", "ulnar_deviation": "bends toward the little finger",
    "eversion": "turns the sole outward", "inversion": "turns the sole inward",
}  # fmt: skip
_ENDS = ("H", "LHN", "RHN", "LF", "RF")
_WAYS = (("forward", "back"), ("to the left", "to the right"), ("up", "down"))


def movement_sentences(body: Body, motion: Poses, *, most: int = 8) -> list[str]:
    """The largest movements of a motion in the order of time: joints ("the left elbow extends from 95 to 20 degrees
    between 100 and 500 ms"), then where head, hands and feet end up, in the axes of the world.

    Turns are those between turning points of each joint's angle, of 15 degrees or more, the `most` largest of them.
    """
    time = motion.clock
    angles = np.degrees(angles_of(body, motion))
    found = []
    for j, name in enumerate(body.joint_names):
        if body.segments[int(body.parent[j + 1])] == "STG":
            continue
        for axis in range(3):
            track = np.degrees(np.unwrap(np.radians(angles[:, j, axis])))
            for first, last in spells(track, _LEAST_TURN):
                found.append((abs(track[last] - track[first]), first, last, name, body.stops.motions[j][axis], track))
    chosen = sorted(sorted(found, key=lambda row: (-row[0], row[1], row[3]))[:most], key=lambda row: (row[1], row[3]))
    return [_turn(row[3], row[4], (row[5], row[1], row[2]), time) for row in chosen] + _ways(body, motion, time)


def spells(track: Floats, least: float) -> list[tuple[int, int]]:
    """First and last index of each stretch in which a track rises or falls by `least` or more, smaller waves within it
    passed over."""
    turning = [0]
    high = low = 0
    rising: bool | None = None
    for k in range(1, len(track)):
        high = k if track[k] > track[high] else high
        low = k if track[k] < track[low] else low
        if rising is not False and track[high] - track[k] >= least:
            turning += [high] if high != turning[-1] else []
            rising, low = False, k
            high = k
        elif rising is not True and track[k] - track[low] >= least:
            turning += [low] if low != turning[-1] else []
            rising, high = True, k
            low = k
    last = high if rising else low if rising is False else turning[-1]
    turning += [last] if last != turning[-1] else []
    return [(a, b) for a, b in pairwise(turning) if abs(track[b] - track[a]) >= least]


def _turn(name: str, pair: tuple[str, str], part: tuple[Floats, int, int], time: Floats) -> str:
    track, first, last = part
    motion = pair[0] if track[last] > track[first] else pair[1]
    verb = _VERBS.get(motion, f"moves in {motion.replace('_', ' ')}")
    sense = 1.0 if motion == pair[0] or min(track[first], track[last]) >= 0 else -1.0
    begin, end = sense * track[first], sense * track[last]
    return (f"The {name} {verb} from {begin:.0f} to {end:.0f} degrees between {1000 * time[first]:.0f} and "
            f"{1000 * time[last]:.0f} ms.")  # fmt: skip


def _ways(body: Body, motion: Poses, time: Floats) -> list[str]:
    at = place(body, motion).world_from_segment[:, :, :, 3]
    told = []
    for segment in _ENDS:
        if segment not in body.segments:
            continue
        way = at[-1, body.segment(segment)] - at[0, body.segment(segment)]
        parts = [f"{1000 * abs(w):.0f} mm {words[0] if w > 0 else words[1]}"
                 for w, words in zip(way, _WAYS, strict=True) if abs(w) >= _LEAST_WAY]  # fmt: skip
        if parts:
            told.append(f"The {body.segment_names[body.segment(segment)]} ends up {', '.join(parts)} "
                        f"of where it was {1000 * (time[-1] - time[0]):.0f} ms before.")  # fmt: skip
    return told
