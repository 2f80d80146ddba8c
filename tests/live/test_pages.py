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
from emg2vsa.live.watch_routes import moments, watch_routes
from emg2vsa.rig.executor.stop_requests import StopRequests
from emg2vsa.rig.record.press_recorder import PressRecorder

TOKEN = "a-token"
IN = f"/{TOKEN}/watch"
PATHS = ("/", "/watch.js", "/watch.css", "/stream", "/frame")
HEADER = {TOKEN_HEADER: TOKEN}


@pytest.fixture
def client(runs):
    return TestClient(application({"watch": watch_routes(runs)}, TOKEN), base_url="http://127.0.0.1:8420")


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
    assert client.get(f"{IN}/stop").status_code == 404
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
    assert "wanted a TIFF of the rig" in answer.text


def test_the_page_loads_nothing_from_elsewhere_and_everything_it_names(client):
    page = client.get(f"{IN}/")
    assert "default-src 'self'" in page.headers["content-security-policy"]
    assert page.headers["cache-control"] == "no-store"
    named = re.findall(r'(?:href|src)="([^":]+)"', page.text) + re.findall(
        r'from "(.+?)"', client.get(f"{IN}/watch.js").text
    )
    assert set(named) == {"watch.css", "watch.js", "./plot.js", "./state.js"}
    for name in named:
        file = client.get(f"{IN}/{name}")
        assert file.status_code == 200
        assert "//" not in re.sub(r"^\s*//.*|\s// .*", "", file.text, flags=re.MULTILINE), name


def test_the_stream_tells_each_moment_as_it_comes(begin, row, runs, ended):
    async def listened():
        stream = moments(Follower(runs), period_s=0)
        assert await anext(stream) == "retry: 500\n\n"
        told = [await anext(stream)]
        record = begin("run")
        record.row(row(0.005))
        told.append(await anext(stream))
        record.row(row(0.010, force_n=float("nan")))
        told.append(await anext(stream))
        record.end(ended())
        told.append(await anext(stream))
        return told

    told = asyncio.run(listened())
    assert all(event.startswith("data: ") and event.endswith("\n\n") and event.count("\n") == 2 for event in told)
    waiting, first, second, over = (json.loads(event.removeprefix("data: ")) for event in told)
    assert waiting["run"] is None
    assert first["run"]["name"] == "run"
    assert (first["curves"]["time_s"], second["curves"]["time_s"], over["curves"]["time_s"]) == ([0.005], [0.01], [])
    assert second["curves"]["raw_n"] == [None]
    assert (second["ended"], over["ended"]["title"]) == (None, "Completed")
