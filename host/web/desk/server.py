"""The server of the desk: NiceGUI protected by a guard, and the files of saved plans."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI, Request, Response
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import Client, core, ui
from nicegui import app as pages

from pathgene.host import interrupts
from pathgene.host.errors import InputError
from pathgene.host.terrain.untrusted import MAX_CELLS
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.guard import BROWSER, Guard, LimitedProtocol
from pathgene.host.web.desk.page import Page
from pathgene.host.web.desk.tabs import Tabs


__all__ = ["serve"]

_FOLDER = Path(__file__).parent
_STYLES = [
    file.read_text(encoding="utf-8")
    for file in (_FOLDER.parent / "colours.css", _FOLDER / "desk.css")
]
# Bytes of a cell in the largest common format, and of the file around the cells.
_CELL_BYTES, _AROUND_BYTES = 8, 1_000_000
_ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">'
    '<rect width="32" height="32" rx="7" fill="#0a4f8f"/>'
    '<path d="M5 25 12 13l5 6 6-11 4 6" fill="none" stroke="#fff" stroke-width="3" '
    'stroke-linejoin="round" stroke-linecap="round"/></svg>'
)


def serve(desk: Desk, host: str, port: int, ready: Callable[[str], object]) -> None:
    """Serve a desk until a signal; then end its jobs and save their plans.

    Parameters
    ----------
    port : int
        Port; 0 chooses a free one.
    ready : callable
        Called with the address to open once the server answers.

    Raises
    ------
    InputError
        If nothing can listen there.
    """
    # NiceGUI would log each request for an unknown address.
    logging.getLogger("nicegui").setLevel(logging.ERROR)
    # NiceGUI lets pages of all origins in, and tells their browsers so; the guard lets in none.
    core.sio.eio.cors_allowed_origins = []
    token = secrets.token_urlsafe(24)
    with _listening(host, port) as listener:
        number = listener.getsockname()[1]
        name = f"[{host}]" if ":" in host else host
        address = f"http://{name}:{number}/?token={token}"
        app = _application(desk, address)
        upload_bytes = _CELL_BYTES * (desk.terrains.max_cells or MAX_CELLS) + _AROUND_BYTES
        config = uvicorn.Config(
            Guard(app, token, number, upload_bytes),
            log_level="warning",
            http=LimitedProtocol,
            ws="wsproto",
            ws_max_size=1 << 20,
            timeout_graceful_shutdown=2,
        )
        server = _Server(config)
        with interrupts.instead(server.end):
            asyncio.run(_serve(server, listener, lambda: ready(address)))


class _Server(uvicorn.Server):
    """A server that leaves signals to the command."""

    def end(self) -> None:
        """Ask the server to end."""
        self.should_exit = True

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave the signal handlers unchanged."""
        yield


async def _serve(server: uvicorn.Server, listener: socket.socket, ready: Callable[[], Any]) -> None:
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    while not server.started and not serving.done():
        await asyncio.sleep(0.01)
    if server.started:
        ready()
    await serving


def _listening(host: str, port: int) -> socket.socket:
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(
            f"Nothing can listen at {host}:{port} ({reason}); give another --host or --port."
        ) from None
    return listener


def _application(desk: Desk, address: str) -> FastAPI:
    app = FastAPI(openapi_url=None)

    @app.get("/meshes/{key}")
    def mesh(key: str) -> Response:
        content = desk.mesh(key)
        if content is None:
            return PlainTextResponse("No such terrain.", 404)
        caching = {"Cache-Control": "private, max-age=31536000, immutable"}
        return Response(content, media_type="application/json", headers=caching)

    @app.get("/plans/{plan}/{name}")
    def plan_file(plan: str, name: str) -> Response:
        file = desk.file(plan, name)
        if file is None:
            return PlainTextResponse("No such file.", 404)
        return FileResponse(file, filename=name)

    # NiceGUI would build a page for each request, and keep it for a minute.
    @pages.exception_handler(404)
    async def missing(_request: Request, _error: Exception) -> Response:
        return PlainTextResponse("No such page; the desk has one, at /.\n", 404)

    tabs = Tabs()

    @ui.page("/")
    def page(request: Request, client: Client) -> None:
        for style in _STYLES:
            ui.add_css(style)
        if not tabs.admit(client, request.scope[BROWSER]):
            ui.label("Too many tabs of this desk are open; close one, and load this one again.")
            return
        # The name that the browser uses, which may be another name of this machine.
        Page(desk, f"{request.base_url}?{address.partition('?')[2]}")

    ui.run_with(
        app,
        title="pathgene desk",
        favicon=_ICON,
        dark=None,
        tailwind=False,
        show_welcome_message=False,
        # A tab that disconnects for less time continues.
        reconnect_timeout=30.0,
        # Modules of another version of pathgene have the same address.
        cache_control_directives="no-cache",
    )
    return app
