"""PeopleReach: what became of the reaches of many people to many targets, one row a person, one
column a target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints, frozen
from workbench.model.body import Body
from workbench.model.reach import limit_words

__all__ = ["PeopleReach"]


@dataclass(frozen=True, eq=False, repr=False)
class PeopleReach:
    """Reaches of one limb of B people of a family to T targets each; rows and columns as in
    `Reach`.

    body: any of them, for the names; limb: its name with the grip; target (B, T, 3) [m]. reached
    (B, T); miss, overlap (B, T) [m]; discomfort (B, T); joint, axis, side, part (B, T): what limits
    a reach that missed, -1 where it is not that. spare (B, T) [m]: how much farther out on the ray
    from the shoulder (of a foot: from the hip) through the target the limb still reaches, found no
    farther than asked for, obstacles aside; 0 where the target is not reached. rotations (B, T, J,
    4): the postures found, None where they were not asked for.
    """

    body: Body
    limb: str
    target: Floats
    reached: Bools
    miss: Floats
    overlap: Floats
    discomfort: Floats
    joint: Ints
    axis: Ints
    side: Ints
    part: Ints
    spare: Floats
    parts: tuple[str, ...] = ()
    rotations: Floats | None = None

    def __repr__(self) -> str:
        return f"PeopleReach({self.reached.shape[0]} people, {self.reached.shape[1]} targets, {self.limb})"

    def __post_init__(self) -> None:
        put = object.__setattr__
        shape = np.shape(self.reached)
        put(self, "target", frozen(self.target, np.float64, (*shape, 3), "people_reach.target"))
        for name in ("miss", "overlap", "discomfort", "spare"):
            put(self, name, frozen(getattr(self, name), np.float64, shape, f"people_reach.{name}"))
        for name in ("joint", "axis", "side", "part"):
            put(self, name, frozen(getattr(self, name), np.int64, shape, f"people_reach.{name}"))
        put(self, "reached", frozen(self.reached, np.bool_, shape, "people_reach.reached"))
        if self.rotations is not None:
            whole = (*shape, len(self.body.joints), 4)
            put(
                self,
                "rotations",
                frozen(self.rotations, np.float64, whole, "people_reach.rotations"),
            )

    def __len__(self) -> int:
        return len(self.reached)

    def limit(self, person: int, target: int) -> str:
        """What limits a reach, in words as of `Reach.limit`; "" where the target is reached."""
        if self.reached[person, target]:
            return ""
        if self.part[person, target] >= 0:
            return self.parts[int(self.part[person, target])]
        return limit_words(
            self.body, (int(a[person, target]) for a in (self.joint, self.axis, self.side))
        )
