"""What items hide from two eyes: solid angles of directions, and shares of targets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError
from workbench.geometry.sampling import even_places
from workbench.model.arguments import check_index
from workbench.model.arrays import Bools, Floats, Ints, read_only
from workbench.model.environment import Environment
from workbench.sight.eyes import Eyes
from workbench.sight.kernels.bands import Pixels, Sums, add_bands
from workbench.sight.kernels.segments import Lines, blocked_lines
from workbench.sight.panorama import (
    BAND,
    FACES,
    PIECES,
    STEP,
    face_directions,
    pixel_weights,
    pixels_of,
    shapes_before,
)
from workbench.sight.regions import WHOLE, Region
from workbench.sight.scenery import Scenery, check_eyes, items_around
from workbench.threads import run_in_threads

__all__ = [
    "SEEN_BY",
    "TURNED_AWAY",
    "Obscuration",
    "Seen",
    "Target",
    "block_lines",
    "lines_of_sight",
    "obscuration",
    "seen_shares",
    "target_of_disc",
    "target_of_part",
    "target_of_point",
]

TURNED_AWAY = "turned away"
"""What keeps a target from being seen whose surface faces away from the eyes."""
_MARGINS = np.array([1e-6, 1e-3])
"""Distance [m] before a point from which on other items, and the item that it is on, no longer hide
it."""
_GROUP = 32
"""Points of `lines_of_sight` that follow each other and are looked at through one cone."""
_ROUNDING = 1e-9
"""By how much the cosine of a cone is made smaller."""
_PIECE = 8
"""Rows of lines of sight that a thread takes at once."""


@dataclass(frozen=True, eq=False)
class Obscuration:
    """What each of N items hides of a region of directions, [sr]; for two eyes at one place each.

    A direction is hidden to both eyes where something stands before each, if it be two things. That
    is what hides things far away; near ones are asked about by `seen_shares`.

    Parameters
    ----------
    names
        Of the items.
    region
        Of which directions.
    left, right
        (N,) what an opaque item hides from an eye: the directions in which it comes first.
    either, both
        (N,) what it hides from one eye at least, and from both at once.
    through
        (N, 4) the same of see-through items: where each is looked through first.
    free
        (4,) where the left eye, the right, one at least, and both meet nothing opaque.
    error
        (N,) bound of the error of the figures of an item: half the pixels on both sides of its
        borders, the region's among them. Items thinner than a step may be missed.
    free_error
        The same of `free`.
    """

    names: tuple[str, ...]
    region: Region
    left: Floats
    right: Floats
    either: Floats
    both: Floats
    through: Floats
    free: Floats
    error: Floats
    free_error: float


def obscuration(
    scenery: Scenery,
    eyes: Eyes,
    *,
    row: int = 0,
    within: Region | None = None,
    step: float = STEP,
) -> Obscuration:
    """Measure what each item hides from the eyes of one person.

    Parameters
    ----------
    scenery
        What may hide something.
    eyes
        Of B people.
    row
        Who of them, and whose scenery.
    within
        The directions that count; all if None.
    step
        Largest width [rad] of a pixel.

    Raises
    ------
    InputError
        If an eye is inside a solid part or a sphere, or the step is not 0.02 to 45 degrees.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> eyes = wb.given_eyes(trainer.points["left_design_eye"])
    >>> hidden = wb.obscuration(wb.scenery_of(trainer), eyes, step=0.02)
    >>> frame = hidden.names.index("canopy_frame")
    >>> f"{hidden.either[frame]:.2f} sr"
    '0.73 sr'
    """
    row = check_index("row", row, len(eyes))
    region = WHOLE if within is None else within
    n = pixels_of(step)
    pieces = _pieces(region, n)
    faces = sorted({one.face for one in pieces})
    left, right = (
        dict(zip(faces, shapes_before(scenery, eye[row], row, n, FACES[faces]), strict=True))
        for eye in (eyes.left, eyes.right)
    )
    weight, before = pixel_weights(n)
    count = len(scenery.names) + 2
    opaque = np.zeros((len(pieces), count, 3))
    clear = np.zeros((len(pieces), count, 3))
    free = np.zeros((len(pieces), 2))
    border = np.zeros((len(pieces), count))

    def work(begin: int, end: int) -> None:
        for k in range(begin, end):
            one = pieces[k]
            sums = Sums(opaque[k], clear[k], free[k], border[k])
            shapes = left[one.face], right[one.face]
            pixels = Pixels(weight, before, one.inside)
            add_bands(*shapes, one.begin, one.end, BAND, pixels, sums)

    run_in_threads(work, len(pieces), 1)
    hidden, through = (_with_either(sums.sum(axis=0)) for sums in (opaque, clear))
    error = border.sum(axis=0) / 2.0
    left_hides, right_hides, either, both = hidden[1:-1].T.copy()
    return Obscuration(
        names=scenery.names,
        region=region,
        left=left_hides,
        right=right_hides,
        either=either,
        both=both,
        through=through[1:-1],
        free=np.append(hidden[0, :2], free.sum(axis=0)),
        error=error[1:-1],
        free_error=float(error[0]),
    )


def _with_either(sums: Floats) -> Floats:
    """(N, 4) left, right, either, both of sums (N, 3) left, right, both."""
    left, right, both = sums.T
    return np.stack([left, right, left + right - both, both], axis=1)


@dataclass(frozen=True, eq=False)
class _Piece:
    """Rows `begin` to `end` of a face, and which of its pixels are in a region; none where all are."""

    face: int
    begin: int
    end: int
    inside: Bools


@lru_cache(maxsize=4)
def _pieces(region: Region, n: int) -> list[_Piece]:
    """The pieces of faces that a region touches."""
    rows = -(-n // PIECES)
    found = []
    everything = region is WHOLE
    for face in range(6):
        inside = np.zeros((0, 0), dtype=np.bool_)
        if not everything:
            inside = region.contains(face_directions(np.eye(3), face, n))
        for begin in range(0, n, rows):
            if everything or inside[begin : begin + rows].any():
                found.append(_Piece(face, begin, min(begin + rows, n), inside))
    return found


@dataclass(frozen=True, eq=False)
class Target:
    """Something to be seen, as M samples of equal area.

    Parameters
    ----------
    name
        What it is called.
    points
        (M, 3) [m].
    normals
        (M, 3) unit, to the side that can be seen; none where it can be seen from all sides.
    item
        The item of the scenery that the points are on, -1 for none. They go along with it.
    """

    name: str
    points: Floats
    normals: Floats | None = None
    item: int = -1

    def __post_init__(self) -> None:
        points = read_only(self.points, np.float64, (None, 3), f"target {self.name}: points")
        object.__setattr__(self, "points", points)
        if not len(points) or not np.isfinite(points).all():
            raise InputError(f"target {self.name}: expected finite points, one at least")
        if self.normals is not None:
            normals = read_only(
                self.normals, np.float64, (len(points), 3), f"target {self.name}: normals"
            )
            object.__setattr__(self, "normals", normals)


def target_of_point(name: str, point: ArrayLike, *, item: int = -1) -> Target:
    """Return a target of one point (3,) [m], seen from all sides."""
    return Target(name, np.asarray(point, dtype=np.float64)[None], None, item)


def target_of_disc(
    name: str,
    point: ArrayLike,
    diameter: float,
    *,
    normal: ArrayLike | None = None,
    count: int = 25,
    item: int = -1,
) -> Target:
    """Return the samples of a disc.

    Parameters
    ----------
    name
        What it is called.
    point
        (3,) [m] its middle.
    diameter
        [m].
    normal
        (3,) to the side that it is seen from; toward -x, and seen from both sides, if None.
    count
        Of samples, about: the nearest of 1, 9, 25, 49, ...
    item
        The item of the scenery that it is on, -1 for none.
    """
    ahead = np.array([-1.0, 0.0, 0.0] if normal is None else normal, dtype=np.float64)
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(np.eye(3)[int(np.argmin(np.abs(ahead)))], ahead)
    right /= np.linalg.norm(right)
    # rings of 1, 8, 16, ... equal areas, (2 r - 1)^2 within ring r: a mirrored disc has the mirrored ones
    rings = round((math.sqrt(count) + 1.0) / 2.0)
    first = np.maximum(2 * np.arange(rings) - 1, 0) ** 2
    last = (2 * np.arange(rings) + 1) ** 2
    ring = np.repeat(np.arange(rings), last - first)
    distance = diameter / 2.0 * np.sqrt(0.5 * (first + last) / last[-1])[ring]
    angle = 2.0 * math.pi * (np.arange(last[-1]) - first[ring] + 0.5) / (last - first)[ring]
    across = distance[:, None] * (
        np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * np.cross(ahead, right)
    )
    normals = None if normal is None else np.broadcast_to(ahead, across.shape)
    return Target(name, np.asarray(point, dtype=np.float64) + across, normals, item)


def target_of_part(
    environment: Environment, part: str, *, count: int = 25, facing: ArrayLike | None = None
) -> Target:
    """Return samples of the surface of a part, evenly by area.

    Parameters
    ----------
    environment, part
        The part, by name.
    count
        Of samples.
    facing
        (3,) keep only triangles whose normal is within 60 degrees of this; all if None.

    Raises
    ------
    InputError
        If there is no such part, or no triangle of it is left.
    """
    index = environment.part_index(part)
    corners = environment.triangle_corners(index)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    normal = cross / np.where(area > 0.0, area, 1.0)[:, None]
    if facing is not None:
        way = np.asarray(facing, dtype=np.float64)
        area = np.where(normal @ way >= 0.5 * np.linalg.norm(way), area, 0.0)
    if not area.sum() > 0.0:
        raise InputError(f"part {part!r} has no surface to that side")
    total = np.cumsum(area) / area.sum()
    chosen = np.minimum(np.searchsorted(total, (np.arange(count) + 0.5) / count), len(area) - 1)
    u, v = even_places(count)
    a, b, c = (corners[chosen, k] for k in range(3))
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    closed = bool(environment.solid[index]) or facing is not None
    return Target(part, points, normal[chosen] if closed else None, index)


def lines_of_sight(
    scenery: Scenery, eye: ArrayLike, points: ArrayLike, own: ArrayLike | None = None
) -> Ints:
    """Find what blocks the straight lines from eyes to points.

    See-through items block nothing. An eye inside a sphere is blocked by it in every direction.

    Parameters
    ----------
    scenery
        Of B rows, or of one for all.
    eye
        (B, 3) [m].
    points
        (B, M, 3) [m].
    own
        (M,) the item that each point is on, -1 for none: its surface within 1 mm of the point does
        not hide it.

    Returns
    -------
    Ints
        (B, M) the item that comes first on the way, -1 where the point is seen.

    Raises
    ------
    InputError, UsageError
        If an eye is not finite, or the scenery is neither of B rows nor of one.
    """
    ends = np.asarray(points, dtype=np.float64)
    on = np.full(1, -1) if own is None else np.asarray(own)
    group = np.append(np.arange(0, ends.shape[1], _GROUP), ends.shape[1])
    return block_lines(scenery, check_eyes(scenery, np.asarray(eye)), ends, on, group).item


def block_lines(scenery: Scenery, eyes: Floats, points: Floats, own: Ints, group: Ints) -> Lines:
    """Return what blocks lines first, and at which share of the way.

    eyes (E, 3): of the rows of the scenery, once or, all after each other, several times. group
    (G + 1,): where groups of points that are near each other begin; else as `lines_of_sight`.
    """
    way = np.ascontiguousarray(points - eyes[:, None])
    far = np.maximum(np.linalg.norm(way, axis=2), np.finfo(float).tiny)
    axis = np.add.reduceat(way, group[:-1], axis=1)
    axis /= np.maximum(np.linalg.norm(axis, axis=2), np.finfo(float).tiny)[..., None]
    along = np.sum(way * np.repeat(axis, np.diff(group), axis=1), axis=2) / far
    cosine = np.maximum(np.minimum.reduceat(along, group[:-1], axis=1) - _ROUNDING, 0.0)
    end = np.maximum.reduceat(far, group[:-1], axis=1)
    cone = [axis, np.sqrt(1.0 - cosine**2)[..., None], cosine[..., None], end[..., None]]
    lines = Lines(
        eyes,
        way,
        group,
        np.concatenate(cone, axis=2),
        _MARGINS,
        np.ascontiguousarray(np.broadcast_to(own, points.shape[1:2]), dtype=np.int64),
        np.full(far.shape, -1),
        np.ones(far.shape),
    )
    blockers = scenery.blockers(~scenery.see_through)
    run_in_threads(lambda begin, end: blocked_lines(lines, blockers, begin, end), len(eyes), _PIECE)
    return lines


SEEN_BY = ("left", "right", "either", "both")
"""By which eyes a share is seen, in the order of `Seen.share`."""


@dataclass(frozen=True, eq=False)
class Seen:
    """How much of K targets B people see.

    Parameters
    ----------
    names
        Of the targets.
    share
        (B, K, 4) of the surface that is turned to the eyes, weighed by solid angle: seen by the left
        eye, by the right, by one at least, by both. 0 where it is turned away.
    blocker
        (B, K) the name of the item that hides most of what is not seen by the eyes that are asked;
        `TURNED_AWAY` where no sample faces an eye; "" where they see all.
    blocked
        (B, K) the share of the target that this item hides, never more than is not seen: half of a
        sample is put down to what each eye meets where both are hidden.
    inside
        (B,) the item of the scenery that an eye is in, -1 for none; who is in one sees nothing.
    """

    names: tuple[str, ...]
    share: Floats
    blocker: np.ndarray
    blocked: Floats
    inside: Ints


def seen_shares(
    scenery: Scenery, eyes: Eyes, targets: Sequence[Target], *, by: str = "either"
) -> Seen:
    """Measure the share of each target that people see.

    A sample weighs cos(angle of incidence) / distance^2, the mean over both eyes; one that faces away
    from an eye is not seen by it.

    Parameters
    ----------
    scenery
        Of B rows, or of one for all.
    eyes
        Of B people.
    targets
        K of them.
    by
        The eyes that are asked what hides the targets, one of `SEEN_BY`.

    Raises
    ------
    InputError, UsageError
        As `lines_of_sight`; UsageError for other eyes.
    """
    if not targets:
        raise UsageError("targets: expected one at least, got none")
    if by not in SEEN_BY:
        raise UsageError(f"by: expected one of {', '.join(SEEN_BY)}, got {by!r}")
    check_eyes(scenery, eyes.middle)
    count = [len(target.points) for target in targets]
    group = np.cumsum([0, *count])
    own = np.repeat([target.item for target in targets], count)
    goes = np.append(scenery.moving, False)[own][:, None]
    samples = np.concatenate([target.points for target in targets])
    shift = np.where(goes, scenery.displacement[:, None], 0.0)
    points = np.broadcast_to(samples + shift, (len(eyes), *samples.shape))
    normals = np.concatenate([_normals(target) for target in targets])
    pairs = np.concatenate([eyes.left, eyes.right])
    ends = np.concatenate([points, points])
    away = pairs[:, None] - ends
    distance = np.linalg.norm(away, axis=2)
    cosine = np.einsum("bmi,mi->bm", away, normals) / distance
    cosine[:, ~normals.any(axis=1)] = 1.0
    weight = (np.maximum(cosine, 0.0) / distance**2).reshape(2, len(eyes), -1).sum(axis=0)
    met = block_lines(scenery, pairs, ends, own, group).item
    inside = items_around(scenery, pairs).reshape(2, -1).max(axis=0)
    blocker = met.reshape(2, len(eyes), -1)
    sees = ((cosine > 0.0) & (met < 0)).reshape(blocker.shape)
    left, right = sees & (inside < 0)[:, None]
    seen = np.stack([left, right, left | right, left & right], axis=2)
    total = np.add.reduceat(weight, group[:-1], axis=1)
    scale = np.where(total > 0.0, total, 1.0)
    share = np.add.reduceat(weight[..., None] * seen, group[:-1], axis=1) / scale[..., None]
    lost = weight * ~seen[..., SEEN_BY.index(by)]
    asked = [
        block
        for side, block in zip(SEEN_BY, blocker, strict=False)
        if by not in SEEN_BY[:2] or by == side
    ]
    hides = np.stack(
        [
            _hidden_by(lost[:, begin:end], [block[:, begin:end] for block in asked], scenery)
            for begin, end in pairwise(group.tolist())
        ],
        axis=1,
    )
    blind = np.flatnonzero(inside >= 0)
    hides[blind] = 0.0
    hides[blind, :, inside[blind]] = scale[blind]
    chief = np.argmax(hides, axis=2)
    blocked = np.take_along_axis(hides, chief[..., None], axis=2)[..., 0] / scale
    name = np.where(blocked > 0.0, np.array(scenery.names, dtype=object)[chief], "")
    name[total == 0.0] = TURNED_AWAY
    return Seen(tuple(target.name for target in targets), share, name, blocked, inside)


def _normals(target: Target) -> Floats:
    """(M, 3) the normals of a target, 0 where it is seen from all sides."""
    return np.zeros_like(target.points) if target.normals is None else target.normals


def _hidden_by(weight: Floats, blocker: Sequence[Ints], scenery: Scenery) -> Floats:
    """(B, N) weights (B, M) of the samples that each item hides, shared by the eyes that it or another
    hides them from.

    blocker: (B, M) of each eye.
    """
    count = len(scenery.names) + 1  # the last one is none
    first = np.arange(len(weight))[:, None] * count
    each = weight / np.maximum(sum(block >= 0 for block in blocker), 1)
    items = [np.where(block >= 0, block, count - 1) + first for block in blocker]
    weights = np.concatenate([each] * len(items), axis=1)
    hides = np.bincount(np.concatenate(items, axis=1).ravel(), weights.ravel(), len(weight) * count)
    return hides.reshape(-1, count)[:, :-1].astype(np.float64)
