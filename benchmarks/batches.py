"""What large batches of poses cost, each in a process of its own whose memory is looked at.

python -m benchmarks.batches pieces|call POSES
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import workbench as wb
from benchmarks.cases import Case, seated_in
from benchmarks.table import Row
from benchmarks.timing import microseconds, one_core, process_cost
from workbench.model.poses import Poses

__all__ = ["POSES", "batch_rows", "hits_of", "main"]

POSES = 1_000_000
PLACED = 100_000
"""Poses that are placed at once at most."""


def hits_of(case: Case, count: int) -> int:
    """Ask for the room of all segments in `count` poses, those of the case over and over; in how
    many something is deeper than permitted."""
    found = wb.room_of_poses(case.placed.body, _repeated(case.poses, count), case.environment)
    return int((found < -1e-9).any(axis=1).sum())


def _repeated(poses: Poses, count: int) -> Poses:
    rows = np.arange(count) % len(poses)
    rotations = poses.rotations[rows]
    world = poses.world_from_reference[rows]
    for values in (rotations, world):  # nobody else holds them: they need not be copied
        values.flags.writeable = False
    return Poses(rotations, poses.reference, world)


def batch_rows(count: int) -> Iterator[Row]:
    """Yield time and memory of so many poses in the trainer by segment in one call."""
    yield from _placed_rows(min(count, PLACED))
    name = f"{count} poses in the trainer"
    found = _measured(count)
    yield Row("time, in one call", name, found["each"], "us a pose")
    yield Row("memory, in one call", name, found["memory"], "GB", "poses and answers included")
    where = f"{POSES} poses, 50k, 1500 spheres"
    for figure in ("any", "by segment"):
        why = "not possible: nothing here runs on one"
        yield Row(f"{figure}, on a graphics card", where, None, "us a pose", why)


def _placed_rows(count: int) -> Iterator[Row]:
    """What placing a body takes in a small batch and in one of `count` poses."""
    case = seated_in("trainer", "399")
    many = _repeated(case.poses, count)
    for poses in (case.poses, many):
        took = microseconds(lambda poses=poses: wb.place(case.placed.body, poses), len(poses))  # type: ignore[misc]
        yield Row("placed", f"{len(poses)} poses, 399 spheres", took, "us a pose")


def _measured(count: int) -> dict[str, float]:
    """Time [us] a pose and the most memory [GB] of a process that asks about so many."""
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["-m", "benchmarks.batches", str(count)]
        cost = process_cost(arguments, {}, Path(folder) / "said.txt")
    if cost.code:
        raise ValueError(f"{count} poses: ended with {cost.code}:\n{cost.out}")
    return {"each": json.loads(cost.out.splitlines()[-1])["each"], "memory": cost.memory}


def main(count: int) -> None:
    """Print the time a pose as JSON, on one core and warm."""
    case = seated_in("trainer", "957")
    with one_core():
        hits_of(case, 256)
        begin = time.process_time()
        hits = hits_of(case, count)
        spent = time.process_time() - begin
    print(json.dumps({"each": 1e6 * spent / count, "hits": hits}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
