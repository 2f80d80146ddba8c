"""The web server of the live pages, on this computer only, and who may come in."""

from __future__ import annotations

import secrets
import socket
from collections.abc import Callable, Mapping, Sequence
from secrets import compare_digest
from urllib.parse import urlsplit

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.routing import BaseRoute, Mount
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from emg2vsa.errors import SettingError

HOST = "127.0.0.1"
TOKEN_HEADER = "x-emg2vsa-token"
_NAMES = (HOST, "localhost")
_HEADERS = {
    "content-security-policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}

Pages = Mapping[str, Sequence[BaseRoute]]
"""First part of the address to the routes of a page."""


def application(pages: Pages, token: str) -> ASGIApp:
    """All pages, behind the door."""
    routes = [Mount(f"/{token}/{name}", routes=routes) for name, routes in pages.items()]
    return Door(Starlette(routes=routes), token)


def serve(pages: Pages, port: int, ready: Callable[[str], None]) -> None:
    """Serve until Ctrl-C or SIGTERM.

    Parameters
    ----------
    port : 0 for any that is free.
    ready : called once with the address of the first page.

    Raises
    ------
    SettingError : the port is taken or not allowed.
    """
    token = secrets.token_urlsafe(16)
    with _listening(port) as listening:
        config = uvicorn.Config(
            application(pages, token), log_level="critical", lifespan="off", timeout_graceful_shutdown=1
        )
        ready(f"http://{HOST}:{listening.getsockname()[1]}/{token}/{next(iter(pages))}/")
        uvicorn.Server(config).run(sockets=[listening])


def _listening(port: int) -> socket.socket:
    listening = socket.socket()
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen()  # whoever opens the address at once waits, and is not refused
    except OSError as error:
        listening.close()
        found = error.strerror or str(error)
        raise SettingError(
            f"port {port}", wanted="a free port", found=found, do="Choose another with --port."
        ) from error
    return listening


class Door:
    """Lets in who is on this computer, calls it by its own name, and has the token of the printed address; 403 else.

    It wraps an application whose every path begins with the token.

    A request that says it comes from another page (Origin) is refused. The Host header is checked because a foreign
    page can make its own name point to 127.0.0.1 (DNS rebinding). Whatever changes something must carry the token in a
    header as well: a foreign page can send a form here, but no such header.
    """

    def __init__(self, app: ASGIApp, token: str) -> None:
        self._app, self._token = app, token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(_HEADERS)
            await send(message)

        refused = self._refused(scope)
        app = self._app if refused is None else PlainTextResponse(refused, status_code=403)
        await app(scope, receive, guarded)

    def _refused(self, scope: Scope) -> str | None:
        headers = Headers(scope=scope)
        if headers.get("host", "").partition(":")[0] not in _NAMES:
            return "This page is shown under 127.0.0.1 or localhost only.\n"
        if not compare_digest(scope["path"].split("/")[1].encode(), self._token):
            return "Wrong address. Use the whole address that emg2vsa printed.\n"
        if (origin := headers.get("origin")) is not None and urlsplit(origin).netloc != headers["host"]:
            return "This page is shown to itself only.\n"
        changes = scope["method"] not in ("GET", "HEAD")
        if changes and not compare_digest(headers.get(TOKEN_HEADER, "").encode(), self._token):
            return "Use the button on the page.\n"
        return None
