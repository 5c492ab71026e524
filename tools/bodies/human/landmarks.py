"""Named places on the skin: found once on a typical adult by what they are, then followed through
every shape.

Each row: name, segment, direction, how to find it, greatest radius of its sphere [m on a man of
1.75 m]. The sphere touches the skin there from inside.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from human.skeleton import JOINTS, SEGMENTS, Skeleton
from workbench.body.surface import Surface

__all__ = ["Landmark", "landmarks"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Landmark:
    """A named sphere: centre (3,) and radius [m] on the typical adult; left or in the middle.
    normal: outward where it touches the skin, zero where it only has to lie inside."""

    name: str
    segment: str
    direction: str
    centre: tuple[float, float, float]
    radius: float
    normal: tuple[float, float, float] = (0.0, 0.0, 0.0)


# Where to look: segment, box about a joint or marker in units of the upper arm's length (low and
# high corner), and the direction in which the wanted place lies farthest.
_RULES: tuple[
    tuple[str, str, str, str, tuple[float, ...], tuple[float, ...], tuple[float, ...], float], ...
] = (
    ("nose", "H", "front", "eye", (-1, -0.01, -0.25), (1, 0.01, -0.1), (1, 0, 0), 0.010),
    ("chin", "H", "front", "jaw", (-1, -0.02, -0.2), (1, 0.02, 0.02), (1, 0, -0.5), 0.021),
    ("mouth", "H", "front", "eye", (-1, -0.02, -0.33), (1, 0.02, -0.19), (1, 0, 0), 0.020),
    ("forehead", "H", "front", "eye", (-1, -0.01, 0.215), (1, 0.01, 0.3), (1, 0, 0), 0.030),
    ("occiput", "H", "back", "eye", (-2, -0.01, -0.2), (1, 0.01, 0.3), (-1, 0, 0), 0.068),
    ("crown", "H", "top", "eye", (-2, -0.01, 0), (1, 0.01, 1), (0, 0, 1), 0.072),
    ("larynx", "N", "front", "NP", (0, -0.02, -0.02), (1, 0.02, 0.16), (1, 0, 0.1), 0.022),
    ("nape", "N", "back", "NP", (-1, -0.02, 0.05), (0, 0.02, 0.25), (-1, 0, 0), 0.045),
    ("chest", "UT", "front", "SP", (0, -0.02, 0.12), (1, 0.02, 0.3), (1, 0, 0), 0.062),
    ("left breast", "UT", "front", "SP", (0, 0.15, 0.1), (1, 0.5, 0.5), (1, 0, 0), 0.050),
    ("left shoulder blade", "UT", "back", "SP", (-1, 0.2, 0.2), (0, 0.4, 0.7), (-1, 0, 0), 0.070),
    ("belly", "CT", "front", "W", (0, -0.02, -0.05), (2, 0.02, 0.35), (1, 0, 0), 0.090),
    ("navel", "CT", "front", "W", (0, -0.02, 0), (2, 0.02, 0.07), (0, 0, -1), 0.018),
    ("pubis", "LT", "front", "PV", (0, -0.02, -0.12), (1, 0.02, 0.12), (1, 0, -0.4), 0.045),
    ("left buttock", "LT", "back", "PV", (-1, 0.05, -0.25), (0, 0.45, 0.3), (-1, 0, 0), 0.078),
    ("left hip point", "LT", "left", "PV", (-1, 0, 0.02), (1, 1, 0.5), (0, 1, 0), 0.062),
    ("elbow point", "LLA", "back", "LE", (-1, -0.2, -0.12), (0, 0.2, 0.04), (-1, 0, -0.2), 0.019),
    ("knee cap", "LLL", "front", "LK", (0, -0.2, -0.1), (1, 0.2, 0.1), (1, 0, 0), 0.029),
    ("calf", "LLL", "back", "LK", (-1, -0.3, -0.6), (0, 0.3, -0.2), (-1, 0, 0), 0.045),
    ("outer ankle", "LLL", "left", "LA", (-0.12, 0, -0.04), (0.08, 1, 0.06), (0, 1, -0.4), 0.015),
    ("inner ankle", "LLL", "right", "LA", (-0.2, -1, -0.02), (0.2, 0, 0.09), (0, -1, 0), 0.015),
    ("heel", "LF", "back", "LA", (-1, -0.3, -0.3), (0, 0.3, -0.05), (-1, 0, 0), 0.027),
    ("toe tip", "LF", "front", "LA", (0, -0.4, -0.5), (2, 0.3, 0), (1, 0, 0), 0.011),
    (
        "ball of foot",
        "LF",
        "bottom",
        "toe-1-1",
        (-0.1, -0.1, -0.3),
        (0.1, 0.1, 0.3),
        (0, 0, -1),
        0.018,
    ),
)


def landmarks(
    skeleton: Skeleton,
    points: Floats,
    joint: Floats,
    skin: tuple[Floats, Floats, Floats],
    surface: Surface,
) -> list[Landmark]:
    """The left and middle ones. points (V, 3): base mesh; joint (J, 3); skin: places, unit normals
    and shares (P, .) of the surface."""
    at = {name: points[rows].mean(axis=0) for name, rows in skeleton.markers.items()}
    at |= dict(zip(JOINTS, joint, strict=True))
    at |= {name[2:]: at[name] for name in list(at) if name.startswith("l-")}
    arm = float(np.linalg.norm(at["LE"] - at["LS"]))
    size = arm / 0.27
    place, normal, share = skin
    found = []
    for name, segment, direction, origin, low, high, way, radius in _RULES:
        middle = low[1] == -high[1] and high[1] <= 0.03
        relative = (place - at[origin] * ([1, 0, 1] if middle else [1, 1, 1])) / arm
        fits = np.all((relative >= low) & (relative <= high), axis=1) & (
            share[:, SEGMENTS.index(segment)] > 0.2
        )
        if not fits.any():
            raise ValueError(f"landmark {name} not found")
        spot = int(np.flatnonzero(fits)[np.argmax(place[fits] @ np.array(way))])
        close = np.linalg.norm(place - place[spot], axis=1) < 0.6 * radius * size
        n = normal[close].sum(axis=0) * ([1, 0, 1] if middle else [1, 1, 1])
        foot = place[spot] * ([1, 0, 1] if middle else [1, 1, 1])
        found.append(
            _inside(name, segment, direction, (foot, n / np.linalg.norm(n)), radius * size)
        )
    return [_fitting(mark, surface) for mark in found + _markers(at, (place, normal), size)]


def _fitting(mark: Landmark, surface: Surface) -> Landmark:
    """The sphere made smaller until it hardly leaves the skin, which has flat faces.

    It goes on reaching as far outward as before, and may slip sideways to where it has more room.
    """
    normal = np.array(mark.normal)
    if not normal.any():
        depth = -float(surface.distance(np.array([mark.centre]))[0])
        return replace(mark, radius=min(mark.radius, depth + 6e-4))
    foot = np.array(mark.centre) + mark.radius * normal
    first = np.cross(normal, [0, 1, 0] if abs(normal[1]) < 0.7 else [1, 0, 0])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first) * (mark.centre[1] != 0)
    grid = np.array(
        [a * first + b * second for a in np.linspace(-1, 1, 9) for b in np.linspace(-1, 1, 9)]
    )
    grid = grid[np.argsort(np.linalg.norm(grid, axis=1), kind="stable")]
    radius = mark.radius
    while True:
        centre = foot - radius * normal + 0.45 * radius * grid
        room = -surface.distance(centre) + 5e-4 + 0.05 * radius - radius
        if room.max() >= 0 or radius < 2e-3:
            break
        radius *= 0.97
    x, y, z = (
        float(v)
        for v in centre[int(np.argmax(room > 0)) if (room > 0).any() else int(room.argmax())]
    )
    return replace(mark, centre=(x, y, z), radius=radius)


def _inside(
    name: str, segment: str, direction: str, spot: tuple[Floats, Floats], radius: float
) -> Landmark:
    x, y, z = (float(v) for v in spot[0] - radius * spot[1])
    u, v, w = (float(c) for c in spot[1])
    return Landmark(name, segment, direction, (x, y, z), radius, (u, v, w))


def _markers(at: dict[str, Floats], skin: tuple[Floats, Floats], size: float) -> list[Landmark]:
    """Landmarks at the mesh's own markers: eyes, knuckles, finger tips; and those that lie off a
    joint."""
    place, normal = skin

    def near(spot: Floats) -> tuple[Floats, Floats]:
        k = int(np.argmin(np.linalg.norm(place - spot, axis=1)))
        return place[k], normal[k]

    def ball(name: str, segment: str, direction: str, spot: Floats, radius: float) -> Landmark:
        x, y, z = (float(v) for v in spot)
        return Landmark(name, segment, direction, (x, y, z), radius * size)

    ear = place[
        (place[:, 1] > place[place[:, 2] > at["HP"][2]][:, 1].max() - 0.008 * size)
        & (place[:, 2] > at["HP"][2])
    ]
    found = [
        ball("left eye", "H", "front", at["eye"] + [0.001, 0, 0], 0.0125),
        ball("left ear", "H", "left", ear.mean(axis=0) - [0.0, 0.012 * size, 0.012 * size], 0.011),
        _inside(
            "shoulder point",
            "LSM",
            "left",
            near(at["LS"] + size * np.array([0, 0.031, 0.06])),
            0.022 * size,
        ),
        _inside("index knuckle", "LHN", "back", near(at["finger-2-1"]), 0.012 * size),
        _inside("little knuckle", "LHN", "back", near(at["finger-5-1"]), 0.0105 * size),
    ]
    palm = 0.4 * at["LW"] + 0.35 * at["finger-3-1"] + 0.25 * at["finger-4-1"]
    found.append(
        _inside("palm", "LHN", "front", near(palm - size * np.array([0, 0.02, 0])), 0.014 * size)
    )
    for k, name in (
        (1, "thumb tip"),
        (2, "index fingertip"),
        (3, "middle fingertip"),
        (4, "ring fingertip"),
        (5, "little fingertip"),
    ):
        way = at[f"finger-{k}-4"] - at[f"finger-{k}-3"]
        way = way / np.linalg.norm(way)
        close = place[np.linalg.norm(place - at[f"finger-{k}-4"], axis=1) < 0.016 * size]
        ahead = close @ way
        radius = (0.0092, 0.0075, 0.0078, 0.0074, 0.0066)[k - 1] * size
        behind = close[
            (ahead < ahead.max() - 0.5 * radius) & (ahead > ahead.max() - 1.6 * radius)
        ].mean(axis=0)
        tip = behind + way * (ahead.max() - behind @ way)
        found.append(_inside(name, "LHN", "right" if k == 1 else "top", (tip, way), radius))
    return found
