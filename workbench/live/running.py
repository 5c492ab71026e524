"""The run that a page has asked for: a study, or one of many people that is written first, is run in a
process of its own, and its report is served.

One is run at a time, for all pages: whoever opens one sees how far it is, and may end it. What it had
finished of a population when it was ended is kept, as that of `workbench run`, and gone on with by the
next.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Protocol

from workbench.errors import WorkbenchError, printable
from workbench.files.output_folder import manifest_of
from workbench.live.protocol import Run, packed

__all__ = ["Runner", "Runs", "Wrote"]

OFTEN = 0.2
"""Time [s] between two words about how far a run is."""
Head = Mapping[str, Any]


class Wrote(Protocol):
    """What the bench tells of a report that was written."""

    @property
    def folder(self) -> Path:
        """Where it is."""

    @property
    def headline(self) -> str:
        """Its first sentence."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What leaves people out, and a line for each verdict."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Its warnings."""


class Runner(Protocol):
    """A function of a module that runs a study and writes its report: `run_and_write`."""

    def __call__(self, source: str, *, say: Callable[[str], None]) -> Wrote:
        """Run a study file. say: called with words on how far it is. WorkbenchError where that
        cannot be done."""


class Runs:
    """The runs of a bench.

    Parameters
    ----------
    runner
        Runs a study.
    tell
        Is given the frame of how far a run is, or how it has ended, in the loop of the server.
    """

    def __init__(self, runner: Runner, tell: Callable[[bytes], None]) -> None:
        self.runner = runner
        self.tell = tell
        self.frame: bytes | None = None
        """What was told last, for pages that are opened later."""
        self.folder = Path()
        self.names: frozenset[str] = frozenset()
        """The files of the report that was made last, which alone are served."""
        self.waiting: asyncio.Queue[Run] = asyncio.Queue()
        self.at_work: BaseProcess | None = None
        self.stopped = False
        self.lock = threading.Lock()
        self.pool = ThreadPoolExecutor(1, "run")

    def begin(self, run: Run) -> bool:
        """Let a study be run; False, and nothing is done, where another one is."""
        if self.at_work is not None or not self.waiting.empty():
            return False
        self.stopped = False
        self.waiting.put_nowait(run)
        return True

    def stop(self) -> None:
        """End what is being run."""
        with self.lock:
            self.stopped = True
            if self.at_work is not None:
                self.at_work.terminate()

    def end(self) -> None:
        """End what is being run, with the bench."""
        self.stop()
        self.pool.shutdown(wait=False, cancel_futures=True)

    def path(self, name: str) -> Path | None:
        """A file of the report that was made last, by its name; None where there is none."""
        return self.folder / name if name in self.names else None

    async def run_next(self) -> None:
        """Run the study that is asked for next."""
        run = await self.waiting.get()
        loop = asyncio.get_running_loop()

        def told(head: Head) -> None:
            loop.call_soon_threadsafe(self._say, run, head)

        last = await loop.run_in_executor(self.pool, self._made, run, told)
        if "folder" in last:
            self.folder = Path(last["folder"]).resolve()
            manifest = manifest_of(self.folder)
            self.names = frozenset(manifest.files if manifest is not None else ())
        self._say(run, last)

    def _say(self, run: Run, head: Head) -> None:
        self.frame = packed({"kind": "report", "study": printable(run.study.name), **head})
        self.tell(self.frame)

    def _made(self, run: Run, told: Callable[[Head], None]) -> Head:
        """Let a study be run, in the thread that waits for it; what is told at the end."""
        context = get_context("spawn")
        own, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_run, args=(self.runner, run, theirs), name="run")
        with self.lock:
            if self.stopped:
                return {"ended": True}
            process.start()
            self.at_work = process
        theirs.close()
        try:
            while "words" in (said := own.recv()):
                told(said)
            return dict(said)
        except EOFError:
            if self.stopped:
                return {"ended": True}
            return {"fault": "the report could not be made: its process has ended"}
        finally:
            own.close()
            process.join()
            self.at_work = None


def _run(runner: Runner, run: Run, told: Connection) -> None:
    """Run a study, and tell how far it is, and how it has ended."""
    with suppress(OSError, KeyboardInterrupt):  # nobody listens any more
        try:
            told.send(_written(runner, run, told))
        except WorkbenchError as error:
            told.send({"fault": printable(str(error))})


def _written(runner: Runner, run: Run, told: Connection) -> Head:
    """Write the study where it is not there, run it, and return what is told of its report."""
    last = 0.0

    def say(words: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= OFTEN:
            last = now
            told.send({"words": printable(words)})

    note = ""
    if run.people:
        from workbench.study.describe.saving import save_first_study

        say(f"writing {run.study.name}")
        save_first_study(run.environment, run.study, people=run.people)
        note = f"{run.study.name} was written: a first study of {run.environment.name} with {run.people} people"
    done = runner(str(run.study), say=say)
    return {
        "folder": str(done.folder),
        "note": note,
        "headline": printable(done.headline),
        "lines": [printable(line) for line in done.lines],
        "warnings": len(done.warnings),
    }
