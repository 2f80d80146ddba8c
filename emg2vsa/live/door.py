"""Who may come in: this computer only, by its own name, and with the token of the printed address."""

from __future__ import annotations

from secrets import compare_digest

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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


class Door:
    """Wraps an application whose every path begins with the token; 403 for everybody else.

    The Host header is checked because a foreign page can make its own name point to 127.0.0.1 (DNS rebinding). Whatever
    changes something must carry the token in a header as well: a foreign page can send a form here, but no such header.
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
        changes = scope["method"] not in ("GET", "HEAD")
        if changes and not compare_digest(headers.get(TOKEN_HEADER, "").encode(), self._token):
            return "Use the button on the page.\n"
        return None
