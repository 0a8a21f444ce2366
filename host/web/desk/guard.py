"""The guard of the desk: it accepts only requests that have the token and limited size."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Awaitable, Callable, MutableMapping, Sequence
from http.cookies import CookieError, SimpleCookie
from typing import Any, cast
from urllib.parse import parse_qs

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from pathgene.host.numeric import whole


__all__ = ["BROWSER", "Guard", "LimitedProtocol"]


#: Maximum simultaneous connections: 32 tabs, each with the maximum number that a browser opens.
_MOST = 256
#: Seconds within which an idle connection must send a request.
_IDLE_S = 10.0


class LimitedProtocol(H11Protocol):
    """HTTP protocol that closes connections without requests.

    A connection is idle until it has sent the complete head of a request, and again once the
    request is answered. An idle connection is closed after ten seconds; if there are too many
    connections, the oldest idle one is closed immediately. A connection that waits for an answer,
    or is a WebSocket, is not disturbed.
    """

    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Accept a connection, and close another one if there are too many."""
        super().connection_made(cast(asyncio.Transport, transport))
        self._watch()
        if len(self.connections) > _MOST:
            # The new one may be among them.
            idle = {
                each._deadline.when(): each
                for each in self.connections
                if isinstance(each, LimitedProtocol) and each._deadline is not None
            }
            oldest = idle[min(idle)]
            oldest.transport.close()
            self.connections.discard(oldest)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        super().connection_lost(exc)
        self._forget()

    def handle_events(self) -> None:
        """Handle the bytes that have arrived."""
        super().handle_events()
        self._watch()

    def on_response_complete(self) -> None:
        """End an answer."""
        super().on_response_complete()
        self._watch()

    def _watch(self) -> None:
        """Set the deadline of an idle connection; bytes of the next request do not extend it."""
        if self.conn.our_state is not h11.IDLE:
            self._forget()
        elif self._deadline is None:
            self._deadline = self.loop.call_later(_IDLE_S, self.transport.close)

    def _forget(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None


Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

# Limit for everything except a file that is uploaded to the desk.
_MOST_BYTES = 1_000_000
_HEADERS = (
    # Nothing is loaded from elsewhere. The page has inline scripts and styles.
    (
        b"content-security-policy",
        b"default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; frame-ancestors 'none'; "
        b"form-action 'self'; base-uri 'none'",
    ),
    # The address contains the token.
    (b"referrer-policy", b"no-referrer"),
    (b"x-content-type-options", b"nosniff"),
)
_REFUSED = b"This desk asks for its token: open the whole address that pathgene desk has printed.\n"
_FOREIGN = b"This desk answers its own pages only; open it in a tab of its own.\n"
_TOO_LARGE = b"This is more than the desk takes; see pathgene desk --max-cells.\n"


#: Key of a scope for the browser that sends a request, as far as its cookies tell.
BROWSER = "pathgene.browser"


class Guard:
    """An application that only passes on requests with the token, from no page but its own.

    The token is in the query of the first address, ``?token=``, and in a cookie from then on. With
    it, each browser gets a name in a cookie, which the application finds in the scope under
    :data:`BROWSER`; a client without cookies is named by its address. A page of another origin on
    this machine has the cookies of the browser too, so a request or a WebSocket that names another
    ``Origin`` is refused.

    Parameters
    ----------
    port : int
        The port of the desk, which is part of the cookie's name, because cookies ignore ports.
    upload_bytes : int
        Maximum bytes of a file that is uploaded to the desk.
    """

    def __init__(self, app: App, token: str, port: int, upload_bytes: int) -> None:
        self.app = app
        self._token, self._upload_bytes = token, upload_bytes
        self._cookie = f"pathgene-desk-{port}"
        self._cookie_of_browser = f"pathgene-desk-{port}-browser"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        by_address = self._is_token(_query(scope))
        if not by_address and not self._is_token(self._cookie_of(scope, self._cookie)):
            await _refuse(scope, send, _REFUSED)
            return
        if not _is_own_page(scope):
            await _refuse(scope, send, _FOREIGN)
            return
        name = self._cookie_of(scope, self._cookie_of_browser)
        scope[BROWSER] = name or str((scope.get("client") or ("",))[0])
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
            return
        limited = _Limited(receive, self._most_bytes(scope))
        if limited.is_too_long(_header(scope, b"content-length")):
            await _answer(send, 413, _TOO_LARGE)
            return
        cookies = []
        if by_address and not name:
            cookies.append((self._cookie_of_browser, secrets.token_urlsafe(12)))
        if by_address:
            cookies.append((self._cookie, self._token))
        await self.app(scope, limited, _with_headers(send, cookies))

    def _is_token(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self._token.encode())

    def _cookie_of(self, scope: Scope, name: str) -> str:
        try:
            cookies = SimpleCookie(_header(scope, b"cookie"))
        except CookieError:
            return ""
        return cookies[name].value if name in cookies else ""

    def _most_bytes(self, scope: Scope) -> int:
        return self._upload_bytes if "/upload/" in scope["path"] else _MOST_BYTES


class _Limited:
    """The body of a request; if it is too long, it ends as if the browser had disconnected."""

    def __init__(self, receive: Receive, most: int) -> None:
        self._receive, self._most, self._taken = receive, most, 0

    def is_too_long(self, stated: str) -> bool:
        try:
            whole(stated, self._most)
        except ValueError:
            return stated.isdecimal()
        return False

    async def __call__(self) -> Message:
        message = await self._receive()
        self._taken += len(message.get("body", b""))
        if self._taken > self._most:
            return {"type": "http.disconnect"}
        return message


def _query(scope: Scope) -> str:
    query: bytes = scope.get("query_string", b"")
    return parse_qs(query.decode("latin-1")).get("token", [""])[0]


def _header(scope: Scope, name: bytes) -> str:
    headers: list[tuple[bytes, bytes]] = scope["headers"]
    return "; ".join(value.decode("latin-1") for key, value in headers if key == name)


def _is_own_page(scope: Scope) -> bool:
    """Return whether a request comes from a page of this server, or from no page."""
    origin = _header(scope, b"origin").lower()
    host = _header(scope, b"host").lower()
    # With a proxy that encrypts, the scheme is another one.
    return not origin or origin in (f"http://{host}", f"https://{host}")


def _with_headers(send: Send, cookies: Sequence[tuple[str, str]]) -> Send:
    """Return a sender that adds headers and cookies to the answer."""

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = [*message.get("headers", ()), *_HEADERS]
            for name, value in cookies:
                cookie = f"{name}={value}; HttpOnly; SameSite=Strict; Path=/"
                headers.append((b"set-cookie", cookie.encode()))
            message = {**message, "headers": headers}
        await send(message)

    return sending


async def _refuse(scope: Scope, send: Send, text: bytes) -> None:
    if scope["type"] == "websocket":
        # Before the connection is accepted, this becomes status 403.
        await send({"type": "websocket.close", "code": 1008})
        return
    await _answer(send, 403, text)


async def _answer(send: Send, status: int, text: bytes) -> None:
    # A refused client is disconnected.
    own = (b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")
    headers = [*own, *_HEADERS]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": text})
