"""A session's two pages over HTTP, as an emulation in another process follows them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.errors import DeviceError
from emg2vsa.session.views import ForceMessage, OperatorState, ParticipantState, PressView, Request, TraceMessage
from emg2vsa.worlds.people.pages import FollowedOperator, FollowedPage

STATE = ParticipantState("start", "", "main", 1, 10, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en")


class StillPage:
    """START, for ever."""

    def participant(self) -> ParticipantState:
        return STATE

    def force(self) -> ForceMessage:
        return ForceMessage(0, 0.0, 0.0, "none", "", "start")


class Door:
    """A session's two pages on a free port, for as long as a test lasts."""

    def __init__(self) -> None:
        self.addresses: tuple[str, ...] = ()
        self.ended, self.open = threading.Event(), threading.Event()

    def serve(self, desk: object) -> None:
        from emg2vsa.live.server import listening
        from emg2vsa.live.server import serve as serve_pages
        from emg2vsa.live.session_routes import session_pages

        with listening(0) as at:
            pages = session_pages(desk, WallClock())  # type: ignore[arg-type]
            serve_pages(pages, at, self._ready, until=self.ended)

    def _ready(self, *addresses: str) -> None:
        self.addresses = addresses
        self.open.set()


class ShortDesk(StillPage):
    """What the routes ask of a desk."""

    def __init__(self) -> None:
        self.specimen, self.number = "S1", 1
        self.asked: list[Request] = []

    def force(self) -> ForceMessage:
        self.number += 1
        return ForceMessage(self.number, 0.5, 1.25, "rising", "too fast", "press", 0.25)

    def operator(self) -> tuple[int, object]:
        presses = (PressView(1, "S1", "main", 1, 1, "ok"),)
        return self.number, OperatorState(
            "P03", "palpation", "start", "", "", self.specimen, "main", presses[0], presses, {"chair": False}
        )

    def ask(self, request: Request) -> str:
        self.asked.append(request)
        return "not yet" if request.name == "start" else ""

    def traces(self, after: int) -> tuple[int, object]:
        return after, TraceMessage([], [], {}, {}, {})


@pytest.fixture
def door() -> Iterator[tuple[Door, ShortDesk]]:
    pytest.importorskip("uvicorn")
    door, desk = Door(), ShortDesk()
    thread = threading.Thread(target=door.serve, args=(desk,), daemon=True)
    thread.start()
    assert door.open.wait(60)
    yield door, desk
    door.ended.set()
    thread.join(10)


def eventually(holds: Callable[[], bool]) -> bool:
    end_s = time.monotonic() + 60
    while not holds() and time.monotonic() < end_s:
        time.sleep(0.01)
    return holds()


def test_pages_are_followed_over_http(door: tuple[Door, ShortDesk]) -> None:
    pages, desk = door
    operator, participant = (next(a for a in pages.addresses if f"/{n}/" in a) for n in ("operator", "participant"))
    placed: list[str] = []
    with FollowedPage(participant) as page, FollowedOperator(operator, placed.append) as asked:
        assert eventually(lambda: page.force().sequence > 1 and placed == ["S1"])
        assert page.participant() == STATE
        assert page.force()[2:] == (1.25, "rising", "too fast", "press", 0.25)
        desk.specimen = "S5"
        assert eventually(lambda: placed == ["S1", "S5"])
        assert (asked.operator()[1].specimen, asked.operator()[1].presses[0].verdict) == ("S5", "ok")
        assert asked.ask(Request("check", item="chair")) == ""
        assert asked.ask(Request("start")) == "not yet"
        assert asked.ask(Request("dance")).startswith("name: expected one of")
        assert desk.asked == [Request("check", item="chair"), Request("start")]


@pytest.mark.parametrize("address", ["http://127.0.0.1:9/x/participant/", "nonsense", "http://127.0.0.1:no/"])
def test_an_address_without_a_page_is_named(address: str) -> None:
    with pytest.raises(DeviceError, match=r"a page of a running session"):
        FollowedPage(address)
