"""The films that pages have asked for: made one after the other, and kept until they are fetched.

A process of its own writes them, behind all others, so that answers of the bench go first. It says
after each frame how far it is. Where nobody listens any more it ends, and leaves no file.
"""

from __future__ import annotations

import asyncio
import os
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

from workbench.errors import InputError, WorkbenchError
from workbench.live.filming import Film, MotionClip, film_ending
from workbench.live.pages import Page
from workbench.live.protocol import packed

__all__ = [
    "FilmStoppedError",
    "Films",
    "write_apart",
]

NICE = 5
"""By how much it stands back behind other processes, where the system knows that."""


def write_apart(take: MotionClip, path: Path, progress: Callable[[int, int], None]) -> int:
    """Write a film in another process.

    Parameters
    ----------
    progress
        Called with the number of frames that are done, and of all; what it raises ends the film.

    Returns
    -------
    int
        The number of frames.

    Raises
    ------
    InputError
        If the film cannot be made.
    """
    own, theirs = get_context("spawn").Pipe(duplex=False)
    process = get_context("spawn").Process(
        target=_write, args=(take, path, theirs), daemon=True, name="film"
    )
    process.start()
    theirs.close()
    frames = 0
    try:
        while True:
            said = own.recv()
            if isinstance(said, str):
                raise InputError(said)
            if said is None:
                return frames
            frames, count = said
            progress(frames, count)
    except EOFError:
        raise InputError("the film could not be made: its process has ended") from None
    finally:
        own.close()
        process.join()


def _write(take: MotionClip, path: Path, told: Connection) -> None:
    """Write a film, and tell how far it is; None at its end, or why it cannot be made."""
    if hasattr(os, "nice"):
        os.nice(NICE)
    with suppress(OSError, KeyboardInterrupt):  # nobody listens any more
        try:
            take.write(path, lambda done, count: told.send((done, count)))
            told.send(None)
        except WorkbenchError as error:
            told.send(str(error))


KEPT = 4
"""Films that are kept; the oldest give way."""
OFTEN = 0.25
"""Time [s] between two frames about how far a film is."""
ENDED = packed({"kind": "film"})
"""The frame of a film that has ended without a file."""
Fault = Callable[[WorkbenchError], bytes]


class FilmStoppedError(Exception):
    """A film is not wanted any more."""


@dataclass
class _Asked:
    """A film that somebody waits for."""

    page: Page
    film: Film
    stopped: bool = False
    told: float = 0.0


class Films:
    """The films of a desk.

    Parameters
    ----------
    fault
        Makes the frame of why a film could not be made.
    """

    def __init__(self, fault: Fault) -> None:
        self.fault = fault
        self.asked: deque[_Asked] = deque()
        self.at_work: _Asked | None = None
        self.some = asyncio.Event()
        self.folder: tempfile.TemporaryDirectory[str] | None = None
        self.kept: deque[Path] = deque()
        self.count = 0
        self.lock = threading.Lock()
        self.pool = ThreadPoolExecutor(1, "film")

    def begin(self, page: Page, film: Film) -> None:
        """Let a film be made for a page, in the place of one that it has asked for before."""
        self.stop(page)
        self.asked.append(_Asked(page, film))
        self.some.set()

    def stop(self, page: Page) -> None:
        """End the film of a page; nothing is kept of it."""
        for one in (*self.asked, self.at_work):
            if one is not None and one.page is page:
                one.stopped = True
        self.asked = deque(one for one in self.asked if one.page is not page)

    def end_for(self, page: Page) -> None:
        """End the film of a page that asks for that, and say so to it."""
        self.stop(page)
        page.put(ENDED)

    def path(self, name: str) -> Path | None:
        """The file of a film by its name; None where there is none."""
        return next((path for path in self.kept if path.name == name), None)

    async def make(self) -> None:
        """Make the film that has been waited for longest."""
        await self.some.wait()
        if not self.asked:
            self.some.clear()
            return
        loop = asyncio.get_running_loop()
        asked = self.asked.popleft()
        self.at_work = asked
        self.count += 1
        path = self._folder() / f"{self.count}{film_ending()}"
        frames = 0
        fault = None
        try:
            frames = await loop.run_in_executor(self.pool, self._made, asked, path, loop)
        except FilmStoppedError:
            return
        except WorkbenchError as error:
            fault = self.fault(error)
        finally:
            self.at_work = None
            if not frames and not asked.stopped:
                asked.page.put(ENDED)
        if asked.stopped:
            path.unlink(missing_ok=True)
        elif fault is not None:
            asked.page.put(fault)
        else:
            self._keep(path)
            head = {"kind": "film", "file": path.name, "frames": frames, "ending": path.suffix}
            asked.page.put(packed(head))

    def end(self) -> None:
        """End what is being made, and remove all files."""
        for one in (*self.asked, self.at_work):
            if one is not None:
                one.stopped = True
        self.pool.shutdown(wait=False, cancel_futures=True)
        with self.lock:  # no file is being written
            if self.folder is not None:
                self.folder.cleanup()

    def _folder(self) -> Path:
        if self.folder is None:
            self.folder = tempfile.TemporaryDirectory(prefix="workbench-film-")
        return Path(self.folder.name)

    def _keep(self, path: Path) -> None:
        self.kept.append(path)
        while len(self.kept) > KEPT:
            self.kept.popleft().unlink(missing_ok=True)

    def _made(self, asked: _Asked, path: Path, loop: asyncio.AbstractEventLoop) -> int:
        """Let a film be written, in the thread that waits for it; the number of its frames."""

        def progress(done: int, count: int) -> None:
            if asked.stopped:
                raise FilmStoppedError
            now = time.monotonic()
            if now - asked.told > OFTEN:
                asked.told = now
                told = packed({"kind": "film", "done": done, "of": count})
                loop.call_soon_threadsafe(asked.page.put, told)

        with self.lock:
            if asked.stopped:
                raise FilmStoppedError
            return write_apart(asked.film.take(), path, progress)
