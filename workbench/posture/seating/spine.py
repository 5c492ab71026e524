"""The trunk in side view: a body's own landmarks for the published angles, and the tilts that come
nearest to them.

The waist joint stands for the sacrum's upper end (L5/S1), the solar plexus joint for T12/L1, the
neck pivot for C7/T1; the ears and the eyes are the body's. Where a body has these joints a little
elsewhere, its bones are so much longer or shorter than people's, and the angles cannot all be had
together with the line from hip to eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.posing import motion_of
from workbench.posture.kernels.trunk import trunk_turns

__all__ = ["SPINE", "Spine", "spine_of", "spine_tilts"]

SPINE = ("LT", "W", "SP", "NP", "HP")
"""The lower torso, and the joints that tilt what is above."""
TRUNK = (5, 4, 3, 2, 1)
"""Pelvis, abdomen, thorax, neck, head in ANGLES."""
JUST = 1e-6
LEAN = (-1.0, 2.0)
"""How far [rad] a lower torso may tilt aft."""


@dataclass(frozen=True, eq=False)
class Spine:
    """B trunks in side view, upright as in the zero pose: hips (B, 3) [m] the middle of the hip
    joints in the lower torso; links (B, 6, 2) [m]: forward and up from the hips to the waist, to the
    solar plexus, the neck pivot, the head pivot, the ear, and from the ear to the eye; flexion (4, 2)
    [rad]: least and greatest flexion of the joints."""

    hips: Floats
    links: Floats
    flexion: Floats


def spine_of(body: Body) -> Spine:
    """The trunks of the rows of a body. InputError where it has no human trunk, or no eyes and
    ears."""
    sides = [body.joint(name) for name in ("LH", "RH")]
    joints = [body.joint(name) for name in SPINE[1:]]
    hips = 0.5 * (body.joint_in_parent[:, sides[0]] + body.joint_in_parent[:, sides[1]])
    ear = _middle(body, "ear")
    points = [body.joint_in_parent[:, joints[0]] - hips]
    points += [body.joint_in_parent[:, b] - body.joint_in_child[:, a] for a, b in pairwise(joints)]
    points += [ear - body.joint_in_child[:, joints[3]], _middle(body, "eye") - ear]
    flexion = np.zeros((4, 2))
    for k, joint in enumerate(joints):
        axis, sign = motion_of(body, joint, "flexion")
        first, second = body.stops.limits[joint, axis]
        flexion[k] = (-second, first) if sign > 0 else (-first, second)
    return Spine(hips, np.stack(points, axis=1)[:, :, [0, 2]], flexion)


def _middle(body: Body, name: str) -> Floats:
    """(B, 3) [m] midway between a left and a right sphere of the head."""
    rows = []
    for side in ("left", "right"):
        if f"{side} {name}" not in body.sphere_names:
            known = [n for n in body.sphere_names if n]
            raise InputError(
                f"body {body.name} has no sphere '{side} {name}'; {one_of(f'{side} {name}', known)}"
            )
        rows.append(body.centre[:, body.sphere_names.index(f"{side} {name}")])
    middle: Floats = 0.5 * (rows[0] + rows[1])
    return middle


def spine_tilts(spine: Spine, mean: Floats, spread: Floats) -> Floats:
    """(B, 5) [rad] how far lower, central and upper torso, neck and head of B trunks tilt aft of
    upright.

    The line from hip to eye is held, as the cascade has it; within the joint stops the five angles
    are as near to the given ones (B, 8) [rad] as they can be, by least squares in units of their
    scatter (B, 8). Where the stops do not let the line be had, it is come near to.
    """
    links = np.ascontiguousarray(spine.links)
    count = len(links)
    bounds = np.empty((count, 5, 2))
    bounds[:, 0] = LEAN
    bounds[:, 1:] = spine.flexion + np.array([JUST, -JUST])
    turns = np.zeros((count, 5))
    turns[:, 0] = mean[:, TRUNK[0]] - np.arctan2(-links[:, 0, 0], links[:, 0, 1])
    turns = np.clip(turns, bounds[..., 0], bounds[..., 1])
    wanted = np.ascontiguousarray(mean[:, [0, *TRUNK]])
    trunk_turns(links, wanted, np.ascontiguousarray(spread[:, list(TRUNK)]), bounds, turns)
    tilts: Floats = np.concatenate(
        [turns[:, :1], turns[:, :1] - np.cumsum(turns[:, 1:], axis=1)], axis=1
    )
    return tilts
