"""The guard around everything that the bench serves.

A page of another origin can make a browser send requests to a server on this machine. So each
request must name this server as its host (a name that was rebound to this address does not), and
carry a cookie that only the printed address gives. A WebSocket must come from the page itself.

Who asks nothing for too long is let go, and of too many connections that have not asked yet the
first that came.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from hmac import compare_digest
from typing import Any
from urllib.parse import parse_qs

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = [
    "MOST_SILENT",
    "PATIENCE",
    "Application",
    "Guard",
    "bounded_connections",
]

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]
Headers = list[tuple[bytes, bytes]]

WRONG_HOST = 421
"""Misdirected Request (RFC 9110, 15.5.20)."""
FORBIDDEN = 403
POLICY_VIOLATION = 1008
"""Close code of a WebSocket (RFC 6455, 7.4.1); before it is accepted, the answer is 403."""


class Guard:
    """An ASGI application that lets through what may reach another one, and adds headers to its
    answers.

    Parameters
    ----------
    app
        What is guarded.
    port
        On which it is served, at 127.0.0.1.
    token
        The secret of the printed address.
    """

    def __init__(self, app: Application, *, port: int, token: str) -> None:
        self.app = app
        self.token = token.encode()
        self.cookie = f"workbench-{port}"
        self.hosts = [f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost")]
        self.origins = [b"http://" + host for host in self.hosts]
        self.headers = _security_headers(port)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or let it through."""
        if scope["type"] == "http":
            await self._http(scope, receive, send)
        elif scope["type"] == "websocket":
            allowed = (
                self._is_host(scope)
                and self._is_known(scope)
                and _one_of(_values(scope, b"origin"), self.origins)
            )
            if allowed:
                await self.app(scope, receive, send)
            else:
                await receive()
                await send({"type": "websocket.close", "code": POLICY_VIOLATION})
        else:
            await self.app(scope, receive, send)

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = list(message.get("headers", ()))
                own = {name for name, _ in given}  # a report has a policy of its own
                message["headers"] = [*given, *(row for row in self.headers if row[0] not in own)]
            await send(message)

        if not self._is_host(scope):
            await _refuse(guarded, WRONG_HOST, "This server has another name.")
        elif scope["method"] not in ("GET", "HEAD"):
            await _refuse(guarded, 405, "Only GET is served.")
        elif scope["path"] == "/" and b"token=" in scope["query_string"]:
            await self._enter(scope, guarded)
        elif not self._is_known(scope):
            await _refuse(guarded, FORBIDDEN, "Open the address that the bench has printed.")
        else:
            await self.app(scope, receive, guarded)

    async def _enter(self, scope: Scope, send: Send) -> None:
        """Exchange the token of the address for a cookie, so that it is in no history."""
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])
        if len(given) != 1 or not compare_digest(given[0].encode(), self.token):
            await _refuse(send, FORBIDDEN, "This address is that of a bench that has ended.")
            return
        cookie = f"{self.cookie}={self.token.decode()}; HttpOnly; SameSite=Strict; Path=/"
        headers = [(b"location", b"/"), (b"set-cookie", cookie.encode())]
        await _respond(send, 303, b"", headers)

    def _is_host(self, scope: Scope) -> bool:
        return _one_of(_values(scope, b"host"), self.hosts)

    def _is_known(self, scope: Scope) -> bool:
        """Whether a request carries the cookie, whatever other programs of this machine have set:
        cookies know no ports. Pairs stand apart by semicolons (RFC 6265, 5.4)."""
        own = b"%s=%s" % (self.cookie.encode(), self.token)
        lines = _values(scope, b"cookie")
        return any(compare_digest(pair.strip(), own) for line in lines for pair in line.split(b";"))


def _values(scope: Scope, name: bytes) -> list[bytes]:
    """The values of a header, one for each time it is given."""
    headers: Iterable[tuple[bytes, bytes]] = scope["headers"]
    return [value for key, value in headers if key.lower() == name]


def _one_of(given: list[bytes], valid: list[bytes]) -> bool:
    """Whether a header is given once, with a valid value."""
    return len(given) == 1 and any(compare_digest(given[0].lower(), one) for one in valid)


async def _refuse(send: Send, status: int, words: str) -> None:
    await _respond(send, status, words.encode(), [(b"content-type", b"text/plain; charset=utf-8")])


async def _respond(send: Send, status: int, body: bytes, headers: Headers) -> None:
    length = (b"content-length", str(len(body)).encode())
    await send({"type": "http.response.start", "status": status, "headers": [*headers, length]})
    await send({"type": "http.response.body", "body": body})


def _security_headers(port: int) -> Headers:
    """What a browser may do with the pages: load from here alone, and show them in no frame."""
    sockets = f"ws://127.0.0.1:{port} ws://localhost:{port}"
    policy = (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
        f"connect-src 'self' {sockets}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    )
    named = {
        "content-security-policy": policy,
        "x-content-type-options": "nosniff",
        "cache-control": "no-store",
        "referrer-policy": "no-referrer",
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-resource-policy": "same-origin",
    }
    return [(name.encode(), value.encode()) for name, value in named.items()]


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
