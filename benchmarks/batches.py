"""What large batches of poses cost, each in a process of its own whose memory is looked at.

python -m benchmarks.batches pieces|call POSES
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import workbench as wb
from benchmarks.cases import Case, seated_in
from benchmarks.clearance import by_segment
from benchmarks.table import Row
from benchmarks.timing import microseconds, one_core, process_cost
from workbench.model.poses import Poses

__all__ = ["batch_rows", "in_one_call", "in_pieces_of_the_caller", "main"]

POSES = 1_000_000
PIECE = 4096
MOST = 2.0
"""[GB] that a batch may take."""


def in_pieces_of_the_caller(case: Case, count: int) -> int:
    """Place `count` poses and ask by segment, in pieces that the caller cuts; how many are deeper
    somewhere than permitted."""
    hits = 0
    for first in range(0, count, PIECE):
        poses = _repeated(case.poses, min(PIECE, count - first), first=first)
        hits += _hits(case, poses)
    return hits


def in_one_call(case: Case, count: int) -> int:
    """The same with all poses in one call."""
    return _hits(case, _repeated(case.poses, count))


def _repeated(poses: Poses, count: int, *, first: int = 0) -> Poses:
    """So many poses from the `first` on: the given ones over and over."""
    return poses.rows(np.arange(first, first + count) % len(poses))


def _hits(case: Case, poses: Poses) -> int:
    body = case.placed.body
    some = Case(case.name, poses, wb.place(body, poses), case.environment)
    return int((by_segment(some) + case.allowed < -1e-9).any(axis=(1, 2)).sum())


WAYS: dict[str, Callable[[Case, int], int]] = {
    "pieces": in_pieces_of_the_caller,
    "call": in_one_call,
}


def batch_rows(count: int) -> Iterator[Row]:
    """Yield time and memory of a million poses in the trainer by segment, in pieces (of `count`
    poses, the time of which is theirs) and in one call."""
    name = f"{POSES} poses in the trainer"
    yield from _placed_rows(count)
    found = _measured("pieces", count)
    said = f"{PIECE} a piece" + ("" if count == POSES else f", {count} poses in all")
    yield Row("time, in pieces of the caller", name, found["each"], "us a pose", said)
    yield Row("memory, in pieces of the caller", name, found["memory"], "GB", said)
    found = _measured("call", POSES) if _fits() else {}
    why = "" if found else _why()
    yield Row("time, in one call", name, found.get("each"), "us a pose", why)
    yield Row("memory, in one call", name, found.get("memory"), "GB", why)
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


def _answer_memory() -> float:
    """[GB] of the placed bodies and the answers of one call about POSES."""
    case = seated_in("trainer", "957", 1)
    arrays = [case.placed.centres, case.placed.world_from_segment, by_segment(case)]
    return POSES * sum(values.nbytes for values in arrays) / 1e9


def _fits() -> bool:
    return _answer_memory() < MOST


def _why() -> str:
    return f"not possible: placed bodies and answers alone are {_answer_memory():.0f} GB"


def _measured(way: str, count: int) -> dict[str, float]:
    """Time [us] a pose and the most memory [GB] of a process that goes one of the WAYS."""
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["-m", "benchmarks.batches", way, str(count)]
        cost = process_cost(arguments, {}, Path(folder) / "said.txt")
    if cost.code:
        raise ValueError(f"{way}, {count} poses: ended with {cost.code}:\n{cost.out}")
    return {"each": json.loads(cost.out.splitlines()[-1])["each"], "memory": cost.memory}


def main(way: str, count: int) -> None:
    """Print the time a pose of one of the WAYS as JSON, on one core and warm."""
    case = seated_in("trainer", "957")
    with one_core():
        WAYS["pieces"](case, 256)
        begin = time.process_time()
        hits = WAYS[way](case, count)
        spent = time.process_time() - begin
    print(json.dumps({"each": 1e6 * spent / count, "hits": hits}))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
