"""How well spheres show the skin: fit errors of a body's segments, gaps at bent joints, overlaps of
segments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import workbench as wb
from human.skeleton import BETWEEN, JOINTS, SEGMENTS
from workbench.body.fitting.fit_quality import distance_to_union, exposed_points
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.sampling import random_samples
from workbench.body.surface import Surface
from workbench.model.body import Body

__all__ = ["BENT", "allowances", "bent_gaps", "fit_errors"]

Floats = NDArray[np.float64]
SEATED = {f"{side}{joint}": {"flexion": 90.0} for side in "LR" for joint in "HKE"}
BENT = {
    "LE": ("flexion", 100.0),
    "LK": ("flexion", 100.0),
    "LW": ("flexion", 50.0),
    "HP": ("flexion", 20.0),
    "NP": ("flexion", 40.0),
    "LH": ("flexion", 90.0),
    "LS": ("abduction", 60.0),
}
FLESH = {
    ("LT", "UT"),
    ("CT", "LUL"),
    ("CT", "RUL"),
    ("LT", "LUA"),
    ("CT", "LUA"),
    ("CT", "RUA"),
    ("UT", "LUA"),
    ("UT", "RUA"),
    ("LUL", "RUL"),
    ("N", "LSM"),
    ("N", "RSM"),
    ("CT", "LSM"),
    ("CT", "RSM"),
    ("LSM", "RSM"),
    ("UT", "H"),
    ("LT", "LLL"),
    ("LT", "RLL"),
    ("LT", "LLA"),
    ("LT", "RLA"),
    ("LT", "RUA"),
    ("N", "LUA"),
    ("N", "RUA"),
    ("LHN", "LUL"),
    ("RHN", "RUL"),
    ("H", "LSM"),
    ("H", "RSM"),
    ("CT", "LLA"),
    ("CT", "RLA"),
}
"""Pairs that flesh joins or presses together, standing or sitting; the palm may lie against the
thigh."""


def neighbours(segment: int) -> list[int]:
    """The segment and those it shares a joint with."""
    pairs = [[SEGMENTS.index(n) for n in pair.split()] for pair in BETWEEN.values()]
    return sorted({n for pair in pairs if segment in pair for n in pair})


def fit_errors(
    surface: Surface, share: Floats, spheres: tuple[Floats, Floats, NDArray[np.int64]]
) -> Floats:
    """(N, 2) [m] how far the skin lies outside and inside the spheres of each segment and its
    neighbours.

    100,000 samples of the skin; in the zero pose skin lies against skin, so each part is held
    against its own, and skin folded in between two parts (an arm pit, a groin) is not counted.
    """
    centre, radius, segment = spheres
    samples = random_samples(surface, 100_000, seed=3)
    label = share[surface.faces[samples.face]].mean(axis=1).argmax(axis=1)
    result = np.zeros((len(SEGMENTS), 2))
    for n in range(1, len(SEGMENTS)):
        own = np.isin(segment, neighbours(n))
        point = samples.point[label == n]
        if not len(point):
            continue
        field, ball = union_field(point, centre[own], radius[own])
        folded = (segment[own][ball] != n) & (field < -0.005)
        point = point[~folded]
        field = field[~folded]
        exposed = exposed_points(centre[own], radius[own], 20_000)
        far = distance_to_union(point, exposed, centre[own], radius[own])
        result[n] = max(field.max(), 0.0), far[field < 0].max(initial=0.0)
    return result


def allowances(body: Body) -> tuple[list[tuple[str, str, float]], list[str]]:
    """Overlaps of segments standing or sitting as allowances, rounded up to 2 mm; and those that no
    flesh explains."""
    bare = wb.place(_without(body), wb.join_poses([wb.pose(body, {}), wb.pose(body, SEATED)]))
    found = wb.self_contacts(bare)
    segment = body.sphere_segment
    deepest: dict[tuple[str, str], float] = {}
    for one, other, distance in zip(found.sphere, found.other_sphere, found.distance, strict=True):
        pair = sorted(
            (body.segments[segment[one]], body.segments[segment[other]]), key=SEGMENTS.index
        )
        key = (pair[0], pair[1])
        deepest[key] = max(deepest.get(key, 0.0), -float(distance))
    rows = [
        (a, b, float(np.ceil(500 * depth + 0.5) / 500)) for (a, b), depth in sorted(deepest.items())
    ]
    return [row for row in rows if row[:2] in FLESH], [
        f"{a}-{b} {1000 * d:.0f} mm" for a, b, d in rows if (a, b) not in FLESH
    ]


def _without(body: Body) -> Body:
    from dataclasses import replace

    return replace(body, allowance=np.zeros_like(body.allowance))


def bent_gaps(surface: Surface, share: Floats, joints: Floats, body: Body) -> dict[str, Floats]:
    """Largest and mean distance [m] between the linearly skinned surface and the spheres within 120
    mm of bent joints.

    surface: the skin in the zero pose; share (P, N); joints (J, 3) of this body. One joint bent at
    a time.
    """
    result = {}
    scale = np.ptp(surface.vertices[:, 2]) / 1.75
    for name, (motion, angle) in BENT.items():
        placed = wb.place(body, wb.pose(body, {name: {motion: angle}}))
        at = placed.world_from_segment[0]
        order = [SEGMENTS.index(n) for n in body.segments]
        rest = wb.place(body, wb.pose(body, {})).world_from_segment[0]
        turn = np.einsum("nij,nkj->nik", at[:, :, :3], rest[:, :, :3])
        shift = at[:, :, 3] - np.einsum("nij,nj->ni", turn, rest[:, :, 3])
        weight = share[:, order]
        moved = np.einsum("pn,nij,pj->pi", weight, turn, surface.vertices) + weight @ shift
        bent = Surface(moved, surface.faces)
        pair = [SEGMENTS.index(n) for n in BETWEEN[name].split()]
        near = sorted({m for n in pair for m in neighbours(n)})
        samples = random_samples(bent, 60_000, seed=4)
        place = joints[JOINTS.index(name)]
        parent = body.segments.index(BETWEEN[name].split()[0])
        place = turn[parent] @ place + shift[parent]
        mine = share[surface.faces[samples.face]].mean(axis=1).argmax(axis=1)
        keep = (np.linalg.norm(samples.point - place, axis=1) < 0.12 * scale) & np.isin(mine, pair)
        segment = np.array([order[n] for n in body.sphere_segment])
        own = np.isin(segment, near)
        gap = union_field(samples.point[keep], placed.centres[0][own], body.radius[0, own])[0]
        result[name] = np.array([gap.max(), np.abs(gap).mean(), -gap.min()])
    return result
