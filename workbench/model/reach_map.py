"""ReachMap: for points on a part's surface, what share of people reach them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats, frozen

__all__ = ["ReachMap"]


@dataclass(frozen=True, eq=False, repr=False)
class ReachMap:
    """M points of a part and the share of people who reach each.

    point, normal (M, 3) [m]: on the surface, and the polygon's unit normal there; uv (M, 2) [m]: the point in the
    part's main plane, to the right and up as somebody sees it who looks against its mean normal; share (M,): weighted,
    0 to 1; limb, grip, zone: with what, people: how many.
    """

    part: str
    limb: str
    grip: str
    zone: int
    people: int
    point: Floats
    normal: Floats
    uv: Floats
    share: Floats

    def __repr__(self) -> str:
        return f"ReachMap({self.part}: {len(self.share)} points, {self.people} people, {self.limb}, {self.grip})"

    def __post_init__(self) -> None:
        count = len(self.share)
        for name, shape in (("point", (count, 3)), ("normal", (count, 3)), ("uv", (count, 2)), ("share", (count,))):
            object.__setattr__(self, name, frozen(getattr(self, name), np.float64, shape, f"reach_map.{name}"))
