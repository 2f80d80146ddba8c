"""How a run ended, in words."""

from __future__ import annotations

import pytest

from emg2vsa.live.run_facts import read_ending


@pytest.fixture
def told(begin, ended, runs):
    def tell(**changes):
        record = begin("run")
        record.presses_done = changes.pop("presses_done", 3)
        record.end(ended(**changes))
        return read_ending(runs / "run", repetitions=3)

    return tell


def test_completed(told):
    ending = told()
    assert (ending.kind, ending.title) == ("good", "Completed")
    assert ending.text == "3 of 3 presses done. Probe retracted. Motors off."


def test_stopped_on_the_page(told):
    ending = told(how="stopped", cause="STOP on the live page", why="asked to stop", phase="load", presses_done=1)
    assert (ending.kind, ending.title) == ("stopped", "Stopped: STOP on the live page")
    assert ending.text == "1 of 3 presses done, ended in phase load. Probe retracted. Motors off."


def test_a_guard_names_its_limit(told):
    ending = told(how="guard", cause="force limit", why="10.03 N, limit 10 N", phase="load", presses_done=0)
    assert (ending.kind, ending.title) == ("guard", "Ended by a guard: force limit")
    assert "10.03 N, limit 10 N." in ending.text


@pytest.mark.parametrize(
    ("unknown", "warning"),
    [
        ({"deactivated": False}, "Motors NOT known to be off: cut their power."),
        ({"retracted": False}, "Probe NOT known to be retracted."),
    ],
)
def test_a_rig_that_is_not_known_to_be_safe_is_a_danger_even_after_all_presses(told, unknown, warning):
    ending = told(**unknown, notes=("qbmove 1: no answer",))
    assert ending.kind == "danger"
    assert warning in ending.text
    assert ending.text.endswith("Qbmove 1: no answer.")


def test_while_it_runs_or_after_a_kill_there_is_no_ending(begin, runs):
    assert read_ending(runs / "run", 3) is None
    begin("run")
    assert read_ending(runs / "run", 3) is None
    (runs / "run" / "ended.json").write_text('{"how": "comp')
    assert read_ending(runs / "run", 3) is None
