"""Principal components of the family: linear in K numbers z, sphere centres, radii, joints and
origins of all levels.

z has mean 0 and variance 1 over the family and no correlation. The components are those of the
finest level and the joints, each sphere weighted by the skin it holds; everything else follows by
regression on the same z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from human.skeleton import BETWEEN, JOINTS, OTHER_JOINT, OTHER_SEGMENT, SEGMENTS
from human.transfer import Rig

__all__ = ["Basis", "Level", "basis_of", "full_level", "mirrored"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FLIP = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Level:
    """All spheres of a level, both sides, grouped by segment: half (S,) the row among the left and
    middle ones; right (S,) whether mirrored; segment, blend_joint, joint (S,) or -1; blend_share;
    names, directions; cell (S,): the share of each sphere's volume that is its own, not
    another's."""

    half: Ints
    right: NDArray[np.bool_]
    segment: Ints
    joint: Ints
    blend_joint: Ints
    blend_share: Floats
    name: tuple[str, ...]
    direction: tuple[str, ...]
    cell: Floats
    offset: Floats

    def whole(self, centre: Floats, radius: Floats) -> tuple[Floats, Floats]:
        """All centres (..., S, 3) and radii (..., S) from those of the left half."""
        both = centre[..., self.half, :] * np.where(self.right[:, None], FLIP, 1.0)
        return both, radius[..., self.half]


@dataclass(frozen=True, eq=False)
class Basis:
    """mean and components (K, .) of everything, by the key of the file; levels by name."""

    table: dict[str, tuple[Floats, Floats]]
    levels: dict[str, Level]
    share: Floats

    def at(self, key: str, z: Floats) -> Floats:
        """A quantity at coefficients z (K,)."""
        mean, parts = self.table[key]
        value: Floats = mean + np.tensordot(z, parts, axes=1)
        return value


def _twin(name: str) -> str:
    swap = {"left": "right", "right": "left"}
    return " ".join(swap.get(word, word) for word in name.split())


def full_level(rig: Rig) -> Level:
    """Both sides of a level, grouped by segment as in the body file."""
    spheres = rig.spheres
    given = rig.given
    count = len(spheres.radius)
    extra = count - spheres.given
    names = (*given.name, *[""] * extra)
    ways = (*given.direction, *[""] * extra)
    joint = np.concatenate([given.joint, np.full(extra, -1)])
    rows = []
    twins = {
        j: JOINTS.index("R" + JOINTS[j][1:]) if JOINTS[j][0] == "L" else j
        for j in range(len(JOINTS))
    }
    for k in range(count):
        rows.append(
            (
                int(spheres.segment[k]),
                k,
                False,
                int(joint[k]),
                int(rig.blend_joint[k]),
                names[k],
                ways[k],
            )
        )
        if spheres.sided[k]:
            blend = twins.get(int(rig.blend_joint[k]), -1)
            tied = twins.get(int(joint[k]), -1)
            way = _twin(ways[k])
            rows.append(
                (int(OTHER_SEGMENT[spheres.segment[k]]), k, True, tied, blend, _twin(names[k]), way)
            )
    rows.sort(key=lambda row: (row[0], row[1], row[2]))
    half = np.array([row[1] for row in rows])
    right = np.array([row[2] for row in rows])
    segment = np.array([row[0] for row in rows])
    cell, offset = cells(*_both(spheres.centre, spheres.radius, half, right))
    return Level(
        half,
        right,
        segment,
        np.array([row[3] for row in rows]),
        np.array([row[4] for row in rows]),
        rig.blend_share[half],
        tuple(row[5] for row in rows),
        tuple(row[6] for row in rows),
        cell,
        offset,
    )


def _both(
    centre: Floats, radius: Floats, half: Ints, right: NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    return centre[half] * np.where(right[:, None], FLIP, 1.0), radius[half]


def cells(centre: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """What each sphere holds alone when every point belongs to the sphere it is deepest in: the
    share of its volume (S,), and the middle of that part (S, 3) from its centre in radii."""
    from workbench.body.fitting.polish import union_field
    from workbench.geometry.nearest import morton_order

    count = 400
    k = np.arange(count)
    height = 1 - (2 * k + 1) / count
    turn = k * np.pi * (3 - 5**0.5)
    flat = np.sqrt(1 - height**2)
    unit = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    unit *= (((k * 0.7548776662) % 1.0 + 0.5 / count) ** (1 / 3))[:, None]
    point = (centre[:, None] + radius[:, None, None] * unit).reshape(-1, 3)
    owner = np.repeat(np.arange(len(radius)), count)
    order = morton_order(point)
    ball = np.empty(len(point), np.int64)
    ball[order] = union_field(point[order], centre, radius)[1]
    mine = (ball == owner).reshape(len(radius), count)
    share = mine.mean(axis=1)
    middle = np.einsum("sk,kc->sc", mine, unit) / np.maximum(mine.sum(axis=1), 1)[:, None]
    return share, middle


def volumes(
    level: Level, centre: Floats, radius: Floats, cell: Floats, offset: Floats
) -> tuple[Floats, Floats]:
    """Volume (N,) [m3] and centre of volume (N, 3) of each segment from the cells of its
    spheres."""
    part = cell * 4.18879020478639 * radius**3
    place = centre + radius[:, None] * offset
    total = np.bincount(level.segment, part, minlength=len(SEGMENTS))
    middle = np.column_stack(
        [np.bincount(level.segment, part * p, minlength=len(SEGMENTS)) for p in place.T]
    )
    return total, middle / np.maximum(total, 1e-12)[:, None]


def basis_of(
    rigs: dict[str, Rig], carried: dict[str, tuple[Floats, Floats]], joints: Floats, count: int
) -> Basis:
    """Principal components of carried spheres (M, S, 3), (M, S) of each level and joints (M, J,
    3)."""
    levels = {name: full_level(rig) for name, rig in rigs.items()}
    centre, radius = carried["fine"]
    rig = rigs["fine"]
    held = np.bincount(rig.sphere, rig.own * (rig.own > 0.5), minlength=centre.shape[1])
    # fine parts carry four times the samples for their area
    dense = np.isin(rig.spheres.segment, [SEGMENTS.index(n) for n in ("H", "LHN", "LF")])
    weight = np.sqrt(held * np.where(dense, 0.35, 1.0) + 4.0)
    people = len(joints)
    rows = np.concatenate(
        [
            (centre * weight[:, None]).reshape(people, -1),
            radius * weight,
            10.0 * joints.reshape(people, -1),
        ],
        axis=1,
    )
    rows = rows - rows.mean(axis=0)
    u, _, _ = np.linalg.svd(rows, full_matrices=False)
    z = u[:, :count] * np.sqrt(people)
    table: dict[str, tuple[Floats, Floats]] = {}

    def regressed(key: str, values: Floats) -> None:
        mean = values.mean(axis=0)
        table[key] = mean, np.tensordot(z.T, values - mean, axes=1) / people

    for name, level in levels.items():
        both = level.whole(*carried[name])
        regressed(f"{name}_centre", both[0])
        regressed(f"{name}_radius", both[1])
    fine = levels["fine"]
    both = fine.whole(*carried["fine"])
    origin = np.array([_origins(fine, c, r) for c, r in zip(*both, strict=True)])
    regressed("joint", joints)
    regressed("origin", origin)
    _tie(table, levels)
    return Basis(mirrored(table, levels), levels, z)


def mirrored(
    table: dict[str, tuple[Floats, Floats]], levels: dict[str, Level]
) -> dict[str, tuple[Floats, Floats]]:
    """The means and components with every right row the mirror image of its left twin, and those
    in the middle plane at y = 0, to the last bit.

    Cells are sampled and components are sums in another order on either side, so that the origins
    of twins would lie up to 4 mm from mirror images of each other.
    """
    result = {}
    for key, (mean, parts) in table.items():
        if key in ("joint", "origin"):
            other = OTHER_JOINT if key == "joint" else OTHER_SEGMENT
            right = np.array([name[0] == "R" for name in (JOINTS if key == "joint" else SEGMENTS)])
            twin = np.where(right, other, np.arange(len(other)))
            middle = other == np.arange(len(other))
        else:
            level = levels[key.rpartition("_")[0]]
            right = level.right
            left = np.flatnonzero(~right)
            twin = left[np.argsort(level.half[left])][level.half]
            middle = np.bincount(level.half)[level.half] == 1
        sign = np.ones((len(twin), 3))
        sign[right, 1] = -1.0
        sign[middle, 1] = 0.0
        if key.endswith("radius"):
            result[key] = mean[twin], parts[:, twin]
        else:
            result[key] = mean[twin] * sign, parts[:, twin] * sign
    return result


def _origins(level: Level, centre: Floats, radius: Floats) -> Floats:
    """(N, 3) centres of volume; the stage stands on the floor below the pelvis's joint."""
    place = volumes(level, centre, radius, level.cell, level.offset)[1]
    place[0] = 0.0
    for n, other in enumerate(OTHER_SEGMENT):
        if n == other:
            place[n, 1] = 0.0
    return place


def _tie(table: dict[str, tuple[Floats, Floats]], levels: dict[str, Level]) -> None:
    """The spheres at joints have the very rows of the joints."""
    for name, level in levels.items():
        tied = np.flatnonzero(level.joint >= 0)
        for part in (0, 1):
            table[f"{name}_centre"][part][..., tied, :] = table["joint"][part][
                ..., level.joint[tied], :
            ]
    assert set(BETWEEN) == set(JOINTS)
