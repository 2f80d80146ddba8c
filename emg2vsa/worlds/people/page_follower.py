"""A session's pages over HTTP, for an emulated participant in another process: what they show now."""

from __future__ import annotations

import http.client
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict, fields
from typing import Any, Self
from urllib.parse import urlsplit

from emg2vsa.errors import DeviceError
from emg2vsa.session.views import ForceMessage, OperatorState, ParticipantState, PressView, Request

ANSWER_S, AGAIN_S = 5.0, 0.5
"Time in which a page must answer, and wait before it is asked again once it has been lost."
_NOTHING_YET = ParticipantState("wait", "", "main", 0, 0, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en")


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
    """The operator's page: what `emg2vsa.worlds.people.operator.EmulatedOperator` works with.

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
