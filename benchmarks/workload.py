"""One deterministic workload: a cockpit of curved panels and instruments, bubbleman, seeded seated
poses.

The cockpit is about 1.8 x 1.3 x 1.9 m. Everything in it is curved, so that merging coplanar
triangles saves nothing and the count of polygons is the count of triangles. Panels and instruments
are open surfaces, as CAD mostly is; the seat pan, the stick and a few boxes of equipment are closed
solids.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

import workbench as wb
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.parts import RawPart
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses

__all__ = ["SIZES", "cockpit", "dense_body", "seated_poses"]

SIZES = {"2k": 0.105, "50k": 0.553, "500k": 1.76}
"""How fine the surfaces are cut for about so many triangles."""


def _sheet(points: Floats) -> tuple[Floats, Ints]:
    """Vertices and triangles of a grid of points (a, b, 3)."""
    a, b = points.shape[:2]
    index = np.arange(a * b).reshape(a, b)
    one = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:]], axis=-1).reshape(-1, 3)
    two = np.stack([index[:-1, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 3)
    return points.reshape(-1, 3), np.concatenate([one, two])


def _panel(
    corner: list[float], along: list[float], up: list[float], bulge: float, cut: tuple[int, int]
) -> Floats:
    """Points (a, b, 3) of a doubly curved panel: a parallelogram pushed out along its normal."""
    u, v = np.meshgrid(np.linspace(0, 1, cut[0] + 1), np.linspace(0, 1, cut[1] + 1), indexing="ij")
    e = np.array(along)
    f = np.array(up)
    n = np.cross(e, f) / np.linalg.norm(np.cross(e, f))
    push = bulge * np.sin(np.pi * u) * np.sin(np.pi * v)
    return np.array(corner) + u[..., None] * e + v[..., None] * f + push[..., None] * n


def _knob(at: Floats, axis: Floats, radius: float, height: float, cut: tuple[int, int]) -> Floats:
    """Points (a, b, 3) of a turned knob: a cylinder with a rounded cap, open at its foot."""
    t, turn = np.meshgrid(
        np.linspace(0, 1, cut[0] + 1), np.linspace(0, 2 * np.pi, cut[1] + 1), indexing="ij"
    )
    across = np.where(t < 0.5, radius, radius * np.cos(np.pi * (t - 0.5)) + 1e-4)
    along = np.where(t < 0.5, 1.6 * t * height, height * (0.8 + 0.2 * np.sin(np.pi * (t - 0.5))))
    a = np.cross(axis, [0.31, 0.95, 0.05])
    a /= np.linalg.norm(a)
    b = np.cross(axis, a)
    ring = np.cos(turn)[..., None] * a + np.sin(turn)[..., None] * b
    return at + across[..., None] * ring + along[..., None] * axis


def _egg(centre: list[float], half: list[float], cut: tuple[int, int]) -> tuple[Floats, Ints]:
    """A closed, rounded box (superellipsoid): vertices and outward triangles."""
    rings = max(cut[0], 3)
    turns = max(cut[1], 6)
    tilt = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]
    turn = np.linspace(0, 2 * np.pi, turns, endpoint=False)
    soft = lambda x: np.sign(x) * np.abs(x) ** 0.4  # noqa: E731
    x = soft(np.cos(tilt))[:, None] * soft(np.cos(turn))
    y = soft(np.cos(tilt))[:, None] * soft(np.sin(turn))
    z = np.broadcast_to(soft(np.sin(tilt))[:, None], x.shape)
    points = np.concatenate([np.stack([x, y, z], axis=-1).reshape(-1, 3), [[0, 0, -1], [0, 0, 1]]])
    index = np.arange(x.size).reshape(x.shape)
    here = index
    right = np.roll(index, -1, axis=1)
    faces = [
        np.stack([here[:-1], right[:-1], right[1:]], axis=-1),
        np.stack([here[:-1], right[1:], here[1:]], axis=-1),
    ]
    low = np.full(turns, x.size)
    high = np.full(turns, x.size + 1)
    caps = [
        np.stack([low, right[0], here[0]], axis=-1),
        np.stack([high, here[-1], right[-1]], axis=-1),
    ]
    triangles = np.concatenate([f.reshape(-1, 3) for f in [*faces, *caps]])
    return np.array(centre) + points * half, triangles


PANELS = {
    "instrument_panel": ([0.66, -0.55, 0.42], [0, 1.1, 0], [-0.10, 0, 0.42], 0.02, (120, 50)),
    "coaming": ([0.62, -0.55, 0.86], [0, 1.1, 0], [-0.16, 0, 0.03], 0.03, (100, 16)),
    "left_console": ([-0.25, 0.36, 0.28], [0.85, 0, 0], [0, 0.24, 0.02], 0.015, (80, 24)),
    "right_console": ([0.6, -0.36, 0.28], [-0.85, 0, 0], [0, -0.24, 0.02], 0.015, (80, 24)),
    "left_wall": ([-0.6, 0.62, -0.62], [1.5, 0, 0], [0, 0.03, 1.47], 0.05, (90, 60)),
    "right_wall": ([0.9, -0.62, -0.62], [-1.5, 0, 0], [0, -0.03, 1.47], 0.05, (90, 60)),
    "floor": ([-0.6, -0.62, -0.655], [1.8, 0, 0.02], [0, 1.24, 0], -0.02, (90, 60)),
    "canopy": ([-0.6, -0.6, 1.15], [1.35, 0, -0.1], [0, 1.2, 0], 0.16, (90, 80)),
    "seat_back": ([-0.32, 0.24, 0.05], [-0.18, 0, 0.85], [0, -0.48, 0], -0.02, (60, 40)),
    "left_rudder": ([0.86, 0.05, -0.56], [0.05, 0, 0.16], [0, 0.13, 0], 0.012, (20, 16)),
    "right_rudder": ([0.86, -0.18, -0.56], [0.05, 0, 0.16], [0, 0.13, 0], 0.012, (20, 16)),
}
SOLIDS = {
    "seat_pan": ([-0.06, 0.0, -0.13], [0.26, 0.24, 0.07], (40, 60)),
    "stick": ([0.46, 0.0, 0.02], [0.02, 0.02, 0.22], (40, 24)),
    "pedestal": ([0.68, 0.0, 0.05], [0.10, 0.09, 0.24], (40, 50)),
    "left_box": ([0.15, 0.48, 0.12], [0.30, 0.09, 0.10], (30, 40)),
    "overhead": ([0.10, 0.0, 1.22], [0.16, 0.20, 0.05], (30, 40)),
}


def _cuts(cut: tuple[int, int], fine: float) -> tuple[int, int]:
    return max(2, round(cut[0] * fine)), max(3, round(cut[1] * fine))


@lru_cache(maxsize=4)
def cockpit(size: str) -> Environment:
    """The cockpit of about `size` triangles, a key of SIZES."""
    fine = SIZES[size]
    parts = [
        RawPart(name, *_sheet(_panel(c, e, f, bulge, _cuts(cut, fine))))
        for name, (c, e, f, bulge, cut) in PANELS.items()
    ]
    parts += [
        RawPart(name, *_egg(c, half, _cuts(cut, fine))) for name, (c, half, cut) in SOLIDS.items()
    ]
    rng = np.random.default_rng(20)
    for name, many in (("instrument_panel", 48), ("left_console", 24), ("right_console", 24)):
        corner, e, f, bulge, _ = PANELS[name]
        normal = np.cross(e, f) / np.linalg.norm(np.cross(e, f))
        found = [
            _knob(
                _panel(corner, e, f, bulge, (1, 1))[0, 0] + u * np.array(e) + v * np.array(f),
                -normal if name == "instrument_panel" else normal,
                r,
                2 * r,
                _cuts((14, 26), fine),
            )
            for u, v, r in rng.uniform([0.04, 0.08, 0.006], [0.96, 0.92, 0.02], (many, 3))
        ]
        sheets = [_sheet(points) for points in found]
        first = np.cumsum([0, *(len(v) for v, _ in sheets)])
        faces = np.concatenate([f + start for (_, f), start in zip(sheets, first, strict=False)])
        parts.append(RawPart(f"{name}_knobs", np.concatenate([v for v, _ in sheets]), faces))
    solid: list[bool | str] = [part.name in SOLIDS for part in parts]
    return build_environment(f"cockpit_{size}", parts, solid=solid)[0]


def dense_body(body: Body, spheres: int = 1500) -> Body:
    """The body with its largest spheres each split into four inside it, until there are about so
    many."""
    split = np.zeros(len(body.sphere_names), dtype=np.bool_)
    split[np.argsort(-body.radius[0], kind="stable")[: (spheres - len(body.sphere_names)) // 3]] = (
        True
    )
    count = np.where(split, 4, 1)
    owner = np.repeat(np.arange(len(count)), count)
    turn = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    corner = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    pieces = split[owner]
    shift = np.where(pieces[:, None], 0.3 * body.radius[0, owner, None] * corner[turn], 0.0)
    first = np.concatenate([[0], np.cumsum(count)])
    topology = replace(
        body.topology,
        start=first[body.start],
        sphere_names=tuple(body.sphere_names[i] for i in owner),
        sphere_direction=body.sphere_direction[owner],
        blend_joint=body.blend_joint[owner],
    )
    return replace(
        body,
        name=f"{body.name}_{len(owner)}",
        topology=topology,
        centre=body.centre[:, owner] + shift,
        radius=np.where(pieces, 0.7, 1.0) * body.radius[:, owner],
        twist_share=body.twist_share[:, owner],
        blend_share=body.blend_share[:, owner],
    )


def seated_poses(body: Body, count: int = 1000, *, seed: int = 7, spread: float = 1.0) -> Poses:
    """Seeded seated poses: joints turned at random about the seated posture, the hips moved a few
    centimetres."""
    library = load_postures(posture_path("bubbleman"), wb.load_body("bubbleman"))[0]  # type: ignore[arg-type]
    base = posture_pose(body, library, "seated")
    rng = np.random.default_rng(seed)
    size = np.array(
        [0.35 if name[0] in "LR" and name[1:] in ("S", "E", "W") else 0.06 for name in body.joints]
    )
    vector = rng.normal(size=(count, len(body.joints), 3)) * (0.5 * spread * size)[:, None]
    turn = np.concatenate([np.ones((*vector.shape[:2], 1)), vector], axis=-1)
    turn /= np.linalg.norm(turn, axis=-1, keepdims=True)
    w = base.rotations[..., :1]
    v = base.rotations[..., 1:]
    real = w * turn[..., :1] - (v * turn[..., 1:]).sum(-1, keepdims=True)
    imaginary = (
        w * turn[..., 1:]
        + turn[..., :1] * v
        + np.cross(np.broadcast_to(v, vector.shape), turn[..., 1:])
    )
    world = np.repeat(base.world_from_reference, count, axis=0)
    world[:, :, 3] += np.array([-0.10, 0.0, 0.12]) + rng.normal(size=(count, 3)) * spread * [
        0.03,
        0.015,
        0.02,
    ]
    return wb.Poses(np.concatenate([real, imaginary], axis=-1), base.reference, world)
