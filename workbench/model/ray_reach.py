"""RayReach: how far a limb reaches along rays, obstacles aside and clear of them, and how far with
ease."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints, frozen

__all__ = ["GRADES", "Losses", "RayReach"]

GRADES = ("easy", "moderate")
"""Grades of reach by discomfort; what is beyond them is reached near the limits of the joints."""


@dataclass(frozen=True, eq=False)
class Losses:
    """L stretches of rays that obstacles take: ray (L,), begin, end (L,) [m] of radius, part (L,):
    the obstacle that a free limb would enter deepest on most of the stretch, -1 where none is
    known."""

    ray: Ints
    begin: Floats
    end: Floats
    part: Ints

    def __post_init__(self) -> None:
        count = len(self.ray)
        for name in ("ray", "part"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), np.int64, (count,), f"losses.{name}")
            )
        for name in ("begin", "end"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), np.float64, (count,), f"losses.{name}")
            )

    def __len__(self) -> int:
        return len(self.ray)


@dataclass(frozen=True, eq=False)
class RayReach:
    """What is reached along R rays that begin at origin (R, 3) [m] and go along direction (R, 3),
    unit vectors.

    outer, inner (R,) [m]: the farthest and nearest reached radius, obstacles aside (where none is,
    that which comes nearest: both the same); reached (R,): whether there is one. clear_outer,
    clear_inner, clear (R,): the same of what is reached clear of obstacles, where these are heeded.
    easy_outer, easy_inner (G, R) [m]: the farthest and nearest radius that is reached within each
    of the GRADES of discomfort, obstacles aside, nan where none is. lost: what obstacles take.
    """

    origin: Floats
    direction: Floats
    outer: Floats
    inner: Floats
    reached: Bools
    clear_outer: Floats
    clear_inner: Floats
    clear: Bools
    easy_outer: Floats
    easy_inner: Floats
    lost: Losses

    def __post_init__(self) -> None:
        put = object.__setattr__
        rays = len(self.direction)
        for name in ("origin", "direction"):
            put(self, name, frozen(getattr(self, name), np.float64, (rays, 3), f"ray_reach.{name}"))
        for name in ("outer", "inner", "clear_outer", "clear_inner"):
            put(self, name, frozen(getattr(self, name), np.float64, (rays,), f"ray_reach.{name}"))
        for name in ("reached", "clear"):
            put(self, name, frozen(getattr(self, name), np.bool_, (rays,), f"ray_reach.{name}"))
        for name in ("easy_outer", "easy_inner"):
            value = np.array(getattr(self, name), dtype=np.float64)
            value.setflags(write=False)
            put(self, name, value)

    def __len__(self) -> int:
        return len(self.direction)

    def bounds(self, *, clear: bool = False) -> tuple[Floats, Floats, Bools]:
        """Outer and inner radius (R,) [m] and whether anything is reached (R,): obstacles aside, or
        clear of them."""
        if clear:
            return self.clear_outer, self.clear_inner, self.clear
        return self.outer, self.inner, self.reached
