"""Pieces of a batch on all cores this process may use: compiled loops let go of Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar

from workbench.errors import UsageError

__all__ = ["THREADS", "available_cores", "one_thread", "run_in_threads"]

THREADS = "WORKBENCH_THREADS"
"""The environment's word on how many cores may be used at most."""


_ALONE: ContextVar[bool] = ContextVar("alone", default=False)
"""Whether what is called goes on in this thread alone."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Let what is called within work in this thread alone: for callers that share out the work
    themselves, to whom more threads are only a burden."""
    token = _ALONE.set(True)
    try:
        yield
    finally:
        _ALONE.reset(token)


def available_cores() -> int:
    """How many cores this process may use, no more than WORKBENCH_THREADS where that is set;
    UsageError where it is no number."""
    there = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    asked = os.environ.get(THREADS, "")
    if not asked:
        return there
    if not asked.isdecimal() or int(asked) < 1:
        raise UsageError(f"{THREADS} is a number of cores, 1 or more, got {asked!r}")
    return min(there, int(asked))


def run_in_threads(
    work: Callable[[int, int], None], count: int, size: int, *, threads: int | None = None
) -> None:
    """Call work(begin, end) for the pieces of at most `size` of range(count), each once, `threads`
    at a time.

    The pieces are the same for every number of threads and must not share what they write, so no
    answer can depend on it. threads: all cores where None.
    """
    if threads is not None and threads < 1:
        raise UsageError(f"threads: expected 1 or more, got {threads}")
    begins = range(0, count, max(size, 1))
    at_once = len(begins)
    if at_once > 1:  # a single piece needs no count of cores, which takes as long as a short piece
        at_once = min(threads or (1 if _ALONE.get() else available_cores()), at_once)
    if at_once <= 1:
        for begin in begins:
            work(begin, min(begin + size, count))
        return
    with ThreadPoolExecutor(at_once) as pool:
        list(pool.map(lambda begin: work(begin, min(begin + size, count)), begins))
