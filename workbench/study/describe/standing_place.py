"""Guess where people stand at controls: on the floor, clear of everything, facing the controls.

Controls that are near one another are used from one place. Places about them are tried, in all
directions; of those where a standing man is clear of everything the one is taken whose way from
the shoulders to the controls is free and short, square to the surfaces that they are on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache

import numpy as np

from workbench.body.forward import place
from workbench.contact.batches import clearance_by_part
from workbench.contact.collide import allowed_depth, room
from workbench.geometry.ground import Ground, ground_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Control, Environment
from workbench.model.poses import Placed, Poses
from workbench.model.units import plain
from workbench.sight.rays import first_hits
from workbench.study.describe.people import standing_man, standing_people
from workbench.study.feet_on_floor import BROAD

__all__ = ["MAY_STEP", "StandingPlace", "floor_mm", "standing_places"]

TOGETHER = 1.4
"""Controls that are all nearer [m] than this to one another are used from one place."""
MOST_PLACES = 4
"""More people than this are not put in at once."""
DISTANCES = (0.30, 0.40, 0.50, 0.60, 0.70)
"""How far [m] before the middle of the controls somebody may stand."""
TURNS = 24
CLEAR = 0.01
"""Room [m] that a standing man has about him where he is clear."""
LIFTED = 0.03
"""A man is lifted so far [m] off the floor while it is asked what else he touches."""
SOLES = ((0.0, 0.0), (0.15, 0.1), (0.15, -0.1), (-0.05, 0.1), (-0.05, -0.1))
"""About where soles are, ahead and to the left [m]."""
SHOULDER = 1.35
"""Height [m] of the shoulders above the floor, about."""
SHORT_OF = 0.04
"""A free way ends so far [m] before a control: there its own part begins."""
AT_WORK = 1.0
"""Height [m] of controls over a floor that nobody has described, about: that of elbows."""
STEP = 0.15
"""A floor higher [m] than the lowest one about the controls is furniture."""
ABOUT = 0.06
"""Triangles nearer [m] than this are the surface that a control is on."""
STRIDE = 0.02
MAY_STEP = {"forward": (0.3, 0.2), "left": (0.5, 0.5)}
"""[m] Between the places where it is asked whether somebody may step there, and how far at most: back and
ahead, to the right and to the left."""
GIVES = 0.01
"""What legs and trunk may be in something [m] where somebody steps: flesh, sleeves and soles give way."""
BODY = ("LT", "CT", "UT", "LUL", "RUL", "LLL", "RLL", "LF", "RF")
FEET = ("LF", "RF")
"""Trunk, legs and feet: arms that hang at rest go elsewhere."""
LEVEL = 0.02
LIFTS = 6
"""How often a man is lifted by what he is in the floor, at most."""
EVEN = 1e-4
"""Floors that are lower, and higher, by less [m] are one: feet would be in a higher one."""
BLOCKED = 0.5
ASKEW = 0.4
"""What a blocked way to every control, and surfaces seen edge-on, weigh against way [m]."""


@dataclass(frozen=True, eq=False)
class StandingPlace:
    """Somebody who stands.

    on: (3,) [m] on the floor; yaw [rad]; controls: within reach of here; clear: whether nothing is
    touched; why: by what this was guessed; area: (low, high) [m] how far he may step, "forward" and
    "left"; limits: in words what keeps everybody from going on, by how far "60 mm ahead" that is.
    """

    on: tuple[float, float, float]
    yaw: float
    controls: tuple[Control, ...]
    clear: bool
    why: str
    area: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    limits: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Spots:
    """(M,) places that are tried: on (M, 3) [m], facing (M,) [rad]; room (M,) [m] there."""

    on: Floats
    yaw: Floats
    room: Floats

    def keep(self, rows: Ints) -> _Spots:
        """The places at indices."""
        return _Spots(self.on[rows], self.yaw[rows], self.room[rows])


def standing_places(environment: Environment) -> list[StandingPlace]:
    """Guess where people stand in an environment, one for each group of controls, of many for the
    first few; one person where there are none.

    The order is that of the controls in the file.
    """
    controls = [one for one in environment.controls if not one.for_feet]
    if not controls:
        return [_anywhere(environment)]
    return [_at(environment, group) for group in _groups(controls)[:MOST_PLACES]]


def _groups(controls: Sequence[Control]) -> list[list[Control]]:
    """Controls that are all near one another, from the first of the file on."""
    groups: list[list[Control]] = []
    for one in controls:
        near = [
            group
            for group in groups
            if all(math.dist(one.at[:2], other.at[:2]) <= TOGETHER for other in group)
        ]
        if near:
            near[0].append(one)
        else:
            groups.append([one])
    return groups


def _at(environment: Environment, controls: Sequence[Control]) -> StandingPlace:
    """Where somebody stands at a group of controls."""
    at = np.array([one.at for one in controls])
    bare = min(float(environment.bounds[0, 2]), float(at[:, 2].mean()) - AT_WORK)
    spots = _spots(environment, at.mean(axis=0), bare)
    spots = _nearest_clear(spots)
    costs = [_cost(environment, spots, row, controls) for row in range(len(spots.yaw))]
    best = int(np.argmin(costs))
    clear = bool(spots.room[best] >= CLEAR)
    yaw = float(spots.yaw[best])
    x, y, z = _on_floor(environment, spots.on[best], yaw)
    below = np.isfinite(_floor(environment, np.array([[x, y, z]]), -math.inf)[0])
    where = "on the floor below, facing them" if below else f"facing them; {_no_floor(z)}"
    away = float(np.hypot(*(at.mean(axis=0) - spots.on[best])[:2]))
    area, limits = _area(environment, np.array([x, y, z]), yaw) if clear else ({}, {})
    return StandingPlace(
        (x, y, z),
        yaw,
        tuple(controls),
        clear,
        f"{1000 * away:.0f} mm before the middle of the controls, {where}"
        + ("" if clear else "; no place was found there that touches nothing"),
        area,
        limits,
    )


def _area(
    environment: Environment, on: Floats, yaw: float
) -> tuple[dict[str, tuple[float, float]], dict[str, str]]:
    """(low, high) [m] how far people may step from a place (3,), "forward" and "left", and by way what
    keeps them from more; see `_steps_along`."""
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    left = np.array([-ahead[1], ahead[0], 0.0])
    ways = {"back": -ahead, "ahead": ahead, "to the right": -left, "to the left": left}
    most = [far for ends in MAY_STEP.values() for far in ends]
    found = {
        name: _steps_along(environment, on, way, yaw, far)
        for (name, way), far in zip(ways.items(), most, strict=True)
    }
    back, forth, right, aside = (far for far, _ in found.values())
    limits = {f"{1e3 * far:.0f} mm {way}": why for way, (far, why) in found.items() if why}
    return {"forward": (-back, forth), "left": (-right, aside)}, limits


def _steps_along(
    environment: Environment, on: Floats, way: Floats, yaw: float, most: float
) -> tuple[float, str]:
    """How far [m] people may step along a way, in strides, and what keeps them from more.

    The floor is level there, and somebody of a small, a middle and a tall person is in nothing by more
    than gives way, with trunk and legs. Feet that are in something on the floor and clear of it once
    lifted would stand on it.
    """
    strides = STRIDE * np.arange(1, round(most / STRIDE) + 1)
    places = on + strides[:, None] * way
    yaws = np.full(len(places), yaw)
    floors = np.array([_under_soles(environment, place, yaw) for place in places])
    level = (floors > on[2] - LEVEL) & (floors < on[2] + EVEN)
    spare = []
    for who in standing_people().values():
        feet = [_room(environment, places, yaws, lifted=up, who=who, of=FEET) for up in (0, LIFTED)]
        on_ledge = (feet[0] < -EVEN) & (feet[1] >= 0)
        apart = _room(environment, places, yaws, who=who, of=BODY)
        spare.append(np.where(on_ledge, -np.inf, apart))
    stays = np.flatnonzero(~(level & (np.max(spare, axis=0) >= -GIVES)))
    if not len(stays):
        return float(strides[-1]), ""
    k = int(stays[0])
    best = int(np.argmax([one[k] for one in spare]))
    if not level[k] or not np.isfinite(spare[best][k]):
        return float(STRIDE * k), "the floor is not level"
    name, who = list(standing_people().items())[best]
    placed = _standing(places[k : k + 1] + np.array([0.0, 0.0, LIFTED]), yaws[:1], who)
    apart = clearance_by_part(placed, environment).distance[0]
    apart += allowed_depth(placed.body, environment)
    rows = [placed.body.segments.index(one) for one in BODY]
    segment, part = np.unravel_index(np.argmin(apart[rows]), apart[rows].shape)
    what = placed.body.segment_names[rows[int(segment)]]
    return float(STRIDE * k), f"even {name} has the {what} in {plain(environment.parts[part])}"


def floor_mm(height: float) -> int:
    """A height of the floor [m] in whole millimetres: a sole in the floor by less is in it."""
    return math.ceil(1e3 * height - 0.01)


def _no_floor(height: float) -> str:
    """That nothing to stand on is there, and what was taken for it [m]."""
    return (
        f"the floor is taken at {floor_mm(height)} mm, since no part {1e3 * BROAD:.0f} mm broad faces "
        "up there: where it is otherwise, the third figure of 'on' says so"
    )


def _spots(environment: Environment, centre: Floats, bare: float) -> _Spots:
    """Places about a point (3,), on the floor there, at a height `bare` [m] where there is none."""
    yaw, away = (
        axis.ravel()
        for axis in np.meshgrid(
            np.arange(TURNS) * 2 * math.pi / TURNS, np.array(DISTANCES), indexing="ij"
        )
    )
    on = centre - away[:, None] * np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=1)
    floor = _floor(environment, on, bare)
    on[:, 2] = floor
    level = floor <= floor.min() + STEP
    on, yaw = on[level], yaw[level]
    return _Spots(on, yaw, _room(environment, on, yaw))


@lru_cache(maxsize=4)
def _floors(environment: Environment) -> Ground:
    """The surfaces of an environment that may be a floor: of parts so broad that nobody takes them for
    a board or a seat."""
    ground = ground_of(environment)
    wide = [row for row in np.unique(ground.part).tolist() if ground.breadth(row) > BROAD]
    some = np.isin(ground.part, wide)
    return Ground(ground.corners[some], ground.part[some], ground.names, ground.one_sided[some])


def _floor(environment: Environment, on: Floats, bare: float) -> Floats:
    """(M,) [m] the height of the floor below places (M, 3); `bare` where nothing is."""
    found = np.full(len(on), bare)
    for row, place_there in enumerate(on):
        heights, _ = _floors(environment).levels(place_there[:2])
        below = heights[heights <= place_there[2] + EVEN]
        if len(below):
            found[row] = below[-1]
    return found


def _on_floor(environment: Environment, on: Floats, yaw: float) -> tuple[float, float, float]:
    """A place (3,) [m], raised to the highest floor under the soles there."""
    z = max(_under_soles(environment, on, yaw), float(on[2]))
    at = np.array([[on[0], on[1], z]])
    # soles stand on what they are in by little: over a ledge before the toes by more than their depth
    for _ in range(LIFTS):
        apart = float(_room(environment, at, np.array([yaw]), lifted=0.0)[0])
        if not -LEVEL < apart < 0.0:
            break
        at[0, 2] -= apart
    return float(on[0]), float(on[1]), float(at[0, 2])


def _under_soles(environment: Environment, on: Floats, yaw: float) -> float:
    """The highest floor [m] under the soles in a place (3,), its own height where there is none."""
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    left = np.array([-ahead[1], ahead[0], 0.0])
    spots = np.array([on + forth * ahead + aside * left for forth, aside in SOLES])
    spots[:, 2] += STEP
    return float(_floor(environment, spots, float(on[2])).max())


def _room(
    environment: Environment,
    on: Floats,
    yaw: Floats,
    *,
    lifted: float = LIFTED,
    who: tuple[Body, Poses] | None = None,
    of: Sequence[str] = (),
) -> Floats:
    """(M,) [m] what a standing man, or who is given, has about him, lifted a little so that the floor is
    not near; of some segments, of all where none is named."""
    placed = _standing(on + np.array([0.0, 0.0, lifted]), yaw, who)
    apart = np.nan_to_num(room(placed, environment), nan=np.inf)
    rows = [placed.body.segments.index(name) for name in of or placed.body.segments]
    return np.asarray(apart[:, rows].min(axis=1))


def _nearest_clear(spots: _Spots) -> _Spots:
    """In each direction the nearest place where a man is clear; where there is none in any, the
    clearest of each."""
    rows = []
    for yaw in np.unique(spots.yaw):
        mine = np.flatnonzero(spots.yaw == yaw)  # in the order of the distances
        clear = mine[spots.room[mine] >= CLEAR]
        rows.append(int(clear[0]) if len(clear) else int(mine[np.argmax(spots.room[mine])]))
    kept = np.array(rows)
    clear_ones = kept[spots.room[kept] >= CLEAR]
    return spots.keep(clear_ones if len(clear_ones) else kept)


def _cost(environment: Environment, spots: _Spots, row: int, controls: Sequence[Control]) -> float:
    """What a place has against it, in metres of way."""
    at = np.array([one.at for one in controls])
    shoulder = spots.on[row] + np.array([0.0, 0.0, SHOULDER])
    way = at - shoulder
    length = np.linalg.norm(way, axis=1)
    hits = first_hits(
        environment,
        np.tile(shoulder, (len(at), 1)),
        way / length[:, None],
        length=float(length.max()),
        among=~environment.hidden,
    )
    blocked = hits.distance < length - SHORT_OF
    ahead = np.array([math.cos(spots.yaw[row]), math.sin(spots.yaw[row])])
    askew = [_askew(environment, one, ahead) for one in controls]
    cost = length.mean() + BLOCKED * blocked.mean() + ASKEW * float(np.mean(askew))
    return float(cost) + max(0.0, CLEAR - float(spots.room[row])) * 10.0


def _askew(environment: Environment, control: Control, ahead: Floats) -> float:
    """How much of the surface that a control is on is seen from its edge: 0 to 1."""
    if control.part not in environment.parts:
        return 0.0
    corners = environment.triangle_corners(environment.part_index(control.part))
    at = np.array(control.at)
    near = (corners.min(axis=1) <= at + ABOUT).all(axis=1)
    near &= (corners.max(axis=1) >= at - ABOUT).all(axis=1)
    normal = np.cross(corners[near, 1] - corners[near, 0], corners[near, 2] - corners[near, 0])
    size = np.linalg.norm(normal, axis=1)
    level = (normal[:, :2] / np.sqrt(np.maximum(size, 1e-12))[:, None]) ** 2
    if not level.sum():
        return 0.0
    along = (normal[:, :2] @ ahead) ** 2 / np.maximum(size, 1e-12)
    return float(1.0 - along.sum() / level.sum())


def _anywhere(environment: Environment) -> StandingPlace:
    """Where somebody stands who has nothing to do: clear, as near to the middle as may be."""
    low, high = environment.bounds
    middle = 0.5 * (low + high)
    steps = [np.linspace(low[k] - 0.5, high[k] + 0.5, 9) for k in (0, 1)]
    x, y = (axis.ravel() for axis in np.meshgrid(*steps, indexing="ij"))
    on = np.stack([x, y, np.full(len(x), low[2] + 0.4)], axis=1)
    on[:, 2] = _floor(environment, on, float(low[2]))
    yaw = np.zeros(len(on))
    spots = _Spots(on, yaw, _room(environment, on, yaw))
    clear = np.flatnonzero(spots.room >= CLEAR)
    rows = clear if len(clear) else np.array([int(np.argmax(spots.room))])
    away = np.hypot(*(on[rows] - middle)[:, :2].T)
    best = int(rows[int(np.argmin(away))])
    a, b, c = _on_floor(environment, on[best], 0.0)
    why = "as near to the middle as a standing man is clear: no seat and no control is described"
    if not len(clear):
        why = "where least is touched: no seat and no control is described, and no place is clear"
    if not len(_floors(environment).corners):
        why = f"{why}; {_no_floor(c)}"
    return StandingPlace((a, b, c), 0.0, (), bool(len(clear)), why)


@cache
def _soles(body: Body, poses: Poses) -> float:
    """Height [m] of the soles of somebody who stands."""
    return float((place(body, poses).centres[0, :, 2] - body.radius[0]).min())


def _standing(on: Floats, yaw: Floats, who: tuple[Body, Poses] | None = None) -> Placed:
    """A man, or who is given, who stands in places (M, 3) [m], facing directions (M,)."""
    body, poses = who or standing_man()
    count = len(on)
    world = np.repeat(poses.world_from_reference, count, axis=0)
    turn = np.zeros((count, 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(yaw)
    turn[:, 1, 0] = np.sin(yaw)
    turn[:, 0, 1] = -turn[:, 1, 0]
    turn[:, 2, 2] = 1.0
    world[:, :, :3] = turn @ world[:, :, :3]
    world[:, :2, 3] = on[:, :2]
    world[:, 2, 3] += on[:, 2] - _soles(body, poses)
    return place(body, Poses(np.repeat(poses.rotations, count, axis=0), poses.reference, world))
