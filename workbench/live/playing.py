"""Motions as the page plays them: the place, frames in windows, and how near each frame comes.

All of it is made in a thread of its own, of a frozen state with its number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import combinations, cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.body.forward import place
from workbench.contact.collide import body_clearance
from workbench.draw.web.motion_view import cord_counts, motion_bodies
from workbench.draw.web.packing import Packing
from workbench.draw.web.views import PEOPLE, WebBody, WebView
from workbench.errors import InputError
from workbench.live.frames import near_row
from workbench.live.protocol import Made, packed
from workbench.model.arrays import Floats, Ints
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed
from workbench.model.units import plain
from workbench.sight.eyes import eyes_of, has_eyes, head_of
from workbench.study.bench.answers import TOUCHES
from workbench.study.bench.motions import Playing, near_in_frame, playing
from workbench.study.bench.state import Arrangement, OpenStudy
from workbench.study.motions import asked_gaps, distance_criteria, frame_rooms

__all__ = ["WINDOW", "Frames", "Gaps", "MotionScene", "Near"]

WINDOW = 256
"""Frames that are sent at a time, and asked how near they come."""
_SAMPLES = 32
"""Frames in which the length of belts is looked at."""
Arrays = list[tuple[str, NDArray[Any]]]


@dataclass(frozen=True, eq=False)
class _Asked:
    """A motion of a state, by its case."""

    opened: OpenStudy
    arrangement: Arrangement
    generation: int
    case: str

    @property
    def playing(self) -> Playing:
        """What each role does in it."""
        return playing(self.opened, self.arrangement, self.case)

    def frame(self, kind: str, head: dict[str, Any], arrays: Arrays) -> bytes:
        """Pack what was made."""
        lead = {"kind": kind, "generation": self.generation, "case": self.case}
        return packed({**lead, **head}, arrays)


@dataclass(frozen=True, eq=False)
class MotionScene(_Asked):
    """The place of a motion, its people in the first frame, and the times of all frames."""

    kind: str = "motion"

    def made(self) -> Made:
        """Pack the picture."""
        found = self.playing
        clock = found.clock
        packing = Packing()
        first = found.motions[0]
        bodies = tuple(_bodies(found, found.placed(clock[:1]), clock[:1]))
        packing.add(WebView(self.case, bodies, first.cabin))
        people = []
        for motion in found.motions:
            head = head_of(motion.body) if has_eyes(motion.body) else None
            people.append({"role": motion.person, "head": head, "bodies": 1 + len(motion.belts)})
        sent = {"frames": len(clock), "window": WINDOW, "people": people}
        moves = [
            {"parts": list(move.parts), "by": list(move.by)} for move in self.arrangement.moves
        ]
        block = np.frombuffer(packing.block(), np.uint8)
        arrays: Arrays = [("block", block), ("times", 1e3 * clock)]
        return Made([self.frame("motion", {**sent, "moves": moves}, arrays)])


@dataclass(frozen=True, eq=False)
class Frames(_Asked):
    """Some frames of a motion, `begin` to `end`."""

    begin: int
    end: int
    kind: str = "frames"

    def made(self) -> Made:
        """Pack the bodies in these frames, with what is deeper in something than it may be."""
        found = self.playing
        times = found.clock[self.begin : self.end]
        if not len(times):
            count = len(found.clock)
            raise InputError(f"{self.case} has frames 0 to {count - 1}, got {self.begin} on")
        placed = found.placed(times)
        packing = Packing()
        packing.add(WebView(self.case, tuple(_bodies(found, placed, times, red=True))))
        arrays: Arrays = [("block", np.frombuffer(packing.block(), np.uint8))]
        for k, one in enumerate(placed):
            if has_eyes(one.body):
                eyes = eyes_of(one)
                rows = np.concatenate([eyes.middle, eyes.line(), eyes.axes[:, 2]], axis=1)
                arrays.append((f"eyes{k}", rows.astype(np.float32)))
        return Made([self.frame("frames", {"from": self.begin, "count": len(times)}, arrays)])


@dataclass(frozen=True, eq=False)
class Near(_Asked):
    """What is nearest to what at one frame of a motion."""

    number: int
    kind: str = "near"

    def made(self) -> Made:
        """Pack the nearest pairs, the worst first."""
        found = self.playing
        if self.number >= len(found.clock):
            count = len(found.clock)
            raise InputError(f"{self.case} has frames 0 to {count - 1}, got {self.number}")
        rows = [near_row(pair) for pair in near_in_frame(found, self.number)]
        return Made([self.frame("near", {"frame": self.number, "rows": rows}, [])])


@dataclass(frozen=True, eq=False)
class Gaps(_Asked):
    """How near a motion comes at each frame, from frame `begin` on, piece by piece."""

    begin: int = 0
    kind: str = "gaps"

    def made(self) -> Made:
        """Pack the least gap of each frame of a piece, and the distances that criteria ask for."""
        found = self.playing
        times = found.clock[self.begin : self.begin + WINDOW]
        placed = found.placed(times)
        least = np.full(len(times), np.inf)
        worst: dict[str, Any] = {}
        for gaps in _least_gaps(found, placed):
            frame = int(gaps.room.argmin())
            if gaps.room[frame] < least.min(initial=np.inf):
                point = gaps.point[frame].round(5).tolist()
                worst = {"words": plain(gaps.words(frame)), "point": point}
            least = np.minimum(least, gaps.room)
        arrays: Arrays = [("least", least.astype(np.float32))]
        rows: list[dict[str, Any]] = []
        for motion, one in zip(found.motions, placed, strict=True):
            for asked in asked_gaps(motion, one, distance_criteria(motion)):
                lead = f"{motion.person}: " if len(found.motions) > 1 else ""
                name = f"{lead}{asked.criterion.name}"
                arrays.append((f"asked{len(rows)}", asked.distance.astype(np.float32)))
                rows.append({"name": name, "limit": asked.limit})
        head = {"from": self.begin, "of": len(found.clock), "rows": rows, "worst": worst}
        frame_bytes = self.frame("gaps", head, arrays)
        after = self.begin + len(times)
        more = replace(self, begin=after) if after < len(found.clock) else None
        return Made([frame_bytes], more)


@dataclass(frozen=True, eq=False)
class _FrameGaps:
    """What comes nearest to what in each of F frames: of a role and parts, or of two roles.

    Parameters
    ----------
    room
        (F,) [m] the least distance, with the overlap that parts allow added.
    point
        (F, 3) [m] where that is.
    words
        From the number of a frame to what comes near to what there.
    """

    room: Floats
    point: Floats
    words: Callable[[int], str]


def _least_gaps(found: Playing, placed: tuple[Placed, ...]) -> Iterator[_FrameGaps]:
    """The gaps of each role and parts, and of each two roles."""
    for motion, one in zip(found.motions, placed, strict=True):
        rooms = frame_rooms(motion, one)
        segment = np.nan_to_num(rooms.distance, nan=np.inf).argmin(axis=1)
        each = np.arange(len(segment))
        polygon = rooms.polygon[each, segment]
        yield _FrameGaps(
            rooms.distance[each, segment],
            np.nan_to_num(rooms.point[each, segment]),
            partial(_part_words, motion, segment, polygon),
        )
    for (a, one), (b, other) in combinations(enumerate(placed), 2):
        near = body_clearance(one, other)
        distance = np.nan_to_num(near.distance, nan=np.inf).reshape(len(one), -1)
        pair = distance.argmin(axis=1)
        each = np.arange(len(pair))
        rows, columns = np.unravel_index(pair, near.distance.shape[1:])
        mine = partial(_segment_words, found.motions[a], rows)
        yours = partial(_segment_words, found.motions[b], columns)
        yield _FrameGaps(
            distance[each, pair],
            near.point[each, rows, columns],
            partial(_pair_words, mine, yours),
        )


def _segment_words(motion: MotionCase, segment: Ints, frame: int) -> str:
    """The role and the segment (F,) of it in a frame."""
    return f"{motion.person}: {motion.body.segment_names[int(segment[frame])]}"


def _part_words(motion: MotionCase, segment: Ints, polygon: Ints, frame: int) -> str:
    """The segment (F,) of a frame and the part of its polygon (F,), -1 for none."""
    environment = motion.environment
    name = "nothing"
    if polygon[frame] >= 0:
        name = environment.parts[int(environment.polygon_part[int(polygon[frame])])]
    return f"{_segment_words(motion, segment, frame)} – {name}"


def _pair_words(mine: Callable[[int], str], yours: Callable[[int], str], frame: int) -> str:
    """The segments of two roles in a frame."""
    return f"{mine(frame)} – {yours(frame)}"


def _bodies(
    found: Playing, placed: tuple[Placed, ...], times: Floats, *, red: bool = False
) -> Iterator[WebBody]:
    """Everybody with the belts that are worn, at some times."""
    deep = [_touching(one, motion) for motion, one in zip(found.motions, placed, strict=True)]
    for (a, one), (b, other) in combinations(enumerate(placed), 2) if red else ():
        near = body_clearance(one, other)
        where = near.distance < -TOUCHES
        frame = np.nonzero(where)[0]
        deep[a].update(zip(near.sphere[where].tolist(), frame.tolist(), strict=True))
        deep[b].update(zip(near.target[where].tolist(), frame.tolist(), strict=True))
    for k, (motion, colour) in enumerate(zip(found.motions, cycle(PEOPLE), strict=False)):
        spans = _spans(deep[k], times) if red else ()
        yield from motion_bodies(motion, placed[k], colour, _counts(motion), touching=spans)


def _touching(placed: Placed, motion: MotionCase) -> set[tuple[int, int]]:
    """The spheres that are deeper in a part than it allows, of each segment the worst, with the
    frames."""
    rooms = frame_rooms(motion, placed)
    frame, segment = np.nonzero((rooms.distance < -TOUCHES) & (rooms.sphere >= 0))
    return set(zip(rooms.sphere[frame, segment].tolist(), frame.tolist(), strict=True))


def _spans(deep: set[tuple[int, int]], times: Floats) -> list[tuple[int, float, float]]:
    """From when to when [s] spheres are red: each run of frames, a quarter of a frame longer at
    both ends, so that rounding loses none."""
    slack = 0.25 * float(np.diff(times).min(initial=1e-3))
    spans: list[tuple[int, float, float]] = []
    last = (-1, -1)
    for sphere, frame in sorted(deep):
        begin = float(times[frame]) - slack
        if last == (sphere, frame - 1):
            begin = spans.pop()[1]
        spans.append((sphere, begin, float(times[frame]) + slack))
        last = (sphere, frame)
    return spans


@lru_cache(maxsize=32)
def _counts(motion: MotionCase) -> tuple[int, ...]:
    """The spheres of each belt's cord, the same in every window."""
    clock = motion.motion.clock
    times = np.linspace(clock[0], clock[-1], min(_SAMPLES, len(clock)))
    return cord_counts(motion, place(motion.body, poses_at(motion.motion, times)))
