"""What rests on a seat, of many bodies at once: heights that do not change with the legs, packed
for the kernel."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place, segment_frames
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.environment import Rest, Seat
from workbench.model.kept import kept_by_row
from workbench.model.poses import Poses
from workbench.posture.kernels.seated_posture import Sitting
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.packing import packed_limbs
from workbench.posture.seating.seating import seat_attitude, seat_planes

__all__ = [
    "FrontFaces",
    "SeatContact",
    "at_rest",
    "front_faces",
    "lap_of",
    "pressed_thighs",
    "sitting_of",
    "thighs_of",
]


@dataclass(frozen=True, eq=False)
class SeatContact:
    """The segment that the legs hang on, of B people who lean with the seat's back.

    lean (B, 3, 4): its frame where the segment that poses are placed by is at the origin; attitude
    (B, 3, 4): the same with itself at the origin; eyes (B, 3) [m]: from it to the middle of the
    eyes; wanted (B,) [m]: its height that brings the eyes to theirs, NaN where none is asked for.
    """

    segment: int
    lean: Floats
    attitude: Floats
    eyes: Floats
    wanted: Floats


def lap_of(body: Body, poses: Poses, seat: Seat, *, segment: int, eye: float | None) -> SeatContact:
    """The laps of bodies in poses, a row each. InputError where eyes are asked for that a body does
    not have."""
    world = np.zeros((len(poses), 3, 4))
    world[:, :, :3] = seat_attitude(seat)
    lean = segment_frames(body, Poses(poses.rotations, poses.reference, world), segment)
    attitude = lean.copy()
    attitude[:, :, 3] = 0.0
    names = ("left eye", "right eye")
    eyes = np.full((len(poses), 3), np.nan)
    if all(name in body.sphere_names for name in names):
        sphere = [body.sphere_names.index(name) for name in names]
        head = segment_frames(
            body, Poses(poses.rotations, segment, attitude), int(body.sphere_segment[sphere[0]])
        )
        eyes = (
            np.einsum("bij,bj->bi", head[:, :, :3], body.centre[:, sphere].mean(axis=1))
            + head[:, :, 3]
        )
    elif eye is not None:
        raise InputError(f"body {body.name} has no spheres 'left eye' and 'right eye'")
    return SeatContact(
        segment,
        lean,
        attitude,
        eyes,
        np.full(len(poses), np.nan) if eye is None else eye - eyes[:, 2],
    )


def sitting_of(
    body: Body,
    poses: Poses,
    seat: Seat,
    lap: SeatContact,
    rise: Floats,
    *,
    feet: Collection[str] = (),
) -> Sitting:
    """How bodies sit on a seat that may travel up by rise (B, 2) [m], least and greatest, with some
    feet on pedals.

    InputError where no segment with spheres rests there.
    """
    segment = lap.segment
    lean = lap.lean
    cushion, back, centre = seat_planes(seat)
    ways = np.stack([cushion, back])
    counts = np.stack([_resting(body, rest) for rest in (seat.cushion, seat.back)])
    moving = counts.any(axis=0) & _by_legs(body, segment)
    still = counts.any(axis=0) & ~moving
    fixed = np.full((len(body), 2), np.inf)
    if still.any():
        fixed = _least_heights(body, poses.rotations, lap, still, ways, counts)
    point = np.array(seat.srp)
    depth = np.array([seat.cushion.depth, seat.back.depth])
    level = np.concatenate(
        [
            np.repeat((ways @ point - depth)[None], len(body), axis=0),
            (centre @ point + lean[:, :, 3] @ centre)[:, None],
        ],
        axis=1,
    )
    segments = tuple(np.flatnonzero(moving).tolist()) or (segment,)
    thighs = thighs_of(body, feet)
    front = front_faces(seat)
    faces = len(front.normal) if thighs else 0
    return Sitting(
        limbs=packed_limbs(body, _rests(body, segment, segments)),
        counts=counts,
        ways=ways,
        fixed=fixed,
        lap=lap.attitude,
        level=level,
        solve=np.linalg.inv(np.stack([cushion, back, centre])),
        ahead=np.array([centre[1], -centre[0], 0.0]),
        rise=rise,
        eye=lap.wanted,
        thighs=packed_limbs(body, _rests(body, segment, thighs or (segment,))),
        front=front.normal[:faces],
        at_front=front.offset[:faces],
        gives=front.gives,
    )


def at_rest(
    body: Body, lap: SeatContact, sitting: Sitting, rotations: Floats
) -> tuple[Floats, Floats]:
    """Where the lap (B, 3) [m] comes to rest with the legs as they are, the seat not moved forward,
    and the seat's travel up (B,) [m] that brings the eyes to their height."""
    segments = np.isin(np.arange(len(body.segments)), sitting.limbs.segment)
    heights = _least_heights(body, rotations, lap, segments, sitting.ways, sitting.counts)
    off = sitting.level.copy()
    off[:, :2] -= np.minimum(heights, sitting.fixed)
    at: Floats = off @ sitting.solve.T
    wanted = np.where(np.isnan(sitting.eye), 0.0, sitting.eye - at[:, 2])
    up = np.clip(wanted, *sitting.rise.T)
    at[:, 2] += up
    return at, up


def _least_heights(
    body: Body, rotations: Floats, lap: SeatContact, segments: Bools, ways: Floats, counts: Bools
) -> Floats:
    """(B, W) least height [m] of the spheres of some segments (N,) along each of the directions
    ways (W, 3), from the lap's origin.

    rotations (B, J, 4); counts (W, N): the segments that count for each direction.
    """
    names = [body.segments[n] for n in np.flatnonzero(segments)]
    poses = Poses(rotations, lap.segment, lap.attitude)
    placed = place(body, poses, window=names)
    heights = np.full((len(rotations), len(ways)), np.inf)
    for w, way in enumerate(ways):
        sphere = np.flatnonzero((segments & counts[w])[body.sphere_segment])
        x, y, z = np.moveaxis(placed.centres[:, sphere], 2, 0)
        height = way[0] * x + way[1] * y + way[2] * z - body.radius[:, sphere]
        heights[:, w] = height.min(axis=1, initial=np.inf)
    return heights


def _resting(body: Body, rest: Rest) -> Bools:
    """(N,) the segments that rest there. InputError where none of them has spheres."""
    names = body.segments if "all" in rest.segments else rest.segments
    found: Bools = np.isin(body.segments, names) & (np.diff(body.start) > 0)
    if not found.any():
        raise InputError(
            f"body {body.name} has no spheres in {list(rest.segments)}, which rest on {rest.part!r}"
        )
    return found


def _by_legs(body: Body, lap: int) -> Bools:
    """(N,) the segments whose spheres move with the joints of the legs: legs, and what is blended
    with them."""
    legs = np.zeros(len(body.segments), dtype=np.bool_)
    for name in ("LUL", "RUL"):
        if name in body.segments:
            legs[body.segment(name)] = True
    for n in range(1, len(body.segments)):
        legs[n] |= legs[body.parent[n]]
    joint = legs[1:]  # a joint is that of the segment beyond it
    found = legs.copy()
    blended = (body.blend_joint >= 0) & joint[np.maximum(body.blend_joint, 0)]
    found[body.sphere_segment[blended]] = True
    return found


@kept_by_row(Limb.rows)
def _rests(body: Body, base: int, segments: tuple[int, ...]) -> Limb:
    """Some segments that rest on a seat, as a limb without joints."""
    nowhere = np.zeros((len(body), 3))
    none = np.zeros((len(body), len(body.sphere_names)), dtype=np.bool_)
    return Limb("what rests", base, base, (), nowhere, nowhere, segments, none)


_THIGHS = {"left foot": "LUL", "right foot": "RUL"}


@dataclass(frozen=True, eq=False)
class FrontFaces:
    """The front of a cushion in the world, with the seat at rest."""

    normal: Floats
    """(F, 3) outward unit normals; no rows where thighs hang as they will."""
    offset: Floats
    """(F,) [m] heights of the faces along them."""
    gives: float
    """How deep [m] thighs may press in."""


def front_faces(seat: Seat) -> FrontFaces:
    """Return the faces of the front of a seat's cushion in the world."""
    front = seat.front
    if front is None:
        return FrontFaces(np.zeros((0, 3)), np.zeros(0), 0.0)
    cushion, _, left = seat_planes(seat)
    along, above, offset = np.array(front.faces).T
    normal = np.outer(along, np.cross(left, cushion)) + np.outer(above, cushion)
    return FrontFaces(normal, offset + normal @ np.array(seat.srp), front.gives)


def thighs_of(body: Body, feet: Collection[str]) -> tuple[int, ...]:
    """Segments of a body that are the thighs of some of its feet and have spheres."""
    names = [name for foot, name in _THIGHS.items() if foot in feet and name in body.segments]
    known = [body.segment(name) for name in names]
    return tuple(n for n in known if body.start[n + 1] > body.start[n])


def pressed_thighs(
    body: Body, poses: Poses, seat: Seat, shift: Floats, feet: Collection[str]
) -> Floats:
    """Measure how much deeper thighs press into the front of a cushion than it gives.

    The greatest depth counts: of a sphere in the convex section of the cushion, which goes on to
    both sides. It is 0 where the cushion gives way far enough, or has no front.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body, in their order.
    seat
        The seat.
    shift
        (B, 3) [m] displacement of the seat.
    feet
        "left foot" and "right foot", as far as they are on pedals: a leg that is not hangs as its
        posture has it.

    Returns
    -------
    Floats
        (B,) [m] depth beyond what is given.
    """
    faces = front_faces(seat)
    thighs = thighs_of(body, feet)
    if not (len(faces.normal) and thighs):
        return np.zeros(len(poses))
    placed = place(body, poses, window=[body.segments[n] for n in thighs])
    sphere = np.flatnonzero(np.isin(body.sphere_segment, thighs))
    centre = placed.centres[:, sphere] - shift[:, None]
    outside = (centre @ faces.normal.T - faces.offset).max(axis=2)
    depth = (body.radius[:, sphere] - outside).max(axis=1)
    return np.maximum(depth - faces.gives, 0.0)
