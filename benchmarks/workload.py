"""Two deterministic cockpits, of curved and of flat faces, and seeded seated poses of bubbleman in
them.

They are about 1.8 x 1.3 x 1.9 m. In the curved one merging coplanar triangles saves nothing: the
count of polygons is the count of triangles. Panels and instruments are open surfaces, as CAD mostly
is; the seat pan, the stick and a few boxes of equipment are closed solids. The flat one has plates
with cut-outs, brackets, boxes and faceted knobs, meshed finely as a mesh generator does it: most
triangles merge into polygons with many corners along straight edges.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import workbench as wb
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.parts import RawPart
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses

__all__ = ["SIZES", "cockpit", "dense_body", "flat_cockpit", "seated_poses"]

SIZES = {"2k": 0.105, "50k": 0.553, "500k": 1.76}
"""How fine the curved surfaces are cut for about so many triangles."""
FLAT_SIZES = {"2k": 0.05, "50k": 0.48, "500k": 1.55}
"""How fine the flat ones are."""


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


PLATE = 0.003
"""[m] The thickness of a plate."""
BRACKET = np.array([[0, 0], [30, 0], [30, 3], [3, 3], [3, 30], [0, 30]]) / 1000
"""[m] The profile of a bracket."""
INNER_CORNER = np.array([0.0015, 0.0015])
"""[m] A point of the profile that sees all of its corners."""


@lru_cache(maxsize=4)
def flat_cockpit(size: str) -> Environment:
    """Return the cockpit of flat faces of about `size` triangles, a key of FLAT_SIZES."""
    fine = FLAT_SIZES[size]
    rng = np.random.default_rng(21)
    parts = []
    for name, (corner, along, up, _, cut) in PANELS.items():
        frame = np.array([corner, along, up], dtype=np.float64)
        parts.append(RawPart(name, *_plate(frame, _cuts(cut, fine), rng)))
    for name, (centre, half, _) in SOLIDS.items():
        parts.append(RawPart(name, *_box(np.array(centre), np.array(half), fine)))
    for name, many in (("left_wall", 30), ("right_wall", 30), ("floor", 20)):
        parts.append(RawPart(f"{name}_brackets", *_brackets(name, _share(many, fine), fine, rng)))
    for name, many in (("instrument_panel", 48), ("left_console", 24), ("right_console", 24)):
        parts.append(RawPart(f"{name}_knobs", *_flat_knobs(name, _share(many, fine), rng)))
    solid: list[bool | str] = [part.name in SOLIDS for part in parts]
    return build_environment(f"flat_{size}", parts, solid=solid)[0]


def _share(many: int, fine: float) -> int:
    """How many of so many brackets or knobs there are."""
    return max(3, round(many * min(fine, 1.0)))


def _plate(frame: Floats, cut: tuple[int, int], rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A closed plate of a grid of cells with rectangles cut out: vertices and triangles.

    frame (3, 3): its corner, its long side and its short one [m].
    """
    a, b = cut
    kept = np.ones((a, b), dtype=np.bool_)
    for u, v, wide, high in rng.uniform([0.1, 0.1, 0.04, 0.1], [0.8, 0.7, 0.1, 0.2], (8, 4)):
        kept[int(u * a) : int((u + wide) * a), int(v * b) : int((v + high) * b)] = False
    corner, along, up = frame
    u, v = np.meshgrid(np.linspace(0, 1, a + 1), np.linspace(0, 1, b + 1), indexing="ij")
    front = corner + u[..., None] * along + v[..., None] * up
    normal = np.cross(along, up) / np.linalg.norm(np.cross(along, up))
    points = np.concatenate([front.reshape(-1, 3), front.reshape(-1, 3) + PLATE * normal])
    return points, _skin(kept)


def _skin(kept: NDArray[np.bool_]) -> Ints:
    """Triangles (T, 3) around the cells (a, b) that are kept of a plate: both faces, and the rims
    along whatever is not kept."""
    a, b = kept.shape
    index = np.arange((a + 1) * (b + 1)).reshape(a + 1, b + 1)
    back = index.size
    ring = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    around = np.pad(kept, 1)
    beyond = [around[1:-1, :-2], around[2:, 1:-1], around[1:-1, 2:], around[:-2, 1:-1]]
    faces = [_quads([corner[kept] for corner in reversed(ring)])]
    faces.append(_quads([corner[kept] + back for corner in ring]))
    for side in range(4):
        rim = kept & ~beyond[side]
        one = ring[side][rim]
        two = ring[(side + 1) % 4][rim]
        faces.append(_quads([one, two, two + back, one + back]))
    return np.concatenate(faces)


def _quads(ring: list[Ints]) -> Ints:
    """Two triangles (2 Q, 3) for each quadrilateral; ring: its corners, (Q,) each."""
    a, b, c, d = ring
    return np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])


def _box(centre: Floats, half: Floats, fine: float) -> tuple[Floats, Ints]:
    """A closed box whose faces are cut into triangles: vertices and triangles."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half[:2]
    cuts = _cuts((24, 24), fine)
    corners = [
        (1 - t) * square[k] + t * square[(k + 1) % 4]
        for k in range(4)
        for t in np.arange(cuts[0]) / cuts[0]
    ]
    points, faces = _prism(np.array(corners), 2 * half[2], cuts[1])
    return points - [0, 0, half[2]] + centre, faces


def _prism(
    profile: Floats, height: float, cuts: int, *, middle: Floats | None = None
) -> tuple[Floats, Ints]:
    """A closed prism over a profile (m, 2), upward from z = 0: vertices and outward triangles.

    middle (2,): a point that sees all corners of the profile, their mean if None.
    """
    many = len(profile)
    z = np.repeat(np.linspace(0.0, height, cuts + 1), many)[:, None]
    sides = np.concatenate([np.tile(profile, (cuts + 1, 1)), z], axis=1)
    middle = profile.mean(axis=0) if middle is None else middle
    points = np.concatenate([sides, [[*middle, 0.0], [*middle, height]]])
    index = np.arange(len(sides)).reshape(cuts + 1, many)
    right = np.roll(index, -1, axis=1)
    walls = _quads([values.ravel() for values in (index[:-1], right[:-1], right[1:], index[1:])])
    low = np.full(many, len(sides))
    caps = [
        np.stack([low, right[0], index[0]], axis=-1),
        np.stack([low + 1, index[-1], right[-1]], axis=-1),
    ]
    return points, np.concatenate([walls, *caps])


def _brackets(name: str, many: int, fine: float, rng: np.random.Generator) -> tuple[Floats, Ints]:
    """Brackets of an angle profile that stand about on the inner side of a panel, along its short
    side."""
    corner, along, up = (np.array(values) for values in PANELS[name][:3])
    one, two, three = _frame(up, np.cross(along, up))
    found = []
    for u, v, length in rng.uniform([0.02, 0.02, 0.05], [0.95, 0.6, 0.3], (many, 3)):
        points, faces = _prism(BRACKET, length, _cuts((1, 30), fine)[1], middle=INNER_CORNER)
        foot = corner + u * along + v * up
        found.append((foot + points @ np.array([three, -two, one]), faces))
    return _joined(found)


def _flat_knobs(name: str, many: int, rng: np.random.Generator) -> tuple[Floats, Ints]:
    """Knobs of 24 sides on a panel."""
    corner, along, up = (np.array(values) for values in PANELS[name][:3])
    toward = -1.0 if name == "instrument_panel" else 1.0
    one, two, three = _frame(toward * np.cross(along, up), up)
    turn = 2 * np.pi * np.arange(24) / 24
    found = []
    for u, v, radius in rng.uniform([0.04, 0.08, 0.006], [0.96, 0.92, 0.02], (many, 3)):
        profile = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        points, faces = _prism(profile, 2 * radius, 1)
        found.append((corner + u * along + v * up + points @ np.array([two, three, one]), faces))
    return _joined(found)


def _frame(axis: Floats, other: Floats) -> tuple[Floats, Floats, Floats]:
    """Three unit vectors at right angles: along an axis, toward another vector, and across both."""
    one = axis / np.linalg.norm(axis)
    two = other - (other @ one) * one
    two /= np.linalg.norm(two)
    return one, two, np.cross(one, two)


def _joined(found: list[tuple[Floats, Ints]]) -> tuple[Floats, Ints]:
    """Several meshes as one."""
    first = np.cumsum([0, *(len(points) for points, _ in found)])
    faces = [faces + start for (_, faces), start in zip(found, first, strict=False)]
    return np.concatenate([points for points, _ in found]), np.concatenate(faces)


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
