"""Mirrors, flat and convex: where a point is seen in one, and the ground that two eyes see in it; and
instruments that a windscreen mirrors into a view that must be clear.

A flat mirror shows what the virtual eye behind it sees through the glass. A convex one is the cap of a
sphere: from eye and point to its place of reflection the angles to the normal are equal. That place
lies in the plane of eye, point and centre, and as it moves from below the eye to below the point the
angle of the eye grows and that of the point falls, so it is found by halving. The glass bounds the
places of reflection: its triangles, seen along the mirror's normal. Each triangle of a windscreen is a
flat mirror with its own outline, on both of its sides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.errors import InputError
from workbench.geometry.polygon import inside_loops
from workbench.model.arguments import check_index
from workbench.model.arrays import Bools, Floats, Ints, read_only
from workbench.model.environment import Environment, Mirror
from workbench.model.rule_set import RuleSet
from workbench.sight.eyes import Eyes
from workbench.sight.obscuration import Target, lines_of_sight
from workbench.sight.regions import Region, azimuth_elevation
from workbench.sight.rules.eye_points import SIGN, Side
from workbench.sight.scenery import Scenery

__all__ = [
    "AWAY",
    "BESIDE",
    "OUTSIDE",
    "SEEN",
    "Glass",
    "MirrorField",
    "Reflection",
    "aimed_normal",
    "glass_of",
    "ground_points",
    "looked_through",
    "mirror_field",
    "mirror_ground",
    "reflected",
    "reflections",
    "required_ground",
    "what_hides",
    "windscreen_reflection",
]

OUTSIDE = "outside the mirror"
"""Why ground is not seen that is reflected beside the glass, or not at all."""
AWAY = "outside the mirror, which faces away from the eyes"
"""Why nothing is seen by an eye that is behind a mirror."""
SEEN = -1
"""What stands for an item where a point is seen."""
BESIDE = -2
"""What stands for an item where a point is reflected beside the glass."""
_AWAY = -3
_HALVINGS = 48
"""Halvings of the angle between eye and point: to the last digits."""
_FACING = 0.8
"""Cosine to the mirror's normal from which on a triangle of its part belongs to the surface: a glass of
300 mm radius is 150 mm from its middle at 0.87."""


@dataclass(frozen=True, eq=False)
class Glass:
    """The surface of a mirror: its middle (3,) [m], the unit normal (3,) there toward who looks in,
    the radius [m] of a convex one, infinite where flat, and triangles (T, 3, 3) [m] of its outline."""

    name: str
    at: Floats
    normal: Floats
    radius: float
    corners: Floats


def glass_of(environment: Environment, mirror: Mirror, *, eye: Floats | None = None) -> Glass:
    """Take the surface of a mirror: the triangles of its part that face along its normal.

    A mirror that is aimed turns about its middle so that an eye (3,) [m] sees there what it aims
    at; as drawn where no eye is given. InputError where the part has no such triangles.
    """
    at = np.array(mirror.at)
    normal = np.array(mirror.normal)
    part = environment.part_index(mirror.part)
    corners = environment.triangle_corners(part)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    along = cross @ normal if environment.solid[part] else np.abs(cross @ normal)
    corners = corners[(along >= _FACING * area) & (area > 0.0)]
    if not len(corners):
        raise InputError(
            f"mirror {mirror.name}: part {mirror.part!r} has no surface that faces along its normal "
            f"({', '.join(f'{n:.3g}' for n in normal)}); state 'face' or another part"
        )
    if mirror.aims is not None and eye is not None:
        at_eye = read_only(eye, np.float64, (3,), f"mirror {mirror.name}: eye")
        if not np.isfinite(at_eye).all():
            raise InputError(f"mirror {mirror.name}: expected a finite eye, got {at_eye.tolist()}")
        aimed = aimed_normal(at_eye, at, np.array(mirror.aims) - at)
        # the least turn from one unit vector to another: I + K + K K / (1 + cos), K of their product
        x, y, z = np.cross(normal, aimed)
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turn = np.eye(3) + across + across @ across / (1.0 + normal @ aimed)
        corners = at + (corners - at) @ turn.T
        normal = aimed
    return Glass(mirror.name, at, normal, mirror.radius, corners)


def aimed_normal(eye: Floats, at: Floats, wanted: Floats) -> Floats:
    """Unit normal (3,) with which a mirror at a point (3,) shows an eye (3,) a wanted direction."""
    toward = eye - at
    both = toward / np.linalg.norm(toward) + wanted / np.linalg.norm(wanted)
    return np.asarray(both / np.linalg.norm(both))


def reflected(points: Floats, at: Floats, normal: Floats) -> Floats:
    """Mirror points (..., 3) at the plane through a point (3,) with a unit normal (3,): virtual eyes
    and virtual images."""
    height = np.asarray((points - at) @ normal)
    return np.asarray(points - 2.0 * height[..., None] * normal)


def reflections(glass: Glass, eye: Floats, points: Floats) -> Floats:
    """Find where an eye (3,) sees points (N, 3) [m] in a mirror: (N, 3) on its surface, NaN where
    they are reflected beside it or are behind it.

    InputError where the eye is behind the mirror.
    """
    at, normal = glass.at, glass.normal
    height = float((eye - at) @ normal)
    if height < 0.0:
        raise InputError(f"mirror {glass.name} faces away from the eyes; turn its normal round")
    if math.isinf(glass.radius):
        before = (points - at) @ normal
        shown = before > 0.0
        share = height / (height + np.where(shown, before, 1.0))
        virtual = reflected(eye, at, normal)
        place = virtual + share[:, None] * (points - virtual)
    else:
        centre = at - glass.radius * normal
        place = _on_sphere(centre, glass.radius, eye, points)
        out = place - centre
        shown = np.einsum("ni,ni->n", out, points - place) > 0.0
        shown &= np.einsum("ni,ni->n", out, eye - place) > 0.0
    return np.where((shown & _within(glass, place))[:, None], place, np.nan)


def _on_sphere(centre: Floats, radius: float, eye: Floats, points: Floats) -> Floats:
    """(N, 3) [m] where a sphere reflects points (N, 3) to an eye (3,), both outside of it."""
    first = (eye - centre) / np.linalg.norm(eye - centre)
    along = (points - centre) @ first
    rest = points - centre - along[:, None] * first
    across = np.linalg.norm(rest, axis=1)
    second = rest / np.where(across > 0.0, across, 1.0)[:, None]
    whole = np.arctan2(across, along)
    near = float(np.linalg.norm(eye - centre))
    far = np.hypot(along, across)
    low, high = np.zeros(len(points)), whole
    for _ in range(_HALVINGS):
        turn = 0.5 * (low + high)
        of_eye = np.arctan2(near * np.sin(turn), near * np.cos(turn) - radius)
        of_point = np.arctan2(far * np.sin(whole - turn), far * np.cos(whole - turn) - radius)
        low = np.where(of_eye < of_point, turn, low)
        high = np.where(of_eye < of_point, high, turn)
    return centre + radius * (np.cos(low)[:, None] * first + np.sin(low)[:, None] * second)


def _within(glass: Glass, places: Floats) -> Bools:
    """(N,) whether places are in one of the triangles of a glass, seen along its normal."""
    sides = np.roll(glass.corners, -1, axis=1) - glass.corners
    inward = np.cross(glass.normal, sides)
    height = np.einsum("tki,ntki->ntk", inward, places[:, None, None] - glass.corners)
    within = np.all(height >= 0.0, axis=2) | np.all(height <= 0.0, axis=2)
    return np.asarray(within.any(axis=1))


def required_ground(
    rules: RuleSet, name: str, *, eye: Floats, bounds: Floats, ground: float, side: Side
) -> Floats:
    """Find the corners (K, 3) [m] of a field of a rule set on the ground.

    Parameters
    ----------
    name
        Of the field, (K, 2) behind and out of the origin that the rule set states for it.
    eye
        (3,) [m] between the eyes.
    bounds
        (2, 3) [m] least and greatest coordinates of the vehicle, without its mirrors.
    ground
        [m] its height.
    side
        To which side is out.

    Raises
    ------
    InputError
        If there is no such field, or it has no origin.
    """
    behind, out = rules.shaped(name, None, 2).T
    origin = rules.values[name].origin
    if origin is None:
        raise InputError(f"rule set {rules.name}: field {name!r} needs 'origin', as [eyes, side]")
    low, high = bounds
    x = {"eyes": eye[0], "front": high[0]}[origin[0]]
    edge = high[1] if side == "left" else low[1]
    y = {"side": edge, "middle": 0.5 * (low[1] + high[1]), "eyes": eye[1]}[origin[1]]
    return np.stack([x - behind, y + SIGN[side] * out, np.full(len(out), ground)], axis=1)


def mirror_ground(
    environment: Environment,
    mirror: Mirror,
    rules: RuleSet,
    *,
    eye: Floats,
    vehicle: Sequence[str],
    ground: float,
) -> Floats:
    """The corners (K, 3) [m] of the ground that a rule set asks for in a mirror, by its class.

    vehicle: the parts that its sides are of; the mirror is on the side of them where its middle is.
    Other arguments and errors as of `required_ground`.
    """
    parts = [environment.triangle_corners(environment.part_index(name)) for name in vehicle]
    corners = np.concatenate(parts)
    bounds = np.stack([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])
    side: Side = "left" if mirror.at[1] > bounds[:, 1].mean() else "right"
    name = f"field_{mirror.field}"
    return required_ground(rules, name, eye=eye, bounds=bounds, ground=ground, side=side)


def ground_points(polygon: Floats, *, count: int = 2500) -> Floats:
    """About `count` points (N, 3) [m] of equal area in a level polygon (K, 3): middles of squares."""
    x, y, z = polygon.T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))
    if not area > 0.0:
        raise InputError("ground: expected a polygon with an area")
    step = math.sqrt(area / count)
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    counts = np.ceil((high - low) / step)
    # about the middle, so that a mirrored field has the mirrored points
    grid = np.meshgrid(
        *((low + high)[k] / 2 + (np.arange(counts[k]) - (counts[k] - 1) / 2) * step for k in (0, 1))
    )
    points = np.stack([axis.ravel() for axis in grid], axis=1)
    inside = inside_loops(points, [polygon[:, :2]])
    return np.column_stack([points[inside], np.full(int(inside.sum()), z[0])])


@dataclass(frozen=True, eq=False)
class MirrorField:
    """The ground that two eyes see in a mirror, of N points of equal area.

    points (N, 3) [m]. seen (2, N): by the left and by the right eye. share: seen by one of them at
    least. hidden: the share that neither sees, by the name of what hides it, `OUTSIDE` where it is
    reflected beside the glass, `AWAY` for an eye behind the mirror; half of a point is put down to
    what each eye meets.
    """

    points: Floats
    seen: Bools
    share: float
    hidden: dict[str, float]


def mirror_field(
    scenery: Scenery, eyes: Eyes, glass: Glass, points: Floats, *, item: int = -1, row: int = 0
) -> MirrorField:
    """See ground, or any points, in a mirror.

    Parameters
    ----------
    scenery
        What may stand between eye, mirror and ground.
    eyes
        Of B people.
    points
        (N, 3) [m] of `ground_points`.
    item
        The item of the scenery that is the mirror's own part, which hides nothing of it.
    row
        Who of them, and whose scenery. An eye behind the mirror sees nothing in it, and is told.
    """
    row = check_index("row", row, len(eyes))
    points = read_only(points, np.float64, (None, 3), f"mirror {glass.name}: points")
    if not len(points) or not np.isfinite(points).all():
        raise InputError(f"mirror {glass.name}: expected finite points, one at least")
    clear = looked_through(scenery.of_row(row), [item])
    met = np.full((2, len(points)), _AWAY)
    for side, eye in enumerate((eyes.left[row], eyes.right[row])):
        if (eye - glass.at) @ glass.normal > 0.0:
            met[side] = what_hides(clear, eye, reflections(glass, eye, points), points)
    seen = met == SEEN
    lost = ~seen.any(axis=0)
    count = np.bincount((met[:, lost] - _AWAY).ravel())
    names = {k: (AWAY, OUTSIDE, "", *clear.names)[k] for k in np.flatnonzero(count).tolist()}
    return MirrorField(
        points,
        seen,
        1.0 - float(lost.mean()),
        {name: 0.5 * float(count[k]) / len(points) for k, name in names.items()},
    )


def looked_through(scenery: Scenery, items: Sequence[int]) -> Scenery:
    """The scenery in which some items hide nothing."""
    return replace(
        scenery, see_through=scenery.see_through | np.isin(np.arange(len(scenery.names)), items)
    )


def what_hides(
    scenery: Scenery, eye: Floats, places: Floats, points: Floats, *, own: int = -1
) -> Ints:
    """Find what hides points (N, 3) [m] from an eye (3,) that are reflected at places (N, 3): (N,) an
    item, `SEEN`, or `BESIDE` where a place is NaN.

    own: the item that the points are on. The part of the mirror must be one that is looked through.
    """
    met = np.full(len(points), BESIDE)
    shown = np.flatnonzero(np.isfinite(places[:, 0]))
    if len(shown):
        met[shown] = lines_of_sight(scenery, eye[None], places[None, shown])[0]
        rest = shown[met[shown] == SEEN]
        met[rest] = lines_of_sight(scenery, places[rest], points[rest, None], own=own)[:, 0]
    return met


@dataclass(frozen=True, eq=False)
class Reflection:
    """What two eyes see of a target in a windscreen, inside a region.

    seen (2, M): the points that the left and the right eye see mirrored. share: of the points, seen
    by one eye at least. middle (2,) [rad]: azimuth to the left and elevation of the mean direction,
    NaN where nothing is seen. parts: that mirror it.
    """

    seen: Bools
    share: float
    middle: Floats
    parts: tuple[str, ...]


def windscreen_reflection(
    scenery: Scenery,
    eyes: Eyes,
    target: Target,
    *,
    environment: Environment,
    windscreen: Sequence[str],
    region: Region,
    row: int = 0,
) -> Reflection:
    """Find the virtual image of a target in a windscreen.

    Parameters
    ----------
    scenery
        Of the environment: what may stand between eye, windscreen and target.
    eyes
        Of B people.
    target
        An instrument; where it has normals, it shines to their side.
    windscreen
        The parts that mirror.
    region
        The view that must be free of images, as `cockpit_outline`.
    row
        Who of them, and whose scenery.

    Raises
    ------
    InputError
        If a part has no such name.
    """
    parts = [environment.part_index(name) for name in windscreen]
    panes = [environment.triangle_corners(part) for part in parts]
    part_of = np.repeat(parts, [len(pane) for pane in panes])
    corners = np.concatenate(panes)
    clear = looked_through(scenery.of_row(row), parts)
    seen = np.zeros((2, len(target.points)), dtype=np.bool_)
    ways = [np.zeros((0, 3))]
    mirroring: dict[int, None] = {}
    for side, eye in enumerate((eyes.left[row], eyes.right[row])):
        places = _reflected_by(corners.tobytes(), eye.tobytes(), target.points.tobytes())
        images = np.isfinite(places[..., 0]) & region.contains(places - eye)
        if target.normals is not None:
            images &= np.einsum("tmi,mi->tm", places - target.points, target.normals) > 0.0
        pane, point = np.nonzero(images)
        place = places[pane, point]
        free = what_hides(clear, eye, place, target.points[point], own=target.item) == SEEN
        seen[side, point[free]] = True
        ways.append(place[free] - eye)
        mirroring |= dict.fromkeys(part_of[pane[free]].tolist())
    way = np.concatenate(ways)
    way = way / np.linalg.norm(way, axis=1)[:, None]
    mean = way.sum(axis=0) if len(way) else np.full(3, np.nan)
    return Reflection(
        seen,
        float(seen.any(axis=0).mean()),
        azimuth_elevation(mean, region.axes),
        tuple(environment.parts[part] for part in mirroring),
    )


@lru_cache(maxsize=32)
def _reflected_by(*arrays: bytes) -> Floats:
    """(T, M, 3) [m] where flat triangles (T, 3, 3) mirror points (M, 3) to an eye (3,), NaN where
    they do not, or the point is on their other side.

    arrays: of triangles, eye and points; while something else is dragged, all three stay.
    """
    given, eye, points = (np.frombuffer(one).reshape(-1, 3) for one in arrays)
    corners = given.reshape(-1, 3, 3)
    sides = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(sides[:, 0], sides[:, 1])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0.0, length, 1.0)[:, None]
    offset = np.einsum("ti,ti->t", normal, corners[:, 0])
    of_eye = (normal @ eye[0] - offset)[:, None]
    of_point = normal @ points.T - offset[:, None]
    # the line from the eye to the virtual image crosses the plane at this share of its way
    same_side = of_eye * of_point > 0.0
    share = np.where(same_side, of_eye / np.where(same_side, of_eye + of_point, 1.0), np.nan)
    image = points - 2.0 * of_point[..., None] * normal[:, None]
    place = eye + share[..., None] * (image - eye)
    inward = np.cross(normal[:, None], sides)
    height = np.einsum("tki,tmki->tmk", inward, place[:, :, None] - corners[:, None])
    return np.where((height >= 0.0).all(axis=2)[..., None], place, np.nan)
