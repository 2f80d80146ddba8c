"""EMG channels of unequal rates and starts in one recording."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import SignalError
from emg2vsa.signals.pairing import band_limited_at

RISE = [(0, 0), (2.6, 7.6), (2.9, 7.6), (3.6, 0)]
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
