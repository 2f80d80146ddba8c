"""The verdict on a press is that of ``emg2vsa check``, and what only a live session knows."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.recordings import Channel
from emg2vsa.session.journal import PressEnded
from emg2vsa.session.live_press import FoundPress, HowJudged, StayJudged, judge_attempt, judge_stay
from emg2vsa.session.press_cycle import Attempt
from emg2vsa.session.state import specimen_fit
from emg2vsa.session_settings import SessionSettings
from emg2vsa.settings import (
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    SimulationSettings,
    WindowSettings,
)
from emg2vsa.worlds.people.recording import RecordingStream

SETTINGS = SessionSettings(emg=SimulatedEmgSettings(), force=SimulatedForceSettings())
HOW = HowJudged(FilterSettings(), WindowSettings(), ForceChannelSettings(name="force"), FitSettings())


def around(**known):
    return PressEnded(1, 1, 10.3, 13.0, **known)


@pytest.fixture(scope="module")
def stay():
    """A made stay of four presses, and its attempts as a session would have seen them."""
    made = RecordingStream(
        np.random.SeedSequence(3), SimulationSettings(repetitions=4), a_v=28e-6, b_v=13e-6, window_n=(0.5, 7.0)
    ).whole()
    emg = {m: Channel(m, x, "V", made.fs_hz, 100.0, "") for m, x in made.emg_v.items()}
    force = Channel("force", made.force_n, "N", made.fs_hz, 100.0, "")
    attempts = [
        Attempt(
            100 + onset - 0.6, begun_s=100 + onset, stop_s=100 + stop, end_s=101 + stop, peak_n=7.5, ending="lifted"
        )
        for onset, stop in zip(made.truth.presses.onset_s, made.truth.presses.stop_s, strict=True)
    ]
    return emg, force, attempts, made.truth


def test_every_attempt_finds_its_press_and_its_slope(stay):
    emg, force, attempts, truth = stay
    judged = judge_stay(emg, force, "P03", "S3", HOW)
    assert judged.failed == ""
    for attempt, b_v in zip(attempts, truth.b_v, strict=True):
        own = judge_attempt(around(), attempt, judged, SETTINGS, HOW.window, {})
        assert own.verdict != "rejected"
        assert own.values["b_v"] == pytest.approx(b_v, rel=0.3)


def test_a_press_is_judged_when_only_the_first_has_been_done(stay):
    emg, force, attempts, _ = stay
    end = round((attempts[0].end_s + 0.5 - 100) * force.fs_hz)
    cut = {m: dataclasses.replace(c, samples=c.samples[:end]) for m, c in emg.items()}
    judged = judge_stay(cut, dataclasses.replace(force, samples=force.samples[:end]), "P03", "S3", HOW)
    assert judge_attempt(around(), attempts[0], judged, SETTINGS, HOW.window, {}).verdict != "rejected"


@pytest.mark.parametrize("half", [True, False])
def test_a_sensor_that_dies_late_or_sends_half_costs_no_press_before_it(stay, half):
    """From the third press on: every second frame, or nothing, of one muscle."""
    emg, force, attempts, _ = stay
    channel = emg["FDS"]
    gone = np.arange(channel.samples.size) >= round((attempts[1].end_s + 0.5 - 100) * channel.fs_hz)
    gone &= (np.arange(gone.size) // 26 % 2 == 0) | (not half)
    spoilt = emg | {"FDS": dataclasses.replace(channel, samples=np.where(gone, np.nan, channel.samples))}
    judged, whole = (judge_stay(each, force, "P03", "S3", HOW) for each in (spoilt, emg))
    assert judged.failed == ""
    for attempt, usable in zip(attempts, (True, True, False, False), strict=True):
        own, before = (judge_attempt(around(), attempt, each, SETTINGS, HOW.window, {}) for each in (judged, whole))
        assert (own.verdict != "rejected") == usable
        if usable:
            assert own.values["b_v"] == pytest.approx(before.values["b_v"], rel=0.01)
        else:
            assert own.problems[0][0].startswith("FDS misses ")


def test_a_long_gap_at_one_press_has_no_say_in_the_lag_of_the_others():
    """2.5 s of all channels."""
    made = RecordingStream(
        np.random.SeedSequence(3), SimulationSettings(repetitions=8), a_v=28e-6, b_v=13e-6, window_n=(0.5, 7.0)
    ).whole()

    def gapped(name, samples, unit):
        from_onset_s = np.arange(samples.size) / made.fs_hz - made.truth.presses.onset_s[2]
        return Channel(name, np.where(np.abs(from_onset_s + 0.25) < 1.25, np.nan, samples), unit, made.fs_hz, 0.0, "")

    emg = {muscle: gapped(muscle, samples, "V") for muscle, samples in made.emg_v.items()}
    judged = judge_stay(emg, gapped("force", made.force_n, "N"), "P03", "S3", HOW)
    assert [press.verdict for press in judged.presses] == ["ok", "ok", "rejected"] + 5 * ["ok"]
    assert not any("lag" in press.reasons for press in judged.presses)


GOOD = Attempt(10.0, begun_s=10.3, stop_s=12.5, end_s=13.0, peak_n=7.6, ending="lifted")
FOUND = FoundPress(10.4, 12.6, "ok", "", 7.6, 28e-6, 13e-6, True)


@pytest.mark.parametrize(
    ("change", "ended", "verdict", "said"),
    [
        ({}, around(), "ok", ""),
        ({"early": True}, around(), "rejected", "before START"),
        ({"begun_s": 10.05}, around(), "rejected", "50 ms after START"),
        ({"begun_s": 12.0}, around(), "warned", "2.0 s after START"),
        ({"end_s": 15.0}, around(), "rejected", "not lifted within 2 s"),
        ({"peak_n": 9.5}, around(), "warned", "9.5 N"),
        ({"zero_n": 0.1}, around(), "warned", "+0.10 N before START"),
        ({"zero_n": -0.25}, around(), "rejected", "-0.25 N before START"),
        ({"ending": "aborted"}, around(), "rejected", "aborted"),
        ({"ending": "interrupted", "why": "EMG lost"}, around(), "rejected", "EMG lost"),
        ({}, around(lost_share=0.002), "warned", "0.2 % of the samples are lost"),
        ({}, around(lost_share=0.02), "rejected", "2 % of the samples are lost"),
        ({}, around(lost_share=1.1), "rejected", "100 % of the samples are lost"),
        ({}, around(uneven=True), "rejected", "some twice"),
        ({}, around(hidden=True), "rejected", "hidden"),
        ({}, around(age_ms=80.0), "warned", "80 ms late"),
    ],
)  # fmt: skip
def test_what_only_a_live_session_knows(change, ended, verdict, said):
    attempt = dataclasses.replace(GOOD, **change)
    judged = judge_attempt(ended, attempt, StayJudged((FOUND,)), SETTINGS, HOW.window, {})
    assert judged.verdict == verdict
    assert said in (judged.problems[0][0] if judged.problems else "")
    assert all(do for _, do in judged.problems)


@pytest.mark.parametrize(
    ("found", "verdict", "said"),
    [
        ({"stop_s": 11.0}, "warned", "loaded in 0.60 s"),
        ({"stop_s": 16.4}, "warned", "loaded in 6.0 s"),
        ({"verdict": "rejected", "reasons": "reached 5.6 of 7 N; EDC is 3.2 dB over rest", "peak_n": 5.6}, "rejected",
         "reached 5.6 of 7 N"),
        ({"start_s": 90.0, "stop_s": 92.0}, "rejected", "no press here"),
    ],
)  # fmt: skip
def test_what_the_analysis_says_of_the_press(found, verdict, said):
    stay = StayJudged((dataclasses.replace(FOUND, **found),))
    judged = judge_attempt(around(), GOOD, stay, SETTINGS, HOW.window, {})
    assert judged.verdict == verdict
    assert said in judged.problems[0][0]
    assert judged.problems[0][1]


def presses(b_v, a_v=28e-6):
    return [(a_v, b) for b in b_v]


def test_the_interval_of_b_covers_its_truth_as_often_as_it_says():
    rng = np.random.default_rng(4)
    inside = 0
    for _ in range(400):
        fit = specimen_fit("S3", presses((13e-6 + 2e-6 * rng.standard_normal(10)).tolist()), 0.95, SETTINGS, 10)
        inside += fit.low_v <= 13e-6 <= fit.high_v
    assert 0.92 <= inside / 400 <= 0.98


def test_more_presses_are_suggested_by_width_alone_and_only_where_the_study_says_so():
    by_width = dataclasses.replace(SETTINGS, stop="width", width=0.05)
    wide, narrow = [8e-6, 18e-6, 12e-6], [13e-6, 13.1e-6, 12.9e-6]
    assert specimen_fit("S3", presses(wide), 0.95, SETTINGS, 3).suggestion == ""
    assert "One more press" in specimen_fit("S3", presses(wide), 0.95, by_width, 3).suggestion
    assert specimen_fit("S3", presses(narrow), 0.95, by_width, 3).suggestion == ""
    assert specimen_fit("S3", presses(wide), 0.95, by_width, by_width.most_presses).suggestion == ""
    assert specimen_fit("S3", presses(wide[:1]), 0.95, by_width, 3) is None


@pytest.mark.parametrize("shift_v", [-20e-6, 0.0, 40e-6])
def test_the_size_of_b_never_changes_the_suggestion(shift_v):
    by_width = dataclasses.replace(SETTINGS, stop="width", width=0.1)
    for spread in (0.5e-6, 1e-6, 3e-6):
        of = [specimen_fit("S3", presses([13e-6 + s + k * spread for k in (-1, 0, 1)]), 0.95, by_width, 3).suggestion
              for s in (0.0, shift_v)]  # fmt: skip
        assert of[0] == of[1]
