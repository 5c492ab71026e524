"""Connections of the bench's server: who asks nothing for too long is let go, and of too many who have
not asked yet the first that came."""

from __future__ import annotations

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ["MOST_SILENT", "PATIENCE", "bounded_connections"]

PATIENCE = 10.0
"""Time [s] in which a request must be whole."""
MOST_SILENT = 64
"""Connections without a whole request: a browser opens up to six at once."""


def bounded_connections(
    *, most: int = MOST_SILENT, patience: float = PATIENCE
) -> type[asyncio.Protocol]:
    """Build the protocol of the connections of one server.

    Parameters
    ----------
    most
        Connections that may wait for a request at the same time.
    patience
        Time [s] in which a request must be whole.
    """
    silent: dict[H11Protocol, asyncio.TimerHandle] = {}

    class Connection(H11Protocol):
        """A connection that is counted while it owes a request."""

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            """Count a connection that was just made."""
            super().connection_made(transport)
            self._await_request()

        def data_received(self, data: bytes) -> None:
            """Count a connection on which a request is begun and not whole."""
            super().data_received(data)
            owes = self.conn.their_state is h11.IDLE and self.conn.trailing_data[0]
            if not owes:
                self._forget()
            elif self not in silent:
                self._await_request()

        def connection_lost(self, exc: Exception | None) -> None:
            """Forget a connection."""
            self._forget()
            super().connection_lost(exc)

        def _await_request(self) -> None:
            silent[self] = self.loop.call_later(patience, self.transport.abort)
            if len(silent) > most:
                first = next(iter(silent))
                silent.pop(first).cancel()
                first.transport.abort()

        def _forget(self) -> None:
            if self in silent:
                silent.pop(self).cancel()

    return Connection
