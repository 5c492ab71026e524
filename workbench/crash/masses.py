"""Masses and moments of inertia of a sphere body, and what each joint carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Placed

__all__ = ["Carried", "carried", "root_segment", "segment_inertia", "segment_masses"]

_CELLS = 22
_LEAST_SHARE = 1e-4


@dataclass(frozen=True, eq=False)
class Carried:
    """What lies beyond each joint in one pose: mass (J,) [kg], lever (J,) [m] of its centre of
    gravity from the joint, inertia (J,) [kg m2] about the joint, the mean of its three principal
    moments."""

    mass: Floats
    lever: Floats
    inertia: Floats


def root_segment(body: Body) -> int:
    """The first segment that has mass or spheres, or branches: what lies before it only says where
    it is."""
    at = 0
    while body.mass[0, at] == 0 and body.start[at] == body.start[at + 1]:
        below = np.flatnonzero(body.parent == at)
        if len(below) != 1:
            break
        at = int(below[0])
    return at


def segment_masses(body: Body) -> Floats:
    """(N,) [kg]; segments without mass get a ten-thousandth of the body's. InputError for a body
    without mass."""
    total = float(body.mass[0].sum())
    if not total > 0:
        raise InputError(f"body {body.name} has no mass, so it cannot be simulated")
    mass: Floats = np.maximum(body.mass[0], _LEAST_SHARE * total)
    return mass


def segment_inertia(body: Body, mass: Floats) -> Floats:
    """(N, 3, 3) [kg m2] about each segment's origin, its centre of gravity: the union of its
    spheres, of even density, on a grid of cells; its mean place is taken out, since the body file
    says where the centre of gravity is."""
    out = np.zeros((len(mass), 3, 3))
    for n in range(len(mass)):
        some = body.spheres(n)
        centre = body.centre[0, some]
        radius = body.radius[0, some]
        if not len(radius):
            out[n] = 1e-4 * mass[n] * np.eye(3)
            continue
        low = (centre - radius[:, None]).min(axis=0)
        high = (centre + radius[:, None]).max(axis=0)
        cell = float((high - low).max()) / _CELLS
        axes = [np.arange(a + cell / 2, b, cell) for a, b in zip(low, high, strict=True)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        filled = np.zeros(len(grid), dtype=np.bool_)
        for c, r in zip(centre, radius, strict=True):
            filled |= np.sum((grid - c) ** 2, axis=1) <= r * r
        at = grid[filled] if filled.any() else centre
        at = at - at.mean(axis=0)
        spread = np.einsum("gi,gj->ij", at, at) / len(at) + cell * cell / 12.0 * np.eye(3)
        out[n] = mass[n] * (np.trace(spread) * np.eye(3) - spread)
    return out


def carried(placed: Placed, mass: Floats, inertia: Floats) -> Carried:
    """What every joint carries in the first pose."""
    body = placed.body
    world = placed.world_from_segment[0]
    rows = []
    for j in range(len(body.joints)):
        beyond = [j + 1]
        beyond += [n for n in range(j + 2, len(mass)) if _descends(body, n, j + 1)]
        at = world[j + 1, :, :3] @ body.joint_in_child[0, j] + world[j + 1, :, 3]
        arm = world[beyond, :, 3] - at
        own = np.einsum(
            "nij,njk,nlk->nil", world[beyond, :, :3], inertia[beyond], world[beyond, :, :3]
        )
        about = own + mass[beyond, None, None] * (
            np.sum(arm**2, axis=1)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None, :]
        )
        total = float(mass[beyond].sum())
        lever = float(np.linalg.norm(mass[beyond] @ arm)) / total
        rows.append((total, lever, float(np.trace(about.sum(axis=0))) / 3.0))
    found = np.array(rows).reshape(-1, 3)
    return Carried(found[:, 0], found[:, 1], found[:, 2])


def _descends(body: Body, segment: int, from_: int) -> bool:
    while segment > from_:
        segment = int(body.parent[segment])
    return segment == from_
