"""Run jobs in parallel: in processes of this machine, or by the workers of a Dask cluster.

Compiled loops release Python's lock, the code between them does not. Whole chunks of people are
therefore worked on in separate processes. On Linux these are forks: they have the compiled
functions and distance indexes of this process, and start within hundredths of a second. Elsewhere
they are new interpreters, and a script that runs a study needs `if __name__ == "__main__":`.
"""

from __future__ import annotations

import logging
import math
import os
import pickle
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from contextvars import ContextVar, copy_context
from functools import cached_property, lru_cache, partial
from itertools import islice
from multiprocessing import current_process, get_context
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeVar
from uuid import uuid4
from weakref import WeakKeyDictionary, WeakValueDictionary

from workbench.errors import InputError, MissingPartError
from workbench.threads import THREADS, available_cores

__all__ = ["Shared", "completed", "dask_executor", "local_executor", "worked"]

K = TypeVar("K")
T = TypeVar("T")

SCHEDULER_TIMEOUT = 6
"""Time [s] within which a Dask scheduler must answer."""
SENDING_TIME = 5
"""Time [s] after which a process whose parent is gone no longer tries to send a result."""
BEAT = 1.0
"""Time [s] after which who waits for jobs is told that these are not done."""
WORKERLESS_TIME = 60.0
"""Time [s] after which a cluster that has no worker is given up."""
_START = "fork" if sys.platform == "linux" else "spawn"
"""How processes begin."""
CLUSTER_JOBS = 256
"""Jobs handed to a cluster at a time."""


class Shared(Generic[T]):
    """A value that many jobs need: pickled once, and unpickled once in each process.

    What is cached with the value therefore serves all jobs of a process. In this process and its
    forks the value is never copied.
    """

    def __init__(self, value: T) -> None:
        self.value = value
        self._token = uuid4().hex
        _SHARED[self._token] = self

    def __reduce__(self) -> tuple[Any, ...]:
        return _received, (self._token, self._pickled)

    @cached_property
    def _pickled(self) -> bytes:
        return pickle.dumps(self.value, protocol=pickle.HIGHEST_PROTOCOL)


_SHARED: WeakValueDictionary[str, Shared[Any]] = WeakValueDictionary()
"""Shared values that were made in this process or in the one that it is a fork of."""


_WATCHED: WeakKeyDictionary[Executor, Callable[[], None]] = WeakKeyDictionary()
"""What who waits for jobs of a cluster calls in between: it raises InputError where nobody works."""


def _received(token: str, pickled: bytes) -> Shared[Any]:
    return _SHARED.get(token) or _unpickled(token, pickled)


@lru_cache(maxsize=4)
def _unpickled(token: str, pickled: bytes) -> Shared[Any]:
    return Shared(pickle.loads(pickled))


_HEARD: ContextVar[Callable[[float], None]] = ContextVar("heard", default=lambda share: None)
"""What is called with the share that is done of the job at hand."""


def worked(share: float) -> None:
    """Tell who waits for the job at hand how much of it is done, from 0 to 1."""
    _HEARD.get()(share)


def completed(
    function: Callable[..., T],
    keys: Sequence[K],
    arguments: Callable[[K], tuple[Any, ...]],
    *,
    executor: Executor | None = None,
    waiting: Callable[[float], None] = lambda done: None,
) -> Generator[tuple[K, T]]:
    """Call a function once for each key, in parallel, and yield the results as they are ready.

    Parameters
    ----------
    function
        A function of a module. Its arguments and its result are pickled.
    keys
        What the jobs are called: the numbers of chunks, for example.
    arguments
        Returns the arguments of the job of a key. It is called shortly before the job begins, so
        that only the arguments of a few jobs are held in memory.
    executor
        Runs the jobs: `local_executor` if None. A single job, or a single core, needs no other
        process: the jobs are then run here, in order.
    waiting
        Called after each result is taken and each second or oftener in between, with how many jobs are done: those at hand
        in part, as far as they tell by `worked` and run on this machine. Where they are those of a
        cluster, its workers are counted every second.

    Yields
    ------
    tuple
        The key and the result of each job, in any order.

    Raises
    ------
    InputError
        If a process is killed, or a cluster has had no worker for `WORKERLESS_TIME`. What the
        function raises is raised here.
    """
    processes = min(available_cores(), len(keys))
    if executor is None and (processes < 2 or current_process().daemon):
        for number, key in enumerate(keys):
            heard = copy_context()
            heard.run(_HEARD.set, partial(_told_in_part, waiting, number))
            yield key, heard.run(function, *arguments(key))
            waiting(number + 1)
        return
    most = CLUSTER_JOBS if executor is not None else 2 * processes
    left = iter(keys)
    futures: dict[Future[T], K] = {}
    ready = 0
    meter = get_context(_START).Value("d", 0.0)
    ours = local_executor(processes, meter)
    with nullcontext(executor) if executor is not None else ours as pool:
        while True:
            for key in islice(left, most - len(futures)):
                futures[pool.submit(_run_job, function, arguments(key))] = key
            if not futures:
                return
            done = wait(futures, timeout=BEAT, return_when=FIRST_COMPLETED).done
            if not done:
                _WATCHED.get(pool, lambda: None)()
            for future in done:
                yield futures.pop(future), future.result()
            ready += len(done)
            waiting(max(meter.value, ready))


@contextmanager
def local_executor(processes: int | None = None, meter: Any = None) -> Iterator[Executor]:
    """Start processes of this machine, each with one thread, and end them on an error.

    A process within a job of `completed` ends at once.

    Parameters
    ----------
    processes
        How many; one for each core if None.
    meter
        A number that processes share: how many jobs are done, those at hand in part.

    Raises
    ------
    InputError
        If a process is killed.
    """
    context = get_context(_START)
    ending, held = context.Pipe(duplex=False)
    executor = ProcessPoolExecutor(
        processes or available_cores(),
        mp_context=context,
        initializer=_begin_worker,
        initargs=(ending, held, meter),
    )
    try:
        with warnings.catch_warnings():
            # Python warns of a fork beside threads: ours wait or draw the progress
            warnings.simplefilter("ignore", DeprecationWarning)
            executor.submit(os.getpid)  # forks all processes, before the pool's own threads start
        yield executor
        executor.shutdown()
    except BrokenProcessPool:
        raise InputError(
            "a process that worked on a part of the people was killed: the machine may be out of "
            "memory (WORKBENCH_THREADS=1 works on one part at a time)"
        ) from None
    finally:
        held.close()  # a process within a job ends at once
        executor.shutdown(cancel_futures=True)
        ending.close()


def _run_job(function: Callable[..., T], args: tuple[Any, ...]) -> T:
    with _WORKER.job():
        return function(*args)


def _told_in_part(waiting: Callable[[float], None], before: int, share: float) -> None:
    waiting(before + share)


class _Worker:
    """What a process of a pool does when its parent ends, or wants it to end.

    Within a job it ends at once. It never ends while it sends a result: who reads half a result
    waits for the other half forever.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._in_job = False
        self._wanted = True
        self._share = 0.0
        self.meter: Any = None

    @contextmanager
    def job(self) -> Iterator[None]:
        """Mark the time in which the process may end."""
        with self._lock:
            if not self._wanted:
                os._exit(1)
            self._in_job = True
        self._share = 0.0
        try:
            yield
            self.count(1.0)
        finally:
            with self._lock:
                self._in_job = False

    def count(self, share: float) -> None:
        """Count the share that is done of the job at hand for who waits for it."""
        if self.meter is not None and share > self._share:
            with self.meter.get_lock():
                self.meter.value += share - self._share
            self._share = share

    def end_with(self, ending: Connection) -> None:
        """Wait until the other end of a pipe, which only the parent has, is closed; then end."""
        with suppress(EOFError, OSError):
            ending.recv_bytes()
        with self._lock:
            self._wanted = False
            if self._in_job:
                os._exit(1)
        time.sleep(SENDING_TIME)
        os._exit(1)


_WORKER = _Worker()
"""This process, where it belongs to a pool."""


def _begin_worker(ending: Connection, held: Connection, meter: Any) -> None:
    """Prepare a process for jobs with one thread each, and let it end with its parent."""
    # Ctrl-C in a terminal reaches all processes: the parent reports it and ends the others
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.environ[THREADS] = "1"
    held.close()
    _WORKER.meter = meter
    _HEARD.set(_WORKER.count)
    threading.Thread(target=_WORKER.end_with, args=(ending,), daemon=True).start()


_AGAIN = "a run into the same folder goes on with the parts of the people that were done"


class _Watch:
    """Whether somebody works at a cluster."""

    def __init__(self, client: Any, address: str) -> None:
        self._client = client
        self._address = address
        self._alone_since = math.inf

    def look(self) -> None:
        """Raise InputError where there has been no worker for `WORKERLESS_TIME`."""
        now = time.monotonic()
        if self._client.scheduler_info()["workers"]:
            self._alone_since = math.inf
            return
        self._alone_since = min(self._alone_since, now)
        if now - self._alone_since >= WORKERLESS_TIME:
            raise InputError(
                f"the cluster at {self._address!r} has had no worker for {WORKERLESS_TIME:g} s: start "
                f"one (dask worker {self._address}) and run again; {_AGAIN}"
            )


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """Connect to a Dask cluster.

    Parameters
    ----------
    address
        That of a scheduler, such as ``tcp://host:8786``, or ``local``: a cluster of its own with a
        process for each core.

    Raises
    ------
    MissingPartError
        If Dask is not installed.
    InputError
        If no scheduler answers or it is gone, if there has been no worker for `WORKERLESS_TIME`, or a
        job ends every worker that it is given to.
    """
    try:
        from distributed import Client, KilledWorker, LocalCluster
    except ImportError:
        raise MissingPartError(
            "a cluster needs Dask: pip install 'bubbleman-workbench[cluster]'"
        ) from None
    with ExitStack() as stack:
        # it writes a traceback of its own where the scheduler is gone, which is said below
        log = logging.getLogger("distributed.client")
        stack.callback(log.setLevel, log.level)
        log.setLevel(logging.CRITICAL)
        target: Any = address
        if address == "local":
            target = stack.enter_context(
                LocalCluster(
                    n_workers=available_cores(), threads_per_worker=1, dashboard_address=None
                )
            )
        try:
            client = stack.enter_context(Client(target, timeout=SCHEDULER_TIMEOUT))
        except (OSError, TimeoutError, ValueError) as error:
            why = str(error).split("\n")[0] or type(error).__name__
            raise InputError(
                f"no Dask scheduler answers at {address!r} within {SCHEDULER_TIMEOUT} s ({why}); "
                "give its address, such as tcp://host:8786, or local"
            ) from None
        executor = client.get_executor(pure=False)
        _WATCHED[executor] = _Watch(client, address).look
        try:
            yield executor
        except CancelledError:
            raise InputError(
                f"the Dask scheduler at {address!r} is gone, and with it the jobs that were not "
                f"done; {_AGAIN}"
            ) from None
        except KilledWorker:
            raise InputError(
                "the workers of the cluster were killed by a part of the people: they may be out "
                "of memory"
            ) from None
