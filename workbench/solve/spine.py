"""The trunk in side view: a body's own landmarks for the published angles, and the tilts that come nearest to them.

The waist joint stands for the sacrum's upper end (L5/S1), the solar plexus joint for T12/L1, the neck pivot for C7/T1;
the ears and the eyes are the body's. Where a body has these joints a little elsewhere, its bones are so much longer or
shorter than people's, and the angles cannot all be had together with the line from hip to eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import DrivingAngles
from workbench.model.poses import Placed
from workbench.model.posing import motion_of

__all__ = ["SPINE", "Spine", "side_view", "spine_of", "spine_tilts"]

SPINE = ("LT", "W", "SP", "NP", "HP")
"""The lower torso, and the joints that tilt what is above."""
TRUNK = (5, 4, 3, 2, 1)
"""Pelvis, abdomen, thorax, neck, head in ANGLES."""
JUST = 1e-6


@dataclass(frozen=True, eq=False)
class Spine:
    """A trunk in side view, upright as in the zero pose: hips (3,) [m] the middle of the hip joints in the lower
    torso; links (6, 2) [m]: forward and up from the hips to the waist, to the solar plexus, the neck pivot, the head
    pivot, the ear, and from the ear to the eye; flexion (4, 2) [rad]: least and greatest flexion of the joints."""

    hips: Floats
    links: Floats
    flexion: Floats


@lru_cache(maxsize=64)
def spine_of(body: Body) -> Spine:
    """The trunk of a body. InputError where it has no human trunk, or no eyes and ears."""
    for name in ("LH", "RH", *SPINE[1:]):
        body.joint(name)
    hips = 0.5 * (body.joint_in_parent[body.joint("LH")] + body.joint_in_parent[body.joint("RH")])
    joints = [body.joint(name) for name in SPINE[1:]]
    ear, eye = _middle(body, "ear"), _middle(body, "eye")
    points = [body.joint_in_parent[joints[0]] - hips]
    points += [body.joint_in_parent[b] - body.joint_in_child[a] for a, b in pairwise(joints)]
    points += [ear - body.joint_in_child[joints[3]], eye - ear]
    flexion = np.zeros((4, 2))
    for k, joint in enumerate(joints):
        axis, sign = motion_of(body, joint, "flexion")
        first, second = body.stops.limits[joint, axis]
        flexion[k] = (-second, first) if sign > 0 else (-first, second)
    return Spine(hips, np.array(points)[:, [0, 2]], flexion)


def _middle(body: Body, name: str) -> Floats:
    """Midway between a left and a right sphere of the head (3,) [m]."""
    rows = []
    for side in ("left", "right"):
        if f"{side} {name}" not in body.sphere_names:
            known = [n for n in body.sphere_names if n]
            raise InputError(f"body {body.name} has no sphere '{side} {name}'; {one_of(f'{side} {name}', known)}")
        rows.append(body.centre[body.sphere_names.index(f"{side} {name}")])
    middle: Floats = 0.5 * (rows[0] + rows[1])
    return middle


def spine_tilts(spine: Spine, angles: DrivingAngles) -> Floats:
    """(5,) [rad] how far lower, central and upper torso, neck and head tilt aft of upright.

    The line from hip to eye is held, as the cascade has it; within the joint stops the five angles are as near to the
    given ones as they can be, by least squares in units of their scatter. Where the stops do not let the line be had,
    it is come near to.
    """
    wanted, spread = angles.mean[list(TRUNK)], angles.spread[list(TRUNK)]

    def tilts(turn: Floats) -> Floats:
        total: Floats = np.concatenate([turn[:1], turn[0] - np.cumsum(turn[1:])])
        return total

    def cost(turn: Floats) -> float:
        off = _wrapped(_angles(spine, tilts(turn))[1:] - wanted) / spread
        return float(off @ off)

    def line(turn: Floats) -> float:
        return float(_wrapped(_angles(spine, tilts(turn))[0] - angles.mean[0]))

    def near(turn: Floats) -> float:
        return cost(turn) + 1e4 * line(turn) ** 2

    inside = spine.flexion + np.array([JUST, -JUST])
    bounds = [(-1.0, 2.0), *((float(low), float(high)) for low, high in inside)]
    start = np.clip(np.zeros(5), *np.array(bounds).T)
    start[0] = wanted[0] - np.arctan2(-spine.links[0, 0], spine.links[0, 1])
    found = minimize(cost, start, bounds=bounds, constraints={"type": "eq", "fun": line}, method="SLSQP",
                     options={"ftol": 1e-10, "maxiter": 200})  # fmt: skip
    if abs(line(found.x)) > 1e-4:
        found = minimize(near, start, bounds=bounds, method="L-BFGS-B")
    return tilts(np.clip(found.x, *np.array(bounds).T))


def _angles(spine: Spine, tilts: Floats) -> Floats:
    """(6,) [rad] hip to eye, pelvis, abdomen, thorax, neck and head of a trunk whose segments tilt aft by (5,)."""
    tilt = np.concatenate([tilts, tilts[4:]])  # ear and eye turn with the head
    c, s = np.cos(tilt), np.sin(tilt)
    x, z = spine.links.T
    link = np.stack([x * c - z * s, x * s + z * c], axis=1)
    neck = link[3] + link[4]
    whole = link.sum(axis=0)
    return np.array([
        *(np.arctan2(-v[0], v[1]) for v in (whole, link[0], link[1], link[2], neck)),
        np.arctan2(link[5, 1], link[5, 0]),
    ])  # fmt: skip


def side_view(placed: Placed) -> Floats:
    """(P, 8) [rad] the angles of ANGLES as placed bodies have them, facing along +x; thigh and knee are the right
    leg's."""
    body, world = placed.body, placed.world_from_segment

    def joint(name: str) -> Floats:
        j = body.joint(name)
        frame = world[:, body.parent[j + 1]]
        at: Floats = frame[:, :, :3] @ body.joint_in_parent[j] + frame[:, :, 3]
        return at

    hips = 0.5 * (joint("LH") + joint("RH"))
    head = world[:, body.segment("H")]
    ear, eye = (head[:, :, :3] @ _middle(body, name) + head[:, :, 3] for name in ("ear", "eye"))
    waist, plexus, neck = joint("W"), joint("SP"), joint("NP")
    hip, knee, ankle = joint("RH"), joint("RK"), joint("RA")
    aft = [(hips, eye), (neck, ear), (plexus, neck), (waist, plexus), (hips, waist)]
    rows = [np.arctan2(a[:, 0] - b[:, 0], b[:, 2] - a[:, 2]) for a, b in aft]
    rows.insert(1, np.arctan2(eye[:, 2] - ear[:, 2], eye[:, 0] - ear[:, 0]))
    rows.append(np.arctan2(knee[:, 2] - hip[:, 2], knee[:, 0] - hip[:, 0]))
    one, two = hip - knee, ankle - knee
    cosine = np.sum(one * two, axis=1) / (np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1))
    rows.append(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return np.stack(rows, axis=1)


def _wrapped(angle: Floats) -> Floats:
    """The same angles between -pi and pi."""
    turned: Floats = (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi
    return turned
