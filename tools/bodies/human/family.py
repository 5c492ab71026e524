"""The designed family: people of both sexes, 2 to 65 years, with wide and independent spreads of
shape and size.

Nothing is drawn from a population here; populations come later, as measures. Each member is a shape
of the mesh, scaled to a stature of its own (the mesh's statures are not those of people), in the
zero pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from human.skeleton import JOINTS, SEGMENTS, Skeleton, posed
from human.source import Person, Source

__all__ = ["Member", "member", "people", "shaped"]

Floats = NDArray[np.float64]
LOCAL = {
    "arms/measure-upperarm-length": 0.35,
    "arms/measure-lowerarm-length": 0.35,
    "arms/measure-upperarm-circ": 0.35,
    "arms/l-lowerarm-fat": 0.3,
    "legs/measure-upperleg-height": 0.3,
    "legs/measure-lowerleg-height": 0.3,
    "legs/measure-thigh-circ": 0.4,
    "legs/measure-knee-circ": 0.3,
    "legs/measure-calf-circ": 0.35,
    "feet/measure-ankle-circ": 0.25,
    "feet/l-foot-scale": 0.25,
    "feet/l-foot-scale-horiz": 0.3,
    "hands/l-hand-scale": 0.25,
    "hands/l-hand-fingers-length": 0.25,
    "hands/measure-wrist-circ": 0.25,
    "torso/measure-shoulder-dist": 0.5,
    "torso/measure-hips-circ": 0.4,
    "torso/measure-waist-circ": 0.5,
    "torso/measure-bust-circ": 0.3,
    "torso/measure-napetowaist-dist": 0.2,
    "torso/measure-waisttohip-dist": 0.2,
    "torso/torso-scale-depth": 0.4,
    "torso/torso-scale-horiz": 0.25,
    "torso/torso-vshape": 0.3,
    "hip/hip-scale-depth": 0.2,
    "hip/hip-scale-horiz": 0.2,
    "neck/measure-neck-circ": 0.4,
    "neck/measure-neck-height": 0.35,
    "head/head-scale-depth": 0.5,
    "head/head-scale-horiz": 0.4,
    "head/head-scale-vert": 0.35,
    "head/head-fat": 0.3,
    "buttocks/buttocks-volume": 0.4,
    "stomach/stomach-pregnant": 0.14,
    "nose/nose-scale-depth": 0.2,
    "eyes/l-eye-trans": 0.25,
}
BASE = (("hands/l-hand-fingers-distance", -1.0), ("eyes/l-eye-trans", 0.5))
"""Of everyone: fingers side by side, eyes as far apart as people have them."""
YEARS = (1.0, 12.0, 25.0, 90.0)
PLACES = (0.0, 1 / 3, 2 / 3, 1.0)
"""The ages [years] of the mesh's stages baby, child, young, old."""
GROWN = ((2, 0.87, 0.87), (3, 0.95, 0.95), (6, 1.15, 1.15), (9, 1.33, 1.33), (12, 1.50, 1.51), (15, 1.69, 1.61),
         (18, 1.76, 1.63), (65, 1.75, 1.62))  # fmt: skip
"""Age [years] and typical stature [m] of boys and girls, men and women (rounded; CDC growth charts
2000, ANSUR II)."""


@dataclass(frozen=True, eq=False)
class Member:
    """A member in the zero pose: vertices (V, 3) of the base mesh and joints (J, 3), feet on z = 0;
    its age [years]."""

    points: Floats
    joints: Floats
    person: Person
    years: float
    stature: float


def people(count: int, seed: int) -> list[tuple[Person, float, float]]:
    """The design: person, age [years] and stature [m]. Ages dense among children, half of the
    members grown up."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        male = (0.0, 1.0, 0.0, 1.0, float(rng.random()))[k % 5]
        years = float(rng.uniform(18, 65)) if k % 2 else float(rng.uniform(1.7, 18))
        local = tuple(
            (name, float(np.clip(sd * rng.standard_normal(), -1, 1))) for name, sd in LOCAL.items()
        )
        person = Person(
            male=male,
            age=float(np.interp(years, YEARS, PLACES)),
            muscle=float(rng.beta(2, 2)),
            weight=float(rng.beta(1.6, 1.6)),
            height=float(rng.beta(3, 3)),
            proportions=float(rng.beta(3, 3)),
            cup=float(rng.beta(2, 2)),
            firmness=float(rng.beta(2, 2)),
            local=local,
        )
        table = np.array(GROWN)
        typical = male * np.interp(years, table[:, 0], table[:, 1]) + (1 - male) * np.interp(
            years, table[:, 0], table[:, 2]
        )
        found.append(
            (
                person,
                years,
                float(typical * np.exp(np.clip(0.065 * rng.standard_normal(), -0.17, 0.17))),
            )
        )
    return found


def shaped(source: Source, person: Person) -> Floats:
    """(V, 3) [m] the shape of a person with what everyone has."""
    local = dict(BASE)
    for name, value in person.local:
        local[name] = float(np.clip(local.get(name, 0.0) + value, -1, 1))
    return source.shape(replace(person, local=tuple(local.items())))


def member(
    source: Source, skeleton: Skeleton, person: Person, stature: float, *, years: float = 25.0
) -> Member:
    """A person in the zero pose, scaled to a stature [m]."""
    shape = shaped(source, person)
    slant = _slant(skeleton, shape)
    points, joints = posed(skeleton, shape, arm=slant)
    scale = stature / np.ptp(points[:13380, 2])
    return Member(points * scale, joints * scale, person, years, stature)


def _slant(skeleton: Skeleton, shape: Floats) -> float:
    """[rad] How far the upper arms slant outward so that forearms and hands hang clear of waist,
    hips and thighs."""
    points, joints = posed(skeleton, shape, arm=np.radians(12))
    at = dict(zip(JOINTS, joints, strict=True))
    label = skeleton.share.argmax(axis=1)
    label[13380:] = -1
    trunk = points[np.isin(label, [SEGMENTS.index(n) for n in ("LT", "CT", "LUL")])]
    size = float(np.linalg.norm(at["LE"] - at["LS"]))
    arm = points[label == SEGMENTS.index("LLA")]
    thick = [
        float(np.percentile(at["LE"][1] - arm[np.abs(arm[:, 2] - z) < 0.08 * size][:, 1], 96))
        for z in (at["LE"][2] - 0.2 * size, 0.2 * at["LE"][2] + 0.8 * at["LW"][2])
    ]
    wide = [
        _widest(trunk, z, 0.25 * size) for z in (at["LE"][2] - 0.2 * size, at["LW"][2] - 0.1 * size)
    ]
    need = (
        np.array([w + t for w, t in zip(wide, thick, strict=True)]) + np.array([0.03, 0.07]) * size
    )
    # a smooth greatest value keeps the family smooth
    sine = (np.logaddexp(*(need / (0.05 * size))) * 0.05 * size - at["LS"][1]) / size
    return float(
        np.arcsin(
            0.07 + 0.45 * np.logaddexp(0, (np.clip(sine, -0.5, 0.7) - 0.07) / 0.08) * 0.08 / 0.45
        )
    )


def _widest(points: Floats, level: float, half: float) -> float:
    """Half breadth near a level."""
    near = points[np.abs(points[:, 2] - level) < half]
    return float(np.percentile(np.abs(near[:, 1]), 99))
