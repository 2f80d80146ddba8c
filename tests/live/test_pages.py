"""Who may see the pages, and what the addresses answer."""

from __future__ import annotations

import asyncio
import json
import re

import cv2
import numpy as np
import pytest
from starlette.testclient import TestClient

from emg2vsa.live.follow import Follower
from emg2vsa.live.server import TOKEN_HEADER, application
from emg2vsa.live.watch_routes import Audience, watch_routes
from emg2vsa.rig.executor.stop_requests import StopRequests
from emg2vsa.rig.record.press_recorder import PressRecorder

TOKEN = "a-token"
IN = f"/{TOKEN}/watch"
PATHS = ("/", "/watch.js", "/watch.css", "/stream", "/frame")
HEADER = {TOKEN_HEADER: TOKEN}


@pytest.fixture
def client(runs):
    return TestClient(application({"watch": watch_routes(runs)}, {"watch": TOKEN}), base_url="http://127.0.0.1:8420")


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("token", ["", "another", TOKEN[:-1], TOKEN + "x", "ä"])
def test_without_the_token_every_address_is_refused(client, path, token):
    assert client.get(f"/{token}/watch{path}").status_code == 403


def test_without_a_path_it_is_refused(client):
    assert client.get("/").status_code == 403


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("host", ["rig.example:8420", "127.0.0.1.rig.example", "192.168.1.7:8420", ""])
def test_under_another_name_it_is_refused(client, path, host):
    assert client.get(IN + path, headers={"host": host}).status_code == 403


@pytest.mark.parametrize("host", ["127.0.0.1:9000", "localhost:8420", "localhost", "127.0.0.1"])
def test_under_its_own_names_it_is_shown_at_any_port(client, host):
    assert client.get(f"{IN}/", headers={"host": host}).status_code == 200


@pytest.mark.parametrize("header", [{}, {TOKEN_HEADER: "another"}, {TOKEN_HEADER: ""}])
def test_a_stop_without_the_token_in_a_header_is_refused(client, begin, runs, header):
    begin("run")
    assert client.post(f"{IN}/stop", headers=header).status_code == 403
    assert StopRequests(runs / "run")() is None


def test_a_stop_reaches_the_run(client, begin, runs):
    begin("run")
    answer = client.post(f"{IN}/stop", headers=HEADER)
    assert (answer.status_code, answer.text) == (200, "run")
    assert StopRequests(runs / "run")() == "STOP on the live page"
    assert client.post(f"{IN}/stop", headers=HEADER).status_code == 200


def test_a_stop_goes_to_the_run_that_is_running_now(client, begin, runs, ended):
    begin("first").end(ended())
    begin("second")
    assert client.post(f"{IN}/stop", headers=HEADER).text == "second"
    assert not (runs / "first" / "stop").exists()


def test_nothing_to_stop_is_said(client, begin, runs, ended):
    assert client.post(f"{IN}/stop", headers=HEADER).status_code == 409
    begin("run").end(ended())
    assert client.post(f"{IN}/stop", headers=HEADER).status_code == 409
    assert not (runs / "run" / "stop").exists()


def test_a_stop_that_cannot_be_written_is_said(client, begin, monkeypatch):
    begin("run")

    def full(path, text):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("emg2vsa.rig.executor.stop_requests.write_text_atomic", full)
    answer = client.post(f"{IN}/stop", headers=HEADER)
    assert (answer.status_code, answer.text) == (500, "No space left on device")


def test_a_stop_is_no_link(client, begin, runs):
    begin("run")
    assert client.get(f"{IN}/stop").status_code == 405
    assert not (runs / "run" / "stop").exists()


def test_the_newest_frame(client, begin, runs):
    assert client.get(f"{IN}/frame").status_code == 204
    begin("run")
    assert client.get(f"{IN}/frame").status_code == 204
    for repetition, grey in ((1, 30), (2, 200)):
        press = PressRecorder(runs / "run" / f"press-{repetition:03d}", (12, 16))
        press.frame(np.full((12, 16), grey, np.uint8), 0.0)
        shown = cv2.imdecode(np.frombuffer(client.get(f"{IN}/frame").content, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert shown.shape == (12, 16)
        assert abs(shown.astype(int) - grey).max() <= 2


def test_a_frame_of_another_program_is_said(client, begin, runs):
    begin("run")
    (runs / "run" / "press-001").mkdir()
    (runs / "run" / "press-001" / "frames.tif").write_bytes(b"II+?")
    answer = client.get(f"{IN}/frame")
    assert answer.status_code == 500
    assert "expected a TIFF of the rig" in answer.text


def test_the_page_loads_nothing_from_elsewhere_and_everything_it_names(client):
    page = client.get(f"{IN}/")
    assert "default-src 'self'" in page.headers["content-security-policy"]
    assert page.headers["cache-control"] == "no-store"
    named = re.findall(r'(?:href|src)="([^":]+)"', page.text) + re.findall(
        r'from "(.+?)"', client.get(f"{IN}/watch.js").text
    )
    assert set(named) == {"look.css", "watch.css", "watch.js", "./plot.js", "./state.js"}
    for name in named:
        file = client.get(f"{IN}/{name}")
        assert file.status_code == 200
        assert "//" not in re.sub(r"^\s*//.*|\s// .*", "", file.text, flags=re.MULTILINE), name


async def until(stream, wanted, times_s=()):
    """The first moment that is as wanted, and the times of all curves up to it, after ``times_s``."""
    async for event in stream:
        if event.startswith("retry"):
            continue
        assert event.startswith("data: ")
        assert event.endswith("\n\n")
        assert event.count("\n") == 2
        moment = json.loads(event.removeprefix("data: "))
        times_s = [*([] if moment["anew"] else times_s), *moment["curves"]["time_s"]]
        if wanted(moment):
            return moment, times_s
    raise AssertionError("the stream has ended")


def test_the_stream_tells_each_moment_as_it_comes(begin, row, runs, ended):
    async def listened():
        stream = Audience(Follower(runs), 0.001).events()
        assert (await until(stream, lambda moment: moment["run"] is None))[1] == []
        record = begin("run")
        record.row(row(0.005))
        _, times_s = await until(stream, lambda moment: moment["phase"] == "load")
        record.row(row(0.010, force_n=float("nan"), phase="pause"))
        paused, times_s = await until(stream, lambda moment: moment["phase"] == "pause", times_s)
        assert (times_s, paused["curves"]["raw_n"][-1], paused["presses_done"]) == ([0.005, 0.01], None, 1)
        record.end(ended())
        over, times_s = await until(stream, lambda moment: moment["ended"], times_s)
        assert (times_s, over["ended"]["title"], over["ended"]["presses_done"]) == ([0.005, 0.01], "Completed", 0)
        await stream.aclose()

    asyncio.run(listened())


def test_the_folder_is_read_once_for_all_who_watch_and_each_has_all_curves(begin, row, runs):
    record = begin("run")
    for turn in range(400):
        record.row(row(turn / 200))
    follower = Follower(runs)
    looks = []
    look = follower.look
    follower.look = lambda: looks.append(1) or look()

    async def viewer(audience):
        stream = audience.events()
        found = await until(stream, lambda moment: moment["run"])
        await stream.aclose()
        return found

    async def watched():
        audience = Audience(follower, 0.02)
        return await asyncio.gather(*(viewer(audience) for _ in range(50)))

    seen = asyncio.run(watched())
    assert all(times_s == [turn / 200 for turn in range(400)] for _, times_s in seen)
    assert len(looks) <= 20


def test_what_ends_the_looking_ends_the_stream(runs):
    class Broken:
        def look(self):
            raise ZeroDivisionError

    async def listened():
        await until(Audience(Broken(), 0.001).events(), lambda moment: True)

    with pytest.raises(ZeroDivisionError):
        asyncio.run(listened())


@pytest.mark.parametrize(
    "origin", ["null", "http://evil.example", "http://127.0.0.1:9", "https://127.0.0.1.evil.example"]
)
def test_a_request_from_another_page_is_refused(client, begin, runs, origin):
    begin("run")
    assert client.post(f"{IN}/stop", headers=HEADER | {"origin": origin}).status_code == 403
    assert StopRequests(runs / "run")() is None


def test_a_request_from_the_page_itself_is_obeyed(client, begin):
    begin("run")
    assert client.post(f"{IN}/stop", headers=HEADER | {"origin": "http://127.0.0.1:8420"}).status_code == 200


def test_largest_forces_and_lateness_are_of_the_whole_run(begin, row, runs):
    record = begin("run")
    record.begin_press(1, 0.0)
    record.row(row(0.005, force_n=-4.0, fx_n=0.0, fy_n=3.0, fz_n=-4.0, late_s=0.004))
    record.end_loading(0.01)
    record.end_press()
    record.row(row(0.010, repetition=2))
    moment = Follower(runs).look()
    assert (moment.largest_n, moment.largest_across_n, moment.presses_done) == (4.0, 3.0, 1)
    assert (moment.turns, moment.late_turns, moment.latest_ms) == (2, 1, 4.0)
