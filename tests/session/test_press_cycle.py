"""Commands of a press, and the direction of the bar's colour."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.session.bar_force import BarForce
from emg2vsa.session.press_cycle import PressCycle
from emg2vsa.session_settings import SessionSettings

SETTINGS = SessionSettings(emg=SimulatedEmgSettings(), force=SimulatedForceSettings())
TURN_S = 0.005


def played(forces, *, start_s=None, longest_s=20.0):
    """Commands in the order in which they came, and the attempts that ended. forces : (time, N) to be interpolated."""
    times, levels = np.array(forces).T
    cycle = PressCycle(SETTINGS, longest_s)
    cycle.open(0.0)
    commands, ended = [cycle.command], []
    for now_s in np.arange(0.0, times[-1], TURN_S).tolist():
        force_n = float(np.interp(now_s, times, levels))
        if start_s is not None and now_s >= start_s:
            cycle.start(now_s, 0.0)
            start_s = None
            commands.append(cycle.command)
        if attempt := cycle.turn(now_s, force_n):
            ended.append(attempt)
        if cycle.command != commands[-1]:
            commands.append(cycle.command)
    return commands, ended


def test_a_press_goes_from_start_to_stop_at_the_upper_force_and_to_rest_once_lifted():
    commands, (attempt,) = played([(0, 0), (1.3, 0), (3.3, 8), (3.6, 8), (4, 0), (7, 0)], start_s=1.0)
    assert commands == ["rest", "ready", "start", "press", "stop", "rest", "ready"]
    assert attempt.begun_s == pytest.approx(1.3 + 0.5 / 4, abs=TURN_S)
    assert attempt.stop_s == pytest.approx(1.3 + 7 / 4, abs=TURN_S)
    assert attempt.end_s == pytest.approx(4 - 0.4 * 0.3 / 8, abs=2 * TURN_S)
    assert attempt.peak_n == pytest.approx(8)
    assert attempt.ending == "lifted"


@pytest.mark.parametrize(
    ("forces", "start_s", "ending", "early"),
    [
        ([(0, 0), (1.3, 0), (2.3, 4), (2.6, 0), (5, 0)], 1.0, "released", False),
        ([(0, 0), (12, 0)], 1.0, "not begun", False),
        ([(0, 0), (1.3, 0), (2.3, 5), (2.6, 0), (5, 0)], None, "lifted", True),
        ([(0, 0), (1.3, 0), (1.8, 2), (2.0, 0.1), (2.2, 2), (4, 8), (4.5, 0), (6, 0)], 1.0, "lifted", False),
    ],
)
def test_each_way_a_press_ends(forces, start_s, ending, early):
    _, (attempt,) = played(forces, start_s=start_s)
    assert (attempt.ending, attempt.early) == (ending, early)


def test_a_press_that_lasts_too_long_is_told_to_stop():
    commands, (attempt,) = played([(0, 0), (1.3, 0), (2.3, 5), (9, 5), (9.2, 0), (10, 0)], start_s=1.0, longest_s=4.0)
    assert "stop" in commands
    assert attempt.peak_n == pytest.approx(5)


def test_the_rest_begins_when_the_finger_is_lifted():
    cycle = PressCycle(SETTINGS, 20.0)
    assert cycle.command == "wait"
    cycle.open(0.0)
    cycle.start(0.0, 0.0)
    cycle.turn(1.0, 8.0)
    cycle.turn(1.5, 0.0)
    cycle.turn(1.7, 0.0)
    assert cycle.rest_until_s == pytest.approx(1.5 + SETTINGS.rest_s)
    cycle.turn(3.4, 0.0)
    assert cycle.command == "rest"
    cycle.turn(3.6, 0.0)
    assert cycle.command == "ready"


def test_a_finger_that_is_never_lifted_is_told_and_the_operator_can_abort():
    cycle = PressCycle(SETTINGS, 20.0)
    cycle.open(0.0)
    cycle.start(0.0, 0.0)
    for now_s in (1.0, 2.0, 4.0):
        assert cycle.turn(now_s, 7.5) is None
    assert cycle.overdue_s(4.0) == pytest.approx(1.0)
    attempt = cycle.give_up(4.0, "aborted", "")
    assert attempt is not None
    assert attempt.ending == "aborted"
    assert cycle.command == "stop"
    cycle.turn(5.0, 0.0)
    cycle.turn(5.2, 0.0)
    assert cycle.command == "rest"


@pytest.mark.parametrize(("load_s", "said"), [(0.5, {"too fast"}), (2.5, {""}), (9.0, {"too slow"})])
def test_the_speed_is_told_while_it_leaves_the_band(load_s, said):
    cycle = PressCycle(SETTINGS, 20.0)
    cycle.open(0.0)
    cycle.start(0.0, 0.0)
    told = set()
    for now_s in np.arange(0.0, load_s, TURN_S).tolist():
        force_n = 0.5 + 6.4 * now_s / load_s
        cycle.turn(now_s, force_n)
        if force_n > 1.5:
            told.add(cycle.speed(now_s, force_n))
    assert told == said


def test_the_direction_does_not_flicker_with_noise_and_follows_the_force():
    rng = np.random.default_rng(0)
    time_s = np.arange(0, 6, 0.001)
    force_n = np.interp(time_s, [0, 1, 3, 4, 5, 6], [0, 0, 5, 5, 0, 0]) + 0.02 * rng.standard_normal(time_s.size)
    bar = BarForce(15.0)
    seen = []
    for i in range(0, time_s.size, 5):
        bar.take(force_n[i : i + 5], 1000.0, float(time_s[i + 4]))
        if not seen or seen[-1][1] != bar.direction:
            seen.append((float(time_s[i]), bar.direction))
    assert [direction for _, direction in seen] == ["none", "rising", "falling", "none"]
    assert seen[1][0] == pytest.approx(1.2, abs=0.15)
    assert seen[2][0] == pytest.approx(4.0, abs=0.15)


def test_the_bar_is_late_by_eleven_milliseconds_and_keeps_its_force_over_samples_that_are_lost():
    bar = BarForce(15.0)
    ramp = np.arange(0, 2, 0.001)
    bar.take(ramp, 1000.0, 2.0)
    assert ramp[-1] - bar.force_n == pytest.approx(1 / (2 * np.pi * 15), rel=0.06)
    before = bar.force_n
    bar.take(np.full(5, np.nan), 1000.0, 2.005)
    assert bar.force_n == before


def test_a_press_while_the_operator_has_something_to_do_is_no_attempt_until_it_is_let_go():
    cycle = PressCycle(SETTINGS, 20.0)
    cycle.open(0.0)
    cycle.hold = True
    cycle.turn(1.0, 4.0)
    assert cycle.between
    cycle.hold = False
    cycle.turn(1.1, 4.0)
    cycle.turn(1.2, 0.4)
    assert cycle.attempt is None
    cycle.turn(1.3, 0.0)
    assert not cycle.between
    cycle.turn(1.4, 4.0)
    assert cycle.attempt is not None
    assert cycle.attempt.early
