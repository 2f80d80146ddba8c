"""Trials out of continuous recordings: pairing in time, verdicts, hostile input, real files.

Levels of maximum contractions: what was put in is found, and too short a recording is refused.

One level for a whole session: the largest envelope of each muscle in its trials that were not rejected.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from emg2vsa.errors import SettingError, SignalError
from emg2vsa.extraction.contractions import contraction_levels_v
from emg2vsa.extraction.rests import rests_differ
from emg2vsa.fits import in_session
from emg2vsa.settings import PAPER, CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.filters import one_pass_band_hz
from emg2vsa.signals.pairing import Instants

FS_HZ = 1000.0
RISE = [(0, 0), (2.6, 7.6), (2.9, 7.6), (3.6, 0)]


def test_a_good_session(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 4))
    trials = extract(emg, force, notes=("a note of the reader",))
    assert trials.verdict.tolist() == ["ok"] * 4
    assert trials.reasons == ("",) * 4
    assert trials.repetition.tolist() == [1, 2, 3, 4]
    assert trials.muscles == ("EDC", "FDS")
    truth_s = 2 + 5.6 * np.arange(4) + 2.6 * 0.5 / 7.6
    assert trials.start_s == pytest.approx(truth_s, abs=0.02)
    assert trials.duration_s == pytest.approx([2.6 * 6.5 / 7.6] * 4, abs=0.03)
    assert trials.rest_force_n == pytest.approx(0.3, abs=1e-3)
    assert trials.activity_unit == "V"
    assert trials.rates_hz == (*(channel.fs_hz for channel in emg.values()), force.fs_hz)
    assert np.array_equal(trials.activity, trials.envelopes_v.sum(axis=0))
    assert trials.offsets[-1] == trials.force_n.size == trials.activity.size
    assert trials.notes[0] == "a note of the reader"
    assert any("as stored" in note for note in trials.notes)
    assert trials.overview_force_n.size == trials.overview_time_s.size == pytest.approx(10 * force.duration_s, abs=1)


def test_a_press_on_an_overloaded_transducer_is_rejected(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 3))
    overloaded = np.zeros(force.samples.size, bool)
    overloaded[9000:9010] = True  # 9 s: the rise of the second press
    trials = extract(emg, replace(force, overloaded=overloaded))
    assert trials.verdict.tolist() == ["ok", "rejected", "ok"]
    assert trials.reasons[1] == "transducer overloaded in 10 samples"


def test_envelopes_are_those_of_the_whole_record(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 3))
    trials = extract(emg, force, filters=FilterSettings(mains="keep", rest_level="keep"))
    edges = one_pass_band_hz((10.0, 450.0), 2, "zero-phase", FS_HZ)
    sos = signal.butter(2, edges, "bandpass", fs=FS_HZ, output="sos")
    taps = signal.firwin(51, 20.0, fs=FS_HZ)
    for row, name in enumerate(trials.muscles):
        whole = np.convolve(np.abs(signal.sosfiltfilt(sos, emg[name].samples)), taps, "same")
        for i, start_s in enumerate(trials.start_s):
            got = trials.envelopes_v[row, trials.offsets[i] : trials.offsets[i + 1]]
            first = int(np.ceil(start_s * 100)) * 10
            assert got == pytest.approx(whole[first : first + 10 * got.size : 10], rel=1e-9)


def test_force_is_the_filtered_tared_force_at_the_envelopes(force_of, recorded, extract):
    emg, force = recorded(force_of(RISE))
    trials = extract(emg, force, filters=FilterSettings(output_fs_hz="native"))
    edge_hz = np.arctan(np.tan(np.pi * 5.0 / FS_HZ) / (np.sqrt(2) - 1) ** 0.25) * FS_HZ / np.pi  # two passes: 5 Hz
    low = signal.butter(2, edge_hz, fs=FS_HZ, output="sos")
    whole = signal.sosfiltfilt(low, force.samples) - trials.rest_force_n
    first = int(np.ceil(trials.start_s[0] * FS_HZ))
    assert trials.fs_hz == FS_HZ
    assert trials.force_n == pytest.approx(whole[first : first + trials.force_n.size], abs=1e-9)
    assert 0.5 <= trials.force_n[0] < 0.51
    assert 6.99 < trials.force_n[-1] <= 7.0


def known_lag_s(trials, rise_s=2.6):
    """How far EMG lags force, from an EMG whose level is a straight ramp of force."""
    slope, level = np.polyfit(trials.force_n, trials.activity, 1)
    force_at_level = -level / slope
    return force_at_level * rise_s / 7.6


def ramp_emg(force_n):
    """A carrier of constant amplitude (an alternating square wave at 125 Hz) on a level that follows force."""
    carrier = np.where(np.arange(force_n.size) // 4 % 2, 1.0, -1.0)
    return {"EDC": 1e-5 * force_n * carrier}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("phase", ["zero-phase", "compensated", "causal"])
def test_the_budget_states_what_a_known_signal_shows(phase, order, force_of, recorded, extract):
    force_n = force_of(RISE)
    emg, force = recorded(force_n, emg=ramp_emg(force_n))
    filters = FilterSettings(phase=phase, force_order=order, output_fs_hz="native")
    trials = extract(emg, force, filters=filters, window=WindowSettings(force_n=(2.0, 6.0)))
    mismatch_s = trials.delay.mismatch_s
    assert known_lag_s(trials) == pytest.approx(mismatch_s, abs=1.5e-3)
    if phase == "causal":
        assert mismatch_s == pytest.approx(0.025 - (0.0318 if order == 1 else 0.0450), abs=2e-3)
        assert trials.delay.removed_s == 0
    else:
        assert mismatch_s == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("phase", ["zero-phase", "compensated", "causal"])
def test_the_delay_of_the_force_sensor_is_removed(phase, force_of, recorded, extract):
    force_n = force_of(RISE)
    emg, force = recorded(force_n, emg=ramp_emg(force_n))
    late = replace(force, samples=np.concatenate([np.full(80, force.samples[0]), force.samples[:-80]]))
    settings = {"filters": FilterSettings(phase=phase), "window": WindowSettings(force_n=(2.0, 6.0))}
    told = extract(emg, late, force_channel=ForceChannelSettings(name="Fz", delay_s=0.08), **settings)
    untold = extract(emg, late, **settings)
    on_time = extract(emg, force, **settings)
    assert known_lag_s(told) == pytest.approx(known_lag_s(on_time), abs=1e-3)
    assert known_lag_s(untold) == pytest.approx(known_lag_s(on_time) - 0.08, abs=1e-3)
    assert told.start_s == pytest.approx(on_time.start_s, abs=1e-6)
    assert dict(told.delay.parts)["force sensor"] == 0.08
    assert told.delay.mismatch_s == pytest.approx(on_time.delay.mismatch_s, abs=1e-12)


def test_unequal_rates_and_starts(force_of, channel, recorded, extract):
    fine = force_of(RISE, RISE, fs_hz=FS_HZ)
    emg, force = recorded(fine)
    same = extract(emg, force)
    slow = channel(force_of(RISE, RISE, fs_hz=200.0, start_s=0.5) + 0.3, "N", 200.0, start_s=0.5)
    other = extract(emg, slow)
    assert other.start_s == pytest.approx(same.start_s, abs=2e-3)
    assert np.array_equal(other.offsets, same.offsets)
    assert other.activity == pytest.approx(same.activity)
    assert other.force_n == pytest.approx(same.force_n, abs=5e-3)


def test_a_later_clock_moves_times_only(force_of, recorded, extract):
    emg, force = recorded(force_of(RISE))
    here = extract(emg, force)
    there = extract({k: replace(c, start_s=100.0) for k, c in emg.items()}, replace(force, start_s=100.0))
    assert there.start_s == pytest.approx(here.start_s + 100)
    assert there.activity == pytest.approx(here.activity)


def test_expected_number_of_presses(force_of, recorded, extract):
    emg, force = recorded(force_of(RISE, RISE))
    trials = extract(emg, force, window=WindowSettings(expected_trials=3))
    assert any("2 found, 3 expected" in note for note in trials.notes)


def test_no_press_gives_no_trials_and_says_so(recorded, extract):
    trials = extract(*recorded(np.zeros(5000)))
    assert trials.verdict.shape == (0,)
    assert trials.offsets.tolist() == [0]
    assert trials.envelopes_v.shape == (2, 0)
    assert any("presses: none" in note for note in trials.notes)


def test_the_nyquist_rule_is_in_the_notes(one_press):
    trials = one_press(filters=FilterSettings(band_hz=(10.0, 500.0)))
    assert any(note.startswith("NYQUIST RULE") for note in trials.notes)


def test_one_muscle(force_of, emg_of, recorded, extract):
    force_n = force_of(RISE)
    trials = extract(*recorded(force_n, emg={"FDS": emg_of(force_n, 1.0, 5)}))
    assert np.array_equal(trials.activity, trials.envelopes_v[0])
    with pytest.raises(SettingError, match="rudolph"):
        extract(
            *recorded(force_n, emg={"FDS": emg_of(force_n, 1.0, 5)}),
            cocontraction=CocontractionSettings(index="rudolph"),
        )


@pytest.mark.parametrize("n", [1, 3, 10])
def test_records_too_short(n, recorded, extract):
    with pytest.raises(SignalError, match="at least"):
        extract(*recorded(np.zeros(n)))


def test_hostile_channels(force_of, recorded, extract):
    emg, force = recorded(force_of(RISE))
    with pytest.raises(SignalError, match="finite"):
        extract(emg, replace(force, samples=np.full(force.samples.size, np.nan)))
    with pytest.raises(SignalError, match="at least one channel"):
        extract({}, force)
    constant = extract(emg, replace(force, samples=np.full(force.samples.size, 3.0)))
    assert constant.verdict.size == 0


def test_the_same_twice(force_of, recorded, extract):
    emg, force = recorded(force_of(RISE, RISE))
    first, second = extract(emg, force), extract(emg, force)
    assert first.activity.tobytes() == second.activity.tobytes()
    assert first.notes == second.notes


def test_openhdemg_ramp(shared_data, channel, extract):
    from scipy.io import loadmat

    stored = loadmat(shared_data("emg/emg_force/openhdemg_otb_testfile_VL64_force.mat"))
    data = stored["Data"][0, 0].astype(float)
    emg = {"VL": channel(1e-6 * (data[:, 10] - data[:, 15]), "V", 2048.0)}
    force = channel(data[:, 74], "N", 2048.0)
    window = WindowSettings(force_n=(2.0, 24.0))
    trials = extract(emg, force, window=window, force_channel=ForceChannelSettings(name="Fz", tare="none"))
    assert trials.verdict.size == 1
    assert trials.verdict[0] != "rejected"
    assert 4 < trials.duration_s[0] < 7
    tared = extract(emg, force, window=WindowSettings(force_n=(1.0, 24.0)))
    assert any("tared on 2 rests" in note for note in tared.notes)
    assert tared.tare == "rest"


def test_novainstrumentation_grip(shared_data, channel, extract):
    emg_file, force_file = (shared_data(f"emg/emg_force/novainstrumentation_{name}.txt") for name in ("emg", "force"))
    emg = {"grip": channel(1e-3 * np.loadtxt(emg_file)[1])}
    force = channel(np.loadtxt(force_file)[1], "N")
    trials = extract(emg, force, window=WindowSettings(force_n=(30.0, 85.0), min_duration_s=0.2))
    assert trials.verdict.size == 1
    assert 1.2 < trials.start_s[0] < 1.7
    assert np.corrcoef(trials.force_n, trials.activity)[0, 1] > 0


def test_c3d_force_plate(shared_data, channel, extract):
    ezc3d = pytest.importorskip("ezc3d")
    file = ezc3d.c3d(str(shared_data("emg/c3d/btk_PiG_Motion-FlatFoot-Full.c3d")))
    labels = file["parameters"]["ANALOG"]["LABELS"]["value"]
    analogs = file["data"]["analogs"][0]
    upright = -analogs[labels.index("Fz1")] if "Fz1" in labels else -analogs[labels.index("Force.Fz1")]
    muscle = next(i for i, label in enumerate(labels) if "EMG" in label.upper() or "GL" in label.upper())
    force = channel(upright, "N")
    window = WindowSettings(force_n=(20.0, 0.9 * float(upright.max())), min_duration_s=0.02)
    trials = extract({"leg": channel(analogs[muscle])}, force, window=window)
    assert trials.verdict.size >= 1
    assert np.all(np.isfinite(trials.force_n))


def test_paper_mode_only_tells_what_is_implausible(force_of, recorded, extract):
    """Rectified EMG, a unit, a zero of force that moved: rules newer than the paper may not change its means."""
    spoilt = {
        "rectified": (lambda x: np.abs(x), lambda f: f),
        "its unit mV": (lambda x: 1e3 * x, lambda f: f),
        "the zero of force moves": (lambda x: x, lambda f: f + 1.0 * (np.arange(f.size) > f.size / 2)),
    }
    paper = WindowSettings(**PAPER["window"])
    for word, (of_emg, of_force) in spoilt.items():
        emg, force = recorded(force_of(*[RISE] * 4))
        emg = {name: replace(one, samples=of_emg(one.samples)) for name, one in emg.items()}
        force = replace(force, samples=of_force(force.samples))
        told = extract(emg, force, window=paper)
        assert told.fault == ""
        assert "rejected" not in told.verdict
        assert told.repetition.size == 4
        assert word in "; ".join((*told.remarks, *told.reasons))
        usual = extract(emg, force, window=replace(paper, implausible="reject"))
        assert np.array_equal(usual.activity, told.activity)
        assert "rejected" in usual.verdict


def test_rests_differ_by_tone_and_not_by_noise() -> None:
    resting = Instants(np.array([0, 500, 1000]), np.full(3, 500), 1, np.ones(3, np.bool_))
    rng = np.random.default_rng(1)
    found = [rests_differ(1 + 0.1 * rng.standard_normal((2, 1500)), resting, 1000.0) for _ in range(200)]
    assert sum(found) <= 1
    toned = 1 + 0.1 * rng.standard_normal((2, 1500))
    toned[1, 500:1000] *= 1.2
    assert rests_differ(toned, resting, 1000.0)
    alone = Instants(np.array([0]), np.array([500]), 1, np.ones(1, np.bool_))
    assert not rests_differ(toned, alone, 1000.0)


def contraction(channel, level_v, seconds=6.0, held_s=2.0, seed=0):
    n = round(seconds * 1000)
    held = np.abs(np.arange(n) / 1000 - seconds / 2) < held_s / 2
    return channel(np.where(held, level_v, 2e-6) * np.random.default_rng(seed).standard_normal(n))


def test_the_largest_held_level_of_all_recordings(channel):
    parts = [
        {"EDC": contraction(channel, 4e-4), "FDS": contraction(channel, 1e-4, seed=1)},
        {"EDC": contraction(channel, 2e-4, seed=2), "FDS": contraction(channel, 3e-4, seed=3)},
    ]
    levels = contraction_levels_v(parts, FilterSettings(band_hz=(10.0, 499.0)))
    # mean rectified value of white noise through most of the band, the largest of a few half seconds
    assert levels["EDC"] == pytest.approx(4e-4 * np.sqrt(2 / np.pi), rel=0.1)
    assert levels["FDS"] == pytest.approx(3e-4 * np.sqrt(2 / np.pi), rel=0.1)


def test_one_peak_is_no_contraction(channel):
    levels = contraction_levels_v([{"EDC": contraction(channel, 4e-4, held_s=0.05)}], FilterSettings())
    assert levels["EDC"] < 0.25 * 4e-4


def test_too_short_a_recording(channel):
    with pytest.raises(SignalError, match="at least"):
        contraction_levels_v([{"EDC": channel(np.ones(20))}], FilterSettings())


SESSION_MAX = CocontractionSettings(normalise="session-max")


def test_the_largest_envelope_of_each_muscle_counts_as_one(by_hand):
    alone = in_session(by_hand, [by_hand], SESSION_MAX)
    assert alone.activity == pytest.approx([1 / 4 + 10 / 20, 2 / 4 + 1, 90 / 4 + 90 / 20, 99 / 4 + 99 / 20, 1.5, 1.25])
    assert alone.activity_unit == "1"
    assert alone.notes[0] == "a note"
    assert alone.notes[1].endswith("EDC 4 uV, FDS 20 uV")
    assert alone.envelopes_v is by_hand.envelopes_v


def test_recordings_of_a_session_share_their_level(by_hand):
    louder = replace(by_hand, specimen="S2", envelopes_v=2 * by_hand.envelopes_v)
    first, second = (in_session(part, [by_hand, louder], SESSION_MAX) for part in (by_hand, louder))
    assert second.activity == pytest.approx(2 * first.activity)
    assert second.activity == pytest.approx(in_session(by_hand, [by_hand], SESSION_MAX).activity)


def test_order_of_muscles_and_recordings_does_not_matter(by_hand):
    turned = replace(by_hand, muscles=("FDS", "EDC"), envelopes_v=3 * by_hand.envelopes_v[::-1])
    expected = in_session(by_hand, [by_hand, turned], SESSION_MAX).activity
    assert np.array_equal(in_session(by_hand, [turned, by_hand], SESSION_MAX).activity, expected)
    assert in_session(turned, [by_hand, turned], SESSION_MAX).activity == pytest.approx(3 * expected)


def test_a_recording_without_the_muscle_or_without_presses_sets_no_level(by_hand):
    alone = in_session(by_hand, [by_hand], SESSION_MAX).activity
    other = replace(by_hand, muscles=("EDC", "FCR"), envelopes_v=by_hand.envelopes_v * [[0.5], [100]])
    empty = replace(by_hand, verdict=by_hand.verdict[:0], offsets=np.zeros(1, np.int64), envelopes_v=np.empty((2, 0)))
    assert np.array_equal(in_session(by_hand, [by_hand, other, empty], SESSION_MAX).activity, alone)


def test_a_session_of_rejected_trials_only_gives_zero_not_infinity(by_hand):
    rejected = replace(by_hand, verdict=np.full(3, "rejected"))
    assert not in_session(rejected, [rejected], SESSION_MAX).activity.any()


def test_volts_stay_volts_where_nothing_is_normalised(by_hand):
    same = in_session(by_hand, [by_hand], CocontractionSettings())
    assert np.array_equal(same.activity, by_hand.activity)
    assert same.activity_unit == "V"


@pytest.mark.parametrize("at", [[5000], [100, 4000, 4001]])
def test_glued_readings_of_a_transducer_are_refused_before_presses_are_looked_for(force_of, recorded, extract, at):
    emg, force = recorded(force_of(RISE, RISE))
    samples = force.samples.copy()
    samples[at] = 3.1e8
    with pytest.raises(SignalError, match="two readings are glued") as told:
        extract(emg, replace(force, samples=samples))
    assert "3.1e+08 N" in str(told.value)
    # millinewtons that are labelled newtons change as smoothly as ever
    extract(emg, replace(force, samples=force.samples * 1e3))


def test_glued_readings_of_a_real_transducer(shared_data, recorded, force_of, extract):
    """One of six readings of a Mini45 is glued to the next: the usual change of force is then large as well."""
    text = shared_data("emg/ati/atusa_myo_mini45_raw_01.csv").read_text(encoding="utf-8").splitlines()[1:]
    samples = np.array([float(line.split(",")[0]) for line in text])
    emg, force = recorded(force_of(RISE, RISE))
    with pytest.raises(SignalError, match=r"747 jumps of up to 3\.1e\+08 N and back"):
        extract(emg, replace(force, samples=samples, fs_hz=243.0))


def test_lines_over_a_fifth_of_the_samples_reject_a_press(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 3))
    samples = emg["EDC"].samples.copy()
    begin = int((2 + 5.6 + 0.4) * FS_HZ)
    for at in range(begin, begin + 2000, 100):
        samples[at : at + 20] = 0.0
    trials = extract(emg | {"EDC": replace(emg["EDC"], samples=samples)}, force)
    assert trials.verdict.tolist() == ["ok", "rejected", "ok"]
    assert "EDC is held, or a straight line, in " in trials.reasons[1]


def test_force_of_the_wrong_sign_is_not_called_ac_coupled(force_of, recorded, extract):
    emg, force = recorded(force_of(*[RISE] * 6))
    trials = extract(emg, replace(force, samples=-force.samples))
    assert "sign" in trials.fault
