"""The figures of a seat from the planes of its cushion and its back.

The two planes meet in a line. The seat reference point is where this line crosses the middle of the
cushion, or where it crosses the place that was pointed at, of a bench for several; the seat looks along the level direction square to the line, from the back over the
cushion. Angles are those of the planes in the upright plane of that direction: of the cushion above
the level, front edge up; of the back from the vertical, aft. These are the definitions of
`workbench.model.environment.Seat`, whose planes are level across the seat.

The middle of a surface is that of the strip of its part which lies near its plane: which faces grew
depends on how the mesh is cut into triangles, and the strip does not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.files.surface_planes import PlaneFit, fitted_plane
from workbench.geometry.clipping import clip_triangles
from workbench.model.arrays import Floats

__all__ = ["BENCH", "Across", "SeatFigures", "seat_figures", "strip"]

PARALLEL = math.radians(20.0)
"""Planes at a smaller angle [rad] to each other meet nowhere in particular."""
ROLLED = math.radians(15.0)
"""A line of cushion and back that slopes more [rad] across the seat is none of a seat."""
STRAIGHT = math.radians(2.0)
"""A seat that is turned less [rad] from straight ahead, back or aside is straight: planes of curved
cushions are not known better."""
STEEP = math.radians(50.0)
"""A cushion that slopes more [rad] is a back."""
LYING = math.radians(75.0)
"""A back farther [rad] from the vertical is a cushion."""
UNEVEN = 0.015
"""A surface whose faces are farther [m] from their plane, in the root mean square, is no plane."""
LONGEST = {"cushion": 0.8, "back": 1.2}
"""A cushion that is longer [m] from back to front, or a back that is higher, is odd."""
BENCH = 0.75
"""A cushion that is wider [m] is a bench for several: the seat is where it was pointed at."""
AWAY = 0.4
"""A seat reference point that is farther [m] from what was picked of the cushion is odd."""
STRIP = 0.02
"""A part is of a surface as far as it lies within this distance [m] of the plane: as deep as the middle
of a curved cushion, and less than a bolster is high."""
STRIP_LONG = (0.2, 0.8)
"""From where to where along a surface, as shares of its length, its sides are sought: away from its
corners, and from where a cushion meets the back."""
TOUCHING = 0.001
"""Pieces of a part that are nearer [m] to each other across the seat are of one surface."""


@dataclass(frozen=True)
class Across:
    """From where to where [m] across a seat something lies; left of its middle is positive."""

    right: float
    left: float

    @property
    def middle(self) -> float:
        """Halfway between its sides."""
        return 0.5 * (self.right + self.left)

    @property
    def wide(self) -> float:
        """From side to side."""
        return self.left - self.right


@dataclass(frozen=True, eq=False)
class SeatFigures:
    """A seat as its faces give it.

    Parameters
    ----------
    srp
        (3,) [m] seat reference point.
    cushion_angle, back_angle, yaw
        [rad] as of `workbench.model.environment.Seat`.
    cushion, back
        The planes.
    cushion_sides, back_sides
        How they lie across the seat, from its reference point.
    across
        Where across the cushion the seat reference point is, in words.
    doubts
        Sentences about what is odd.
    """

    srp: Floats
    cushion_angle: float
    back_angle: float
    yaw: float
    cushion: PlaneFit
    back: PlaneFit
    cushion_sides: Across
    back_sides: Across
    across: str
    doubts: tuple[str, ...]


def seat_figures(
    cushion: Floats,
    back: Floats,
    picked: Floats,
    *,
    cushion_part: Floats | None = None,
    back_part: Floats | None = None,
) -> SeatFigures:
    """Compute the figures of a seat.

    Parameters
    ----------
    cushion, back
        (T, 3, 3) [m] faces of each in the world, z up.
    picked
        (N, 3) [m] where the cushion was pointed at: across a bench the seat is in their middle.
    cushion_part, back_part
        (T, 3, 3) [m] all faces of the part of each; no more than its own if None.

    Raises
    ------
    InputError
        If the planes are parallel, exchanged, or no seat's.
    """
    lap = fitted_plane(cushion)
    lean = fitted_plane(back)
    yaw, turned = _heading(_fold(lap, lean), lap, lean)
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    above = np.array([0.0, 0.0, 1.0])
    aside = np.cross(above, ahead)
    cushion_angle = _half_turn(math.atan2(-float(lap.normal @ ahead), float(lap.normal[2])))
    back_angle = _half_turn(math.atan2(float(lean.normal[2]), float(lean.normal @ ahead)))
    _check_angles(cushion_angle, back_angle)
    along = math.cos(cushion_angle) * ahead + math.sin(cushion_angle) * above
    sides = _sides(
        cushion if cushion_part is None else cushion_part, cushion, lap.centre, along, aside
    )
    along = math.cos(back_angle) * above - math.sin(back_angle) * ahead
    back_sides = _sides(back if back_part is None else back_part, back, lean.centre, along, aside)
    bench = sides.wide > BENCH
    across = float((picked @ aside).mean()) if bench else sides.middle
    srp = _reference_point(lap, lean, across * aside, ahead)
    away = float(np.linalg.norm(cushion.reshape(-1, 3) - srp, axis=1).min())
    extents = {"cushion": float(np.ptp(cushion @ ahead)), "back": float(np.ptp(back @ above))}
    doubts = _bench_doubt(sides.wide) + _size_doubts(extents) + _doubts(lap, lean, turned, away)
    words = "where it was clicked" if bench else "in the middle of the cushion"
    lap_sides, lean_sides = (
        Across(one.right - across, one.left - across) for one in (sides, back_sides)
    )
    angles = (cushion_angle, back_angle, yaw)
    return SeatFigures(srp, *angles, lap, lean, lap_sides, lean_sides, words, doubts)


def _fold(lap: PlaneFit, lean: PlaneFit) -> Floats:
    """Unit vector (3,) along the line in which the planes of cushion and back meet; InputError where
    they hardly do, or not across a seat."""
    line = np.cross(lap.normal, lean.normal)
    size = float(np.linalg.norm(line))
    if size < math.sin(PARALLEL):
        degrees = math.degrees(math.asin(min(size, 1.0)))
        raise InputError(
            f"cushion and back are parallel, {degrees:.0f} degrees apart: pick faces of both"
        )
    line /= size
    slope = math.asin(min(abs(float(line[2])), 1.0))
    if slope > ROLLED:
        raise InputError(
            f"the line of cushion and back slopes {math.degrees(slope):.0f} degrees across the "
            f"seat: are up and forward right?"
        )
    return line


def _reference_point(lap: PlaneFit, lean: PlaneFit, middle: Floats, ahead: Floats) -> Floats:
    """(3,) [m] where both planes meet in the upright plane through a point along a direction ahead:
    with p = middle + a ahead + b up, n . (p - c) = 0 for either normal n and centre c."""
    above = np.array([0.0, 0.0, 1.0])
    planes = np.array([[n @ ahead, n @ above] for n in (lap.normal, lean.normal)])
    offsets = [plane.normal @ (plane.centre - middle) for plane in (lap, lean)]
    forward, up = np.linalg.solve(planes, offsets)
    return np.asarray(middle + forward * ahead + up * above)


def _sides(part: Floats, surface: Floats, centre: Floats, along: Floats, aside: Floats) -> Across:
    """From where to where [m] across a seat a part lies near the plane of a surface of it, side by side
    with the surface.

    part, surface: (T, 3, 3) [m] faces. centre: (3,) of the plane. along, aside: (3,) unit vectors in it.
    """
    axes = np.stack([along, aside, np.cross(along, aside)], axis=1)
    own = (surface - centre) @ axes
    low, high = own[..., 0].min(), own[..., 0].max()
    spans = [float(low + share * (high - low)) for share in STRIP_LONG]
    places = strip((part - centre) @ axes, STRIP, (spans[0], spans[1]))[..., 1]
    at = float(centre @ aside)
    right, left = own[..., 1].min(), own[..., 1].max()
    if not len(places):  # faces on both sides of their plane
        places = own[..., 1]
    # pieces that touch are joined, from right to left; the row that has most of the surface counts
    order = np.argsort(places.min(axis=1))
    starts = places.min(axis=1)[order]
    reach = np.maximum.accumulate(places.max(axis=1)[order])
    gaps = np.flatnonzero(starts[1:] > reach[:-1] + TOUCHING)
    starts = starts[np.append(0, gaps + 1)]
    ends = reach[np.append(gaps, len(reach) - 1)]
    row = int(np.argmax(np.minimum(ends, left) - np.maximum(starts, right)))
    return Across(at + float(starts[row]), at + float(ends[row]))


def strip(own: Floats, within: float, along: tuple[float, float]) -> Floats:
    """Cut out what of faces is near a plane.

    Parameters
    ----------
    own
        (T, 3, 3) [m] faces by axes of the plane: along it, across it, before it.
    within
        How far [m] from the plane at most.
    along
        From where to where [m] along it.

    Returns
    -------
    Floats
        (K, 3, 3) pieces of the faces.
    """
    for axis, most in (
        ((0, 0, 1), within),
        ((0, 0, -1), within),
        ((1, 0, 0), along[1]),
        ((-1, 0, 0), -along[0]),
    ):
        own = clip_triangles(own, np.array(axis), most)[0]
    return own


def _heading(line: Floats, lap: PlaneFit, lean: PlaneFit) -> tuple[float, float]:
    """Yaw [rad] of a seat, straight where it nearly is, and by how much it was turned to that."""
    level = np.array([line[1], -line[0], 0.0]) / np.hypot(line[0], line[1])
    # a point of the line beside the cushion, by the two planes and the one square to the line
    ways = np.stack([lap.normal, lean.normal, line])
    met = np.linalg.solve(
        ways, [lap.normal @ lap.centre, lean.normal @ lean.centre, line @ lap.centre]
    )
    if (lap.centre - met) @ level < 0.0:
        level = -level
    yaw = math.atan2(float(level[1]), float(level[0]))
    quarter = round(yaw / (0.5 * math.pi)) * 0.5 * math.pi
    if abs(yaw - quarter) > STRAIGHT:
        return yaw, 0.0
    straight = math.pi if abs(quarter + math.pi) < 1e-9 else quarter
    return straight, abs(yaw - quarter)


def _half_turn(angle: float) -> float:
    """An angle of a line [rad], which may be turned by half a turn, between -pi/2 and pi/2."""
    return (angle + 0.5 * math.pi) % math.pi - 0.5 * math.pi


def _check_angles(cushion: float, back: float) -> None:
    """InputError where a cushion is too steep or a back lies."""
    if abs(cushion) > STEEP or abs(back) > LYING:
        raise InputError(
            f"the cushion slopes {math.degrees(cushion):.0f} degrees and the back leans "
            f"{math.degrees(back):.0f} degrees from the vertical: were they exchanged, or is up "
            f"another axis?"
        )
    if back < -0.25 * math.pi:
        raise InputError(
            f"the back leans {math.degrees(-back):.0f} degrees forward: pick its front side"
        )


def _bench_doubt(wide: float) -> tuple[str, ...]:
    if wide <= BENCH:
        return ()
    words = "the seat is where it was clicked; type the y of its SRP if it is elsewhere"
    return (f"the cushion is a bench of {1e3 * wide:.0f} mm: {words}",)


def _size_doubts(extents: Mapping[str, float]) -> tuple[str, ...]:
    return tuple(
        f"the {surface} is {1e3 * extent:.0f} mm {'high' if surface == 'back' else 'long'}, and "
        f"{1e3 * LONGEST[surface]:.0f} mm at most is usual: is it one?"
        for surface, extent in extents.items()
        if extent > LONGEST[surface]
    )


def _doubts(lap: PlaneFit, lean: PlaneFit, turned: float, away: float) -> tuple[str, ...]:
    found = []
    if away > AWAY:
        found.append(
            f"the seat reference point is {1e3 * away:.0f} mm away from the cushion: is this its "
            f"back?"
        )
    for name, plane in (("cushion", lap), ("back", lean)):
        if plane.off > UNEVEN:
            found.append(
                f"the faces of the {name} are {1e3 * plane.off:.0f} mm from their plane in the "
                f"mean: pick fewer"
            )
    if turned > math.radians(0.05):
        found.append(
            f"by its planes the seat is turned {math.degrees(turned):.1f} degrees; it is taken as "
            f"straight"
        )
    return tuple(found)
