"""The web server of the live pages, on this computer only unless another address is named, and who may come in."""

from __future__ import annotations

import errno
import ipaddress
import mimetypes
import secrets
import socket
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from secrets import compare_digest
from threading import Event, Thread
from typing import NamedTuple
from urllib.parse import urlsplit

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import BaseRoute, Mount, Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from emg2vsa.errors import SettingError

HOST = "127.0.0.1"
TOKEN_HEADER = "x-emg2vsa-token"
_UNREAD_MS = 10_000
"""A connection whose other end takes nothing for so long is cut: no crowd of them uses up the files of this process."""
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


def application(pages: Pages, tokens: Mapping[str, str], names: Sequence[str] = _NAMES) -> ASGIApp:
    """All pages, each behind the door with a token of its own; names : of this computer, as a browser may call it."""
    routes = [Mount(f"/{tokens[name]}/{name}", routes=routes) for name, routes in pages.items()]
    return Door(Starlette(routes=routes), tokens, names)


class Listening(NamedTuple):
    """Sockets that listen, on ``host`` as the printed addresses name it; names : this computer is called by there."""

    sockets: list[socket.socket]
    host: str
    port: int
    names: tuple[str, ...]


@contextmanager
def listening(port: int, bind: str | None = None) -> Iterator[Listening]:
    """Take the port, before anything begins that a port which is taken would end.

    Parameters
    ----------
    port : 0 for any that is free.
    bind : a further address of this computer, for a second screen or a tablet; the pages' addresses then name it.
        What is sent over it is not encrypted.

    Raises
    ------
    SettingError : the port is taken or not allowed; ``bind`` is no IPv4 address of this computer.
    """
    with ExitStack() as stack:
        sockets = [stack.enter_context(_listening(HOST, port))]
        port = sockets[0].getsockname()[1]
        if bind is not None and (bind := own_address(bind)) != HOST:
            sockets.append(stack.enter_context(_listening(bind, port)))
        yield Listening(sockets, bind or HOST, port, _NAMES if bind is None else (*_NAMES, bind))


def serve(pages: Pages, at: Listening, ready: Callable[..., None], until: Event | None = None) -> None:
    """Serve until Ctrl-C, SIGTERM or ``until``. ready : called once with the address of every page, in their order."""
    tokens = {name: secrets.token_urlsafe(16) for name in pages}
    config = uvicorn.Config(
        application(pages, tokens, at.names), log_level="critical", lifespan="off", timeout_graceful_shutdown=0
    )
    server = uvicorn.Server(config)
    if until is not None:
        Thread(target=_end, args=(server, until), daemon=True).start()
    ready(*(f"http://{at.host}:{at.port}/{token}/{name}/" for name, token in tokens.items()))
    server.run(sockets=at.sockets)


def _end(server: uvicorn.Server, until: Event) -> None:
    until.wait()
    server.should_exit = True


def own_address(text: str) -> str:
    """One IPv4 address; 0.0.0.0 would leave open by which name a browser may call this computer. SettingError : that,
    or no address."""
    try:
        address = ipaddress.IPv4Address(text)
    except ValueError:
        address = ipaddress.IPv4Address(0)
    if address.is_unspecified or address.is_multicast:
        do = "Name one IPv4 address of this computer, as its network settings show it (192.168.1.7)."
        raise SettingError("--bind", wanted="one address of this computer", found=repr(text), do=do)
    return str(address)


def _listening(host: str, port: int) -> socket.socket:
    """A socket on an address of this computer. SettingError where that, or the port, cannot be had."""
    own = socket.socket()
    own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if hasattr(socket, "TCP_USER_TIMEOUT"):  # Linux; accepted connections have it, too
        own.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNREAD_MS)
    try:
        own.bind((host, port))
        own.listen()  # whoever opens the address at once waits, and is not refused
    except OSError as error:
        own.close()
        found = error.strerror or str(error)
        if error.errno == errno.EADDRNOTAVAIL:
            do = "Name one IPv4 address of this computer, as its network settings show it."
            raise SettingError(f"--bind {host}", wanted="an address of this computer", found=found, do=do) from error
        raise SettingError(
            f"port {port}", wanted="a free port", found=found, do="Choose another port with --port."
        ) from error
    return own


def file_routes(*folders: Path) -> list[BaseRoute]:
    """The files of a page; index.html is the page itself."""
    files = sorted(path for folder in folders for path in folder.iterdir())
    return [_file("" if path.name == "index.html" else path.name, path) for path in files]


def _file(name: str, path: Path) -> Route:
    """Read now, so that many who come at once wait for no disk."""
    content, kind = path.read_bytes(), mimetypes.guess_type(path.name)[0]

    async def answer(request: Request) -> Response:
        return Response(content, media_type=kind)

    return Route(f"/{name}", answer)


class Door:
    """Lets in who calls this computer by its own name, and has the token of the page's printed address; 403 else.

    It wraps an application whose every path begins with a page's token and the page's name.

    A request that says it comes from another page (Origin) is refused. The Host header is checked because a foreign
    page can make its own name point to 127.0.0.1 (DNS rebinding). Whatever changes something must carry the token in a
    header as well: a foreign page can send a form here, but no such header.
    """

    def __init__(self, app: ASGIApp, tokens: Mapping[str, str], names: Sequence[str] = _NAMES) -> None:
        self._app, self._names = app, names
        self._tokens = {name: token.encode() for name, token in tokens.items()}

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
        if headers.get("host", "").partition(":")[0] not in self._names:
            return f"This page is shown under {' or '.join(self._names)} only.\n"
        parts: list[str] = [*scope["path"].split("/"), "", ""]
        token = self._tokens.get(parts[2], b"")
        if not token or not compare_digest(parts[1].encode(), token):
            return "Wrong address. Use the whole address that emg2vsa printed.\n"
        if (origin := headers.get("origin")) is not None and urlsplit(origin).netloc != headers["host"]:
            return "This page is shown to itself only.\n"
        changes = scope["method"] not in ("GET", "HEAD")
        if changes and not compare_digest(headers.get(TOKEN_HEADER, "").encode(), token):
            return "Use the button on the page.\n"
        return None
