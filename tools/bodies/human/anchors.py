"""Coefficients of known people: the median man and woman of ANSUR II, children of three and six
after crash dummies.

Measures are taken on the sphere body as workbench takes them; they are linear in the coefficients
while their extreme spheres stay, so Gauss-Newton on them, drawn toward a typical person of that sex
and age, ends in a few rounds.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from human.basis import Basis, cells, volumes
from human.skeleton import JOINTS, SEGMENTS
from human.write import BODY_JOINTS, BODY_SEGMENTS
from workbench.body.scaling.manikin import DOWN, UP, Length, Manikin
from workbench.body.scaling.measure import lengths
from workbench.body.scaling.rig import Shape
from workbench.model.body import Body

__all__ = ["DENSITY", "Family", "fitted_z", "heights"]

Floats = NDArray[np.float64]
DENSITY = {
    "STG": 1000,
    "LT": 1010,
    "CT": 1010,
    "UT": 960,
    "N": 1090,
    "H": 1090,
    "SM": 1040,
    "UA": 1063,
    "LA": 1110,
    "HN": 1135,
    "UL": 1047,
    "LL": 1087,
    "F": 1092,
}
"""[kg/m3], means of the sets of Dempster and of Clauser (facts of the yeadon package, 2.0.1)."""


def density(name: str) -> float:
    """The density of a segment by its mnemonic."""
    return float(DENSITY.get(name, DENSITY.get(name[1:], 1000)))


def heights(manikin: Manikin, joints: list[str]) -> dict[str, Length]:
    """The heights of joints over the soles, standing."""
    sole = manikin.farthest("standing", DOWN, ("LF", "RF"))
    return {name: manikin.joint("standing", UP, name) + sole for name in joints}


class Family:
    """A level of the basis as a body whose shape follows coefficients z (K,)."""

    def __init__(self, basis: Basis, body: Body, level: str) -> None:
        """body: any body of this level, loaded from a file that `write.body_text` made."""
        self.basis = basis
        self.body = body
        self.level = basis.levels[level]
        order = [SEGMENTS.index(name) for name in BODY_SEGMENTS]
        place = np.array([order.index(n) for n in self.level.segment])
        self.rows = np.argsort(place, kind="stable")
        self.order, self.joints = order, [JOINTS.index(name) for name in BODY_JOINTS]
        tables = [
            basis.table[key] for key in (f"{level}_centre", f"{level}_radius", "joint", "origin")
        ]
        stacked = [np.concatenate([mean[None], parts]) for mean, parts in tables]
        self.radius = stacked[1]
        self.centre = stacked[0]
        self.parts = [self.shape(*(table[k] for table in stacked)) for k in range(len(stacked[0]))]
        self.base = Manikin(body)
        self.unit = [self.base.changed(shape) for shape in self.parts]

    def shape(self, centre: Floats, radius: Floats, joint: Floats, origin: Floats) -> Shape:
        """Spheres and joints of the world in the frames of their segments, in body order."""
        origin = origin[self.order]
        joint = joint[self.joints]
        parent = self.body.parent[1:]
        segment = self.body.sphere_segment
        return Shape(
            centre[self.rows] - origin[segment],
            radius[self.rows],
            joint - origin[parent],
            joint - origin[1:],
        )

    def manikin(self, z: Floats) -> Manikin:
        """The body at z in the postures of anthropometry."""
        weight = np.concatenate([[1.0], z])
        shape = Shape(
            *(
                np.tensordot(weight, np.stack([getattr(p, f) for p in self.parts]), axes=1)
                for f in ("centre", "radius", "in_parent", "in_child")
            )
        )
        return self.base.changed(shape)

    def rows_of(self, manikin: Manikin, names: list[str]) -> tuple[Floats, Floats]:
        """Measures [m] and their derivatives by z (m, K)."""
        found = lengths(manikin, names)
        value = np.array([manikin.value(length) for length in found.values()])
        # a length whose extreme spheres are held is linear in the shape
        slope = np.array(
            [
                [unit.value(length) - length.fixed for unit in self.unit[1:]]
                for length in found.values()
            ]
        )
        return value, slope

    def volume_rows(self, z: Floats) -> tuple[Floats, Floats]:
        """Volumes (N,) [m3] of the segments and their derivatives by z (N, K); cells anew at z."""
        weight = np.concatenate([[1.0], z])
        centre = np.tensordot(weight, self.centre, axes=1)
        radius = weight @ self.radius
        cell, offset = cells(centre, radius)
        total, _ = volumes(self.level, centre, radius, cell, offset)
        part = 3 * cell * 4.18879020478639 * radius**2
        slope = np.stack(
            [
                np.bincount(self.level.segment, part * self.radius[k], minlength=len(SEGMENTS))
                for k in range(1, len(self.radius))
            ],
            axis=1,
        )
        return total, slope

    def hips_apart(self, z: Floats) -> tuple[float, Floats]:
        """How far the hip joints are apart [m], and the derivative (K,)."""
        mean, parts = self.basis.table["joint"]
        left = JOINTS.index("LH")
        right = JOINTS.index("RH")
        slope = parts[:, left, 1] - parts[:, right, 1]
        return float(mean[left, 1] - mean[right, 1] + z @ slope), slope

    def pressed(self, z: Floats) -> tuple[Floats, Floats]:
        """How deep forearm and hand lie in trunk and thigh in the zero pose (m,) [m], with
        derivatives (m, K): the deepest sphere of the trunk and thigh for each sphere of the arm
        that comes nearer than a millimetre."""
        weight = np.concatenate([[1.0], z])
        centre = np.tensordot(weight, self.centre, axes=1)
        radius = weight @ self.radius
        names = np.array(SEGMENTS)[self.level.segment]
        arm = np.flatnonzero(np.isin(names, ["LLA", "LHN"]))
        side = np.flatnonzero(np.isin(names, ["LUL", "LT", "CT"]))
        away = centre[arm][:, None] - centre[side][None]
        far = np.linalg.norm(away, axis=2)
        deep = radius[arm][:, None] + radius[side][None] - far
        k = deep.argmax(axis=1)
        row = np.flatnonzero(deep.max(axis=1) > -1e-3)
        i = arm[row]
        j = side[k[row]]
        unit = away[row, k[row]] / far[row, k[row]][:, None]
        slope = self.radius[1:, i] + self.radius[1:, j]
        slope = slope - np.einsum("kmc,mc->km", self.centre[1:, i] - self.centre[1:, j], unit)
        return deep[row, k[row]], slope.T


def fitted_z(
    family: Family,
    start: Floats,
    measures: dict[str, tuple[float, float]],
    masses: dict[str, float],
    whole: float,
    hips: float,
    *,
    loose: float,
) -> Floats:
    """Coefficients near `start` (K,) whose body has the measures (value, tolerance) [m], segment
    masses [kg] and a whole mass [kg].

    hips: how far the hip joints are apart [m]. Forearm and hand are kept out of trunk and thigh. loose: the weight of staying at the start;
    masses are wanted within about 15 %, the whole within 2 %.
    """
    names = list(measures)
    wanted = np.array([measures[name][0] for name in names])
    weight = 1 / np.array([measures[name][1] for name in names])
    z = start.copy()
    for turn in range(14):
        value, slope = family.rows_of(family.manikin(z), names)
        rows = [loose * np.eye(len(z)), weight[:, None] * slope]
        gap = [loose * (start - z), weight * (wanted - value)]
        apart, wider = family.hips_apart(z)
        rows.append(wider[None] / 0.003)
        gap.append(np.array([hips - apart]) / 0.003)
        deep, push = family.pressed(z)
        rows.append(push / 0.008)
        gap.append((-0.001 - deep) / 0.008)
        volume, grow = family.volume_rows(z)
        heavy = np.array([density(name) if name != "STG" else 0.0 for name in SEGMENTS])
        rows.append((heavy @ grow)[None] / (0.02 * whole))
        gap.append(np.array([whole - heavy @ volume]) / (0.02 * whole))
        for name, mass in masses.items():
            n = SEGMENTS.index(name)
            rows.append(heavy[n] * grow[n][None] / (0.15 * mass))
            gap.append(np.array([mass - heavy[n] * volume[n]]) / (0.15 * mass))
        step = np.linalg.lstsq(np.concatenate(rows), np.concatenate(gap), rcond=None)[0]
        z = z + (1.0 if turn < 8 else 0.5) * step
    return z


def replaced(body: Body, manikin: Manikin) -> Body:
    """The body in another shape, for trying it out."""
    return replace(
        body,
        centre=manikin.shape.centre[None],
        radius=manikin.shape.radius[None],
        joint_in_parent=manikin.shape.in_parent[None],
        joint_in_child=manikin.shape.in_child[None],
    )
