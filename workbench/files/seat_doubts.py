"""What is odd about a seat: its cushion and back held against each other, and the floor before it.

What a sitter rests on is sought in the mesh: the faces near the planes of cushion and back, that face
as these do. Across the seat they must lie behind and under the sitter, whose middle is over the seat
reference point.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats
from workbench.model.environment import Doubt, Seat
from workbench.model.posing import attitude_matrix

__all__ = [
    "SITTER",
    "another_seats",
    "floor_before",
    "floor_doubts",
    "place_of",
    "rest_doubts",
    "rest_lines",
    "twice_doubts",
]

SITTER = 0.4
"""Width [m] of who sits: hips and chest of most people, without arms (ANSUR II, hip breadth sitting
of men, 95th percentile 0.41 m)."""
HELD = 0.5
"""Share of this width that cushion and back are under and behind at least."""
NEAR = 0.08
"""How far [m] a face of a cushion or a back is from its plane at most: foam is curved."""
ALIKE = math.cos(math.radians(35.0))
"""Cosine of the angle between a face and the plane that it belongs to, at least."""
SPAN = {"cushion": (0.0, 0.6), "back": (0.05, 0.9)}
"""Where [m] along its plane from the seat reference point a sitter rests."""
OFF_PLANE = 0.06
"""A surface that is met farther [m] before or behind the plane of its seat is doubted: a fitted plane
is within 15 mm of its faces in the mean."""
MET = {"cushion": (0.1, 0.2, 0.3), "back": (0.15, 0.3, 0.45)}
"""Where [m] along its plane from the seat reference point it is asked what a sitter meets first."""
MET_ASIDE = (-0.08, 0.0, 0.08)
"""Where [m] across the seat."""
LOST = 0.2
"""A back that is farther [m] from its plane is that of a seat in another place: who sits there has the
right height otherwise."""
ALL_OVER = tuple(np.array((x, y)) for x in (0.1, 0.3, 0.5, 0.7, 0.9) for y in (0.2, 0.5, 0.8))
"""Where in the box of a cushion or a back, as shares of its extents, its outer side is asked for."""
MET_WITHIN = 0.25
"""What is farther [m] from the plane is another thing."""
OPENING = (80.0, 160.0)
"""Degrees between cushion and back: of a crouched racer's seat, of one that nearly lies."""
FEET = ((0.6, 0.75, 0.9), (-0.1, 0.1))
"""Where [m] ahead of the seat reference point, and beside it, feet are."""
CLEAR = 0.05
"""A surface less [m] below the seat reference point than this is a cushion, no floor."""
HEIGHT = (0.08, 0.65)
"""Height [m] of a seat reference point over the floor: of a glider's seat, of a high lorry's."""
SAME = 0.3
"""Two people whose seat reference points are nearer [m] sit in each other."""
_DEEPEST = 1.5
"""A surface farther [m] below is not the floor of this seat."""


@dataclass(frozen=True)
class _Across:
    """From where to where [m] across a seat something lies; left of its middle is positive."""

    right: float
    left: float


def rest_doubts(seat: Seat, cushion: Floats, back: Floats) -> Iterator[Doubt]:
    """Return what is odd about the cushion and the back of a seat.

    Parameters
    ----------
    seat
        Its figures.
    cushion, back
        (T, 3, 3) [m] the faces of each, or of the parts that they are of; of a back that has no part
        none are needed.
    """
    faces = {"cushion": (seat.cushion.part, cushion), "back": (seat.back.part, back)}
    off = {}
    for name, (part, corners) in faces.items():
        across = _across(seat, name, corners) if part else None
        words = _aside_words(name, part, across) if across is not None else ""
        if words:
            yield Doubt(f"{name} of seat {seat.name}", f"seat {seat.name!r}: {words}")
        elif part:
            off[name] = _off_plane(seat, name, corners, near=across is not None)
    if unlike := [name for name, size in off.items() if math.isnan(size)]:
        parts = " and ".join(f"of {faces[name][0]!r} in the plane of its {name}" for name in unlike)
        words = (
            f"no face lies {parts}: are the seat reference point, the angles and the part right?"
        )
        yield Doubt(place_of(seat.name), f"seat {seat.name!r}: {words}")
    elif any(abs(size) > OFF_PLANE for size in off.values()):
        named = {name: faces[name][0] for name in off}
        outer = {name: _off_plane(seat, name, faces[name][1], near=False) for name in off}
        words = _place_words(seat, named, off, outer)
        lost = abs(off.get("cushion", 0.0)) > OFF_PLANE or max(map(abs, off.values())) > LOST
        about = place_of(seat.name) if lost else f"back of seat {seat.name}"
        yield Doubt(about, f"seat {seat.name!r}: {words}")
    opening = _opening(seat)
    if not OPENING[0] <= opening <= OPENING[1]:
        yield Doubt(
            f"angles of seat {seat.name}",
            f"seat {seat.name!r}: cushion and back open by {opening:.0f} degrees, and "
            f"{OPENING[0]:g} to {OPENING[1]:g} degrees are plausible: are back_angle and "
            f"cushion_angle right, and not exchanged?",
        )


def place_of(name: str) -> str:
    """Return what a doubt about where a seat is, by its name, is about."""
    return f"place of seat {name}"


def another_seats(seat: Seat, back: Floats) -> str:
    """Return why the faces (T, 3, 3) [m] of a back cannot be those of a seat, in words; "" where
    they can: somebody leans against them."""
    across = _across(seat, "back", back)
    if across is None or (across.right < 0.5 * SITTER and across.left > -0.5 * SITTER):
        return ""
    return _aside_words("back", seat.back.part, across)


def rest_lines(seat: Seat, cushion: Floats, back: Floats, ground: Ground) -> Iterator[str]:
    """Return how the cushion and the back of a seat stand to each other and over the floor.

    Parameters
    ----------
    seat, cushion, back
        As of `rest_doubts`.
    ground
        What is to be stood on.
    """
    lap = _across(seat, "cushion", cushion)
    lean = _across(seat, "back", back)
    if lap and lean:
        aside = 0.5 * (lean.left + lean.right - lap.left - lap.right)
        shared = max(min(lap.left, lean.left) - max(lap.right, lean.right), 0.0)
        yield (
            f"the middle of the back is {1e3 * abs(aside):.0f} mm to the "
            f"{'left' if aside > 0.0 else 'right'} of that of the cushion; the cushion is "
            f"{1e3 * (lap.left - lap.right):.0f} mm wide, the back {1e3 * (lean.left - lean.right):.0f} "
            f"mm, and {1e3 * shared:.0f} mm of it are behind the cushion"
        )
    yield (
        f"cushion and back open by {_opening(seat):.0f} degrees; {OPENING[0]:g} to {OPENING[1]:g} "
        f"are plausible"
    )
    floor = floor_before(seat, ground)
    if floor is not None:
        yield (
            f"the seat reference point is {1e3 * (seat.srp[2] - floor.height):.0f} mm above "
            f"{floor.part!r}, the floor before it; {1e3 * HEIGHT[0]:.0f} to {1e3 * HEIGHT[1]:.0f} "
            f"mm are plausible"
        )


def _opening(seat: Seat) -> float:
    """Degrees between cushion and back."""
    return 90.0 + math.degrees(seat.back_angle - seat.cushion_angle)


def _across(seat: Seat, name: str, corners: Floats) -> _Across | None:
    """Where across a seat the faces lie that a sitter can rest on; None where there are none."""
    own = _in_plane(seat, name, corners)
    crosses = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
    area = np.linalg.norm(crosses, axis=1)
    facing = np.abs(crosses[:, 2]) >= ALIKE * area
    off = own[..., 2]
    way = own[..., 0]
    low, high = SPAN[name]
    near = (off.min(axis=1) <= NEAR) & (off.max(axis=1) >= -NEAR)
    within = (way.min(axis=1) <= high) & (way.max(axis=1) >= low)
    rows = (area > 0.0) & facing & near & within
    if not rows.any():
        return None
    sides = own[rows][..., 1]
    return _Across(float(sides.min()), float(sides.max()))


def _in_plane(seat: Seat, name: str, corners: Floats) -> Floats:
    """(T, 3, 3) [m] faces as the plane of a cushion or a back has them: along it from the seat
    reference point, to the left, and how far before it."""
    own = (corners - np.array(seat.srp)) @ attitude_matrix(yaw=seat.yaw)
    if name == "back":
        c, s = math.cos(seat.back_angle), math.sin(seat.back_angle)
        axes = np.array([[-s, 0.0, c], [0.0, 1.0, 0.0], [c, 0.0, s]])
    else:
        c, s = math.cos(seat.cushion_angle), math.sin(seat.cushion_angle)
        axes = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return own @ axes.T


def _met_first(seat: Seat, name: str, corners: Floats) -> float:
    """How far [m] before the plane of a cushion or a back a sitter meets its faces first, in the
    middle of several places; 0 where most of them meet nothing."""
    own = _in_plane(seat, name, corners)
    count = len(own)
    faces = Ground(own, np.zeros(count, dtype=np.int64), (name,), np.zeros(count, dtype=np.bool_))
    places = [(along, aside) for along in MET[name] for aside in MET_ASIDE]
    met = []
    for place in places:
        heights = faces.levels(np.array(place))[0]
        near = heights[np.abs(heights) <= MET_WITHIN]
        met += near[-1:].tolist()
    return float(np.median(met)) if 2 * len(met) > len(places) else 0.0


def _off_plane(seat: Seat, name: str, corners: Floats, *, near: bool) -> float:
    """How far [m] before the plane of a cushion or a back its faces are; nan where none faces as it
    does. near: whether some are near the plane: then what a sitter meets counts, else the outer side
    of the part, in the middle of places all over it."""
    if near:
        return _met_first(seat, name, corners)
    own = _in_plane(seat, name, corners)
    crosses = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
    own = own[np.abs(crosses[:, 2]) >= ALIKE * np.linalg.norm(crosses, axis=1)]
    if not len(own):
        return math.nan
    low, high = own[..., :2].min(axis=(0, 1)), own[..., :2].max(axis=(0, 1))
    count = len(own)
    faces = Ground(own, np.zeros(count, dtype=np.int64), (name,), np.zeros(count, dtype=np.bool_))
    met = []
    for share in ALL_OVER:
        heights = faces.levels(low + share * (high - low))[0]
        met += heights[-1:].tolist()
    return float(np.median(met)) if met else math.nan


def _place_words(
    seat: Seat, parts: Mapping[str, str], off: Mapping[str, float], outer: Mapping[str, float]
) -> str:
    """How far the seat reference point is from cushion and back, what that does to a sitter, and
    where it would be right. parts: of each; off, outer: how far [m] what a sitter meets and the whole
    outer side are before the plane."""
    ways = {"cushion": ("below", "above"), "back": ("behind", "ahead of")}
    where = [
        f"{1e3 * abs(size):.0f} mm {ways[name][size < 0.0]} its {name} {parts[name]!r}"
        for name, size in off.items()
        if abs(size) > OFF_PLANE
    ]
    cushion = off.get("cushion", 0.0)
    back = off.get("back", 0.0)
    does = "leans through the back" if back > 0.0 else "has no back behind"
    if abs(cushion) > OFF_PLANE:
        does = "sinks through the cushion" if cushion > 0.0 else "floats above the cushion"
    sides = [outer.get("cushion", 0.0), outer.get("back", 0.0)]
    # the shift (x, z) whose part along either normal is what that plane is off
    normals = np.array(
        [
            [-math.sin(seat.cushion_angle), math.cos(seat.cushion_angle)],
            [math.cos(seat.back_angle), math.sin(seat.back_angle)],
        ]
    )
    ahead, up = np.linalg.solve(normals, np.nan_to_num(sides)).tolist()
    right = np.array(seat.srp) + attitude_matrix(yaw=seat.yaw) @ np.array([ahead, 0.0, up])
    at = ", ".join(f"{round(1e3 * value) + 0}" for value in right.tolist())
    return (
        f"its reference point is {' and '.join(where)}, so that a sitter {does}; at ({at}) mm it would be "
        f"where the planes of both meet"
    )


def _aside_words(name: str, part: str, across: _Across) -> str:
    """How far a cushion or a back is beside the sitter; "" where it is not."""
    under = "under" if name == "cushion" else "behind"
    half = 0.5 * SITTER
    held = min(across.left, half) - max(across.right, -half)
    if held >= HELD * SITTER:
        return ""
    middle = 0.5 * (across.left + across.right)
    side = "left" if middle > 0.0 else "right"
    called = name if part == name else f"{name} {part!r}"
    lead = f"its {called} lies {1e3 * abs(middle):.0f} mm to the {side} of its middle"
    if held <= 0.0:
        return f"{lead}, and nothing is {under} the sitter: is it that of another seat?"
    return (
        f"{lead}, and {1e3 * held:.0f} of the {1e3 * SITTER:.0f} mm of a sitter have it {under} "
        f"them: is it all of the {name}, and of this seat?"
    )


@dataclass(frozen=True)
class Floor:
    """The floor before a seat: its height [m] and its part."""

    height: float
    part: str


def floor_before(seat: Seat, ground: Ground) -> Floor | None:
    """Return the floor where the feet of a sitter are likely: the highest surface below the seat,
    in the middle of several places; None where there is none at most of them."""
    heading = attitude_matrix(yaw=seat.yaw)
    found: list[Floor] = []
    places = [(ahead, aside) for ahead in FEET[0] for aside in FEET[1]]
    for ahead, aside in places:
        at = np.array(seat.srp) + heading @ np.array([ahead, aside, 0.0])
        heights, parts = ground.levels(at[:2])
        below = (heights < seat.srp[2] - CLEAR) & (heights > seat.srp[2] - _DEEPEST)
        if below.any():
            top = int(np.flatnonzero(below)[-1])
            found.append(Floor(float(heights[top]), ground.names[int(parts[top])]))
    if 2 * len(found) <= len(places):
        return None
    return sorted(found, key=lambda floor: floor.height)[len(found) // 2]


def floor_doubts(seat: Seat, ground: Ground) -> Iterator[Doubt]:
    """Return what is odd about the floor before a seat."""
    about = f"floor of seat {seat.name}"
    floor = floor_before(seat, ground)
    if floor is None:
        yield Doubt(
            about,
            f"seat {seat.name!r}: there is no floor before it, {1e3 * FEET[0][0]:.0f} to "
            f"{1e3 * FEET[0][-1]:.0f} mm ahead of its reference point: feet find nothing to stand "
            f"on",
        )
        return
    low = seat.srp[2] + seat.travel_up[0] - floor.height
    high = seat.srp[2] + seat.travel_up[1] - floor.height
    if high < HEIGHT[0] or low > HEIGHT[1]:
        height = seat.srp[2] - floor.height
        yield Doubt(
            about,
            f"seat {seat.name!r}: its reference point is {1e3 * height:.0f} mm above "
            f"{floor.part!r}, the floor before it, and {1e3 * HEIGHT[0]:.0f} to "
            f"{1e3 * HEIGHT[1]:.0f} mm is plausible: is the seat right, or the floor another part?",
        )


def twice_doubts(seats: Sequence[Seat]) -> Iterator[Doubt]:
    """Return which seats are in each other."""
    for one, other in combinations(seats, 2):
        apart = math.dist(one.srp, other.srp)
        if apart < SAME:
            yield Doubt(
                f"seats {one.name} and {other.name}",
                f"seats {one.name!r} and {other.name!r} are {1e3 * apart:.0f} mm apart: people in "
                f"both are in each other: is one of them that of another place?",
            )
