"""How well spheres show the skin: fit errors of a body's segments, gaps at bent joints, overlaps of
segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray
from scipy import ndimage

import workbench as wb
from human.skeleton import BETWEEN, JOINTS, SEGMENTS
from workbench.body.fitting.candidates import random_samples
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.proof import gap_bound
from workbench.body.scaling.seated import seated
from workbench.body.surface import Surface
from workbench.geometry.nearest import morton_order
from workbench.geometry.polygon import winding_number
from workbench.model.body import Body
from workbench.model.poses import Placed

__all__ = ["BENT", "BentGap", "Skinned", "allowances", "bent_gaps", "fit_errors", "inside_skin"]

Floats = NDArray[np.float64]
SEATED = {f"{side}{joint}": {"flexion": 90.0} for side in "LR" for joint in "HKE"}
LEANING = {
    "W": {"flexion": 5.0},
    "SP": {"flexion": 4.0},
    "NP": {"flexion": 4.0},
    "HP": {"flexion": 2.0},
}
"""Trunk, neck and head of the posture `driving`."""
SLOUCHED = LEANING | {"W": {"flexion": 12.0}, "SP": {"flexion": 20.0}}
"""The trunk of mean drivers (Park and others 2016) on a body: two joints bend as many do."""
TRUNK = {"LT", "CT", "UT", "N", "LSM", "RSM"}
BENT = {
    "LE": ("flexion", 100.0),
    "LK": ("flexion", 100.0),
    "LW": ("flexion", 50.0),
    "HP": ("flexion", 20.0),
    "NP": ("flexion", 40.0),
    "LH": ("flexion", 90.0),
    "LS": ("abduction", 60.0),
}
WIDEST_CUBE = 0.032
NARROWEST_CUBE = 0.001
OFF_SKIN = 3e-4
"""Sides [m] of the first and the last cubes in which points inside the skin are looked for; the
distance [m] off a face at which it is asked whether the face is buried."""
FLESH = {
    ("LT", "UT"),
    ("CT", "N"),
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


@dataclass(frozen=True, eq=False)
class Skinned:
    """A skin with the shares (P, N) of its points, and of its faces (T,) whether they lie inside
    the body because the skin passes through itself."""

    surface: Surface
    share: Floats
    buried: NDArray[np.bool_]

    @classmethod
    def of(cls, surface: Surface, share: Floats) -> Skinned:
        corner = surface.vertices[surface.faces]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-18)[:, None]
        return cls(surface, share, inside_skin(surface, corner.mean(axis=1) + OFF_SKIN * normal))


def fit_errors(skin: Skinned, spheres: tuple[Floats, Floats, NDArray[np.int64]]) -> Floats:
    """(N, 2) [m] proved bounds of how far the body lies outside its spheres, and they outside it.

    Outside: no point of the skin or inside it is farther from the spheres of the whole body; a
    point counts for the segment whose skin is nearest. Triangles are split until the bound of each
    holds (`gap_bound`), the inside is cut into ever smaller cubes (`_hollows`). Inside: a ball of
    radius r about a point at signed distance d of the skin leaves it by r + d at most.
    """
    centre, radius, segment = spheres
    surface = skin.surface
    label = skin.share[surface.faces].mean(axis=1).argmax(axis=1)
    corner = surface.vertices[surface.faces]
    result = np.zeros((len(SEGMENTS), 2))
    away = np.abs(surface.distance(centre))
    sticks_out = radius + np.where(inside_skin(surface, centre), -away, away)
    for n in range(1, len(SEGMENTS)):
        result[n, 0] = gap_bound(corner[label == n], centre, radius)
        result[n, 1] = max(float(sticks_out[segment == n].max()), 0.0)
    result[:, 0] = np.maximum(result[:, 0], _hollows(skin, label, (centre, radius), result[:, 0]))
    return result


def _hollows(
    skin: Skinned, label: NDArray[np.int64], spheres: tuple[Floats, Floats], known: Floats
) -> Floats:
    """(N,) [m] bounds of how far points inside the skin lie from the spheres.

    A cube about x of half diagonal h holds no point farther than f(x) + h. Cubes outside the skin
    and those within the least of the known bounds (N,) are left; the others are cut into eight
    until they are small.
    """
    surface = skin.surface
    buried = skin.buried
    least = float(known[1:].min())
    side = WIDEST_CUBE
    cube = _cubes_of(surface, side)
    corners = np.stack(np.meshgrid(*[[-0.25, 0.25]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    found = np.zeros(len(SEGMENTS))
    while True:
        half = 0.5 * side * np.sqrt(3.0)
        cube = cube[morton_order(cube)]
        field = union_field(cube, *spheres)[0]
        cube = cube[field + half > least]
        field = field[field + half > least]
        distance, face, _ = surface.nearest(cube)
        # a cube that the skin passes is kept; of the others those inside. Beside skin that lies
        # inside the body, where limb passes through trunk, the sign says nothing
        kept = (distance < half) | buried[face]
        if side <= NARROWEST_CUBE or not kept.any():
            np.maximum.at(found, label[face[kept]], field[kept] + half)
            return found
        cube = (cube[kept][:, None] + side * corners).reshape(-1, 3)
        side *= 0.5


def _cubes_of(surface: Surface, side: float) -> Floats:
    """(n, 3) the middles of cubes that the skin may pass, and of those inside it.

    Cubes that hang together and that the skin does not pass are all inside or all outside.
    """
    low = surface.vertices.min(axis=0) - side
    high = surface.vertices.max(axis=0) + side
    axes = [np.arange(a + 0.5 * side, b + side, side) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    flat = grid.reshape(-1, 3)
    near = np.abs(surface.distance(flat)) < 0.5 * side * np.sqrt(3.0)
    region, count = ndimage.label(~near.reshape(grid.shape[:3]))
    kept = near.copy()
    for number in range(1, count + 1):
        rows = np.flatnonzero(region.ravel() == number)
        if inside_skin(surface, flat[rows[:1]])[0]:
            kept[rows] = True
    return flat[kept]


def inside_skin(surface: Surface, points: Floats) -> NDArray[np.bool_]:
    """(n,) whether points (n, 3) are inside the skin, which may pass through itself where limb lies
    against trunk: where it winds round them once or more."""
    corner = np.ascontiguousarray(surface.vertices[surface.faces])
    return np.asarray(_winding(np.ascontiguousarray(points), corner) > 0.5)


@njit(cache=True, parallel=True)
def _winding(points, corner):  # type: ignore[no-untyped-def]
    """How often a closed mesh (T, 3, 3) winds round points (n, 3)."""
    found = np.zeros(len(points))
    for i in prange(len(points)):
        x, y, z = points[i]
        found[i] = winding_number(x, y, z, corner, 0, len(corner))
    return found


def allowances(body: Body) -> tuple[list[tuple[str, str, float]], list[str]]:
    """Overlaps of segments standing or sitting, upright and leaning, the flesh spread or not, of segments
    of the trunk slouched too, as allowances, rounded up to 2 mm; and those that no flesh explains."""
    bare = _without(body)
    segment = body.sphere_segment
    deepest: dict[tuple[str, str], float] = {}
    sitting = seated(bare)
    for shape, posture in (
        (bare, {}),
        (bare, SEATED),
        (sitting, SEATED),
        (sitting, SEATED | LEANING),
        (sitting, SEATED | SLOUCHED),
    ):
        found = wb.self_contacts(wb.place(shape, wb.pose(shape, posture)))
        rows = zip(found.sphere, found.other_sphere, found.distance, strict=True)
        for one, other, distance in rows:
            pair = sorted(
                (body.segments[segment[one]], body.segments[segment[other]]), key=SEGMENTS.index
            )
            key = (pair[0], pair[1])
            if posture == SEATED | SLOUCHED and not set(key) <= TRUNK:
                continue  # drivers' arms do not hang beside the trunk
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


@dataclass(frozen=True, eq=False)
class BentGap:
    """How far [m] the skin near a joint stands out from the spheres at most: bent, and straight."""

    bent: float
    straight: float


def bent_gaps(skin: Skinned, joints: Floats, body: Body) -> dict[str, BentGap]:
    """By joint how far the linearly skinned surface within 120 mm of it (at a stature of 1.75 m)
    stands out from the spheres, with that joint alone bent far.

    Parameters
    ----------
    skin
        In the zero pose.
    joints
        (J, 3) [m] of this body.
    body
        Its spheres.
    """
    straight = wb.place(body, wb.pose(body, {}))
    result = {}
    for name, (motion, angle) in BENT.items():
        placed = wb.place(body, wb.pose(body, {name: {motion: angle}}))
        at = placed.world_from_segment[0]
        rest = straight.world_from_segment[0]
        turn = np.einsum("nij,nkj->nik", at[:, :, :3], rest[:, :, :3])
        shift = at[:, :, 3] - np.einsum("nij,nj->ni", turn, rest[:, :, 3])
        weight = skin.share[:, [SEGMENTS.index(n) for n in body.segments]]
        vertices = skin.surface.vertices
        moved = np.einsum("pn,nij,pj->pi", weight, turn, vertices) + weight @ shift
        parent = body.segments.index(BETWEEN[name].split()[0])
        joint = joints[JOINTS.index(name)]
        bent_at = turn[parent] @ joint + shift[parent]
        bent_skin = Surface(moved, skin.surface.faces)
        result[name] = BentGap(
            _stands_out(bent_skin, skin.share, (name, bent_at), placed),
            _stands_out(skin.surface, skin.share, (name, joint), straight),
        )
    return result


def _stands_out(
    surface: Surface, share: Floats, joint: tuple[str, Floats], placed: Placed
) -> float:
    """How far [m] a skin stands out from the spheres of the segments about a joint at a point."""
    name, point = joint
    body = placed.body
    pair = [SEGMENTS.index(n) for n in BETWEEN[name].split()]
    near = sorted({m for n in pair for m in neighbours(n)})
    scale = np.ptp(surface.vertices[:, 2]) / 1.75
    samples = random_samples(surface, 60_000, seed=4)
    mine = share[surface.faces[samples.face]].mean(axis=1).argmax(axis=1)
    keep = (np.linalg.norm(samples.point - point, axis=1) < 0.12 * scale) & np.isin(mine, pair)
    order = np.array([SEGMENTS.index(n) for n in body.segments])
    own = np.isin(order[body.sphere_segment], near)
    gap = union_field(samples.point[keep], placed.centres[0][own], body.radius[0, own])[0]
    return float(gap.max())
