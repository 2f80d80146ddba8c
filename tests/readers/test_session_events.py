"""Presses that a session put aside do not count, and are missing to nobody."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.extraction.remedies import remedy_of
from emg2vsa.readers.session_events import SessionPress, only_counted
from emg2vsa.recordings import Channel
from emg2vsa.session_verdict import judge_session
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings


@pytest.fixture(scope="module")
def trials() -> Trials:
    """Four presses, at 3, 8, 13 and 18 s, each from 0.5 to 7 N within two seconds."""
    rng = np.random.default_rng(2)
    time_s = np.arange(0, 24, 1e-3)
    force_n = np.zeros(time_s.size)
    for start_s in (3.0, 8.0, 13.0, 18.0):
        x = time_s - start_s
        force_n = np.maximum(force_n, np.clip(x / 2, 0, 1) * 7.5 * np.clip((3.0 - x) / 0.4, 0, 1))
    level_v = 20e-6 + 10e-6 * np.log(np.maximum(force_n, 0.4))
    emg = {"EDC": Channel("EDC", rng.normal(size=time_s.size) * level_v, "V", 1000.0, 0.0, "")}
    force = Channel("Fz", force_n + 0.01 * rng.normal(size=time_s.size), "N", 1000.0, 0.0, "")
    made = extract_trials(
        emg, force, participant="P01", specimen="S1", filters=FilterSettings(), cocontraction=CocontractionSettings(),
        window=WindowSettings(), force_channel=ForceChannelSettings(name="Fz"),
    )  # fmt: skip
    assert made.repetition.size == 4
    return replace(made, verdict=np.array(["ok"] * 4), reasons=("",) * 4, remarks=())


def test_presses_by_the_attempt_that_they_lie_in(trials):
    presses = [
        SessionPress(2.9, 6.0, True, ""),
        SessionPress(7.9, 11.0, False, "operator: repeat: too fast; dips"),
        SessionPress(17.9, np.inf, False, "interrupted"),
    ]
    counted = only_counted(trials, presses)
    assert counted.verdict.tolist() == ["ok", "rejected", "rejected", "rejected"]
    assert counted.reasons == (
        "", "operator: repeat: too fast, dips", "session: not a press that the screen asked for",
        "session: interrupted",
    )  # fmt: skip
    said = replace(trials, reasons=("too silent",) * 4)
    assert only_counted(said, presses).reasons[1] == "operator: repeat: too fast, dips; too silent"
    assert only_counted(said, presses).reasons[0] == "too silent"
    said = replace(trials, reasons=("too fast; dips",) * 4)
    assert only_counted(said, presses).reasons[1] == "operator: repeat: too fast, dips"


def test_the_larger_share_of_a_press_decides(trials):
    first = trials.start_s[0]
    long, short = SessionPress(first - 1, first + 1.2, False, "aborted"), SessionPress(first + 1.2, first + 5, True, "")
    assert only_counted(trials, [long, short]).verdict[0] == "rejected"
    assert only_counted(trials, [long._replace(counts=True), short._replace(counts=False)]).verdict[0] == "ok"


def test_a_repeated_press_is_missing_to_nobody(trials):
    presses = [SessionPress(start_s - 0.2, start_s + 3, True, "") for start_s in (3.0, 8.0, 13.0)]
    presses.append(SessionPress(17.8, 21.0, False, "operator: repeat: too fast"))
    found = judge_session("P01", [only_counted(trials, presses)], {}, {"S1": 3}, {})
    assert found.verdict == "good"
    (own,) = found.specimens
    assert (own.found, own.ok, own.rejected) == (3, 3, 0)
    assert own.problems == ("press 4 rejected: operator: repeat: too fast",)
    one_short = judge_session("P01", [only_counted(trials, presses)], {}, {"S1": 4}, {})
    assert one_short.verdict == "repeat" or "3 presses found, 4 wanted" in one_short.specimens[0].problems


def test_nothing_is_to_be_done_about_a_press_that_was_put_aside():
    assert remedy_of("press 4 rejected: operator: repeat: lasted 0.3 s, shorter than 0.5 s") == ""
