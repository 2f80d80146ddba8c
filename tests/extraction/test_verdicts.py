"""Each verdict provoked, and its reason: on EMG, on force, and on the sign of the force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.settings import ForceChannelSettings, WindowSettings

FS_HZ = 1000.0
RISE = [(0, 0), (2.6, 7.6), (2.9, 7.6), (3.6, 0)]


def clipped(samples):
    return np.clip(samples, -1e-5, 1e-5)


def flat(samples):
    return np.zeros_like(samples)


def hum(samples):
    return samples + 2e-5 * np.sin(2 * np.pi * 50 * np.arange(samples.size) / FS_HZ)


def held(samples):
    samples[3000:3050] = samples[3000]
    return samples


def held_long(samples):
    samples[2800:3400] = samples[2800]
    return samples


def upsampled(samples):
    return np.repeat(samples[::2], 2)[: samples.size]


def with_gaps(samples):
    samples[3000:3003] = np.nan
    return samples


def noisy(samples):
    return samples + 1.5e-5 * np.random.default_rng(3).standard_normal(samples.size)


def off(samples):
    return 1e-5 * np.random.default_rng(3).standard_normal(samples.size)


def quieter(samples):
    """Loud in the rests alone, as of a finger held up between the presses."""
    return samples + 1e-4 * np.random.default_rng(3).standard_normal(samples.size) * (samples**2 < 3e-11)


@pytest.mark.parametrize(
    ("change", "verdict", "reason"),
    [
        (clipped, "rejected", "EDC clips in"),
        (flat, "rejected", "EDC is flat"),
        (hum, "warned", "mains is"),
        (held, "warned", "EDC holds one value for 50 ms"),
        (held_long, "rejected", "EDC holds one value for 600 ms"),
        (upsampled, "warned", "EDC repeats 50 % of its samples"),
        (with_gaps, "rejected", "EDC misses 3 samples"),
        (noisy, "warned", "dB over rest"),
        (off, "rejected", "EDC is as silent as at rest ("),
        (quieter, "warned", "EDC is -"),
    ],
)
def test_verdicts_on_emg(change, verdict, reason, one_press):
    trials = one_press(change_emg=change)
    assert trials.verdict.tolist() == [verdict]
    assert reason in trials.reasons[0]
    assert "FDS" not in trials.reasons[0]
    assert np.all(np.isfinite(trials.activity))


@pytest.mark.parametrize("offset_n", [0.3, -20.0])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("dead", [(), ("EDC",)])
def test_a_wrong_sign_is_noticed(offset_n, sign, dead, force_of, recorded, extract):
    held = [(0, 0), (2.0, 7.6), (4.5, 7.6), (5.5, 0)]
    emg, force = recorded(force_of(*[held] * 3, rest_s=1.0))
    emg |= {name: replace(emg[name], samples=off(emg[name].samples)) for name in dead}
    reversed_force = replace(force, samples=offset_n - force.samples)
    trials = extract(emg, reversed_force, force_channel=ForceChannelSettings(name="Fz", sign=sign))
    assert trials.verdict.tolist() == ["rejected"] * 3
    assert set(trials.reasons) == {f"force rises while EMG is below its rest; is its sign {-sign}?"}
    assert trials.fault == trials.reasons[0]
    assert trials.fault in trials.notes


def test_a_wrong_sign_without_presses_is_noticed(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 3))
    trials = extract(emg, replace(force, samples=-force.samples))
    assert trials.verdict.size == 0
    assert trials.fault.endswith("is its sign -1?")


@pytest.mark.parametrize("dead", [("EDC",), ("FDS",), ("EDC", "FDS")])
def test_dead_electrodes_are_no_wrong_sign(dead, force_of, channel, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 4))
    off_v = {name: 1e-6 * np.random.default_rng(i).standard_normal(force.samples.size) for i, name in enumerate(dead)}
    trials = extract({**emg, **{name: channel(samples) for name, samples in off_v.items()}}, force)
    assert trials.fault == ""
    assert trials.verdict.tolist() == ["rejected"] * 4
    assert all(f"{name} is as silent as at rest" in reason for name in dead for reason in trials.reasons)


def test_one_muscle_quieter_than_at_rest_is_no_wrong_sign(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 3))
    emg["EDC"] = replace(emg["EDC"], samples=quieter(emg["EDC"].samples))
    assert extract(emg, force).fault == ""


def test_a_held_grip_with_short_rests_is_no_wrong_sign(force_of, recorded, extract):
    held = [(0, 0), (2.0, 7.6), (12.0, 7.6), (12.5, 0)]
    trials = extract(*recorded(force_of(*[held] * 3, rest_s=0.8)))
    assert trials.fault == ""
    assert trials.verdict.tolist() == ["ok"] * 3


def test_the_tare_says_how_many_rests(force_of, recorded, extract):
    held = [(0, 0), (2.0, 7.6), (6, 7.6)]
    said = [note for note in extract(*recorded(force_of(held, rest_s=1.0)[:-999])).notes if "tared" in note]
    assert said[0].startswith("force: tared on 1 rest, median 0.3")


SLOW_RISE = [(0, 0), (26, 7.6), (27, 0)]


FALLS = [(0, 0), (1, 4), (1.5, 3), (3, 7.6), (4, 0)]


FALLS_A_LITTLE = [(0, 0), (1, 4), (1.4, 3.65), (3, 7.6), (4, 0)]


@pytest.mark.parametrize(
    ("press", "verdict", "reason"),
    [
        ([(0, 0), (2, 5.2), (3, 0)], "rejected", "reached 5."),
        ([(0, 0), (0.4, 7.8), (0.9, 7.8), (2, 0)], "rejected", "shorter than 0.5 s"),
        (SLOW_RISE, "rejected", "longer than 20 s"),
        (FALLS, "rejected", "force falls on"),
        (FALLS_A_LITTLE, "warned", "force falls on"),
        ([(0, 0), (0.02, 0.4), (2.1, 0.4), (4.6, 7.6), (5.6, 0)], "warned", "force rests at 0.4"),
    ],
)
def test_verdicts_on_force(press, verdict, reason, force_of, recorded, extract):
    force_n = force_of(press, RISE, RISE, rest_s=3.0)
    trials = extract(*recorded(force_n))
    assert trials.verdict.tolist() == [verdict, "ok", "ok"]
    assert reason in trials.reasons[0]
    assert trials.reasons[0].startswith(reason) or verdict == "rejected"


def test_missing_force_rejects_the_trial_that_holds_it(one_press):
    def lose(samples):
        samples[3000:3004] = np.nan
        return samples

    trials = one_press(change_force=lose)
    assert trials.verdict.tolist() == ["rejected"]
    assert "force misses 4 samples" in trials.reasons[0]


def test_emg_that_ends_early_does_not_cover_the_trial(force_of, recorded, extract):
    emg, force = recorded(force_of(RISE, RISE))
    short = {name: replace(c, samples=c.samples[:9000]) for name, c in emg.items()}
    trials = extract(short, force)
    assert trials.verdict.tolist() == ["ok", "rejected"]
    assert "does not cover" in trials.reasons[1]
    none = extract({name: replace(c, samples=c.samples[:7000]) for name, c in emg.items()}, force)
    assert none.offsets[2] == none.offsets[1]
    assert none.verdict.tolist() == ["ok", "rejected"]


def test_a_record_that_begins_in_its_only_ramp(recorded, extract):
    ramp = np.interp(np.arange(0, 6, 1 / FS_HZ), [0, 3, 4, 6], [1.5, 8, 8, 7.5])
    emg, force = recorded(ramp - 0.3)
    trials = extract(emg, force)
    assert trials.verdict.tolist() == ["rejected"]
    assert trials.tare == "impossible"
    assert "record begins at 1.5" in trials.reasons[0]
    assert "force is not tared: the record never rests" in trials.reasons[0]
    zeroed, wide = ForceChannelSettings(name="Fz", tare="none"), WindowSettings(max_missed_n=1.1)
    assert extract(emg, force, window=wide, force_channel=zeroed).verdict.tolist() == ["warned"]
    assert trials.start_s.tolist() == [0.0]
    assert trials.rest_force_n == 0
    assert np.isnan(trials.snr_db).all()
    assert any("tare impossible" in note for note in trials.notes)


@pytest.mark.parametrize(("offset", "counts"), [(-26, False), (-25, True), (0, True)])
def test_quality_is_of_the_samples_under_the_kernel_from_the_first_on(one_press, offset, counts):
    """51 taps reach 25 samples before the first instant of the envelope, which is a multiple of 10 samples."""
    first = 10 * math.ceil(100 * one_press().start_s[0] - 1e-9)

    def lost(samples):
        samples[first + offset] = np.nan
        return samples

    assert ("EDC misses 1 samples" in one_press(lost).reasons[0]) is counts


@pytest.mark.parametrize(("offset", "counts"), [(0, True), (25, True), (26, False)])
def test_quality_is_of_the_samples_under_the_kernel_to_the_last(one_press, offset, counts):
    whole = one_press()
    last = 10 * (math.ceil(100 * whole.start_s[0] - 1e-9) + whole.force_n.size - 1)

    def lost(samples):
        samples[last + offset] = np.nan
        return samples

    assert ("EDC misses 1 samples" in one_press(lost).reasons[0]) is counts
