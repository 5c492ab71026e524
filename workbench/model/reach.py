"""Reach: what became of reaches of people to targets, one row a person, one column a target."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints, read_only
from workbench.model.body import Body
from workbench.model.criterion import NO_REASON, TOO_SHORT, Reason, hider
from workbench.model.joint_angles import compose
from workbench.model.poses import Poses, people_of
from workbench.model.units import plain

__all__ = ["DOUBTS", "MOST_SPARE", "Reach", "join_reaches", "stop_reason"]

DOUBTS = (
    "not in doubt",
    "clear after a few steps",
    "clear in another posture",
    "kept",
    "kept for certain",
)
"""What becomes of a reach beside obstacles. In doubt is one whose posture without obstacles enters
something, or misses the target by less than 2 mm. It may come clear from that posture, or from
another start of the search. Or the search finds no way, or there is a proof that there is none: the
target is too deep in a solid."""
MOST_SPARE = 0.2
"""A control that is reached with this much to spare [m], or more, is reported to have this."""


@dataclass(frozen=True, eq=False, repr=False)
class Reach:
    """Reaches of one limb: B people (or B poses of one person) to T targets each."""

    body: Body
    """The body whose rows reach."""
    limb: str
    """The limb with its grip: "right hand, push"."""
    held: Poses
    """The B postures from which they reach, placed by the segment that the limb hangs on."""
    joints: tuple[int, ...]
    """The K joints of the limb, from the held segment out."""
    free: tuple[int, ...]
    """Those of them that are free."""
    target: Floats
    """(B, T, 3) [m] where the limb was to go."""
    tip: Floats
    """(B, T, 3) [m] where it got."""
    angles: Floats
    """(B, T, K, 3) [rad] angles of the joints: two of swing, one of twist."""
    reached: Bools
    """(B, T) whether the tip is on the target and enters no obstacle."""
    miss: Floats
    """(B, T) [m] distance from the tip to the target."""
    overlap: Floats
    """(B, T) [m] depth in obstacles beyond what they allow; 0 where none is entered."""
    discomfort: Floats
    """(B, T) sum of squared distances from the comfort modes, in units of half the comfortable
    range."""
    extension: Floats
    """(B, T) [m] how much farther out the limb still reaches, on the ray from its shoulder or hip
    through the target, obstacles aside; 0 where the target is missed."""
    joint: Ints
    """(B, T) joint whose stop limits a reach that missed, -1 where none does."""
    axis: Ints
    """(B, T) axis of that stop, -1 where there is none."""
    side: Ints
    """(B, T) side of that stop, -1 where there is none."""
    part: Ints
    """(B, T) obstacle that limits a reach that missed, -1 where none does. With neither stop nor
    obstacle, the limb is straight and too short."""
    doubt: Ints
    """(B, T) how a reach ended that obstacles put in doubt, as an index into DOUBTS."""
    parts: tuple[str, ...] = ()
    """Names of the parts that are obstacles."""
    bodies: tuple[str, ...] = ()
    """Names of the segments of people that are, numbered after the parts: "pilot's left lower arm",
    "own left upper leg"."""

    def __repr__(self) -> str:
        rows, columns = self.reached.shape
        return (
            f"Reach({rows} by {columns} of {self.limb} of {self.body!r}, "
            f"{int(self.reached.sum())} reached)"
        )

    def __post_init__(self) -> None:
        shape = np.shape(self.reached)
        kinds = dict.fromkeys(_NUMBERS, np.float64) | dict.fromkeys(_INDICES, np.int64)
        for name, dtype in kinds.items():
            self._freeze(name, dtype, shape)
        self._freeze("reached", np.bool_, shape)
        for name in ("target", "tip"):
            self._freeze(name, np.float64, (*shape, 3))
        self._freeze("angles", np.float64, (*shape, len(self.joints), 3))

    def _freeze(self, name: str, dtype: type, shape: tuple[int, ...]) -> None:
        object.__setattr__(
            self, name, read_only(getattr(self, name), dtype, shape, f"reach.{name}")
        )

    def __len__(self) -> int:
        return len(self.reached)

    @property
    def poses(self) -> Poses:
        """The B T postures found, the targets of the first person first.

        Where a target is missed, the posture is the best there was.
        """
        count = self.reached.shape[1]
        rows = np.repeat(np.arange(len(self)), count)
        every = np.zeros((len(rows), len(self.body.joints), 3))
        every[:, self.joints] = self.angles.reshape(len(rows), -1, 3)
        free = list(self.free)
        rotations = self.held.rotations[rows]
        rotations[:, free] = compose(self.body, every)[:, free]
        person = people_of(self.body, self.held)[rows] if len(self.body) > 1 else None
        world = self.held.world_from_reference[rows]
        return Poses(rotations, self.held.reference, world, person=person)

    def reason(self, row: int, target: int) -> Reason:
        """What limits a reach: a part, a stop, or the length of the limb; `NO_REASON` where the
        target is reached."""
        if self.reached[row, target]:
            return NO_REASON
        if self.part[row, target] >= 0:
            return hider((*self.parts, *self.bodies)[int(self.part[row, target])], self.parts)
        stop = (int(values[row, target]) for values in (self.joint, self.axis, self.side))
        return stop_reason(self.body, stop)

    def limit(self, row: int, target: int) -> str:
        """What limits a reach in words: "right elbow (flexion)", "instrument_panel", "length of the
        limb"; "" where the target is reached."""
        return self.reason(row, target).text


_NUMBERS = ("miss", "overlap", "discomfort", "extension")
_INDICES = ("joint", "axis", "side", "part", "doubt")


def join_reaches(parts: Sequence[Reach], body: Body, held: Poses) -> Reach:
    """The rows of several reaches of the same limb, in their order, as those of one body.

    held: the postures of all of them.
    """

    def whole(name: str) -> Any:
        return np.concatenate([getattr(part, name) for part in parts])

    return replace(
        parts[0],
        body=body,
        held=held,
        target=whole("target"),
        tip=whole("tip"),
        angles=whole("angles"),
        reached=whole("reached"),
        miss=whole("miss"),
        overlap=whole("overlap"),
        discomfort=whole("discomfort"),
        extension=whole("extension"),
        joint=whole("joint"),
        axis=whole("axis"),
        side=whole("side"),
        part=whole("part"),
        doubt=whole("doubt"),
    )


_SHOULDER = {
    "protraction": "forward",
    "retraction": "back",
    "elevation": "up",
    "depression": "down",
}
"""Where a motion of the clavicular joint takes the shoulder."""


def stop_reason(body: Body, stop: Iterable[int]) -> Reason:
    """A stop (joint, axis, side) as what limits, the length of the limb where the joint is -1."""
    joint, axis, side = stop
    if joint < 0:
        return TOO_SHORT
    motion = plain(body.stops.motions[joint][axis][side])
    goes = _SHOULDER.get(motion) if "clavicular" in body.joint_names[joint] else None
    seen = f": the shoulder is as far {goes} as it goes" if goes else ""
    return Reason("stop", f"{body.joint_names[joint]} ({motion}{seen})")
