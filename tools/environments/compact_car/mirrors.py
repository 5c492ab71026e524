"""The mirrors of the compact car, set for eyes 635 mm above the seating reference point, and what is
outside in front: the bonnet. Lengths [mm].

Shapes, sizes and places are this project's choice. The glasses outside are spheres of 1,260 mm
radius, the one inside is flat. Each is turned so that whoever has his eyes there sees in its middle
the point it aims at, by the law of reflection: its normal halves the angle between the two. Behind
each glass there is room for it to turn, as other eyes set it.
"""

from __future__ import annotations

import numpy as np
from dimensions import H5, H30, W20
from manifold3d import Manifold
from numpy.typing import ArrayLike, NDArray
from solids import frame, hull, mirrored, place, shell, sweep, union

__all__ = ["outside_parts"]

Floats = NDArray[np.float64]
Parts = dict[str, Manifold]

OCULAR = np.array([0.0, W20, H30 + 635.0])
GROUND = H30 - H5
RADIUS = 1260.0
OUTSIDE = np.array([660.0, 885.0, 815.0])
INSIDE = np.array([405.0, 0.0, 1000.0])
AIMED_BESIDE = (-9000.0, 2200.0, GROUND)
AIMED_BEHIND = (-60000.0, 0.0, GROUND)


def outside_parts() -> Parts:
    """Mirrors and bonnet. The right mirror outside is set for the driver, so it is no mirror image
    of the left one."""
    left = set_frame(OUTSIDE, AIMED_BESIDE)
    flip = np.array([1.0, -1.0, 1.0])
    right = set_frame(OUTSIDE * flip, AIMED_BESIDE * flip)
    inside = set_frame(INSIDE, AIMED_BEHIND)
    foot = [(x, 764.0, z) for x in (716.0, 772.0) for z in (712.0, 736.0)]
    head = [(x, 850.0, z) for x in (706.0, 726.0) for z in (780.0, 800.0)]
    arm = hull([*foot, *head])
    stalk = sweep([(435.0, 0.0, 1008.0), (418.0, 0.0, 1042.0)], 9.0, sides=8)
    case = outline(112.0, 34.0, 8.0)
    return {
        "left_mirror_housing": place(housing(), left) + arm,
        "left_mirror_glass": place(glass(), left),
        "right_mirror_housing": place(housing(), right) + mirrored(arm),
        "right_mirror_glass": place(glass(), right),
        "inside_mirror": union([place(hull([(u, v, n) for u, v in case for n in (-27.0, -12.0)]), inside), stalk]),
        "inside_mirror_glass": place(hull([(u, v, n) for u, v in outline(108.0, 30.0, 8.0) for n in (-2.0, 0.0)]), inside),
        "bonnet": bonnet(),
    }  # fmt: skip


def set_frame(middle: Floats, aimed: ArrayLike) -> Floats:
    """The placement of a mirror by its axes as the driver sees it: to the right, up, out of the glass
    toward him."""
    to_eye, to_aim = (np.asarray(point, dtype=np.float64) - middle for point in (OCULAR, aimed))
    out = to_eye / np.linalg.norm(to_eye) + to_aim / np.linalg.norm(to_aim)
    out /= np.linalg.norm(out)
    right = np.cross([0.0, 0.0, 1.0], out)
    right /= np.linalg.norm(right)
    return frame(middle, right, np.cross(out, right))


def outline(half: float, high: float, cut: float) -> list[tuple[float, float]]:
    """The corners of a rectangle with its own corners cut off."""
    return [
        (s * (half - a), t * (high - b))
        for s in (-1.0, 1.0)
        for t in (-1.0, 1.0)
        for a, b in ((cut, 0.0), (0.0, cut))
    ]


def glass() -> Manifold:
    """The convex glass, 176 mm wide and 112 mm high: its middle is the origin."""
    across, up = np.meshgrid(np.linspace(-88.0, 88.0, 12), np.linspace(-56.0, 56.0, 8))
    within = np.abs(across) / 88.0 + np.abs(up) / 56.0 < 1.8
    u = across[within]
    v = up[within]
    front = np.column_stack([u, v, np.sqrt(RADIUS**2 - u**2 - v**2) - RADIUS])
    return hull(np.vstack([front, [(x, y, -7.0) for x, y in outline(88.0, 56.0, 18.0)]]))


def housing() -> Manifold:
    """The housing before the glass, rounded off forward."""
    rings = ((96.0, 64.0, -14.0), (96.0, 64.0, -30.0), (78.0, 50.0, -64.0), (40.0, 26.0, -86.0))
    return hull([(u, v, n) for a, b, n in rings for u, v in outline(a, b, 0.25 * b)])


def bonnet() -> Manifold:
    """The bonnet's outer skin: it falls away forward and to the sides."""
    stations = [(1165.0, 742.0, 690.0), (1400.0, 728.0, 710.0), (1650.0, 700.0, 715.0),
                (1850.0, 666.0, 700.0), (1950.0, 610.0, 670.0)]  # fmt: skip
    shares = np.linspace(-1.0, 1.0, 9)
    top = np.array([[(x, s * w, z - 34.0 * s**4) for s in shares] for x, z, w in stations])
    return shell(top - np.array([0.0, 0.0, 12.0]), top)
