"""Who may see a session's pages, what they are sent, and what they may send."""

from __future__ import annotations

import asyncio
import errno
import http.client
import json
import re
import socket
import sys
import threading
import time
import urllib.error
import urllib.request
from dataclasses import fields
from types import SimpleNamespace

import pytest
from starlette.testclient import TestClient

from emg2vsa.devices.clock import VirtualClock, WallClock, undisturbed
from emg2vsa.errors import SettingError
from emg2vsa.live import server, session_routes
from emg2vsa.live.server import HOST, TOKEN_HEADER, application, listening, own_address, serve
from emg2vsa.live.session_routes import MOST_VIEWERS, participant_events, session_pages
from emg2vsa.session.views import OperatorState, ParticipantState, Request
from tests.live.scripted_desk import PLAN, ScriptedDesk

TOKENS = {"operator": "of-the-operator", "participant": "of-the-participant"}
OPERATOR, PARTICIPANT = (f"/{token}/{name}" for name, token in TOKENS.items())
REPORT = {"frames_per_s": 60.0, "age_p50_ms": 3, "age_p95_ms": 8.5, "longest_frame_ms": 17.0, "hidden": False}


@pytest.fixture
def clock():
    return VirtualClock()


@pytest.fixture
def desk(clock):
    return ScriptedDesk(clock, "start")


@pytest.fixture
def client(desk, clock):
    pages = application(session_pages(desk, clock), TOKENS)
    return TestClient(pages, base_url="http://127.0.0.1:8420")


def asked(client, content, at=OPERATOR, token=TOKENS["operator"]):
    return client.post(f"{at}/request", content=content, headers={TOKEN_HEADER: token})


def reported(client, content):
    headers = {TOKEN_HEADER: TOKENS["participant"]}
    return client.post(f"{PARTICIPANT}/screen", content=json.dumps(content), headers=headers)


@pytest.mark.parametrize("page", [OPERATOR, PARTICIPANT])
def test_each_address_shows_its_page(client, page):
    shown = client.get(f"{page}/")
    assert shown.status_code == 200
    named = re.findall(r'(?:href|src)="([^":]+)"', shown.text)
    script = client.get(f"{page}/{named[-1]}").text
    for name in named + re.findall(r'from "\./(.+?)"', script):
        assert client.get(f"{page}/{name}").status_code == 200


@pytest.mark.parametrize("path", ["/", "/stream", "/request", "/operator.js"])
def test_the_participants_token_opens_nothing_of_the_operators(client, path):
    assert client.get(f"/{TOKENS['participant']}/operator{path}").status_code == 403
    assert client.get(f"{PARTICIPANT}/request").status_code == 404


def test_the_operators_token_opens_its_own_page_only(client):
    assert client.get(f"/{TOKENS['operator']}/participant/").status_code == 403
    assert client.get(f"/{TOKENS['operator']}/").status_code == 403


@pytest.mark.parametrize("token", ["", "another", TOKENS["participant"]])
def test_a_command_with_another_token_is_refused(client, desk, token):
    assert asked(client, '{"name": "start"}', token=token).status_code == 403
    assert desk.asked == []


def test_the_participants_page_takes_no_commands(client, desk):
    answer = asked(client, '{"name": "start"}', PARTICIPANT, TOKENS["participant"])
    assert answer.status_code == 404
    assert desk.asked == []


def test_a_command_reaches_the_session(client, desk):
    assert asked(client, '{"name": "start", "press": null}').status_code == 200
    assert asked(client, '{"name": "note", "press": 1, "text": "äh"}').status_code == 200
    assert desk.asked == [Request("start"), Request("note", 1, text="äh")]


def test_what_the_session_refuses_is_said(client):
    answer = asked(client, '{"name": "continue"}')
    assert (answer.status_code, answer.text) == (409, "continue is not possible now.")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "Expecting value"),
        ("start", "Expecting value"),
        ("[]", "expected a JSON object, but found list"),
        ("[" * 5000, "lists within lists"),
        ("{}", "name: expected one of"),
        ('{"name": "begin"}', "name: expected one of measure-rest, .+, but found 'begin'"),
        ('{"name": ["start"]}', "name: expected one of"),
        ('{"name": "repeat", "press": "3"}', "press: expected the number of a press, but found '3'"),
        ('{"name": "repeat", "press": 0}', "press: expected the number of a press, but found 0"),
        ('{"name": "repeat", "press": true}', "press: expected the number of a press, but found True"),
        ('{"name": "check", "item": 1}', "item: expected a text, but found 1"),
        ('{"name": "note", "text": null}', "text: expected a text, but found None"),
        ('{"name": "note", "text": "\\ud83d"}', "text: expected a text in Unicode"),
        ('{"name": "start", "specimen": "S1"}', "expected name, press, item, text, but found 'specimen'"),
        (json.dumps({"name": "note", "text": "x" * 10_000}), "expected at most 10000 bytes"),
    ],
)
def test_what_is_no_command_is_refused(client, desk, content, said):
    answer = asked(client, content)
    assert answer.status_code == 400
    assert re.search(said, answer.text)
    assert desk.asked == []


def test_the_screen_tells_how_well_it_draws(client, desk):
    assert reported(client, REPORT | {"more": {"width": 1920, "full_screen": True}}).status_code == 200
    (report,) = desk.screens
    assert (report.frames_per_s, report.age_p95_ms, report.hidden) == (60.0, 8.5, False)
    assert report.more == {"width": 1920, "full_screen": True}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frames_per_s": None}, "frames_per_s: expected a number from 0 to 5000, but found 'None'"),
        ({"age_p95_ms": "8"}, "age_p95_ms: expected a number from 0 to 5000, but found '8'"),
        ({"age_p50_ms": -0.1}, "age_p50_ms: expected a number from 0 to 5000, but found '-0.1'"),
        ({"longest_frame_ms": 5000.1}, "longest_frame_ms: expected a number from 0 to 5000"),
        ({"command_ms": [20, -1]}, "command_ms: expected a number from 0 to 5000, but found '-1'"),
        ({"command_ms": 20}, "command_ms: expected at most 20 numbers"),
        ({"command_ms": [1] * 21}, "command_ms: expected at most 20 numbers"),
        ({"age_p50_ms": True}, "age_p50_ms: expected a number"),
        ({"age_p50_ms": 10**400}, "age_p50_ms: expected a number"),
        ({"longest_frame_ms": float("nan")}, "expected finite numbers, but found NaN"),
        ({"hidden": 0}, "hidden: expected true or false, but found 0"),
        ({"more": [1]}, "more: expected an object"),
        ({"more": {"a": 1}}, "but found 'a'"),
        ({"more": {"\ud800": 1}}, "expected width"),
        ({"more": {"width": "\ud800"}}, "more, width: expected a number"),
        ({"more": {"width": {}}}, "more, width: expected a number"),
        ({"name": "P03"}, "found 'name'"),
    ],
)
def test_what_is_no_report_of_a_screen_is_refused(client, desk, change, said):
    answer = reported(client, REPORT | change)
    assert answer.status_code == 400
    assert said in answer.text
    assert desk.screens == []


def streams(pages, name):
    """What a page's stream sends, as the route answers."""
    (route,) = [route for route in pages[name] if route.path == "/stream"]
    return route.endpoint(SimpleNamespace(query_params={}))


def parsed(text):
    """(name, content) of each event."""
    events = re.findall(r"(?:event: (\w+)\n)?data: (.+)\n\n", text)
    return [(name, json.loads(content)) for name, content in events]


async def until(stream, wanted):
    """All events up to the one that is wanted."""
    events = []
    async for text in stream:
        for event in parsed(text):
            events.append(event)
            if wanted(*event):
                return events
    raise AssertionError("the stream has ended")


def test_the_participant_is_sent_the_state_first_and_again_when_it_changes(desk, clock):
    async def listened():
        stream = participant_events(desk, clock)
        first = await until(stream, lambda name, content: name == "")
        clock.sleep_until(0.1)
        desk.ask(Request("start"))
        return first, await until(stream, lambda name, content: content["command"] == "start" and not name)

    first, then = asyncio.run(listened())
    assert [name for name, _ in first] == ["state", ""]
    assert set(first[0][1]) == {field.name for field in fields(ParticipantState)}
    assert first[1][1] | {"sent_s": 0} == {
        "sequence": 0, "time_s": 0.0, "force_n": 0.0, "direction": "none", "speed": "", "command": "ready",
        "command_s": 0.0, "age_s": 0.0, "sent_s": 0,
    }  # fmt: skip
    assert [name for name, _ in then] == ["state", ""]
    assert then[0][1]["text"] == "START"


def test_a_force_that_is_not_new_is_not_sent_again(desk, clock):
    async def listened():
        stream = participant_events(desk, clock)
        await until(stream, lambda name, content: name == "")
        turns = asyncio.create_task(until(stream, lambda name, content: name == ""))
        await asyncio.sleep(0.05)
        waits = not turns.done()
        clock.sleep_until(1.0)
        return waits, await turns

    waits, events = asyncio.run(listened())
    assert waits
    assert [content["sequence"] for _, content in events] == [200]


def test_one_who_is_slow_gets_the_newest_and_not_what_was_missed(desk, clock):
    async def listened():
        stream = participant_events(desk, clock)
        await until(stream, lambda name, content: name == "")
        for turn in range(1000):
            clock.sleep_until(turn / 200)
            desk.force()
        return await until(stream, lambda name, content: name == "")

    assert [content["sequence"] for _, content in asyncio.run(listened())] == [999]


def test_nothing_that_the_participants_page_gets_tells_the_specimen(client, desk, clock):
    files = [client.get(f"{PARTICIPANT}/{name}").text for name in ("", "participant.js", "state.js", "participant.css")]

    async def listened():
        stream, texts = participant_events(desk, clock), []
        for turn in range(1, 12_000):
            clock.sleep_until(turn / 200)
            awaits = desk.operator()[1].awaits
            name = {"start": "start", "specimen": "placed", "checklist": "check"}.get(awaits)
            if name:
                left = [item for item, done in desk.operator()[1].checklist.items() if not done]
                assert desk.ask(Request(name, item=left[0] if name == "check" else "")) == ""
            if turn % 40 == 0:
                texts.append(await anext(stream))
        return texts

    sent = asyncio.run(listened())
    assert {press.verdict for press in desk.operator()[1].presses} == {"ok"}
    for text in files + sent:
        assert not [press.specimen for press in PLAN if press.specimen in text]
        assert "P03" not in text
        assert "palpation" not in text


def test_the_operator_is_sent_everything_at_once_and_then_what_is_new(desk, clock):
    clock.sleep_until(12.0)

    async def listened():
        answer = await streams(session_pages(desk, clock), "operator")
        first = await until(answer.body_iterator, lambda name, content: name == "traces")
        clock.sleep_until(12.5)
        second = await until(answer.body_iterator, lambda name, content: name == "traces")
        desk.ask(Request("start"))
        third = await until(answer.body_iterator, lambda name, content: name == "participant")
        return first, second, third, await until(answer.body_iterator, lambda name, content: name == "alive")

    first, second, third, _ = asyncio.run(listened())
    assert [name for name, _ in first] == ["state", "participant", "traces"]
    assert set(first[0][1]) == {field.name for field in fields(OperatorState)}
    assert first[0][1]["presses"][2]["specimen"] == "S3"
    assert first[2][1]["time_s"][0] == 2.0
    assert [name for name, _ in second] == ["traces"]
    assert (second[0][1]["time_s"][0], second[0][1]["time_s"][-1]) == (12.01, 12.5)
    assert [name for name, _ in third] == ["state", "participant"]
    assert (third[0][1]["awaits"], third[1][1]["text"]) == ("", "START")


@pytest.mark.parametrize("page", ["operator", "participant"])
def test_a_page_that_is_open_too_often_is_refused_until_one_is_closed(desk, clock, page):
    async def opened():
        pages = session_pages(desk, clock)
        some = [(await streams(pages, page)).body_iterator for _ in range(MOST_VIEWERS)]
        for one in some:
            await anext(one)
        full = await streams(pages, page)
        await some[0].aclose()
        again = await streams(pages, page)
        return full, again

    full, again = asyncio.run(opened())
    assert (full.status_code, again.status_code) == (503, 200)
    assert b"Close the others" in full.body


@pytest.mark.parametrize("address", ["", "0.0.0.0", "::1", "tablet", "192.168.1", "224.0.0.1", "192.168.1.7:80"])
def test_an_address_that_is_none_to_serve_on(address):
    with pytest.raises(SettingError, match="--bind: expected one address of this computer, but found"):
        own_address(address)


def test_an_address_of_another_computer():
    with (
        pytest.raises(SettingError, match=r"--bind 192\.0\.2\.7: expected an address of this computer, but found"),
        listening(0, "192.0.2.7"),
    ):
        pass


class Served:
    """The pages of a desk, from a thread."""

    def __init__(self, desk, clock, bind=None):
        self.addresses, self._end, ready = [], threading.Event(), threading.Event()

        def told(*addresses):
            self.addresses.extend(addresses)
            ready.set()

        def served():
            with listening(0, bind) as at:
                serve(session_pages(desk, clock), at, told, self._end)

        self._thread = threading.Thread(target=served)
        self._thread.start()
        assert ready.wait(60)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join(60)
        assert not self._thread.is_alive()


def status(address, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=60) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def test_streams_that_nobody_reads_leave_the_page_of_the_participant_its_place(monkeypatch):
    monkeypatch.setattr(session_routes, "_GONE_S", 0.5)
    desk = ScriptedDesk(WallClock(), "start")
    with Served(desk, desk.clock) as served:
        address = served.addresses[1]

        def unread(number):
            try:
                return urllib.request.urlopen(f"{address}stream?page=unread-{number}", timeout=60)
            except urllib.error.HTTPError as refused:
                return refused

        first = [unread(number) for number in range(MOST_VIEWERS)]
        assert [answer.status for answer in first] == [200] * MOST_VIEWERS
        assert status(f"{address}stream?page=real") == 503
        time.sleep(0.6)
        real = urllib.request.urlopen(f"{address}stream?page=real", timeout=60)
        later = []
        for number in range(15):
            token = {TOKEN_HEADER: address.split("/")[3]}
            report = urllib.request.Request(f"{address}screen?page=real", json.dumps(REPORT).encode(), token)
            assert urllib.request.urlopen(report, timeout=60).status == 200
            later.append(unread(number))
            assert all(real.readline() for _ in range(10))
            time.sleep(0.2)
        assert sum(answer.status == 200 for answer in later) > MOST_VIEWERS
        with pytest.raises(http.client.IncompleteRead):  # it lost its place
            first[0].read()
        for answer in (real, *first, *later):
            answer.close()


@pytest.mark.skipif(not hasattr(socket, "TCP_USER_TIMEOUT"), reason="Linux cuts such connections")
def test_a_connection_that_nobody_reads_is_cut(monkeypatch):
    monkeypatch.setattr(server, "_UNREAD_MS", 300)
    with listening(0) as at, socket.create_connection((HOST, at.port), timeout=60):
        own, _ = at.sockets[0].accept()
        own.settimeout(0.2)
        with pytest.raises(TimeoutError):
            own.sendall(bytes(64 << 20))
        end_s = time.monotonic() + 30
        while not (cut := own.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)) and time.monotonic() < end_s:
            time.sleep(0.05)
        own.close()
    assert cut == errno.ETIMEDOUT


def test_without_bind_only_this_computer_is_served(desk, clock):
    with Served(desk, clock) as served:
        assert all(address.startswith(f"http://{HOST}:") for address in served.addresses)
        assert [address.split("/")[-2] for address in served.addresses] == ["operator", "participant"]
        assert [status(address) for address in served.addresses] == [200, 200]
        assert len({address.split("/")[3] for address in served.addresses}) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not have 127.0.0.2 by themselves")
def test_with_bind_that_address_is_served_as_well_and_needs_the_token(desk, clock):
    with Served(desk, clock, "127.0.0.2") as served:
        for address in served.addresses:
            assert address.startswith("http://127.0.0.2:")
            assert status(address) == status(address.replace("127.0.0.2", HOST)) == 200
            assert status(address, Host="tablet.example") == 403
            assert status("/".join(address.split("/")[:3]) + "/") == 403


@pytest.mark.realtime
def test_many_who_come_and_go_and_some_who_do_not_read_hold_up_no_engine():
    clock = WallClock()
    desk = ScriptedDesk(clock, "start")
    late_s, end = [], threading.Event()

    def engine():
        due_s = clock.now_s()
        while not end.is_set():
            due_s += 0.005
            clock.sleep_until(due_s)
            late_s.append(clock.now_s() - due_s)
            desk.force()

    with undisturbed(), Served(desk, clock) as served:
        thread = threading.Thread(target=engine)
        thread.start()
        host, port = served.addresses[0].split("/")[2].split(":")
        paths = ["/" + address.split("/", 3)[3] for address in served.addresses]

        def opened(path):
            viewer = socket.create_connection((host, int(port)))
            viewer.sendall(f"GET {path}stream HTTP/1.1\r\nHost: {HOST}\r\n\r\n".encode())
            return viewer

        deaf = [opened(path) for path in paths for _ in range(3)]  # never read
        end_s, comings = time.monotonic() + 4, 0
        while time.monotonic() < end_s:
            some = [opened(path) for path in paths]
            for viewer in some:
                assert viewer.recv(200).startswith(b"HTTP/1.1 200")
                viewer.close()
            comings += len(some)
            time.sleep(0.05)
        end.set()
        thread.join()
        for viewer in deaf:
            viewer.close()
    late_s.sort()
    assert comings >= 80
    assert len(late_s) > 700
    assert late_s[int(0.99 * len(late_s))] < 0.02
