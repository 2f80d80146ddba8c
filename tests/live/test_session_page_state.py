"""What a session's two pages make of what they are sent, as the browser computes it."""

from __future__ import annotations

from dataclasses import asdict, replace

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.session.views import Request
from tests.live.scripted_desk import TOO_FAST, ScriptedDesk

FORCE = {"sequence": 7, "time_s": 10.0, "force_n": 3.5, "direction": "rising", "speed": "", "command": "press"}
NOW = 3
RISING = {"colour": "rise", "begunS": 9.0}


@pytest.fixture
def participant(computed_by):
    return computed_by("participant")


@pytest.fixture
def operator(computed_by):
    return computed_by("operator")


@pytest.fixture
def state():
    return asdict(ScriptedDesk(VirtualClock(), "start").participant()) | {"command": "press", "text": "Press"}


def desk_at(awaits, **arguments):
    return ScriptedDesk(VirtualClock(), awaits, **arguments)


def state_of(desk):
    return asdict(desk.operator()[1])


def test_every_command_has_a_look(participant, state):
    looks = {
        ("ready", "plain"): "plain", ("start", "plain"): "start", ("press", "plain"): "plain",
        ("press", "rise"): "rise", ("press", "fall"): "fall", ("stop", "rise"): "stop", ("rest", "plain"): "plain",
        ("wait", "plain"): "wait", ("pause", "plain"): "pause", ("done", "plain"): "wait",
    }  # fmt: skip
    rows = [(state, FORCE | {"command": command}, RISING | {"colour": colour}, NOW) for command, colour in looks]
    scenes = participant.each("sceneOf", rows)
    assert [scene["look"] for scene in scenes] == list(looks.values())
    assert {(scene["share"], scene["over"]) for scene in scenes} == {(0.5, False)}


@pytest.mark.parametrize(
    ("change", "word", "hint"),
    [
        ({}, "Press", ""),
        ({"speed": "too fast"}, "Press", "slower"),
        ({"speed": "too slow"}, "Press", "faster"),
        ({"command": "stop", "speed": "too fast"}, "STOP", ""),
    ],
)
def test_words_of_a_press(participant, state, change, word, hint):
    scene = participant("sceneOf", state, FORCE | change, RISING, NOW)
    assert (scene["word"], scene["hint"]) == (word, hint)


def test_a_falling_force_is_told(participant, state):
    scene = participant("sceneOf", state, FORCE | {"speed": "too slow"}, RISING | {"colour": "fall"}, NOW)
    assert (scene["word"], scene["hint"]) == ("Press", "keep increasing")


@pytest.mark.parametrize("age_ms", [199, 201])
def test_a_bar_that_hears_nothing_is_grey_and_says_so(participant, state, age_ms):
    scene = participant("sceneOf", state, FORCE, RISING, age_ms)
    lost = age_ms > 200
    assert scene["look"] == ("lost" if lost else "rise")
    assert scene["word"] == (state["texts"]["lost"] if lost else "Press")


@pytest.mark.parametrize(
    ("force_n", "share", "over"), [(-0.3, 0, False), (7.0, 1, False), (7.03, 1, False), (7.6, 1, True)]
)
def test_more_force_than_the_bar_shows_is_marked(participant, state, force_n, share, over):
    scene = participant("sceneOf", state, FORCE | {"force_n": force_n}, RISING, NOW)
    assert (scene["share"], scene["over"], scene["value"]) == (share, over, max(0, force_n))


@pytest.mark.parametrize(
    ("elapsed_s", "low_n", "high_n"), [(0.0, 0.5, 0.5), (0.5, 1.15, 3.75), (1.0, 1.8, 7.0), (9.0, 7.0, 7.0)]
)
def test_the_window_moves_as_fast_as_the_band_of_times_says(participant, state, elapsed_s, low_n, high_n):
    low, high = participant("zoneOf", elapsed_s, state)
    assert (low, high) == (pytest.approx(low_n / 7), pytest.approx(high_n / 7))


@pytest.mark.parametrize(
    ("memory", "change", "after"),
    [
        (None, {"force_n": 0.4}, {"colour": "rise", "begunS": None}),
        (None, {"command": "start", "force_n": 0.5, "direction": "none"}, {"colour": "plain", "begunS": 10.0}),
        (RISING, {}, RISING),
        (RISING, {"direction": "steady"}, RISING),
        (RISING, {"direction": "falling", "force_n": 0.2}, RISING | {"colour": "fall"}),
        (RISING, {"command": "stop"}, {"colour": "plain", "begunS": None}),
    ],
)
def test_the_colour_stays_while_the_force_is_steady_and_the_window_begins_at_the_lower_force(
    participant, state, memory, change, after
):
    memory = memory or {"colour": "plain", "begunS": None}
    assert participant("remembered", memory, FORCE | change, state) == after


@pytest.mark.parametrize(("left_s", "shown"), [(24.2, "0:25"), (61.0, "1:01"), (-3.0, "0:00")])
def test_a_break_is_counted_down(participant, state, left_s, shown):
    break_ = state | {"command": "pause", "pause_until_s": 10 + left_s}
    assert participant("sceneOf", break_, FORCE | {"command": "pause"}, RISING, NOW)["pause"] == shown


def test_the_clocks_are_compared_by_the_quickest_answer(participant):
    answers = [
        {"sentMs": 1000, "receivedMs": 1040, "serverMs": 500},
        {"sentMs": 2000, "receivedMs": 2002, "serverMs": 1501},
    ]
    assert participant("offsetOf", answers) == 500


def test_a_command_was_given_so_long_before_its_message_was_sent(participant):
    force = {"age_s": 0.012, "time_s": 3.004, "command_s": 3.002}
    assert participant("commandAt", force, 5000) == pytest.approx(4986)


def test_the_report_of_a_second(participant):
    frames = [0, 16, 32, 48, 148]
    report = participant("reportOf", frames, [5, 1, 3, 2, 40], True, [17, 9000])
    assert report == {
        "frames_per_s": pytest.approx(4000 / 148), "age_p50_ms": 3, "age_p95_ms": 40, "longest_frame_ms": 100,
        "hidden": True, "command_ms": [17, 5000],
    }  # fmt: skip
    assert participant("reportOf", [0], [], True, []) == {
        "frames_per_s": 0, "age_p50_ms": 0, "age_p95_ms": 0, "longest_frame_ms": 0, "hidden": True, "command_ms": [],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("awaits", "name", "label"),
    [
        ("quality", "measure-rest", "Measure rest"), ("contraction", "measure-contraction", "Measure contraction"),
        ("specimen", "placed", "Specimen is placed"), ("checklist", "check", "Tick: Forearm lies on its support"),
        ("start", "start", "START"), ("end", "end", "End session"),
    ],
)  # fmt: skip
def test_the_large_button_does_what_is_awaited(operator, awaits, name, label):
    primary = operator("primaryOf", state_of(desk_at(awaits)))
    assert (primary["name"], primary["label"]) == (name, label)


@pytest.mark.parametrize(("commands", "name"), [(["repeat", "accept", "skip"], "repeat"), (["accept", "skip"], "skip")])
def test_a_press_that_is_not_usable_is_repeated_as_long_as_that_is_allowed(operator, commands, name):
    assert operator("primaryOf", state_of(desk_at("verdict")) | {"commands": commands})["name"] == name


def test_the_large_button_goes_on_after_a_break_and_leaves_nothing_out_by_itself(operator):
    paused = state_of(desk_at("start")) | {"awaits": "", "commands": ["continue", "end"]}
    assert operator("primaryOf", paused)["name"] == "continue"
    assert operator("primaryOf", paused | {"commands": ["continue", "pause", "end"]})["name"] == ""
    assert operator("askedBy", "p", paused, None)["name"] == "continue"
    without = state_of(desk_at("quality")) | {"commands": ["measure-rest", "continue", "pause"]}
    assert operator("askedBy", "p", without, None)["name"] == "pause"
    assert operator("askedBy", "c", without, None)["name"] == "continue"


def test_what_is_asked_too_early_is_asked_all_the_same_and_shown_as_early(operator):
    resting = state_of(desk_at("start")) | {"commands": ["pause", "end"]}
    assert operator("primaryOf", resting) == {"name": "start", "item": "", "label": "START", "ready": False}
    assert operator("askedBy", " ", resting, None) == {"name": "start", "press": None, "item": ""}


def test_keys(operator):
    keys = {
        ("start", " "): ("start", None, ""), ("start", "PageDown"): ("start", None, ""), ("start", "Escape"): None,
        ("start", "x"): None, ("start", "p"): ("pause", None, ""), ("start", "."): ("pause", None, ""),
        ("start", "r"): ("repeat", 1, ""), ("verdict", "PageDown"): ("repeat", None, ""),
        ("verdict", "PageUp"): ("repeat", 1, ""), ("verdict", "a"): ("accept", 1, ""),
        ("verdict", "s"): ("skip", 1, ""), ("checklist", "2"): ("check", None, "Electrodes hold"),
        ("checklist", "9"): None,
    }  # fmt: skip
    states = {awaits: state_of(desk_at(awaits)) for awaits, _ in keys}
    asked = operator.each("askedBy", [(key, states[at], states[at]["presses"][0]) for at, key in keys])
    for (where, wanted), found in zip(keys.items(), asked, strict=True):
        assert found == (wanted and dict(zip(("name", "press", "item"), wanted, strict=True))), where


def test_the_verdict_shown_is_that_of_the_last_press_unless_another_is_chosen(operator):
    desk = desk_at("start", faults={2: TOO_FAST})
    clock = desk.clock

    def pressed():
        assert desk.ask(Request("start")) == ""
        clock.sleep_until(clock.now_s() + 5)
        desk.force()
        return state_of(desk)

    assert operator("shownPress", state_of(desk), None) is None
    pressed()
    state = pressed()
    assert operator("shownPress", state, None)["number"] == 2
    assert operator("shownPress", state, "1")["number"] == 1
    assert operator("shownPress", state, "5")["number"] == 2
    assert operator("countOf", state) == "Training: 1 of 2 presses"
    assert operator("upcoming", state) == ["S3", "S1"]
    assert [cell["kind"] for cell in operator("cellsOf", state)] == ["ok", "rejected"]
    assert desk.ask(Request("repeat", 2)) == ""
    state = state_of(desk)
    assert [cell["kind"] for cell in operator("cellsOf", state)] == ["ok", "now"]
    first = operator("shownPress", state, "2")
    assert (first["attempt"], first["last"]) == (1, True)
    assert operator("verdictOf", first) == {"kind": "rejected", "mark": "✕", "text": "Not usable, to be repeated"}
    state = pressed()
    again = operator("shownPress", state, None)
    assert (again["attempt"], again["last"], again["verdict"]) == (2, True, "ok")
    assert not operator("shownPress", state, "2")["last"]
    assert operator("shownPress", state, "2, attempt 2")["attempt"] == 2


@pytest.mark.parametrize(
    ("change", "silent_s", "refused", "news", "kind"),
    [
        ({}, 0.1, "", "", None), ({}, 2.5, "Not now.", "", "danger"), ({}, 0.1, "Not now.", "", "warn"),
        ({}, 0.1, "", "The page is hidden.", "warn"), ({"ended": "completed"}, 60, "", "", "good"),
    ],
)  # fmt: skip
def test_the_message_says_the_worst(operator, change, silent_s, refused, news, kind):
    message = operator("messageOf", state_of(desk_at("start")) | change, silent_s, refused, news)
    assert (message and message["kind"]) == kind


def test_a_lost_device_is_said_before_all_else(operator):
    desk = desk_at("start")
    device = asdict(replace(desk.operator()[1].devices[0], state="lost", text="EMG is lost."))
    message = operator("messageOf", state_of(desk) | {"devices": [device]}, 0.1, "Not now.", "x")
    assert message == {"kind": "danger", "stale": False, "text": "EMG is lost."}
    assert operator("messageOf", None, 0.1, "", "")["text"] == "Connecting."


def test_intervals_share_one_axis(operator):
    fits = [{"low_v": 1e-5, "high_v": 3e-5, "b_v": 2e-5}, {"low_v": 2e-5, "high_v": 4e-5, "b_v": 3e-5}]
    assert operator("intervalOf", fits[0], fits) == {
        "from": pytest.approx(0.25), "to": pytest.approx(0.75), "middle": pytest.approx(0.5),
    }  # fmt: skip
    assert [operator("microvolts", v) for v in (None, 3.04e-6, 2.4e-4)] == ["–", "3.0 µV", "240 µV"]
