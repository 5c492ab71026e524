"""Chunks of a work shared among processes of this machine.

Kernels let go of Python's lock, what stands between them does not; so whole chunks are worked on
side by side. The processes are forks of this one: they know everything it knows, compiled kernels
among it, and begin within hundredths of a second. Each takes the next chunk's number from one pipe,
and ends when that is empty or nobody reads any more what it found; so none outlives its parent by
more than a chunk. Where there is no safe fork (macOS, Windows), one core, or one chunk, the work is
done here, by the kernels' own threads.
"""

from __future__ import annotations

import os
import signal
import sys
import warnings
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from io import FileIO
from multiprocessing import current_process, get_context
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from workbench.errors import InputError, WorkbenchError
from workbench.threads import THREADS, cores

__all__ = ["shared"]

T = TypeVar("T")
_NUMBER = 4
"""Bytes of a chunk's number: a read of so few from a pipe is whole."""
_MOST = 16_000
"""Numbers that a pipe holds for sure."""


def shared(
    work: Callable[[int], T], chunks: Sequence[int], *, processes: int | None = None
) -> Generator[tuple[int, T]]:
    """What `work` says of each of some chunks, as it gets ready; in order where one process does
    all.

    processes: as many as there are cores where None. The answers are the same for any number.
    InputError where a process is killed; errors of the work are raised here.
    """
    many = min(cores() if processes is None else processes, len(chunks))
    if many < 2 or sys.platform != "linux" or current_process().daemon or len(chunks) > _MOST:
        for chunk in chunks:
            yield chunk, work(chunk)
        return
    crowd: dict[Connection, Any] = {}
    try:
        with _numbers(chunks) as waiting:
            for _ in range(many):
                _begin(work, waiting, crowd)
        while crowd:
            for end in wait(list(crowd)):
                assert isinstance(end, Connection)
                found = _answer(end, crowd)
                if found is not None:
                    yield found
    finally:
        for process in crowd.values():
            process.terminate()
        for end, process in crowd.items():
            process.join()
            end.close()


def _numbers(chunks: Sequence[int]) -> FileIO:
    """A pipe with the numbers of all chunks in it."""
    waiting, put = os.pipe()
    os.write(put, b"".join(chunk.to_bytes(_NUMBER, "little") for chunk in chunks))
    os.close(put)
    return FileIO(waiting)


def _begin(work: Callable[[int], Any], waiting: FileIO, crowd: dict[Connection, Any]) -> None:
    """Fork a process that works, and add it to the crowd by the end at which its answers arrive."""
    context = get_context("fork")
    end, far = context.Pipe(duplex=False)
    process = context.Process(target=_serve, args=(work, waiting, far, [end, *crowd]), daemon=True)
    with (
        warnings.catch_warnings()
    ):  # Python warns of threads beside a fork: ours wait, or draw a spinner
        warnings.simplefilter("ignore", DeprecationWarning)
        process.start()
    far.close()
    crowd[end] = process


def _answer(end: Connection, crowd: dict[Connection, Any]) -> tuple[int, Any] | None:
    """What a process has to say: a chunk's number and what was found of it; None where it has ended
    as it should."""
    try:
        number, found, error = end.recv()
    except (EOFError, OSError):
        process = crowd.pop(end)
        process.join()
        end.close()
        if process.exitcode == 0:
            return None
        how = (
            f"killed by signal {-process.exitcode}"
            if process.exitcode < 0
            else f"exit code {process.exitcode}"
        )
        raise InputError(
            f"a process that worked on a part of the people ended before its work ({how}): is there memory left?"
        ) from None
    if error is not None:
        raise error
    return number, found


def _serve(
    work: Callable[[int], Any], waiting: FileIO, far: Connection, others: Sequence[Connection]
) -> None:
    """The work of a process: one chunk after the other, with one thread, until none is left or
    nobody listens."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # the parent tells of an interruption, and ends its children
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.environ[THREADS] = "1"
    for end in others:
        end.close()
    with suppress(BrokenPipeError):
        while number := waiting.read(_NUMBER):
            chunk = int.from_bytes(number, "little")
            try:
                answer: tuple[int, Any, WorkbenchError | None] = chunk, work(chunk), None
            except WorkbenchError as error:
                answer = chunk, None, error
            far.send(answer)
