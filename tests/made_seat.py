"""A seat made of boxes with known figures, as an OBJ file in any unit and axes."""

from __future__ import annotations

import math

import numpy as np

from workbench.files.meshes.reading import axes_rotation

SRP = (0.1, 0.2, 0.3)
"""[m] of the made seat."""
METRES = {"m": 1.0, "mm": 0.001, "cm": 0.01, "in": 0.0254, "ft": 0.3048}
BOX = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6),
       (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]  # fmt: skip


def corners(low, high):
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], dtype=float)  # fmt: skip


def sloped(points, angle):
    """Points turned with x going up by an angle [degrees]."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def seat_parts(cushion=10.0, back=20.0, yaw=0.0):
    """Corners [m] of a pan, a rest, a floor and a lever by their names, in the world."""
    pan = sloped(corners((0.0, -0.25, -0.1), (0.45, 0.25, 0.0)), cushion)
    rest = sloped(corners((-0.08, -0.22, 0.05), (0.0, 0.22, 0.6)), back)
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return {
        "pan": pan @ turn + SRP,
        "rest": rest @ turn + SRP,
        "floor": corners((-0.6, -0.6, -0.05), (1.2, 0.9, 0.0)),
        "lever": corners((0.6, 0.0, 0.4), (0.64, 0.04, 0.6)),
    }


def obj_text(parts, unit="m", up="z", forward="x", names=True):
    """An OBJ file of boxes."""
    rotation = axes_rotation(up, forward)
    lines, first = [], 1
    for name, points in parts.items():
        lines += [f"o {name}"] if names else []
        lines += [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in points @ rotation / METRES[unit]]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in BOX]
        first += len(points)
    return "\n".join(lines) + "\n"
