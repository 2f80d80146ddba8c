"""The addresses of a session's two pages: what they show goes down as server-sent events, what they ask comes up."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from starlette.requests import Request as WebRequest
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from emg2vsa.devices.clock import Clock, FastClock
from emg2vsa.live.server import Pages, file_routes
from emg2vsa.session.desk import SessionDesk
from emg2vsa.session.views import REQUESTS, ForceMessage, Request, ScreenReport

_FORCE_PERIOD_S = 0.004
"""A little shorter than that of the messages, so that none waits long to be fetched."""
_OPERATOR_PERIOD_S = 0.05
_SILENT_S = 0.5
"""After so long without news the operator's page is told that there is a connection."""
MOST_VIEWERS = 6
"""Most viewers of each page at once. A page that is opened again leaves its place. A further one takes the place of the
one that has been silent for longest, and is refused where none has been for `_GONE_S`.
"""
_GONE_S = 3.0
"""A participant's page tells of itself every second; an operator's takes what it is sent."""
_LARGEST_MS, _MOST_COMMANDS = 5000.0, 20
"""Largest delay that a page may tell of itself, and most new commands in one report."""
_LARGEST_BODY = 10_000
_LARGEST_FIGURE = 1e9
_PAGE = "page"
"""Key in the addresses that a participant's page asks for: which page it is."""
_MORE = ("width", "height", "pixel_ratio", "messages", "full_screen")
"""What the participant's page may say of its screen beyond its figures."""
_PAGES = Path(__file__).parent / "page"


def session_pages(desk: SessionDesk, clock: Clock) -> Pages:
    """The pages "operator" and "participant" of a session. clock : the one that the session's times are on.

    A page fetches the newest from the desk when it can take it, so one that is slow misses messages and holds nobody
    up. Events of the operator: "state", "participant", "traces", "alive"; of the participant: "state", and forces
    without a name.
    """
    return {"operator": _operator_routes(desk), "participant": _participant_routes(desk, clock)}


def _operator_routes(desk: SessionDesk) -> list[BaseRoute]:
    async def ask(request: WebRequest) -> Response:
        try:
            wanted = operator_request(await _document(request))
        except ValueError as error:
            return PlainTextResponse(str(error), status_code=400)
        refused = desk.ask(wanted)
        return PlainTextResponse(refused, status_code=409 if refused else 200)

    stream = _Stream(_OperatorEvents(desk).of_viewer, told=False)
    files = file_routes(_PAGES / "operator", _PAGES / "shared")
    return [Route("/stream", stream.answer), Route("/request", ask, methods=["POST"]), *files]


def _participant_routes(desk: SessionDesk, clock: Clock) -> list[BaseRoute]:
    async def screen(request: WebRequest) -> Response:
        try:
            report = screen_report(await _document(request))
        except ValueError as error:
            return PlainTextResponse(str(error), status_code=400)
        stream.hear(request.query_params.get(_PAGE, ""))
        desk.screen(report)
        return PlainTextResponse("")

    async def server_clock(request: WebRequest) -> Response:
        return JSONResponse({"server_s": time.perf_counter()})

    stream = _Stream(lambda: participant_events(desk, clock), told=True)
    return [
        Route("/stream", stream.answer),
        Route("/screen", screen, methods=["POST"]),
        Route("/clock", server_clock),
        *file_routes(_PAGES / "participant"),
    ]


@dataclass
class _Viewer:
    """page : its own name. answers : the task of its request. heard_s : when it last showed that it is there."""

    page: str
    answers: asyncio.Task[Any] | None
    heard_s: float


class _Stream:
    """Events for a few viewers at once. told : a page tells of itself; else it is there while it takes its events."""

    def __init__(self, events: Callable[[], AsyncIterator[str]], told: bool) -> None:
        self._events, self._told = events, told
        self._viewers: list[_Viewer] = []

    def hear(self, page: str) -> None:
        """A page has told of itself."""
        for viewer in self._viewers:
            if viewer.page == page:
                viewer.heard_s = time.monotonic()

    async def answer(self, request: WebRequest) -> Response:
        now_s = time.monotonic()
        if len(self._viewers) >= MOST_VIEWERS:
            silent = min(self._viewers, key=lambda viewer: viewer.heard_s)
            if now_s - silent.heard_s < _GONE_S:
                return PlainTextResponse("This page is open too often. Close the others.", status_code=503)
            self._viewers.remove(silent)
            if silent.answers is not None:
                silent.answers.cancel()
        viewer = _Viewer(request.query_params.get(_PAGE, ""), asyncio.current_task(), now_s)
        self._viewers.append(viewer)
        return StreamingResponse(self._sent(viewer), media_type="text/event-stream")

    async def _sent(self, viewer: _Viewer) -> AsyncIterator[str]:
        try:
            yield "retry: 500\n\n"
            async for text in self._events():
                if not self._told:
                    viewer.heard_s = time.monotonic()
                yield text
        finally:
            self._leave(viewer)

    def _leave(self, viewer: _Viewer) -> None:
        if viewer in self._viewers:
            self._viewers.remove(viewer)


async def participant_events(desk: SessionDesk, clock: Clock) -> AsyncIterator[str]:
    """The state whenever it changes, and each new force."""
    state, sequence = None, None
    factor = clock.factor if isinstance(clock, FastClock) else 1.0
    while True:
        text = ""
        if (new := desk.participant()) is not state and new != state:
            state, text = new, _event("state", asdict(new))
        force = desk.force()
        if force.sequence != sequence:
            sequence, text = force.sequence, text + _force_event(force, (clock.now_s() - force.time_s) / factor)
        if text:
            yield text
        await asyncio.sleep(_FORCE_PERIOD_S)


def _force_event(force: ForceMessage, age_s: float) -> str:
    """With its age when sent, and when that was on the server's own clock, which the page compares with its own."""
    sent = {"age_s": round(age_s, 5), "sent_s": round(time.perf_counter(), 5)}
    rounded = {"force_n": round(force.force_n, 4)}
    rounded |= {"time_s": round(force.time_s, 5), "command_s": round(force.command_s, 5)}
    return _event("", force._asdict() | rounded | sent)


class _OperatorEvents:
    """The state is written out once for all who see it. "participant" is what the participant's page shows."""

    def __init__(self, desk: SessionDesk) -> None:
        self._desk = desk
        self._number, self._text = -1, ""

    async def of_viewer(self) -> AsyncIterator[str]:
        seen, shown, after, silent = None, None, 0, 0
        while True:
            number, state = self._desk.operator()
            if number != self._number:
                self._number, self._text = number, _event("state", asdict(state))
            text = "" if number == seen else self._text
            seen = number
            if (participant := self._desk.participant()) != shown:
                shown, text = participant, text + _event("participant", asdict(participant))
            after, traces = self._desk.traces(after)
            if traces.time_s:
                text += _event("traces", asdict(traces))
            silent = 0 if text else silent + 1
            if silent * _OPERATOR_PERIOD_S >= _SILENT_S:
                silent, text = 0, _event("alive", {})
            if text:
                yield text
            await asyncio.sleep(_OPERATOR_PERIOD_S)


def _event(name: str, content: dict[str, Any]) -> str:
    head = f"event: {name}\n" if name else ""
    return f"{head}data: {json.dumps(content, separators=(',', ':'), ensure_ascii=False)}\n\n"


async def _document(request: WebRequest) -> dict[str, Any]:
    """The JSON object that was sent. ValueError in words for whoever sent it."""
    body = b""
    async for piece in request.stream():
        body += piece
        if len(body) > _LARGEST_BODY:
            raise ValueError(f"expected at most {_LARGEST_BODY} bytes")
    try:
        document = json.loads(body.decode(), parse_constant=_not_finite)
    except RecursionError as error:
        raise ValueError("expected a JSON object, but found lists within lists") from error
    if not isinstance(document, dict):
        raise ValueError(f"expected a JSON object, but found {type(document).__name__}")
    return document


def _not_finite(name: str) -> float:
    raise ValueError(f"expected finite numbers, but found {name}")


def operator_request(document: dict[str, Any]) -> Request:
    """ValueError for anything that is no request of the operator's page."""
    _only(document, ("name", "press", "item", "text"))
    name, press = document.get("name"), document.get("press")
    if name not in REQUESTS:
        raise ValueError(f"name: expected one of {', '.join(REQUESTS)}, but found {name!r}")
    if press is not None and (type(press) is not int or press < 1):
        raise ValueError(f"press: expected the number of a press, but found {press!r}")
    item, text = document.get("item", ""), document.get("text", "")
    for key, value in (("item", item), ("text", text)):
        if not isinstance(value, str):
            raise ValueError(f"{key}: expected a text, but found {value!r}")
        if any("\ud800" <= sign <= "\udfff" for sign in value):
            raise ValueError(f"{key}: expected a text in Unicode, but found half of a surrogate pair")
    return Request(name, press, item, text)


def screen_report(document: dict[str, Any]) -> ScreenReport:
    """ValueError for anything that is no report of the participant's page, or tells what no page can."""
    figures = ("frames_per_s", "age_p50_ms", "age_p95_ms", "longest_frame_ms")
    _only(document, (*figures, "command_ms", "hidden", "more"))
    values = {key: _figure(key, document.get(key)) for key in figures}
    hidden, more, commands = document.get("hidden"), document.get("more", {}), document.get("command_ms", [])
    if not isinstance(hidden, bool):
        raise ValueError(f"hidden: expected true or false, but found {hidden!r}")
    if not isinstance(commands, list) or len(commands) > _MOST_COMMANDS:
        raise ValueError(f"command_ms: expected at most {_MOST_COMMANDS} numbers")
    command_ms = tuple(_figure("command_ms", value) for value in commands)
    if not isinstance(more, dict):
        raise ValueError(f"more: expected an object, but found {type(more).__name__}")
    _only(more, _MORE)
    for key, value in more.items():
        if not isinstance(value, int | float) or not abs(value) < _LARGEST_FIGURE:
            raise ValueError(f"more, {key}: expected a number, true or false, but found {str(value)[:40]!r}")
    return ScreenReport(**values, hidden=hidden, more=more, command_ms=command_ms)


def _figure(key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= _LARGEST_MS:
        raise ValueError(f"{key}: expected a number from 0 to {_LARGEST_MS:g}, but found {str(value)[:40]!r}")
    return float(value)


def _only(document: dict[str, Any], known: tuple[str, ...]) -> None:
    if unknown := sorted(set(document) - set(known)):
        raise ValueError(f"expected {', '.join(known)}, but found {unknown[0]!r}")
