"""A page that is open: what is still to be sent to it, and whose question is answered next.

A page that takes no answers, or asks without end, is closed. It connects again if somebody looks at
it, and gets the state as it is then. So no page makes others wait, or what is kept for it grow. Who
asks is answered in turn, of one subject the newest question, but none that ends a drag is lost.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

from workbench.errors import InputError
from workbench.live.protocol import Question

__all__ = [
    "MOST_ASKED",
    "MOST_UNSENT",
    "MOST_WAITING",
    "SLOWEST",
    "TOO_MUCH",
    "TOO_SLOW",
    "Page",
    "PageClosedError",
    "Waiting",
]

SLOWEST = 10.0
"""Time [s] in which a page must take a frame."""
MOST_UNSENT = 64_000_000
"""Bytes that may wait for a page, apart from one frame."""
MOST_ASKED = 500
"""Messages that a page may send within a second; one that waits for answers sends about fifty."""
TOO_SLOW = 4408
TOO_MUCH = 4429
"""Close codes of a socket, after the status codes 408 and 429 of HTTP (RFC 9110, RFC 6585)."""


class PageClosedError(Exception):
    """A page is to be closed: with which code, and why in words."""

    def __init__(self, code: int, words: str) -> None:
        super().__init__(words)
        self.code = code


class _Socket(Protocol):
    """What of a WebSocket is needed to send."""

    async def send_bytes(self, data: bytes) -> None:
        """Send a frame."""


class Page:
    """A page, by its socket.

    Parameters
    ----------
    socket
        Over which frames are sent.
    """

    def __init__(self, socket: _Socket) -> None:
        self.socket = socket
        self._unsent: deque[bytes] = deque()
        self._bytes = 0
        self._filled = asyncio.Event()
        self._second = 0
        self._asked = 0

    def put(self, frame: bytes) -> None:
        """Let a frame be sent after those before it."""
        self._unsent.append(frame)
        self._bytes += len(frame)
        self._filled.set()

    def count(self, time: float) -> None:
        """Count a message that came at a time [s].

        Raises
        ------
        PageClosedError
            If too many came within a second.
        """
        if int(time) != self._second:
            self._second = int(time)
            self._asked = 0
        self._asked += 1
        if self._asked > MOST_ASKED:
            raise PageClosedError(TOO_MUCH, f"a page asks {MOST_ASKED} times a second at most")

    async def deliver(self) -> None:
        """Send frames as they come.

        Raises
        ------
        PageClosedError
            If the page does not take them.
        """
        while True:
            await self._filled.wait()
            while self._unsent:
                frame = self._unsent.popleft()
                self._bytes -= len(frame)
                await self._send(frame)
            self._filled.clear()

    async def _send(self, frame: bytes) -> None:
        if self._bytes > MOST_UNSENT:
            raise PageClosedError(TOO_SLOW, "the page takes answers too slowly")
        try:
            await asyncio.wait_for(self.socket.send_bytes(frame), SLOWEST)
        except TimeoutError:
            raise PageClosedError(TOO_SLOW, "the page takes no answers") from None


MOST_WAITING = 256
"""Questions of one who asks that may wait; who sends more has lost count."""
Asker = TypeVar("Asker", bound=Hashable)


@dataclass
class Waiting(Generic[Asker]):
    """The questions of each who asks, in their order; whose turn is next comes first."""

    rows: dict[Asker, list[Question]] = field(default_factory=dict)

    def __len__(self) -> int:
        return sum(map(len, self.rows.values()))

    def put(self, asker: Asker, question: Question) -> None:
        """Let a question wait, in the place of one on the way of the same drag.

        Raises
        ------
        InputError
            If too many wait.
        """
        mine = self.rows.get(asker, [])
        kept = [one for one in mine if one.done or one.subject != question.subject]
        if len(kept) >= MOST_WAITING:
            raise InputError(f"{MOST_WAITING} questions wait already")
        self.rows[asker] = [*kept, question]

    def take(self) -> tuple[Asker, Question]:
        """The question that has waited longest of the one whose turn it is."""
        asker = next(iter(self.rows))
        first, *rest = self.rows.pop(asker)
        if rest:
            self.rows[asker] = rest  # behind the others
        return asker, first

    def forget(self, asker: Asker) -> None:
        """Drop what somebody asked who has gone; what ends a drag is still done."""
        done = [question for question in self.rows.pop(asker, []) if question.done]
        if done:
            self.rows[asker] = done
