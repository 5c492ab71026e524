"""What is odd about a seat: its cushion and back held against each other, and the floor before it.

What a sitter rests on is sought in the mesh: the faces near the planes of cushion and back, that face
as these do. Across the seat they must lie behind and under the sitter, whose middle is over the seat
reference point.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from workbench.errors import InputError
from workbench.files.names import is_for_eyes, is_for_heels
from workbench.files.seat_figures import BENCH, Across, strip
from workbench.files.seat_search import SITTER, PartFaces, found_seat
from workbench.geometry.clipping import clip_triangles
from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats, xyz
from workbench.model.environment import Doubt, Seat
from workbench.model.joint_angles import attitude_matrix

__all__ = [
    "SEAT_PART",
    "another_seats",
    "eye_doubts",
    "floor_before",
    "floor_doubts",
    "heel_doubts",
    "place_of",
    "point_doubts",
    "rest_doubts",
    "rest_lines",
    "twice_doubts",
]

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
SEAT_PART = 1.5
"""A part that is larger [m], as far as it is about a seat, is more than a seat."""
SAME = 0.3
"""Two people whose seat reference points are nearer [m] sit in each other."""
_DEEPEST = 1.5
"""A surface farther [m] below is not the floor of this seat."""
_EYE_UP = (0.35, 1.0)
"""Eye height [m] over the seat reference point: from a child of three years (0.4 m) to more than the
99.9th percentile of men (0.92 m; ANSUR II, eye height sitting)."""
_EYE_AHEAD = 0.4
"""How far [m] an eye is ahead of the plane of the back at most: the depth of a large head, and a
neck that bends."""
_EYE_ASIDE = 0.25
_EYE_NEAR = 0.6
_FACTORS = (1e-3, 1e-2, 0.1, 10.0, 100.0, 1e3)
"""An eye point that is nearer [m] to the eyes of a seat, as seen from above, is meant for it, and one
that would be there in another unit of length; others may be of people who stand."""
_HEEL_SUNK = 0.1
"""A heel point is no more [m] under the floor that it is meant for: what is higher is over the feet."""
_HEEL_OFF = 0.03
"""How far [m] a heel point may be from the surface under or over it: a carpet, a sole."""
_FLOOR = 0.1
"""A part that is narrower [m] is no floor: a foot is so broad. It is a stick, a rail, a screw."""


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
            off[name] = math.nan if across is None else _met_first(seat, name, corners)
    if not all(abs(size) <= OFF_PLANE for size in off.values()):
        yield from _place_doubts(seat, {name: PartFaces(*faces[name]) for name in off}, off)
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


def rest_lines(seat: Seat, cushion: Across, back: Across, ground: Ground) -> Iterator[str]:
    """Return how the cushion and the back of a seat stand to each other and over the floor.

    Parameters
    ----------
    seat
        Its figures.
    cushion, back
        How they lie across it.
    ground
        What is to be stood on.
    """
    aside = round(1e3 * (back.middle - cushion.middle))
    shared = max(min(cushion.left, back.left) - max(cushion.right, back.right), 0.0)
    off = f"{abs(aside)} mm to the {'left' if aside > 0 else 'right'} of" if aside else "behind"
    yield (
        f"the middle of the back is {off} that of the cushion; the cushion is "
        f"{1e3 * cushion.wide:.0f} mm wide, the back {1e3 * back.wide:.0f} "
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


def _across(seat: Seat, name: str, corners: Floats) -> Across | None:
    """Where across a seat the faces lie that a sitter can rest on; None where there are none."""
    own = _in_plane(seat, name, corners)
    crosses = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
    area = np.linalg.norm(crosses, axis=1)
    facing = (area > 0.0) & (np.abs(crosses[:, 2]) >= ALIKE * area)
    sides = strip(own[facing], NEAR, SPAN[name])[..., 1]
    return Across(float(sides.min()), float(sides.max())) if len(sides) else None


def _in_plane(seat: Seat, name: str, corners: Floats) -> Floats:
    """(T, 3, 3) [m] faces as the plane of a cushion or a back has them: along it from the seat
    reference point, to the left, and how far before it."""
    found: Floats = (corners - np.array(seat.srp)) @ _axes(seat, name).T
    return found


def _axes(seat: Seat, name: str) -> Floats:
    """(3, 3) unit vectors, row by row: along the plane of a cushion or a back, to the left, and before
    it."""
    if name == "back":
        c, s = math.cos(seat.back_angle), math.sin(seat.back_angle)
        axes = np.array([[-s, 0.0, c], [0.0, 1.0, 0.0], [c, 0.0, s]])
    else:
        c, s = math.cos(seat.cushion_angle), math.sin(seat.cushion_angle)
        axes = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return axes @ attitude_matrix(yaw=seat.yaw).T


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


def _place_doubts(
    seat: Seat, parts: Mapping[str, PartFaces], off: Mapping[str, float]
) -> Iterator[Doubt]:
    """How far the seat reference point is from cushion and back, what that does to a sitter, and
    where it would be right. parts: of each; off: how far [m] each is before its plane, nan where no
    face of it is near."""
    right = _right_place(seat, *parts.values()) if len(parts) == len(SPAN) else None
    sizes = dict(off)
    if right is not None:
        sizes = {name: float(_axes(seat, name)[2] @ (right - seat.srp)) for name in off}
    far = {name: size for name, size in sizes.items() if abs(size) > OFF_PLANE}
    unlike = [name for name, size in off.items() if math.isnan(size)]
    if unlike and right is None:
        far = {}
    if unlike and not far:
        of = " and ".join(f"of {parts[name].name!r} in the plane of its {name}" for name in unlike)
        words = f"no face lies {of}: are the seat reference point, the angles and the part right?"
        yield Doubt(place_of(seat.name), f"seat {seat.name!r}: {words}")
    if not far:
        return
    ways = {"cushion": ("below", "above"), "back": ("behind", "ahead of")}
    where = " and ".join(
        f"{1e3 * abs(size):.0f} mm {ways[name][size < 0.0]} its {name} {parts[name].name!r}"
        for name, size in far.items()
    )
    does = "leans through the back" if far.get("back", 0.0) > 0.0 else "has no back behind"
    if "cushion" in far:
        does = "sinks through the cushion" if far["cushion"] > 0.0 else "floats above the cushion"
    words = f"its reference point is {where}, so that a sitter {does}"
    if right is not None:
        at = ", ".join(f"{round(1e3 * value) + 0}" for value in right.tolist())
        words += f"; at ({at}) mm it would be where the planes of both meet"
    lost = "cushion" in far or max(map(abs, far.values())) > LOST
    about = place_of(seat.name) if lost else f"back of seat {seat.name}"
    yield Doubt(about, f"seat {seat.name!r}: {words}")


def _right_place(seat: Seat, *parts: PartFaces) -> Floats | None:
    """(3,) [m] where the planes of cushion and back meet; None where one is no part of a seat."""
    left = attitude_matrix(yaw=seat.yaw)[:, 1]
    own = []
    for part in parts:
        corners = part.corners
        if np.ptp(corners @ left) > BENCH:  # of several seats: what is about this one
            middle = float(left @ np.array(seat.srp))
            for axis, most in ((left, middle), (-left, -middle)):
                corners = clip_triangles(corners, axis, most + 0.5 * BENCH)[0]
        if not len(corners) or np.ptp(corners.reshape(-1, 3), axis=0).max() > SEAT_PART:
            return None
        own.append(PartFaces(part.name, corners))
    try:
        return found_seat(*own).figures.srp
    except InputError:
        return None


def _aside_words(name: str, part: str, across: Across) -> str:
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


def eye_doubts(seat: Seat, name: str, point: tuple[float, float, float]) -> Iterator[str]:
    """Return where a point for the eyes [m] is out of what any sitter can have, in any position of
    the seat."""
    x, y, up = (point[axis] - seat.srp[axis] for axis in range(3))
    forward, left = attitude_matrix(yaw=seat.yaw)[:2, :2].T @ (x, y)
    usual = ", ".join(f"{1e3 * value:.0f}" for value in seat.nominal_eye)
    back = math.tan(seat.back_angle)
    aft = -_EYE_UP[1] * back
    ahead = -_EYE_UP[0] * back + _EYE_AHEAD
    ways = (
        (forward, seat.travel_forward, (aft, ahead), ("behind", "ahead of")),
        (left, (0.0, 0.0), (-_EYE_ASIDE, _EYE_ASIDE), ("to the right of", "to the left of")),
        (up, seat.travel_up, _EYE_UP, ("below", "above")),
    )
    for at, travel, (least, most), (short, beyond) in ways:
        below = travel[0] + least - at
        above = at - travel[1] - most
        if max(below, above) > 0:
            where = short if below > 0 else beyond
            yield (
                f"point {name!r} is {1e3 * max(below, above):.0f} mm {where} where the eyes of "
                f"anybody in seat {seat.name!r} can be: about ({usual}) mm is usual"
            )


def heel_doubts(
    seat: Seat, ground: Ground, name: str, point: tuple[float, float, float]
) -> Iterator[str]:
    """Return where a heel point [m] is not on what may be a floor: the highest surface under it or little
    above it, or else the floor before its seat, or else the lowest surface above."""
    heights, parts = ground.levels(np.array(point[:2]))
    broad = np.array([ground.breadth(int(part)) >= _FLOOR for part in parts], dtype=np.bool_)
    if not broad.any():
        yield f"point {name!r}: there is no floor under or over it for the heels"
        return
    heights = heights[broad]
    row = max(int((heights <= point[2] + _HEEL_SUNK).sum()) - 1, 0)
    below = Floor(float(heights[row]), ground.names[int(parts[broad][row])])
    before = floor_before(seat, ground) if below.height > point[2] + _HEEL_SUNK else None
    floor = before or below
    off = point[2] - floor.height
    if abs(off) > _HEEL_OFF:
        where = "above" if off > 0 else "under"
        what = f"the floor before seat {seat.name!r}" if before else "the surface there"
        yield (
            f"point {name!r}, where the heels stand, is {1e3 * abs(off):.0f} mm {where} {what}, "
            f"{floor.part!r}"
        )


def point_doubts(
    seats: Sequence[Seat], ground: Ground, points: Mapping[str, tuple[float, float, float]]
) -> Iterator[Doubt]:
    """Return which points are for eyes or heels of sitters by their names and places, and where none
    has these: of who sits in the nearest seat."""
    for name, at in points.items() if seats else ():
        found: Iterable[str] = ()
        if is_for_eyes(name):
            seat = min(seats, key=lambda one: math.dist(one.nominal_eye, at))
            found = list(eye_doubts(seat, name, at))
            there = [xyz(factor * np.array(at)) for factor in _FACTORS]
            slip = any(not list(eye_doubts(seat, name, place)) for place in there)
            if math.dist(seat.nominal_eye[:2], at[:2]) > _EYE_NEAR and not slip:
                found = ()  # of somebody who stands
        elif is_for_heels(name):
            seat = min(seats, key=lambda one: math.dist(one.srp, at))
            found = heel_doubts(seat, ground, name, at)
        for said in found:
            yield Doubt(f"place of point {name}", said)
