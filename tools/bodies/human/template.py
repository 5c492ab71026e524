"""The typical adult that everything is found on: skin, shares, landmarks, and spheres at three
levels of detail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from human.family import shaped
from human.fit import Given, fitted
from human.landmarks import Landmark, landmarks
from human.skeleton import JOINTS, SEGMENTS, Skeleton, posed
from human.skin import Skin
from human.source import Person, Source
from human.transfer import Rig, rigged
from workbench.body.fitting.candidates import corner_normals
from workbench.body.surface import Surface

__all__ = ["FACTORS", "Template", "made_template", "rigs_of"]

Floats = NDArray[np.float64]
TYPICAL = Person(male=0.5, muscle=0.55, weight=0.7)
STATURE = 1.7
ARM = np.radians(38)
LEG = np.radians(9)
"""Limbs apart while spheres are fitted, so that no skin lies against other skin."""
FACTORS = {"fine": 1.1, "medium": 2.6, "coarse": 5.0}
HOME = {
    "PV": "LT",
    "W": "LT",
    "SP": "CT",
    "NP": "UT",
    "HP": "N",
    "LC": "LSM",
    "LS": "LSM",
    "LE": "LUA",
    "LW": "LLA",
    "LH": "LT",
    "LK": "LUL",
    "LA": "LLL",
}
"""The segment whose sphere sits at each joint."""


@dataclass(frozen=True, eq=False)
class Template:
    """surface: the skin, its limbs apart; joints (J, 3) in that pose; share (P, N) of the segments
    in its points."""

    source: Source
    skeleton: Skeleton
    skin: Skin
    surface: Surface
    joints: Floats
    share: Floats
    marks: tuple[Landmark, ...]


def made_template(source: Source) -> Template:
    """The typical adult; takes a minute, most of it for the light in mouth and nose."""
    points = shaped(source, TYPICAL)
    points = points * (STATURE / np.ptp(points[:13380, 2]))
    points = points - [0, 0, points[:13380, 2].min()]
    skeleton = Skeleton.of(source, points)
    skin = Skin.of(source, np.flatnonzero(skeleton.share[:, SEGMENTS.index("H")] > 0.99))
    apart, joints = posed(skeleton, points, arm=ARM, leg=LEG)
    surface = Surface(skin.points(apart), skin.faces)
    share = skin.points(skeleton.share)
    share /= share.sum(axis=1, keepdims=True)
    marks = landmarks(
        skeleton, apart, joints, (surface.vertices, corner_normals(surface), share), surface
    )
    return Template(source, skeleton, skin, surface, joints, share, tuple(marks))


def _given(template: Template) -> Given:
    """The spheres at the joints, each as large as the skin lets it, and those of the landmarks;
    left and middle."""
    rows = []
    for j, name in enumerate(JOINTS):
        if name[0] == "R":
            continue
        place = template.joints[j] * ([1, 1, 1] if name[0] == "L" else [1, 0, 1])
        depth = -float(template.surface.distance(place[None])[0])
        rows.append((place, depth + 1e-3, HOME[name], j, "", ""))
    rows += [
        (np.array(m.centre), m.radius, m.segment, -1, m.name, m.direction) for m in template.marks
    ]
    place, radius, segment, joint, names, ways = zip(*rows, strict=True)
    at = np.array([SEGMENTS.index(name) for name in segment])
    return Given(np.array(place), np.array(radius), at, np.array(joint), names, ways)


def rigs_of(template: Template) -> dict[str, Rig]:
    """The spheres of each level with their patches of skin."""
    given = _given(template)
    eye = np.array(next(m.centre for m in template.marks if m.name == "left eye"))
    rigs = {}
    for level, factor in FACTORS.items():
        spheres = fitted(template.surface, template.share, given, factor=factor, eye=eye)
        rigs[level] = rigged(template.surface, template.share, spheres, given)
    return rigs
