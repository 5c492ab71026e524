"""Sitting, slowly and obviously: every place of the seat is tried, sitting and stepping take turns
a fixed number of times, each foot begins anew. What the compiled search must equal."""

from __future__ import annotations

import numpy as np

import workbench as wb
from workbench import limb, reach
from workbench.posture.seating.posture import pointed_foot, positions
from workbench.posture.seating.seating import seat_attitude, seat_planes

TURNS = 3
LIFTS = 4
SHORT = 1e-3
HEEL_IN_AIR = 10.0


def eye_points(placed):
    """(P, 3) [m] the point midway between the two eyes."""
    names = placed.body.sphere_names
    return 0.5 * (
        placed.centres[:, names.index("left eye")] + placed.centres[:, names.index("right eye")]
    )


def seat_slowly(body, poses, seat, *, eye, pedals):
    """Forward, up [m], eye (3,), misses [m], limits in words, discomfort, rotations (J, 4) of one
    sitter: the best of all places with the heels on the floor where that can be, and of those where
    the thighs press too deep so with the heels in the air."""
    down = every_place(body, poses, seat, eye=eye, pedals=pedals, heels=True)
    ways = [(down, p) for p in range(len(down["forward"]))]
    if pedals.floor is not None and down["pressed"].max() >= 5e-4:
        air = every_place(body, poses, seat, eye=eye, pedals=pedals, heels=False)
        ways += [(air, p) for p in np.flatnonzero(down["pressed"] >= 5e-4)]

    def worth(way):
        found, p = way
        return (
            round(found["missed"][p], 4),
            round(max(found["pressed"][p], 0.0), 3),
            round(found["discomfort"][p], 3),
            abs(found["forward"][p]),
        )

    found, p = min(ways, key=worth)
    one = {name: values[p] for name, values in found.items() if name not in ("miss", "limit")}
    for name in ("miss", "limit"):
        one[name] = {foot: values[p] for foot, values in found[name].items()}
    return one


def every_place(body, poses, seat, *, eye, pedals, heels):
    """What `seat_slowly` returns of the best, for each place of the seat."""
    forward = positions(seat.travel_forward)
    up = np.full(len(forward), min(max(0.0, seat.travel_up[0]), seat.travel_up[1]))
    poses = wb.Poses(
        np.repeat(poses.rotations, len(forward), axis=0),
        poses.reference,
        np.repeat(poses.world_from_reference, len(forward), axis=0),
    )
    for _ in range(1 + LIFTS * (eye is not None)):
        poses, miss, limit, ease = stepped(body, poses, seat, (forward, up), pedals, heels)
        eyes = eye_points(wb.place(body, poses, window=["H"]))
        if eye is not None:
            before = up
            up = np.clip(up + eye - eyes[:, 2], *seat.travel_up)
    missed = np.sum([np.where(m > SHORT, m, 0.0) for m in miss.values()], axis=0) * np.ones(
        len(forward)
    )
    at = up if eye is None else before
    pressed = thighs_too_deep(
        wb.place(body, poses, window=["LUL", "RUL"]), seat, (forward, at), pedals
    )
    return {
        "forward": forward,
        "up": at,
        "eye": eyes,
        "missed": missed,
        "discomfort": ease,
        "pressed": pressed,
        "rotations": poses.rotations,
        "miss": miss,
        "limit": limit,
    }


def thighs_too_deep(placed, seat, travel, pedals):
    """(P,) how much deeper the thighs press into the front of the cushion than it gives, sphere by
    sphere and face by face."""
    body = placed.body
    thighs = [{"left foot": "LUL", "right foot": "RUL"}[foot] for foot in pedals.at]
    cushion, _, left = seat_planes(seat)
    found = np.zeros(len(placed.centres))
    for p, (forward, up) in enumerate(zip(*travel, strict=True)):
        at = np.array(seat.srp) + forward * np.array([left[1], -left[0], 0.0])
        at = at + up * np.array([0.0, 0.0, 1.0])
        for s in range(len(body.sphere_segment)):
            if body.segments[body.sphere_segment[s]] not in thighs:
                continue
            away = placed.centres[p, s] - at
            along = away @ np.cross(left, cushion)
            height = max(a * along + b * (away @ cushion) - c for a, b, c in seat.front.faces)
            found[p] = max(found[p], body.radius[0, s] - height - seat.front.gives)
    return found


def stepped(body, poses, seat, travel, pedals, heels):
    """Sitters (P) with the seat at these places, feet on the pedals: poses, misses, limits,
    discomfort (P,)."""
    side = seat_planes(seat)[2]
    ahead = np.array([side[1], -side[0], 0.0])
    shift = travel[0][:, None] * ahead + travel[1][:, None] * np.array([0.0, 0.0, 1.0])
    miss = {}
    limit = {}
    poses = sat(body, poses, seat, shift)
    for _ in range(TURNS):
        total = np.zeros(len(poses))
        for foot, at in pedals.at.items():
            poses, miss[foot], limit[foot], ease = on_pedal(
                body, poses, (foot, at, ahead), pedals.floor, heels
            )
            total = total + ease
        poses = sat(body, poses, seat, shift)
    return poses, miss, limit, total


def sat(body, poses, seat, shift):
    """The poses moved until the body rests on cushion and back with the stated depths."""
    world = poses.world_from_reference.copy()
    world[:, :, :3] = seat_attitude(seat)
    placed = wb.place(body, wb.Poses(poses.rotations, poses.reference, world))
    cushion, back, centre = seat_planes(seat)
    point = np.array(seat.srp)
    low = least_height(placed, cushion, seat.cushion) - cushion @ point
    rear = least_height(placed, back, seat.back) - back @ point
    aside = world[:, :, 3] @ centre - centre @ point
    wanted = np.stack([-seat.cushion.depth - low, -seat.back.depth - rear, -aside], axis=1)
    world[:, :, 3] += np.linalg.solve(np.stack([cushion, back, centre]), wanted.T).T + shift
    return wb.Poses(poses.rotations, poses.reference, world)


def least_height(placed, normal, rest):
    """(P,) least height along a normal of the spheres of the segments that rest there."""
    body = placed.body
    names = body.segments if "all" in rest.segments else rest.segments
    rows = np.isin(body.sphere_segment, [body.segments.index(n) for n in names])
    return (placed.centres[:, rows] @ normal - body.radius[0, rows]).min(axis=1)


def on_pedal(body, poses, pedal, floor, heels):
    name, at, ahead = pedal
    ball = limb(body, name, grip="ball")
    heel = limb(body, name, grip="heel")
    targets = np.array(at)
    free = reach(body, poses, targets, limb=ball)
    words = [free.limit(p, 0) for p in range(len(poses))]
    rotations = free.poses.rotations
    miss = free.miss[:, 0]
    ease = free.discomfort[:, 0]
    if floor is not None:
        rise = float(np.clip((at[2] - floor) / np.linalg.norm(ball.tip - heel.tip), -0.95, 0.95))
        along = np.sqrt(1.0 - rise * rise) * ahead + rise * np.array([0.0, 0.0, 1.0])
        heeled = reach(body, poses, targets, limb=pointed_foot(body, name), direction=along)
        down = heeled.reached[:, 0] & heels
        rotations = np.where(down[:, None, None], heeled.poses.rotations, rotations)
        miss = np.where(down, heeled.miss[:, 0], miss)
        ease = np.where(down, heeled.discomfort[:, 0], ease + HEEL_IN_AIR)
        words = ["" if down[p] else words[p] for p in range(len(poses))]
    return wb.Poses(rotations, poses.reference, poses.world_from_reference), miss, words, ease
