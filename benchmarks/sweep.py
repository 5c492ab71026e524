"""Continuous contact of a whole motion: 2,752 frames of bubbleman in the cockpit, in CPU seconds.

    python -m benchmarks.sweep [SIZE]

SIZE: 2k, 50k (default) or 500k triangles. The motion goes through seeded seated poses, two a
second, at 120 frames a second. Each figure is the least of three runs after one to compile; the
last column is the ratio to asking for the clearance of every segment to every part at the frames
alone, which sees nothing in between.
"""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Callable

import numpy as np

import workbench as wb
from benchmarks.workload import cockpit, seated_poses
from workbench.model.body import Body
from workbench.model.poses import Poses

__all__ = ["long_motion"]

FRAMES = 2752


def long_motion(body: Body, frames: int = FRAMES, *, every: int = 60, spread: float = 1.0) -> Poses:
    """A motion of so many frames at 120 a second through seeded seated poses, one every `every`
    frames."""
    keys = seated_poses(body, frames // every + 2, spread=spread)
    at = np.arange(frames) / every
    first = at.astype(np.int64)

    def some(index: np.ndarray) -> Poses:
        return Poses(keys.rotations[index], keys.reference, keys.world_from_reference[index])

    # slow down at each pose, as limbs do
    soft = 0.5 - 0.5 * np.cos(np.pi * (at - first))
    moved = wb.between(some(first), some(first + 1), soft)
    return Poses(
        moved.rotations, moved.reference, moved.world_from_reference, np.arange(frames) / 120.0
    )


def _least(work: Callable[[], object], runs: int = 3) -> tuple[float, float]:
    """CPU and wall-clock seconds of the best of some runs, after one to compile and pack."""
    work()
    best = (np.inf, np.inf)
    for _ in range(runs):
        cpu = time.process_time()
        wall = time.perf_counter()
        work()
        best = min(best, (time.process_time() - cpu, time.perf_counter() - wall))
    return best


def main() -> None:
    """Print the table."""
    size = sys.argv[1] if len(sys.argv) > 1 else "50k"
    environment = cockpit(size)
    body = wb.load_body("bubbleman")
    motion = long_motion(body)
    count = len(motion) - 1
    start, end = (
        Poses(motion.rotations[some], motion.reference, motion.world_from_reference[some])
        for some in (slice(0, count), slice(1, count + 1))
    )
    found = wb.episodes(body, motion, environment)
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}")
    print(f"{body}, {environment}; {len(motion)} frames, {len(found)} episodes by segment and part")
    cases: dict[str, Callable[[], object]] = {
        "clearance at the frames alone": lambda: wb.clearance(wb.place(body, motion), environment),
        "first contact by segment and part": lambda: wb.sweep(
            body, (start, end), environment, by="part"
        ),
        "episodes by segment and part": lambda: wb.episodes(body, motion, environment),
        "episodes by sphere and part": lambda: wb.episodes(body, motion, environment, by="sphere"),
        "episodes of the body with itself": lambda: wb.self_episodes(body, motion),
    }
    base = 0.0
    for name, work in cases.items():
        cpu, wall = _least(work)
        base = base or cpu
        print(
            f"{name:36s} {cpu:8.2f} s CPU {wall:8.2f} s wall {1e6 * cpu / len(motion):9.0f} us/frame "
            f"{cpu / base:7.2f} x"
        )


if __name__ == "__main__":
    main()
