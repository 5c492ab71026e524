"""Envelope: how far a limb reaches about a point, direction by direction and level by level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints, read_only

__all__ = ["GRADES", "Envelope", "Losses", "RayReach", "ReachTask"]


# RayReach: how far a limb reaches along rays, obstacles aside and clear of them, and how far with
# ease.

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
                self, name, read_only(getattr(self, name), np.int64, (count,), f"losses.{name}")
            )
        for name in ("begin", "end"):
            object.__setattr__(
                self, name, read_only(getattr(self, name), np.float64, (count,), f"losses.{name}")
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
            put(
                self,
                name,
                read_only(getattr(self, name), np.float64, (rays, 3), f"ray_reach.{name}"),
            )
        for name in ("outer", "inner", "clear_outer", "clear_inner"):
            put(
                self, name, read_only(getattr(self, name), np.float64, (rays,), f"ray_reach.{name}")
            )
        for name in ("reached", "clear"):
            put(self, name, read_only(getattr(self, name), np.bool_, (rays,), f"ray_reach.{name}"))
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


@dataclass(frozen=True)
class ReachTask:
    """Reach envelopes that a study asks for: whose, by which hand, grip and zone, whether obstacles
    are heeded, and the index of the case of the study whose posture it begins from."""

    person: str
    limb: str
    grip: str
    zone: int
    obstacles: bool
    case: int = 0


@dataclass(frozen=True, eq=False, repr=False)
class Envelope:
    """The reach of one limb about an origin (3,) [m], the seat reference point, or the shoulder of
    who has no seat: of a person, or of a share of people.

    about: along D rays of a grid of azimuth and elevation, `step` [rad] wide, level by level from
    below and the two poles last; triangles (T, 3) between neighbouring rays; cell (D,) [sr]: the
    solid angle that each ray stands for. levels: along level rays from the upright axis through the
    origin, `step` apart, at heights (H,) [m] above it, height by height; both empty where they were
    not asked for. obstacles: whether they were heeded; parts: their names. people: 1, or of how
    many people each boundary is a percentile. origin_name: what the origin is called.
    """

    person: str
    limb: str
    zone: int
    origin: Floats
    step: float
    about: RayReach
    triangles: Ints
    cell: Floats
    heights: Floats
    levels: RayReach
    obstacles: bool
    parts: tuple[str, ...] = ()
    people: int = 1
    origin_name: str = "seat reference point"

    def __repr__(self) -> str:
        return f"Envelope({self.person}, {self.limb}, zone {self.zone}: {1000 * self.volume:.0f} litres)"

    def __post_init__(self) -> None:
        put = object.__setattr__
        rays = len(self.about)
        put(self, "origin", read_only(self.origin, np.float64, (3,), "envelope.origin"))
        put(self, "cell", read_only(self.cell, np.float64, (rays,), "envelope.cell"))
        put(
            self,
            "heights",
            read_only(self.heights, np.float64, (len(self.heights),), "envelope.heights"),
        )
        put(self, "triangles", read_only(self.triangles, np.int64, (None, 3), "envelope.triangles"))

    @property
    def volume(self) -> float:
        """[m3] between the inner and the outer boundary, obstacles aside: each ray for its solid
        angle."""
        shell = self.about.outer**3 - self.about.inner**3
        return float(np.sum(self.cell * np.where(self.about.reached, shell, 0.0)) / 3.0)

    @property
    def lost(self) -> float:
        """[m3] of it that obstacles take."""
        return sum(self.lost_to.values())

    @property
    def lost_to(self) -> dict[str, float]:
        """[m3] that each obstacle takes, the most first; by the part that a free limb would enter
        deepest."""
        lost = self.about.lost
        each = self.cell[lost.ray] * (lost.end**3 - lost.begin**3) / 3.0
        taken = {
            self.parts[k] if k >= 0 else "": float(each[lost.part == k].sum())
            for k in np.unique(lost.part)
        }
        return dict(sorted(taken.items(), key=lambda row: (-row[1], row[0])))

    def surface(self, *, clear: bool = False) -> tuple[Floats, Ints]:
        """Vertices (V, 3) [m] and triangles (T, 3) of the outer and the inner boundary as one
        closed surface, obstacles aside or clear of them, facing out of what is reached; it tapers
        to where rays that meet nothing come nearest.
        """
        outer, inner, reached = self.about.bounds(clear=clear)
        rays = len(outer)
        points = (
            np.concatenate([outer, inner])[:, None] * np.tile(self.about.direction, (2, 1))
            + self.origin
        )
        open_: Bools = reached & (outer - inner > 1e-9)
        own = np.where(open_, np.arange(rays) + rays, np.arange(rays))
        kept = self.triangles[open_[self.triangles].any(axis=1)]
        faces = np.concatenate([kept, own[kept[:, ::-1]]])
        return points, _tidy(points, faces)


def _tidy(points: Floats, faces: Ints) -> Ints:
    """Faces with corners at one place made one corner, those without an area gone."""
    _, first, same = np.unique(points.round(9), axis=0, return_index=True, return_inverse=True)
    joined = first[same.ravel()][faces]
    whole = (
        (joined[:, 0] != joined[:, 1])
        & (joined[:, 1] != joined[:, 2])
        & (joined[:, 2] != joined[:, 0])
    )
    return joined[whole]
