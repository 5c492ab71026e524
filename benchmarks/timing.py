"""CPU time of calls on one core, of engines in turn, and of commands in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

__all__ = ["Cost", "Turn", "in_turn", "microseconds", "one_core", "process_cost"]

SHORTEST = 0.05
"""[s] A call is repeated until so much is spent: the clock of CPU time has grains of its own."""
REPEAT = 5
Answer = TypeVar("Answer")


@contextmanager
def one_core() -> Iterator[None]:
    """Hold this process to one core, where the system can."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


def microseconds(work: Callable[[], object], count: int = 1, *, repeat: int = REPEAT) -> float:
    """Return the median CPU time [us] of one of the `count` things that a call does.

    The first call, which compiles and packs, is not counted. What takes longer than a second is
    done twice only.
    """
    work()
    times: list[float] = []
    while len(times) < repeat and not (times and min(times) > 1.0):
        times.append(_timed(work)[0])
    return 1e6 * float(np.median(times)) / count


def _timed(work: Callable[[], Answer]) -> tuple[float, Answer]:
    """CPU seconds of a call, repeated until they can be told, and what it returns."""
    calls = 0
    begin = time.process_time()
    while True:
        found = work()
        calls += 1
        spent = time.process_time() - begin
        if spent > SHORTEST:
            return spent / calls, found


@dataclass
class Turn:
    """What an engine has answered in its turns: CPU seconds, and the answers so far."""

    spent: float
    answers: list[np.ndarray]

    @property
    def each(self) -> float:
        """CPU time of an answer [us]."""
        return 1e6 * self.spent / max(len(self.told), 1)

    @property
    def told(self) -> np.ndarray:
        """All answers, (P, ...)."""
        return np.concatenate(self.answers)


Ask = Callable[[slice], Callable[[], np.ndarray]]
"""Asks about some poses, which is timed; what it returns gives the answers, which is not."""


def in_turn(
    engines: Mapping[str, Ask], pieces: Sequence[slice], *, most: float = 3.0
) -> dict[str, Turn]:
    """Ask engines about the same poses in turn, piece by piece.

    Each is warmed by the first piece. One that has spent `most` seconds [s] is asked no further.
    """
    for ask in engines.values():
        ask(pieces[0])()
    turns = {name: Turn(0.0, []) for name in engines}
    for piece in pieces:
        for name, ask in engines.items():
            turn = turns[name]
            if turn.spent > most:
                continue
            spent, found = _timed(partial(ask, piece))
            turn.spent += spent
            turn.answers.append(found())
    return turns


@dataclass(frozen=True)
class Cost:
    """What a process took: CPU seconds with its children, wall seconds, the most memory [GB] that
    one process held, and how it ended."""

    cpu: float
    wall: float
    memory: float
    code: int
    out: str


WATCH = """
import json, resource, subprocess, sys, time
begin = time.perf_counter()
with open(sys.argv[1], "w", encoding="utf-8") as out:
    done = subprocess.run([sys.executable, *sys.argv[2:]], stdout=out, stderr=subprocess.STDOUT)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
wall = time.perf_counter() - begin
print(json.dumps([used.ru_utime + used.ru_stime, wall, used.ru_maxrss, done.returncode]))
"""
"""Runs a process from a small one: the system counts the memory of whoever starts a process as its
own."""


def process_cost(arguments: Sequence[str], environment: Mapping[str, str], out: Path) -> Cost:
    """Run Python with some arguments in a new process, its output in a file, and return its cost."""
    done = subprocess.run(
        [sys.executable, "-c", WATCH, str(out), *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    cpu, wall, memory, code = json.loads(done.stdout)
    unit = 1 if sys.platform == "darwin" else 1024
    return Cost(cpu, wall, memory * unit / 1e9, code, out.read_text(encoding="utf-8"))
