"""Both pages of a session in a real browser: what is shown, how often and how late."""

from __future__ import annotations

import socket
import time
from dataclasses import replace

import pytest

from benchmarks.browser import CHROMIUM, running
from emg2vsa.devices.clock import WallClock
from emg2vsa.session.views import Request
from tests.live.scripted_desk import PLAN, TOO_FAST, ScriptedDesk
from tests.live.test_session_routes import Served

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
METER = "+document.querySelector('[role=meter]').getAttribute('aria-valuenow')"
WORD = "document.querySelector('#word').textContent"
LOOK = "document.body.dataset.look"
PRIMARY = "document.querySelector('#primary b').textContent"


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with running(tmp_path_factory.mktemp("browser")) as browser:
        yield browser


@pytest.fixture
def desk():
    return ScriptedDesk(WallClock(), "start", {1: TOO_FAST})


@pytest.fixture
def served(desk):
    with Served(desk, desk.clock) as served:
        yield served


@pytest.fixture
def windows(browser, served):
    """The operator's and the participant's, both connected."""
    both = browser.open(served.addresses[0]), browser.open(served.addresses[1], 1920, 1080)
    both[0].until("document.querySelector('#who').textContent.includes('P03')")
    both[1].until(f"{LOOK} !== 'lost'")
    yield both
    for window in both:
        window.close()


@pytest.mark.realtime
def test_a_key_of_the_presenter_on_one_page_begins_a_press_on_the_other(windows, desk):
    operator, participant = windows
    meters = []
    operator.key("PageDown", repeat=True)
    assert desk.asked == []
    operator.key("PageDown")
    participant.until(f"{WORD} === 'START' && {LOOK} === 'start'", 2)
    participant.until(f"{LOOK} === 'rise' && !document.querySelector('#zone').hidden", 2)
    while participant.value(WORD) != "STOP":
        meters.append(participant.value(METER))
    peak = participant.until(f"{METER} === 7 && {LOOK} === 'stop' && {METER}", 2)
    participant.until(f"{METER} === 0", 2)
    assert peak == 7.0
    assert meters == sorted(meters)
    assert len(set(meters)) > 5
    operator.until(f"{PRIMARY} === 'Repeat press'", 3)
    assert "Force goes from 0.5 to 7 N in 0.4 s; 1 to 5 s wanted." in operator.text()
    assert [request.name for request in desk.asked] == ["start"]
    operator.key("PageUp")
    operator.until(f"{PRIMARY} === 'START'", 2)
    assert desk.asked[1] == Request("repeat", 1)


def test_a_note_is_written_about_the_press_that_is_shown_and_its_letters_are_no_commands(windows, desk):
    operator, _ = windows
    desk.ask(Request("start"))
    desk.ask(Request("abort"))
    operator.until(f"{PRIMARY} === 'Repeat press'")
    operator.key("n")
    operator.until("document.activeElement.matches('#note input')")
    for letter in "rest":
        operator.key(letter)
    operator.key(" ")
    operator.key("Enter")
    operator.until("document.querySelector('#problems').textContent.includes('Note: rest')")
    assert [request.name for request in desk.asked] == ["start", "abort", "note"]


def test_the_end_is_asked_for_twice(windows, desk):
    operator, _ = windows
    for answer, asked in (("#no", []), ("#yes", ["end"])):
        operator.key("e")
        operator.until("document.querySelector('#sure').open")
        operator.key("PageDown")
        operator.click(answer)
        operator.until("!document.querySelector('#sure').open")
        time.sleep(0.2)
        assert [request.name for request in desk.asked] == asked


def test_a_command_that_is_refused_says_why(windows, desk):
    operator, _ = windows
    operator.key("a")
    operator.until("document.querySelector('#message').textContent === 'Accept is not possible now.'")
    assert desk.asked == []


def test_a_warning_is_news_when_it_comes_and_gone_when_it_is_over(windows, desk):
    operator, _ = windows
    message = "document.querySelector('#message')"
    desk.warn("EMG: nothing for 2 s.")
    operator.until(f"{message}.textContent === 'EMG: nothing for 2 s.'")
    desk.warn("Force: nothing for 2 s.")  # as many as before
    operator.until(f"{message}.textContent === 'Force: nothing for 2 s.'")
    assert "EMG: nothing" not in operator.text()
    desk.warn()
    operator.until(f"{message}.hidden && document.querySelector('#warnings').hidden")


@pytest.mark.realtime
def test_a_page_reports_its_frames_and_commands_and_says_at_once_that_it_is_hidden(windows, desk):
    """How many frames and how late is for benchmarks/session_browser.py and command_frame.py to say."""
    _, participant = windows
    desk.ask(Request("start"))
    end_s = time.monotonic() + 20
    while sum(len(report.command_ms) for report in desk.screens) < 3:  # START, press, STOP; the rest comes later
        assert time.monotonic() < end_s
        time.sleep(0.05)
    pressing = [report for report in desk.screens if report.more["messages"]]
    assert pressing
    assert all(report.frames_per_s > 0 for report in pressing)
    assert all(0 < report.age_p50_ms <= report.age_p95_ms for report in pressing)
    assert all(ms > 0 for report in desk.screens for ms in report.command_ms)
    assert not any(report.hidden for report in desk.screens)

    desk.screens.clear()
    participant.value(
        "Object.defineProperty(document, 'hidden', { value: true });"
        "document.dispatchEvent(new Event('visibilitychange'))"
    )
    end_s = time.monotonic() + 0.8  # sooner than the next report of itself need come
    while not any(report.hidden for report in desk.screens):
        assert time.monotonic() < end_s
        time.sleep(0.01)


@pytest.mark.realtime
def test_a_page_that_is_loaded_again_goes_on_in_the_middle_of_a_press(windows, desk):
    operator, participant = windows
    participant.key("F5")  # a presenter's; it does nothing
    participant.value("window.kept = 1")
    desk.ask(Request("start"))
    participant.until(f"{METER} > 2", 3)
    assert participant.value("window.kept") == 1
    for window in windows:
        window.call("Page.reload")
        window.until("window.kept === undefined && document.readyState === 'complete'")
    participant.until(f"{WORD} === 'STOP'", 3)
    operator.until(f"{PRIMARY} === 'Repeat press'", 5)


@pytest.mark.parametrize("word", ["STOP", "Drücken", "LOSLASSEN", "Tense your forearm as hard as you can"])
def test_words_of_any_language_are_whole_and_large(browser, word):
    desk = ScriptedDesk(WallClock(), "start")
    desk.texts = replace(desk.texts, wait=word)
    with Served(desk, desk.clock) as served:
        window = browser.open(served.addresses[1], 1920, 1080)
        window.until(f"{WORD} === {word!r}")
        word_box, room_px, font_px = window.value(
            "(() => { const word = document.querySelector('#word'), range = document.createRange();"
            "range.selectNodeContents(word); const box = range.getBoundingClientRect();"
            "return [[box.left, box.right], document.querySelector('#scale').getBoundingClientRect().left,"
            "parseFloat(getComputedStyle(word).fontSize)]; })()"
        )
        window.close()
    assert word_box[1] < room_px - 60  # the marks of the bar
    assert font_px >= (64 if " " in word else 126)


@pytest.mark.parametrize("sound", [True, False])
def test_a_tone_comes_with_start_and_stop_where_it_is_asked_for(browser, desk, served, sound):
    desk.sound = sound
    window = browser.open("about:blank")
    heard = (
        "window.heard = []; const start = OscillatorNode.prototype.start;"
        "OscillatorNode.prototype.start = function () { heard.push(this.frequency.value); start.call(this); };"
    )
    window.call("Page.enable")
    window.call("Page.addScriptToEvaluateOnNewDocument", source=heard)
    window.go(served.addresses[1])
    window.until(f"{LOOK} === 'plain'")
    desk.ask(Request("start"))
    window.until(f"{LOOK} === 'stop'")
    time.sleep(0.2)
    assert window.value("heard") == ([880, 440] if sound else [])
    window.close()


def test_a_square_for_a_photodiode_is_white_while_start_is_shown_where_the_address_asks_for_it(browser, desk, served):
    window = browser.open(f"{served.addresses[1]}#light")
    square = "getComputedStyle(document.body, '::after').backgroundColor"
    window.until(f"{LOOK} === 'plain' && {square} === 'rgb(0, 0, 0)'")
    desk.ask(Request("start"))
    window.until(f"{LOOK} === 'start' && {square} === 'rgb(255, 255, 255)'")
    window.until(f"{LOOK} === 'rise' && {square} === 'rgb(0, 0, 0)'")
    window.close()


def test_nothing_on_the_participants_page_tells_the_specimen(windows):
    _, participant = windows
    everything = participant.value("document.documentElement.outerHTML + location.href + document.title")
    assert "Practice" in everything
    key = participant.value("location.pathname.split('/')[1]")
    everything = everything.replace(key, "")  # chance may spell a specimen in it
    for press in PLAN:
        assert press.specimen not in everything
    assert "P03" not in everything


def test_keys_that_reach_the_participants_window_go_to_the_operators(windows, desk):
    operator, participant = windows
    participant.key(" ")
    operator.until(f"{PRIMARY} !== 'START'")
    assert [request.name for request in desk.asked] == ["start"]
    participant.key("Escape")
    operator.until(f"{PRIMARY} === 'Repeat press'")
    assert [request.name for request in desk.asked] == ["start", "abort"]


def test_a_lost_connection_greys_the_bar_and_comes_back(browser):
    desk = ScriptedDesk(WallClock(), "start")
    with Served(desk, desk.clock) as served:
        participant = browser.open(served.addresses[1])
        operator = browser.open(served.addresses[0])
        participant.until(f"{LOOK} === 'plain'")
        desk.sequence_step = 0  # the session is held up: no new force
        participant.until(f"{LOOK} === 'lost'")
        assert participant.value(WORD) == "The display has lost the connection"
        desk.sequence_step = 1
        participant.until(f"{LOOK} === 'plain'")
    participant.until(f"{LOOK} === 'lost'")  # the server is gone
    operator.until("document.querySelector('#message').textContent.includes('No connection')")
    participant.close()
    operator.close()


def test_a_page_that_comes_when_the_places_are_taken_gets_one_later(browser, desk, served):
    path = "/" + served.addresses[1].split("/", 3)[3]
    host, port = served.addresses[1].split("/")[2].split(":")
    others = []
    for _ in range(6):
        other = socket.create_connection((host, int(port)))
        other.sendall(f"GET {path}stream HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        assert other.recv(100).startswith(b"HTTP/1.1 200")
        others.append(other)
    participant = browser.open(served.addresses[1])
    time.sleep(0.5)
    assert participant.value(LOOK) == "lost"
    for other in others:
        other.close()
    participant.until(f"{LOOK} === 'plain'")
    participant.close()
