"""Run in a process of its own with NUMBA_ENABLE_CUDASIM=1: the device's answers beside the
processor's, as JSON."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench.contact.collide import by_segment
from workbench.contact.posed import posed_collides
from workbench.model.quaternions import exponential


def main(body_file: Path) -> None:
    """Write the greatest differences."""
    body = wb.load_body(body_file)
    cab = environment_of(
        box_part("floor", [-1, -1, -0.9], [1, 1, -0.8]),
        box_part("wall", [0.4, -1, -0.8], [0.45, 1, 0.5]),
        box_part("post", [-0.2, 0.15, -0.8], [-0.1, 0.25, 0.5]),
    )
    rng = np.random.default_rng(4)
    world = np.zeros((70, 3, 4))
    world[:, :, :3], world[:, :, 3] = np.eye(3), rng.normal(size=(70, 3)) * 0.2
    poses = wb.Poses(exponential(rng.normal(size=(70, 3, 3))), 0, world)
    placed = wb.place(body, poses)
    one = by_segment(placed, cab)
    two = by_segment(placed, cab, device="cuda")
    apart = wb.clearance(placed, cab) - wb.clearance(placed, cab, device="cuda")
    hit = wb.collides(placed, cab)
    told = {
        "clearance": float(np.abs(apart).max()),
        "by_segment": float(np.abs(one.distance - two.distance).max()),
        "witnesses": bool(
            np.array_equal(one.sphere, two.sphere) and np.array_equal(one.polygon, two.polygon)
        ),
        "collides": bool(np.array_equal(hit, wb.collides(placed, cab, device="cuda"))),
        "posed": bool(np.array_equal(hit, posed_collides(body, poses, cab, device="cuda"))),
        "hits": int(hit.sum()),
    }
    sys.stdout.write(json.dumps(told) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
