"""What the page makes of a moment: its message and its stop button, as the browser computes them."""

from __future__ import annotations

import pytest

RUNNING = {
    "folder": "runs",
    "run": {"name": "run"},
    "age_s": 0.01,
    "stop_requested": False,
    "ended": None,
    "trouble": "",
}
OVER = RUNNING | {"ended": {"kind": "good", "title": "Completed", "text": "3 of 3"}}
CLICKED = {"askedS": 100.0, "failure": ""}
UNTOUCHED = {"askedS": None, "failure": ""}


@pytest.fixture
def computed(computed_by):
    return computed_by("watch")


@pytest.mark.parametrize(
    ("now", "silent_s", "kind", "title", "stale"),
    [
        (None, 0, "wait", "Connecting.", False),
        (RUNNING | {"run": None}, 0, "wait", "Waiting for a run.", False),
        (RUNNING | {"trouble": "log.csv: wanted"}, 0, "guard", "Cannot be shown.", True),
        (RUNNING | {"age_s": 0.45}, 0.1, "warn", "No data for 0.6 s.", True),
        (RUNNING | {"age_s": 4}, 0, "danger", "No data for 4 s.", True),
        (RUNNING | {"age_s": 7200}, 0, "danger", "No data for 2 h.", True),
        (RUNNING, 1.6, "danger", "No connection for 1.6 s.", True),
        (OVER | {"age_s": 7200}, 0, "good", "Completed", False),
        (OVER, 1.6, "danger", "No connection for 1.6 s.", True),
    ],
)
def test_message(computed, now, silent_s, kind, title, stale):
    message = computed("messageOf", {"now": now, "silentS": silent_s})
    assert (message["kind"], message["title"], message["stale"]) == (kind, title, stale)


def test_no_message_while_rows_come(computed):
    assert computed("messageOf", {"now": RUNNING | {"age_s": 0.4}, "silentS": 0.05}) is None


@pytest.mark.parametrize(
    ("now", "stop", "clock_s", "title", "enabled"),
    [
        (None, UNTOUCHED, 0, "STOP", False),
        (RUNNING | {"run": None}, UNTOUCHED, 0, "STOP", False),
        (RUNNING, UNTOUCHED, 0, "STOP", True),
        (RUNNING | {"age_s": 60}, UNTOUCHED, 0, "STOP", True),
        (RUNNING, CLICKED, 100.1, "Stopping", True),
        (RUNNING | {"stop_requested": True}, UNTOUCHED, 0, "Stopping", True),
        (RUNNING | {"stop_requested": True}, CLICKED, 103.1, "NO ANSWER", True),
        (RUNNING, {"askedS": None, "failure": "No connection"}, 0, "NOT STOPPED", True),
        (OVER, UNTOUCHED, 0, "STOP", False),
        (OVER, CLICKED, 110, "STOP", False),
        (OVER, {"askedS": None, "failure": "Refused: nothing is running"}, 0, "STOP", False),
    ],
)
def test_stop_button(computed, now, stop, clock_s, title, enabled):
    button = computed("stopStateOf", {"now": now, "silentS": 0}, stop, clock_s)
    assert (button["title"], button["enabled"]) == (title, enabled)


@pytest.mark.parametrize(
    ("run", "frame", "shown", "asked"),
    [
        (None, "", "", ""),
        ({"name": "b"}, "", "", "b/"),  # opened after the end, or between presses
        ({"name": "b"}, "", "b/", ""),
        ({"name": "b"}, "", "b/2-7", ""),
        ({"name": "b"}, "", "a/2-7", "b/"),
        ({"name": "b-2"}, "", "b/2-7", "b-2/"),
        ({"name": "b"}, "2-8", "b/2-7", "b/2-8"),
        ({"name": "b"}, "2-8", "b/2-8", ""),
    ],
)
def test_the_newest_frame_is_asked_for_once(computed, run, frame, shown, asked):
    assert computed("frameToAsk", run, frame, shown) == asked


@pytest.mark.parametrize(
    ("repetitions", "done", "pressing", "kinds"),
    [
        (2, 0, False, ["", ""]),
        (2, 0, True, ["now", ""]),
        (2, 1, True, ["done", "now"]),
        (2, 2, False, ["done", "done"]),
        (0, 0, False, []),
    ],
)
def test_the_bar_of_presses(computed, repetitions, done, pressing, kinds):
    assert computed("pressesOf", repetitions, done, pressing) == kinds


def test_ten_million_presses_are_a_hundred_parts(computed):
    assert computed("pressesOf", 10_000_000, 2_500_000, True) == ["done"] * 25 + ["now"] + [""] * 74


def test_a_busy_computer_is_named(computed):
    health = {"largest_n": 7.123, "largest_across_n": 0.3, "turns": 1000, "latest_ms": 12.34}
    assert computed("healthOf", health | {"late_turns": 1}) == (
        "largest force 7.12 N, across 0.30 N · loop late in 0.10 % of turns, by up to 12.3 ms"
    )
    assert computed("healthOf", health | {"late_turns": 100}).endswith("by up to 12.3 ms: the computer is busy")


def test_the_last_press_tells_its_specimen(computed):
    health = {"largest_n": 7, "largest_across_n": 0, "turns": 0, "late_turns": 0, "latest_ms": 0}
    told = computed("healthOf", health | {"weighed": "press 2 by its depth: 7.5 N/mm, 95 %: 6.6 to 8.7"})
    assert told == "largest force 7.00 N, across 0.00 N · press 2 by its depth: 7.5 N/mm, 95 %: 6.6 to 8.7"
