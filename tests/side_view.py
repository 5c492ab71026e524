"""The angles of a driving posture, measured on placed bodies in side view."""

from __future__ import annotations

import numpy as np

__all__ = ["side_view"]


def apply(matrices, vectors):
    """(P, 3) matrices (P, 3, 3) times vectors (P, 3)."""
    return np.einsum("pij,pj->pi", matrices, vectors)


def between_sides(body, name):
    """(B, 3) [m] midway between a left and a right sphere of the head."""
    left, right = (body.sphere_names.index(f"{side} {name}") for side in ("left", "right"))
    return 0.5 * (body.centre[:, left] + body.centre[:, right])


def side_view(placed):
    """(P, 8) [rad] the angles of ANGLES as placed bodies have them, facing along +x; thigh and knee
    are the right leg's."""
    body = placed.body
    world = placed.world_from_segment

    def joint(name):
        j = body.joint(name)
        frame = world[:, body.parent[j + 1]]
        return apply(frame[:, :, :3], body.joint_in_parent[placed.person, j]) + frame[:, :, 3]

    hips = 0.5 * (joint("LH") + joint("RH"))
    head = world[:, body.segment("H")]
    ear, eye = (
        apply(head[:, :, :3], between_sides(body, name)[placed.person]) + head[:, :, 3]
        for name in ("ear", "eye")
    )
    waist = joint("W")
    plexus = joint("SP")
    neck = joint("NP")
    hip = joint("RH")
    knee = joint("RK")
    ankle = joint("RA")
    aft = [(hips, eye), (neck, ear), (plexus, neck), (waist, plexus), (hips, waist)]
    rows = [np.arctan2(a[:, 0] - b[:, 0], b[:, 2] - a[:, 2]) for a, b in aft]
    rows.insert(1, np.arctan2(eye[:, 2] - ear[:, 2], eye[:, 0] - ear[:, 0]))
    rows.append(np.arctan2(knee[:, 2] - hip[:, 2], knee[:, 0] - hip[:, 0]))
    one = hip - knee
    two = ankle - knee
    cosine = np.sum(one * two, axis=1) / (np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1))
    rows.append(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return np.stack(rows, axis=1)
