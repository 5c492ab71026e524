"""How much farther out on a ray limbs of people still reach, obstacles aside."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.posture.kernels.outward import reach_outward
from workbench.posture.reaching.chains import NO_PLANES, PIECE, Found, Task
from workbench.threads import in_pieces

__all__ = ["outward"]

STEPS = 60


def outward(
    task: Task, found: Found, ways: Floats, alike: Ints, *, most: float, threads: int | None = None
) -> Floats:
    """(P,) [m] how far beyond the targets, which all are reached, limbs get along ways (P, 3), at
    `most` [m].

    alike (P,): rows of the same number are for the same target, sorted by how far people must
    stretch, so that each starts from where the one before has come to.
    """
    count = len(task)
    place = np.arange(count)
    follow = np.where((place % PIECE == 0) | (np.append(-1, alike[:-1]) != alike), -1, place - 1)
    size = np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
    rays = np.concatenate([task.goal[:, :3], ways / size], axis=1)
    far = np.zeros(count)
    out = (
        np.array(found.angles),
        np.zeros((count, 6 + len(task.link.rows))),
        far,
        np.zeros(count, dtype=np.int64),
    )

    def work(begin: int, end: int) -> None:
        reach_outward(
            task.link, task.who, task.base, rays, NO_PLANES, most, STEPS, out, follow, begin, end
        )

    in_pieces(work, count, PIECE, threads=threads)
    return np.clip(far, 0.0, most)
