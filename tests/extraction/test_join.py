"""Presses of several recordings as if they were of one.

EMG channels of unequal rates and starts in one recording.
"""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from emg2vsa.errors import SignalError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.join import _JOINED, join_trials
from emg2vsa.signals.bias import BiasBudget, left_in
from emg2vsa.signals.pairing import band_limited_at

RISE = [(0, 0), (2.6, 7.6), (2.9, 7.6), (3.6, 0)]


def test_every_field_is_joined_somehow():
    by_hand = {"start_s", "stop_s", "overview_time_s", "overviews", "lag_s", "lag_se_s"}
    assert {field.name for field in fields(Trials)} == by_hand | set(_JOINED)


def test_presses_follow_each_other(force_of, recorded, extract):
    parts = [extract(*recorded(force_of(*[RISE] * n))) for n in (2, 1, 3)]
    joined = join_trials(parts, ["x/a.csv", "x/b.csv", "x/c.csv"])
    assert joined.repetition.tolist() == [1, 2, 3, 4, 5, 6]
    assert len(joined.reasons) == len(joined.verdict) == 6
    for i, (part, own) in enumerate([(0, 0), (0, 1), (1, 0), (2, 0), (2, 1), (2, 2)]):
        mine = slice(joined.offsets[i], joined.offsets[i + 1])
        theirs = slice(parts[part].offsets[own], parts[part].offsets[own + 1])
        np.testing.assert_array_equal(joined.force_n[mine], parts[part].force_n[theirs])
        np.testing.assert_array_equal(joined.envelopes_v[:, mine], parts[part].envelopes_v[:, theirs])
        assert joined.duration_s[i] == parts[part].duration_s[own]
    assert np.all(np.diff(joined.start_s) > 0)
    assert np.all(np.diff(joined.overview_time_s) > 0)
    shift = joined.start_s[2] - parts[1].start_s[0]
    assert shift == pytest.approx(round(shift))
    assert shift > parts[0].overview_time_s[-1]
    np.testing.assert_allclose(joined.stop_s[2] - joined.start_s[2], joined.duration_s[2])
    assert joined.notes[0].startswith("3 recordings joined: a.csv (presses 1 to 2, times + 0 s), b.csv (press 3, times")
    np.testing.assert_allclose(joined.rest_envelope_v, np.median([p.rest_envelope_v for p in parts], axis=0))


def test_one_recording_stays_as_it_is(force_of, recorded, extract):
    part = extract(*recorded(force_of(RISE)))
    assert join_trials([part], ["a"]) is part


def test_unlike_recordings_are_refused(force_of, recorded, extract):
    part = extract(*recorded(force_of(RISE)))
    with pytest.raises(SignalError, match=r"b: expected fs_hz 100.0 Hz, as in a, but found 50 Hz"):
        join_trials([part, replace(part, fs_hz=50)], ["a", "b"])


def test_a_fault_of_one_is_not_a_fault_of_all(force_of, recorded, extract):
    part = replace(extract(*recorded(force_of(RISE))), fault="", remarks=())
    faulty = replace(part, fault="is its sign -1?")
    joined = join_trials([part, faulty], ["x/a", "x/b"])
    assert (joined.fault, joined.remarks) == ("", ("b: is its sign -1?",))
    assert join_trials([faulty, faulty], ["a", "b"]).fault == "is its sign -1?"


def test_the_lag_is_the_mean_by_certainty(force_of, recorded, extract):
    part = extract(*recorded(force_of(RISE)))
    sure, unsure = replace(part, lag_s=0.05, lag_se_s=0.01), replace(part, lag_s=0.1, lag_se_s=0.02)
    unknown = replace(part, lag_s=np.nan, lag_se_s=np.nan)
    joined = join_trials([sure, unsure, unknown], ["a", "b", "c"])
    assert joined.lag_s == pytest.approx((0.05 * 4 + 0.1) / 5)
    assert joined.lag_se_s == pytest.approx(0.02)  # by what the two differ
    assert np.isnan(join_trials([unknown, unknown], ["a", "b"]).lag_s)


def test_recordings_of_one_press_tell_together_what_none_tells_alone(force_of, recorded, extract):
    part = extract(*recorded(force_of(RISE)))
    alone = [replace(part, lag_s=lag_s, lag_se_s=np.nan, remarks=(), fault="") for lag_s in (0.06, 0.061, 0.059, 0.06)]
    joined = join_trials(alone, ["a", "b", "c", "d"])
    assert joined.lag_s == pytest.approx(0.06)
    assert 0 < joined.lag_se_s < 0.002
    assert joined.remarks == ("force follows EMG by 60 ms, which 4 recordings together show",)
    shift = left_in("lag", np.zeros(1), np.array([-0.1]))
    told = [replace(one, bias=BiasBudget.of([shift], 1)) for one in alone]
    assert join_trials(told, ["a", "b", "c", "d"]).remarks == ()
    apart = [replace(part, lag_s=lag_s, lag_se_s=0.002, remarks=(), fault="") for lag_s in (-0.1, 0.0, 0.1)]
    assert "differs by 100 ms" in join_trials(apart, ["a", "b", "c"]).remarks[0]
    unsure = [replace(one, lag_se_s=0.1) for one in apart]
    assert join_trials(unsure, ["a", "b", "c"]).remarks == ()


def test_rest_that_only_one_recording_has(force_of, recorded, extract):
    part = extract(*recorded(force_of(RISE)))
    without = replace(part, rest_envelope_v=np.full(2, np.nan))
    np.testing.assert_array_equal(join_trials([without, part], ["a", "b"]).rest_envelope_v, part.rest_envelope_v)
    assert np.isnan(join_trials([without, without], ["a", "b"]).rest_envelope_v).all()


RNG = np.random.default_rng(7)
TONES_HZ, PHASES = RNG.uniform(20, 420, 60), RNG.uniform(0, 2 * np.pi, 60)


def emg_at(time_s, force_of, fs_hz=1000.0):
    """A known continuous EMG: tones times a level that follows the force."""
    force_n = force_of(*[RISE] * 3, fs_hz=fs_hz)
    level_v = 3e-6 + 3e-5 * np.log1p(np.interp(time_s, np.arange(force_n.size) / fs_hz, force_n))
    return level_v * np.sin(2 * np.pi * np.outer(time_s, TONES_HZ) + PHASES).sum(axis=1) / np.sqrt(30)


def at(channel, force_of, rate_hz, start_s=0.0):
    time_s = np.arange(start_s, 18.0, 1 / rate_hz)
    return channel(emg_at(time_s, force_of), "V", rate_hz, start_s)


@pytest.mark.parametrize(("rate_hz", "start_s"), [(1259.2593, 0.0), (1000.0, 0.0003), (1000.0, 0.7)])
def test_envelopes_are_those_of_equal_rates(force_of, channel, extract, rate_hz, start_s):
    force = channel(force_of(*[RISE] * 3) + 0.3, "N")
    same = extract({"EDC": at(channel, force_of, 2000), "FDS": at(channel, force_of, 2000)}, force)
    other = extract({"EDC": at(channel, force_of, 2000), "FDS": at(channel, force_of, rate_hz, start_s)}, force)
    assert other.repetition.size == same.repetition.size == 3
    assert other.fs_hz == same.fs_hz
    for i in range(3):
        a, b = (t.envelopes_v[:, t.offsets[i] : t.offsets[i + 1]] for t in (same, other))
        assert b.shape[1] == pytest.approx(a.shape[1], abs=1)
        n = min(a.shape[1], b.shape[1])
        np.testing.assert_allclose(b[:, :n].mean(axis=1), a[:, :n].mean(axis=1), rtol=2e-3)


def test_a_slow_channel_is_judged_by_its_own_samples(force_of, channel, extract):
    force = channel(force_of(*[RISE] * 3) + 0.3, "N")
    slow = at(channel, force_of, 1000)
    limit = np.quantile(np.abs(slow.samples), 0.97)
    clipped = channel(np.clip(slow.samples, -limit, limit), "V", 1000.0)
    found = extract({"EDC": at(channel, force_of, 2000), "FDS": clipped}, force)
    alone = extract({"FDS": clipped}, force)
    assert found.clip_share[1] == pytest.approx(alone.clip_share[0], rel=0.02)
    assert found.clip_share[1] > 0.005
    assert found.clip_share[0] == 0
    assert found.verdict.tolist() == ["rejected"] * 3


def test_channels_without_time_in_common(force_of, channel, extract):
    force = channel(force_of(*[RISE] * 3), "N")
    first, later = channel(np.ones(900), "V", 1000.0), channel(np.ones(900), "V", 500.0, 5.0)
    with pytest.raises(SignalError, match="expected channels with time in common"):
        extract({"EDC": first, "FDS": later}, force)


def test_band_limited_interpolation():
    index = np.arange(2000)
    for share in (0.05, 0.5, 0.9):
        position = 200 + 1600 * RNG.random(3000)
        error = band_limited_at(np.sin(np.pi * share * index), position) - np.sin(np.pi * share * position)
        assert np.abs(error).max() < 1e-3
    np.testing.assert_allclose(band_limited_at(index**2.0, np.arange(50.0, 60.0)), np.arange(50.0, 60.0) ** 2)
