"""Who is at a session's pages: an emulated operator, and both pages over HTTP for an emulation in another process."""

from __future__ import annotations

import http.client
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict, fields
from typing import Any, Protocol, Self
from urllib.parse import urlsplit

from emg2vsa.errors import DeviceError
from emg2vsa.session.views import ForceMessage, OperatorState, ParticipantState, PressView, Request

THINKING_S, START_S = 0.3, 1.0
"Between two looks at the page; and from a participant who is ready to START: sooner, no press could be early."
ANSWER_S, AGAIN_S = 5.0, 0.5
"Time in which a page must answer, and wait before it is asked again once it has been lost."
_NOTHING_YET = ParticipantState("wait", "", "main", 0, 0, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en")


class Asked(Protocol):
    """What the operator works with."""

    def operator(self) -> tuple[int, OperatorState]:
        """The newest state, and its number."""

    def ask(self, request: Request) -> str:
        """Ask for something; why it is refused, or ""."""


class EmulatedOperator:
    """Call ``turn`` often. A rejected press is repeated as long as that is allowed, and accepted then.

    place : puts a specimen on the table. most_presses : ends the session after so many attempts; None: when all are
    done.
    """

    def __init__(self, desk: Asked, place: Callable[[str], None], most_presses: int | None = None) -> None:
        self._desk, self._place, self._most_presses = desk, place, most_presses
        self._seen = -1
        self._act_at_s = 0.0
        self._on_table = ""
        self._ready_s: float | None = None

    def turn(self, now_s: float) -> None:
        """Do what is due by ``now_s``, s."""
        if now_s < self._act_at_s:
            return
        self._act_at_s = now_s + THINKING_S
        _, state = self._desk.operator()
        if state.command != "ready":
            self._ready_s = None
        elif self._ready_s is None:
            self._ready_s = now_s
        if state.ended:
            return
        begun = sum(bool(press.verdict) for press in state.presses)
        if self._most_presses is not None and begun >= self._most_presses and state.awaits != "verdict":
            self._desk.ask(Request("end"))
            return
        match state.awaits:
            case "quality":
                self._desk.ask(Request("measure-rest"))
            case "contraction":
                self._desk.ask(Request("measure-contraction"))
            case "specimen":
                self._put(state.specimen)
            case "checklist":
                for item in (item for item, done in state.checklist.items() if not done):
                    self._desk.ask(Request("check", item=item))
            case "start" if self._ready_s is not None and now_s - self._ready_s >= START_S:
                self._desk.ask(Request("start"))
            case "verdict":
                if self._desk.ask(Request("repeat")):
                    self._desk.ask(Request("accept"))
            case "end":
                self._desk.ask(Request("end"))
            case _ if "continue" in state.commands and state.command == "pause":
                self._desk.ask(Request("continue"))

    def _put(self, specimen: str) -> None:
        """Put it there, and confirm it once the hands are off."""
        if self._on_table != specimen:
            self._on_table = specimen
            self._place(specimen)
        else:
            self._desk.ask(Request("placed"))


class _Events:
    """Server-sent events of one page, handed to ``take`` in a thread of their own within a with statement."""

    def __init__(self, address: str, take: Callable[[str, dict[str, Any]], None]) -> None:
        """DeviceError when there is no page at ``address``, which is the one that emg2vsa session prints."""
        self._address, self._take = address, take
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._follow, name=f"follows {address}", daemon=True)
        self._line, self._answer = self._asked()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._line.close()

    def _asked(self) -> tuple[http.client.HTTPConnection, http.client.HTTPResponse]:
        where = urlsplit(self._address)
        try:
            line = http.client.HTTPConnection(where.hostname or "", where.port or 80, timeout=ANSWER_S)
            line.request("GET", where.path.rstrip("/") + "/stream")
            answer = line.getresponse()
        except (OSError, ValueError, http.client.HTTPException) as error:
            raise self._no_page(str(error)) from error
        if answer.status != http.client.OK:
            raise self._no_page(f"HTTP status {answer.status}")
        return line, answer

    def _no_page(self, found: str) -> DeviceError:
        do = "Give the whole address that emg2vsa session prints, while it runs."
        return DeviceError(self._address, wanted="a page of a running session", found=found, do=do)

    def _follow(self) -> None:
        while not self._ended.is_set():
            try:
                for name, content in _events(self._answer):
                    self._take(name, content)
            except (OSError, ValueError, AttributeError, TypeError, KeyError, http.client.HTTPException):
                pass  # the connection was lost, or closed by the end of this
            if self._ended.wait(AGAIN_S):
                return
            try:
                self._line, self._answer = self._asked()
            except DeviceError:
                continue


def _events(answer: http.client.HTTPResponse) -> Iterator[tuple[str, dict[str, Any]]]:
    """Name and content of each event, until the connection ends."""
    name, data = "", ""
    for raw in answer:
        line = raw.decode("utf-8").rstrip("\r\n")
        if not line:
            if data:
                yield name, json.loads(data)
            name, data = "", ""
        elif line.startswith("event:"):
            name = line[6:].strip()
        elif line.startswith("data:"):
            data += line[5:].strip()


class FollowedPage(_Events):
    """The participant's page: a `emg2vsa.worlds.people.participant.Page`."""

    def __init__(self, address: str) -> None:
        self._state, self._force = _NOTHING_YET, ForceMessage(0, 0.0, 0.0, "none", "", "wait")
        super().__init__(address, self._seen)

    def participant(self) -> ParticipantState:
        """The newest."""
        return self._state

    def force(self) -> ForceMessage:
        """The newest."""
        return self._force

    def _seen(self, name: str, content: dict[str, Any]) -> None:
        if name == "state":
            known = {field.name for field in fields(ParticipantState)}
            pairs: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in content.items()}
            self._state = ParticipantState(**{key: value for key, value in pairs.items() if key in known})
        elif not name:
            self._force = ForceMessage(*(content[key] for key in ForceMessage._fields))


class FollowedOperator(_Events):
    """The operator's page: what `EmulatedOperator` works with.

    place : called with the specimen that the page names, whenever that is another; None: whoever asks here does it.
    """

    def __init__(self, address: str, place: Callable[[str], None] | None = None) -> None:
        self._place, self._specimen = place, ""
        self._number, self._state = 0, OperatorState("", "", "wait", "", "", "", "quality", None)
        super().__init__(address, self._seen)

    def operator(self) -> tuple[int, OperatorState]:
        """The newest state, and its number."""
        return self._number, self._state

    def ask(self, request: Request) -> str:
        """Ask for something as the page does; why it is refused, or ""."""
        where = urlsplit(self._address)
        headers = {"x-emg2vsa-token": where.path.split("/")[1], "content-type": "application/json"}
        try:
            line = http.client.HTTPConnection(where.hostname or "", where.port or 80, timeout=ANSWER_S)
            line.request("POST", where.path.rstrip("/") + "/request", json.dumps(asdict(request)), headers)
            answer = line.getresponse()
            said = answer.read().decode("utf-8", "replace")
            line.close()
        except (OSError, http.client.HTTPException) as error:
            return str(error)
        return "" if answer.status == http.client.OK else said or f"HTTP status {answer.status}"

    def _seen(self, name: str, content: dict[str, Any]) -> None:
        if name != "state":
            return
        known = {field.name for field in fields(OperatorState)} - {"press", "presses", "devices", "signals", "fits"}
        plain: dict[str, Any] = {key: value for key, value in content.items() if key in known}
        presses = tuple(PressView(**press) for press in content["presses"])
        self._number, self._state = self._number + 1, OperatorState(**plain, press=None, presses=presses)
        if self._place is not None and self._state.specimen not in ("", self._specimen):
            self._specimen = self._state.specimen
            self._place(self._specimen)
