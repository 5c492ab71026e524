"""Small calls of the kernels of pictures, to compare compiled with plain Python.

`python -m tests.pictures_plain` prints what each gives as JSON; with NUMBA_DISABLE_JIT=1 the
kernels run as plain Python there, and an index out of bounds is an error.
"""

from __future__ import annotations

import json
import sys

import numpy as np

from tests.test_frames import cameras, lit, swarm
from workbench.draw.kernels.disk_painter import sphere_depths
from workbench.draw.lines.occlusion import (
    Occluders,
    hidden_arcs,
    hidden_lines,
    lines_among_balls,
    occluder_planes,
)
from workbench.draw.sphere_raster import (
    cast_rays,
    exact_item_buffer,
    painter_item_buffer,
    project_disks,
)
from workbench.sight.kernels.rasterization import Fragments, fill_triangles

__all__ = ["CALLS", "as_text"]


def frames():
    """Nine spheres painted from several cameras."""
    found = []
    for camera in cameras(1, 13, 11):
        disk = project_disks(swarm(2, 9), camera)
        found += [painter_item_buffer(disk, camera), exact_item_buffer(disk, camera)]
        depth = np.round(cast_rays(disk, camera).depth, 9)
        found += [depth, lit(swarm(2, 9), camera, (250, 200, 99))[0]]
    return found


def raster():
    """Depths of two disks and one triangle over them."""
    disks = np.array([[5.0, 5.0, 3.0], [7.5, 5.2, 2.0]])
    depth = np.full((10, 12), -np.inf)
    sphere_depths(disks, disks[:, 0], disks[:, 2] / 10, depth)
    triangle = np.array([[[-3.0, 1, 0], [11, 2, 1], [4, 20, 2]]])
    number = np.full((10, 12), -1)
    covered = number > 0
    fill_triangles(triangle, np.array([7]), 0.1, 1.5, Fragments(depth, number, covered))
    return [number, depth, covered]


def hiding():
    """Arcs and lines behind twenty triangles and among nine balls."""
    random = np.random.default_rng(5)
    planes = occluder_planes(random.uniform(-3, 3, (20, 3, 3)), 1e-3)
    hiders = Occluders(planes, 10.0, 1, 1, np.array([0, 20]), np.arange(20))
    circles = random.uniform(-1, 1, (15, 3, 3))
    arcs = hidden_arcs(circles, np.tile([0.3, 6.0], (15, 1)), hiders)
    lines = random.uniform(0, 3, (15, 2, 3))
    balls = random.uniform(0.2, 1, (9, 4))
    among = [lines_among_balls(lines, balls, away) for away in (7.0, np.inf)]
    found = [*arcs, *hidden_lines(lines, hiders), *among[0], *among[1]]
    return [np.round(array.astype(float), 9) for array in found]


def as_text(call):
    """What a call gives as JSON."""
    return json.dumps([array.tolist() for array in call()])


CALLS = {"frames": frames, "raster": raster, "hiding": hiding}

if __name__ == "__main__":
    sys.stdout.write(json.dumps({name: as_text(call) for name, call in CALLS.items()}))
