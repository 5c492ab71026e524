"""A small family of bodies made from bubbleman: size, limbs, trunk, girth and so on as components,
for tests."""

from __future__ import annotations

import numpy as np
import yaml

import workbench as wb
from tests.conftest import ROOT
from workbench.model.body import DIRECTIONS

ARMS = ("UA", "LA", "HN")
LEGS = ("UL", "LL", "F")


def world_of(body):
    """Sphere centres, joints and segment origins in the zero pose."""
    placed = wb.place(body, wb.pose(body, {}))
    origin = placed.world_from_segment[0, :, :, 3]
    return placed.centres[0].copy(), origin[1:] + body.joint_in_child[0], origin.copy()


def fields(points, arm, leg):
    """(K, P, 3) what each component does to points, by whether they are of an arm or a leg;
    symmetric."""
    x, y, z = points.T
    none = np.zeros_like(x)
    trunk = ~arm & ~leg
    side = np.sign(np.round(y, 9))
    rise = np.clip(z - 0.9, 0, None)
    hang = np.where(arm, np.clip(1.43 - z, 0, None), 0)
    out = np.clip(np.abs(y) / 0.17, 0, 1)
    head = np.clip((z - 1.52) / 0.15, 0, 1)
    foot = np.where(leg, np.clip(1 - z / 0.08, 0, 1), 0)
    hand = np.where(arm, np.clip((0.80 - z) / 0.05, 0, 1), 0)
    knee = np.where(leg, np.clip(z / 0.5, 0, 1) * np.clip((0.9 - z) / 0.4, 0, 1), 0)
    elbow = np.where(arm, np.clip((z - 0.8) / 0.3, 0, 1) * np.clip((1.43 - z) / 0.33, 0, 1), 0)
    return np.stack(
        [
            np.stack([0.040 * x, 0.040 * y, 0.040 * z], 1),  # size
            np.stack([none, none, 0.03 * np.minimum(z, 0.9)], 1),  # long legs: what is above rises
            np.stack([none, none, 0.05 * rise * ~arm + 0.05 * 0.53 * arm], 1),  # long trunk
            np.stack([0.07 * x * trunk, 0.014 * side * out, none], 1),  # girth
            np.stack([none, none, -0.05 * hang], 1),  # long arms
            np.stack(
                [none, 0.012 * side * out * np.clip((z - 1.1) / 0.3, 0, 1), none], 1
            ),  # broad shoulders
            np.stack(
                [0.05 * x * head, 0.05 * y * head, 0.05 * np.clip(z - 1.52, 0, None)], 1
            ),  # large head
            np.stack([none, none, -0.08 * hand * np.clip(0.80 - z, 0, None)], 1),  # long hands
            np.stack([0.06 * x * foot, 0.02 * y * foot, none], 1),  # long feet
            np.stack([none, none, 0.012 * knee], 1),  # high knees
            np.stack([none, none, 0.010 * elbow], 1),  # high elbows
            np.stack([0.015 * np.clip(x * trunk / 0.1, -1, 1), none, none], 1),  # deep trunk
            np.stack(
                [
                    none,
                    0.010 * side * np.clip(np.abs(y) / 0.1, 0, 1) * np.clip((1.1 - z) / 0.3, 0, 1),
                    none,
                ],
                1,
            ),
        ]
    )


def write_family(folder):
    """Write family.npz and adult.yaml, the member at its middle; returns the path of the body."""
    body = wb.load_body("bubbleman")
    centre, joint, origin = world_of(body)
    segment = body.sphere_segment
    limb = [name[1:] for name in body.segments]
    arm_segment = np.isin(limb, ARMS)
    leg_segment = np.isin(limb, LEGS)
    joint_of = body.parent[
        1:
    ]  # a joint moves as the segment above it; so do the spheres tied to it
    arm_joint = arm_segment[joint_of]
    leg_joint = leg_segment[joint_of]
    joint_basis = fields(joint, arm_joint, leg_joint)
    centre_basis = fields(centre, arm_segment[segment], leg_segment[segment])
    tied, at = np.nonzero(np.linalg.norm(centre[:, None] - joint[None], axis=-1) < 1e-9)
    centre_basis[:, tied] = joint_basis[:, at]
    growth = np.zeros((len(centre_basis), len(centre)))
    growth[0] = 0.040 * body.radius[0]
    trunk = ~(arm_segment | leg_segment)[segment]
    growth[3] = 0.06 * body.radius[0]
    growth[6] = 0.05 * body.radius[0] * (segment == body.segment("H"))
    growth[11] = 0.03 * body.radius[0] * trunk
    named = np.array([bool(name) for name in body.sphere_names])
    kept = {
        "fine": np.arange(len(segment)),
        "coarse": np.flatnonzero(
            named | np.isin(np.arange(len(segment)), tied) | (np.arange(len(segment)) % 2 == 0)
        ),
    }
    arrays = {
        "format": np.array(1),
        "segments": np.array(body.segments),
        "joints": np.array(body.joints),
        "joint_mean": joint,
        "joint_basis": joint_basis,
        "origin_mean": origin,
        "origin_basis": fields(origin, arm_segment, leg_segment),
        "density": np.full(len(body.segments), 1000.0),
        "anchor_names": np.array(["adult", "large"]),
        "anchors": np.array([np.zeros(len(growth)), np.eye(len(growth))[0] * 3]),
        "anchor_spread": np.ones((2, len(growth))),
        "anchor_seated": np.repeat(body.seated_factors, 2, axis=0),
    }
    blend = np.where(segment == body.segment("LLA"), 0.3, 0.0)
    side = np.array(["", *DIRECTIONS])[body.sphere_direction + 1]
    for level, rows in kept.items():
        arrays |= {
            f"{level}_segment": segment[rows],
            f"{level}_centre_mean": centre[rows],
            f"{level}_centre_basis": centre_basis[:, rows],
            f"{level}_radius_mean": body.radius[0, rows],
            f"{level}_radius_basis": growth[:, rows],
            f"{level}_name": np.array(body.sphere_names)[rows],
            f"{level}_direction": side[rows],
            f"{level}_fit_error": np.full((len(body.segments), 2), 0.004),
            f"{level}_blend_joint": np.where(blend > 0, body.joint("LE"), -1)[rows],
            f"{level}_blend_share": blend[rows],
        }
    np.savez(folder / "family.npz", **arrays)
    value = yaml.safe_load((ROOT / "bodies" / "bubbleman.yaml").read_text())
    value |= {"body": "adult", "basis": "family.npz", "basis_at": [0.0] * len(growth)}
    rows = [str(i) for i in range(len(value["segments"]["LLA"]["spheres"]))]
    value["segments"]["LLA"]["blend"] = {"LE": dict.fromkeys(rows, 0.3)}
    path = folder / "adult.yaml"
    path.write_text(yaml.safe_dump(value, sort_keys=False))
    return path
