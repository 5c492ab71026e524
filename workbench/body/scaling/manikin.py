"""Hold a body in the postures of anthropometry, to read off lengths as an anthropometer does.

A length is a sum of reaches: how far a sphere's surface, or a joint, lies along a direction. With
its extreme spheres held fixed, a length is linear in the body's coordinates and radii. On a seat
the flesh of hips and thighs is spread (see `scaling.seated`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.body.scaling.rig import ON_A_SEAT, POSTURES, Shape, rig_of
from workbench.body.scaling.seated import SeatedFlesh, seated_flesh
from workbench.errors import InputError
from workbench.geometry.overlap import segment_overlaps
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body, check_one

__all__ = [
    "AXES",
    "BACK",
    "DOWN",
    "FRONT",
    "LEFT",
    "QUEUE",
    "RIGHT",
    "SEATED",
    "UP",
    "Band",
    "Length",
    "Manikin",
    "PointExtent",
]

FRONT, BACK, LEFT, RIGHT, UP, DOWN = range(6)
"""Directions: x forward and back, y left and right, z up and down."""
AXES = np.repeat(np.eye(3), 2, axis=0) * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])[:, None]
"""(6, 3) unit vectors of the directions."""
_BAND_SLOPE = 2.0
"""By how much a reach counts less for each metre that its sphere is beyond a band."""
_TAPE = 48
"""Directions in which a tape's reach is taken."""
_CROSSES = 0.98
"""Share of its radius that a sphere's centre may be off a tape: beyond, its circle is a mere dot."""
QUEUE = {name: q for q, name in enumerate(POSTURES)}
"""Number of each posture in arrays of all postures."""
SEATED = frozenset(QUEUE[name] for name in ON_A_SEAT)
"""The postures on a seat, by number."""


class PointExtent(NamedTuple):
    """How far one point lies along a direction in a posture: of a sphere, or of a joint."""

    posture: str
    direction: int
    """0 to 5, see AXES."""
    sphere: int = -1
    """Number of the sphere, -1 for a joint."""
    joint: int = -1
    """Number of the joint, -1 for a sphere."""
    surface: bool = True
    """True for the sphere's surface, False for its centre."""


@dataclass(frozen=True)
class Length:
    """A sum of signed reaches."""

    terms: tuple[tuple[float, PointExtent], ...]
    """Factors and reaches."""
    fixed: float = 0.0
    """What does not change with the body [m]."""

    def __add__(self, other: Length) -> Length:
        return Length(self.terms + other.terms, self.fixed + other.fixed)

    def __sub__(self, other: Length) -> Length:
        return self + other * -1.0

    def __mul__(self, factor: float) -> Length:
        return Length(
            tuple((factor * sign, reach) for sign, reach in self.terms), factor * self.fixed
        )


class Band(NamedTuple):
    """Spheres of some segments near a level."""

    level: Length
    """Level along the direction that the band lies across."""
    half_width: float
    """Distance [m] on either side of the level."""
    where: Sequence[str]
    """Segments ("LF") or subparts ("LF/heel")."""


class Manikin:
    """A body, or a changed shape of one, in the postures of anthropometry."""

    def __init__(self, body: Body, shape: Shape | None = None) -> None:
        """Hold a body in all postures.

        Raises
        ------
        InputError
            If the body lacks joints that the postures name, so that it is not a human body.
        """
        check_one(body)
        missing = sorted(
            {joint for angles in POSTURES.values() for joint in angles} - set(body.joints)
        )
        if missing:
            raise InputError(
                f"body {body.name} cannot be measured as a person: it has no joint {', '.join(missing)}"
            )
        self.body = body
        self.rig = rig_of(body)
        self._found = _landmarks(body.segments, body.sphere_names, body.start.tobytes())
        self._take(
            shape
            or Shape(
                body.centre[0], body.radius[0], body.joint_in_parent[0], body.joint_in_child[0]
            )
        )

    def _take(self, shape: Shape) -> None:
        self.shape = shape
        self._origin, self.joints = self.rig.origins(shape)
        self.flesh: SeatedFlesh | None = seated_flesh(self.body, shape)
        self._seen: dict[int, tuple[Floats, Floats, Floats]] = {}
        self._farthest: dict[tuple[str, int, tuple[str, ...]], Length] = {}
        self.lengths: dict[tuple[str, ...], Length] = {}
        """Measures and levels that are known, by name and, of a level, posture."""

    def _posture(self, queue: int) -> tuple[Floats, Floats, Floats]:
        """Sphere centres (S, 3) in a posture, computed when first needed.

        Then, along each direction, how far each sphere's centre and its surface lie, (6, S) each.
        """
        if queue not in self._seen:
            shape = self.shape
            if self.flesh is not None and queue in SEATED:
                shape = self.flesh.spread(shape)
            centres = self.rig.spheres(shape, self._origin, queue)
            middles = np.empty((6, len(centres)))
            middles[0::2] = centres.T
            middles[1::2] = -middles[0::2]
            self._seen[queue] = centres, middles, middles + shape.radius
        return self._seen[queue]

    def centres(self, posture: str) -> Floats:
        """Return the sphere centres (S, 3) in the world [m], with the stage at the origin."""
        return self._posture(QUEUE[posture])[0]

    def changed(self, shape: Shape) -> Manikin:
        """Return the same body with another shape."""
        other = object.__new__(Manikin)
        other.body = self.body
        other.rig = self.rig
        other._found = self._found
        other._take(shape)
        return other

    def lowest(self) -> float:
        """Return the height [m] of the lowest surface above the stage, standing."""
        return -float(self._posture(QUEUE["standing"])[2][DOWN].max())

    def overlaps(self) -> Floats:
        """Return the greatest depth (N, N) [m] of two segments without a common joint in each other, standing or sitting."""
        deepest = np.zeros(self.body.allowance[0].shape)
        asked = ~self.body.adjacent
        for posture in ("standing", "sitting"):
            centres, middles, surfaces = self._posture(QUEUE[posture])
            radius = surfaces[UP] - middles[UP]
            segment_overlaps(centres, radius, self.body.start, asked, deepest)
        return deepest

    def value(self, length: Length) -> float:
        """Return a length [m]. With extreme spheres of another shape it is linear in this one."""
        total = length.fixed
        for sign, (posture, direction, sphere, joint, surface) in length.terms:
            q = QUEUE[posture]
            if joint >= 0:
                far = self.joints[q, joint, direction // 2]
                total += sign * float(-far if direction % 2 else far)
            else:
                total += sign * float(self._posture(q)[2 if surface else 1][direction, sphere])
        return total

    def farthest(self, posture: str, direction: int, where: Iterable[str]) -> Length:
        """Return the farthest surface along a direction, of segments ("LF") or subparts ("LF/heel")."""
        key = posture, direction, tuple(where)
        found = self._farthest.get(key)
        if found is None:
            rows = self._rows(key[2])
            best = int(rows[self._posture(QUEUE[posture])[2][direction][rows].argmax()])
            found = self._farthest[key] = Length(((1.0, PointExtent(posture, direction, best)),))
        return found

    def band(
        self,
        posture: str,
        direction: int,
        band: Band,
        *,
        along: int = UP,
    ) -> Length:
        """Return the farthest surface along a direction, of spheres in a band across `along`.

        A sphere beyond the half width counts less by _BAND_SLOPE times what it is beyond, so that a
        measure changes smoothly where a sphere enters the band.

        Raises
        ------
        InputError
            If no sphere is in the band.
        """
        rows = self._rows(band.where)
        _, middles, surfaces = self._posture(QUEUE[posture])
        off = middles[along][rows] - self.value(band.level)
        beyond = np.abs(off) - band.half_width
        if not (beyond <= 0).any():
            raise InputError(
                f"body {self.body.name} has no spheres within {1000 * band.half_width:.0f} mm of that level"
            )
        k = int((surfaces[direction][rows] - _BAND_SLOPE * np.maximum(beyond, 0.0)).argmax())
        best = int(rows[k])
        found = Length(((1.0, PointExtent(posture, direction, best)),))
        if beyond[k] <= 0:
            return found
        side = _BAND_SLOPE if off[k] > 0 else -_BAND_SLOPE
        aside = Length(((1.0, PointExtent(posture, along, best, surface=False)),)) - band.level
        return found - aside * side + Length((), _BAND_SLOPE * band.half_width)

    def tape(self, level: Length, where: Iterable[str]) -> Length:
        """Return the length of a tape around spheres at a level, standing.

        A sphere of radius r whose centre is d off the level shows a circle of radius s there,
        s = sqrt(r^2 - d^2). A tight tape runs along the convex hull of the circles, whose perimeter
        is the mean of its breadths over all directions times pi (Cauchy): the sum of how far it
        reaches in _TAPE directions, times 2 pi / _TAPE. With the farthest circles held,
        s = (r / s) r - (d / s) d is linear in r and d to the first order.

        Raises
        ------
        InputError
            If no sphere crosses the level.
        """
        posture = "standing"
        rows = self._rows(where)
        _, middles, surfaces = self._posture(QUEUE[posture])
        radius = surfaces[UP, rows] - middles[UP, rows]
        off = middles[UP, rows] - self.value(level)
        crossing = np.abs(off) < _CROSSES * radius
        rows, radius, off = rows[crossing], radius[crossing], off[crossing]
        if not len(rows):
            raise InputError(f"body {self.body.name} has no spheres for a tape at that level")
        shown = np.sqrt(radius**2 - off**2)
        angle = 2.0 * np.pi / _TAPE * np.arange(_TAPE)
        ways = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        best = (ways @ middles[[FRONT, LEFT]][:, rows] + shown).argmax(axis=1)
        found = Length(())
        for k in np.unique(best).tolist():
            row = int(rows[k])
            x, y = ways[best == k].sum(axis=0).tolist()
            circles = float(np.sum(best == k) / shown[k])
            spot = [PointExtent(posture, way, row, surface=False) for way in (FRONT, LEFT, UP)]
            grown = Length(((1.0, PointExtent(posture, UP, row)), (-1.0, spot[2])))
            aside = Length(((1.0, spot[2]),)) - level
            found += Length(((x, spot[0]), (y, spot[1])))
            found += grown * (circles * float(radius[k])) - aside * (circles * float(off[k]))
        return found * (2.0 * np.pi / _TAPE)

    def middle(self, posture: str, direction: int, subpart: str) -> Length:
        """Return the centre of a named sphere along a direction."""
        row = int(self._rows([subpart])[0])
        return Length(((1.0, PointExtent(posture, direction, row, surface=False)),))

    def joint(self, posture: str, direction: int, name: str) -> Length:
        """Return a joint along a direction."""
        return Length(((1.0, PointExtent(posture, direction, joint=self.body.joint(name))),))

    def _rows(self, where: Iterable[str]) -> Ints:
        """The spheres of segments ("LF") or subparts ("LF/heel"), looked up once for all shapes of a body."""
        key = tuple(where)
        if key not in self._found:
            rows = [row for name in key for row in self._named(name)]
            if not rows:  # of two feet one may be missing
                names = ", ".join(key)
                raise InputError(
                    f"body {self.body.name}: {names} is missing, and with it what is measured there"
                )
            self._found[key] = np.array(rows)
        return self._found[key]

    def _named(self, name: str) -> list[int]:
        segment, _, subpart = name.partition("/")
        rows = range(*self.body.spheres(self.body.segment(segment)).indices(len(self.rig.segment)))
        # what is worn over a subpart has its name ("heel (boots)") and comes after it
        worn = f"{subpart} ("
        named = [
            row
            for row in rows
            if not subpart
            or (label := self.body.sphere_names[row]) == subpart
            or label.startswith(worn)
        ]
        if subpart and not named:
            raise InputError(
                f"body {self.body.name}: segment {segment} has no sphere named {subpart!r}"
            )
        return named


@lru_cache(maxsize=16)
def _landmarks(
    segments: tuple[str, ...], names: tuple[str, ...], start: bytes
) -> dict[tuple[str, ...], Ints]:
    """A dictionary that keeps the spheres of landmarks, one for all bodies with the same names."""
    del segments, names, start
    return {}
