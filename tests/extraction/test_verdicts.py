"""Each verdict provoked, and its reason: on EMG, on force, and on the sign of the force.

Presses that say the same are named once.

Every reason has a remedy, and the page for coordinators lists them all.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.extraction.reasons import grouped, most_frequent
from emg2vsa.extraction.remedies import REMEDIES, remedy_of
from emg2vsa.settings import ForceChannelSettings, WindowSettings
from scripts.reasons import table

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


def with_a_hole(samples):
    samples[3000:3400] = np.nan
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
        (hum, "ok", "mains is"),
        (held, "ok", "EDC holds one value for 50 ms"),
        (held_long, "rejected", "EDC holds one value for 600 ms"),
        (upsampled, "ok", "EDC repeats 50 % of its samples"),
        (with_gaps, "ok", "EDC misses 3 samples"),
        (with_a_hole, "rejected", "EDC misses 400 samples"),
        (noisy, "ok", "dB over rest"),
        (off, "rejected", "EDC is as silent as at rest ("),
        (quieter, "ok", "EDC is -"),
    ],
)
def test_verdicts_on_emg(change, verdict, reason, one_press):
    trials = one_press(change_emg=change)
    assert trials.verdict.tolist() == [verdict]
    assert reason in trials.reasons[0]
    assert "FDS" not in trials.reasons[0]
    # 50 ms of one value are left out, with 25 ms of the envelope's memory on either side
    assert np.count_nonzero(np.isnan(trials.activity)) == {held: 10}.get(change, 0)


@pytest.mark.parametrize("length", [26, 60, 400, 900])
def test_a_gap_is_told_as_one_thing(length, one_press):
    """Not as held samples, a straight line or a movement as well."""

    def with_a_gap(samples):
        samples[3000 : 3000 + length] = np.nan
        return samples

    (reason,) = one_press(change_emg=with_a_gap).reasons
    assert f"EDC misses {length} samples" in reason
    assert not any(word in reason for word in ("held", "holds", "line", "moves", "repeats"))


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
        (FALLS_A_LITTLE, "ok", "force falls on"),
        ([(0, 0), (0.02, 0.4), (2.1, 0.4), (4.6, 7.6), (5.6, 0)], "ok", "force rests at 0.4"),
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
    assert extract(emg, force, window=wide, force_channel=zeroed).verdict.tolist() == ["ok"]
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


def test_equal_reasons_are_one_line_with_the_range_of_their_numbers():
    said = [
        (1, "rejected", "lasted 0.33 s, shorter than 0.5 s; EDC is -0.6 dB over rest"),
        (2, "rejected", "lasted 0.28 s, shorter than 0.5 s; EDC is -2.8 dB over rest"),
        (3, "ok", ""),
        (4, "rejected", "lasted 2e-05 s, shorter than 0.5 s; EDC is 0.1 dB over rest"),
        (5, "doubtful", "mains is 38 % of the power of EDC"),
    ]
    assert grouped(said) == [
        "presses 1-2, 4 rejected: lasted 2e-05 to 0.33 s, shorter than 0.5 s; EDC is -2.8 to 0.1 dB over rest",
        "press 5 doubtful: mains is 38 % of the power of EDC",
    ]


def test_names_with_numbers_and_verdicts_stay_apart():
    said = [(1, "rejected", "EMG 1 is flat"), (2, "rejected", "EMG 2 is flat"), (3, "doubtful", "EMG 2 is flat")]
    assert len(grouped(said)) == 3
    assert grouped([(1, "rejected", "EMG 2 misses 3 samples"), (2, "rejected", "EMG 2 misses 40 samples")]) == [
        "presses 1-2 rejected: EMG 2 misses 3 to 40 samples"
    ]


@given(st.lists(st.tuples(st.sampled_from(["doubtful", "rejected"]), st.integers(-99, 99)), max_size=12))
def test_every_press_is_named_once(said):
    lines = grouped([(i, verdict, f"EDC is {n} dB over rest") for i, (verdict, n) in enumerate(said, 1)])
    named = []
    for line in lines:
        for part in line.split(maxsplit=1)[1].split(" doubtful")[0].split(" rejected")[0].split(", "):
            first, _, last = part.partition("-")
            named += range(int(first), int(last or first) + 1)
    assert sorted(named) == list(range(1, len(said) + 1))


def test_the_most_frequent_kinds_are_counted_with_the_range_of_their_numbers():
    said = ["EDC is flat", "force falls on 3.4 % of its path", "FDS is flat", "force falls on 3.6 % of its path"]
    assert most_frequent(said, 2) == ["force falls on 3.4 to 3.6 % of its path (2)", "EDC is flat (1)"]
    assert most_frequent([], 5) == []


PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "coordinator.md"


def test_examples_are_found_by_their_own_pattern_first():
    for remedy in REMEDIES:
        first = next(each for each in REMEDIES if re.fullmatch(each.found, remedy.example))
        assert first is remedy, remedy.example
        assert remedy.means


def test_the_cause_goes_before_what_follows_from_it():
    line = "presses 1-2, 4 rejected: its fit explains too little (adjusted R2 -0.05); EDC has spikes: 2 samples far"
    assert "plugs" in remedy_of(line)
    assert "3 s" in remedy_of("press 1 rejected: lasted 0.42 s, shorter than 0.5 s; record begins at 5.81 N")
    assert remedy_of("a reason that nobody has written") == ""


def test_the_page_for_coordinators_has_the_tables_of_the_code():
    page = PAGE.read_text(encoding="utf-8")
    for rejects in (True, None, False):
        assert table(rejects) in page, "run python scripts/reasons.py"
