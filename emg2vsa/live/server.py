"""The web server of the live pages, on this computer only."""

from __future__ import annotations

import secrets
import socket
from collections.abc import Callable, Mapping, Sequence

import uvicorn
from starlette.applications import Starlette
from starlette.routing import BaseRoute, Mount
from starlette.types import ASGIApp

from emg2vsa.errors import SettingError
from emg2vsa.live.door import HOST, Door

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
