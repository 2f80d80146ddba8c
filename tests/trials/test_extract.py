"""Trials out of continuous recordings: pairing in time, verdicts, hostile input, real files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from emg2vsa.errors import SettingError, SignalError
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.filters import one_pass_band_hz
from emg2vsa.trials.extract import extract_trials

FS_HZ = 1000.0
RISE = [(0, 0), (2.6, 7.6), (2.9, 7.6), (3.6, 0)]


def force_of(*presses, rest_s=2.0, fs_hz=FS_HZ, start_s=0.0):
    """Newtons at ``fs_hz`` from ``start_s`` on: rest, then each press as (seconds, newtons) knots, then rest."""
    knots, at = [(0.0, 0.0)], rest_s
    for press in presses:
        knots += [(at + t, f) for t, f in press]
        at += press[-1][0] + rest_s
    times, values = zip(*knots, strict=True)
    return np.interp(np.arange(start_s, at, 1 / fs_hz), times, values)


def emg_of(force_n, share, seed, fs_hz=FS_HZ):
    """Volts: Gaussian noise that follows force, on a rest tone of 1.5 uV."""
    rng = np.random.default_rng(seed)
    level_v = share * (3e-6 + 30e-6 * np.log1p(np.maximum(force_n, 0)))
    return level_v * rng.standard_normal(force_n.size)


def channel(samples, unit="V", fs_hz=FS_HZ, start_s=0.0):
    return Channel(unit, np.asarray(samples, dtype=float), unit, fs_hz, start_s, "as stored")


def recorded(force_n, *, emg=None, fs_hz=FS_HZ):
    emg = emg or {"EDC": emg_of(force_n, 0.4, 1, fs_hz), "FDS": emg_of(force_n, 0.6, 2, fs_hz)}
    return {name: channel(samples, "V", fs_hz) for name, samples in emg.items()}, channel(force_n + 0.3, "N", fs_hz)


def extract(emg, force, **settings):
    chosen = {
        "filters": FilterSettings(),
        "cocontraction": CocontractionSettings(),
        "window": WindowSettings(),
        "force_channel": ForceChannelSettings(name="Fz"),
        **settings,
    }
    return extract_trials(emg, force, participant="P01", specimen="S1", **chosen)


def one_press(change_emg=None, change_force=None, press=RISE, **settings):
    force_n = force_of(press)
    emg, force = recorded(force_n)
    if change_emg:
        emg["EDC"] = replace(emg["EDC"], samples=change_emg(emg["EDC"].samples.copy()))
    if change_force:
        force = replace(force, samples=change_force(force.samples.copy()))
    return extract(emg, force, **settings)


def test_a_good_session():
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
    assert np.array_equal(trials.activity, trials.envelopes_v.sum(axis=0))
    assert trials.offsets[-1] == trials.force_n.size == trials.activity.size
    assert trials.notes[0] == "a note of the reader"
    assert any("as stored" in note for note in trials.notes)
    assert trials.overview_force_n.size == trials.overview_time_s.size == pytest.approx(10 * force.duration_s, abs=1)


def test_envelopes_are_those_of_the_whole_record():
    emg, force = recorded(force_of(*[RISE] * 3))
    trials = extract(emg, force)
    edges = one_pass_band_hz((10.0, 450.0), 2, "zero-phase", FS_HZ)
    sos = signal.butter(2, edges, "bandpass", fs=FS_HZ, output="sos")
    taps = signal.firwin(51, 20.0, fs=FS_HZ)
    for row, name in enumerate(trials.muscles):
        whole = np.convolve(np.abs(signal.sosfiltfilt(sos, emg[name].samples)), taps, "same")
        for i, start_s in enumerate(trials.start_s):
            got = trials.envelopes_v[row, trials.offsets[i] : trials.offsets[i + 1]]
            first = int(np.ceil(start_s * 100)) * 10
            assert got == pytest.approx(whole[first : first + 10 * got.size : 10], rel=1e-9)


def test_force_is_the_filtered_tared_force_at_the_envelopes():
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
def test_the_budget_states_what_a_known_signal_shows(phase, order):
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
def test_the_delay_of_the_force_sensor_is_removed(phase):
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


def test_unequal_rates_and_starts():
    fine = force_of(RISE, RISE, fs_hz=FS_HZ)
    emg, force = recorded(fine)
    same = extract(emg, force)
    slow = channel(force_of(RISE, RISE, fs_hz=200.0, start_s=0.5) + 0.3, "N", 200.0, start_s=0.5)
    other = extract(emg, slow)
    assert other.start_s == pytest.approx(same.start_s, abs=2e-3)
    assert np.array_equal(other.offsets, same.offsets)
    assert other.activity == pytest.approx(same.activity)
    assert other.force_n == pytest.approx(same.force_n, abs=5e-3)


def test_a_later_clock_moves_times_only():
    emg, force = recorded(force_of(RISE))
    here = extract(emg, force)
    there = extract({k: replace(c, start_s=100.0) for k, c in emg.items()}, replace(force, start_s=100.0))
    assert there.start_s == pytest.approx(here.start_s + 100)
    assert there.activity == pytest.approx(here.activity)


def clipped(samples):
    return np.clip(samples, -1e-5, 1e-5)


def flat(samples):
    return np.zeros_like(samples)


def hum(samples):
    return samples + 1e-5 * np.sin(2 * np.pi * 50 * np.arange(samples.size) / FS_HZ)


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
def test_verdicts_on_emg(change, verdict, reason):
    trials = one_press(change_emg=change)
    assert trials.verdict.tolist() == [verdict]
    assert reason in trials.reasons[0]
    assert "FDS" not in trials.reasons[0]
    assert np.all(np.isfinite(trials.activity))


@pytest.mark.parametrize("offset_n", [0.3, -20.0])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("dead", [(), ("EDC",)])
def test_a_wrong_sign_is_noticed(offset_n, sign, dead):
    held = [(0, 0), (2.0, 7.6), (4.5, 7.6), (5.5, 0)]
    emg, force = recorded(force_of(*[held] * 3, rest_s=1.0))
    emg |= {name: replace(emg[name], samples=off(emg[name].samples)) for name in dead}
    reversed_force = replace(force, samples=offset_n - force.samples)
    trials = extract(emg, reversed_force, force_channel=ForceChannelSettings(name="Fz", sign=sign))
    assert trials.verdict.tolist() == ["rejected"] * 3
    assert set(trials.reasons) == {f"force rises while EMG is below its rest; is its sign {-sign}?"}
    assert trials.sign_doubt == trials.reasons[0]
    assert trials.sign_doubt in trials.notes


def test_a_wrong_sign_without_presses_is_noticed():
    emg, force = recorded(force_of(*[RISE] * 3))
    trials = extract(emg, replace(force, samples=-force.samples))
    assert trials.verdict.size == 0
    assert trials.sign_doubt.endswith("is its sign -1?")


@pytest.mark.parametrize("dead", [("EDC",), ("FDS",), ("EDC", "FDS")])
def test_dead_electrodes_are_no_wrong_sign(dead):
    emg, force = recorded(force_of(*[RISE] * 4))
    off_v = {name: 1e-6 * np.random.default_rng(i).standard_normal(force.samples.size) for i, name in enumerate(dead)}
    trials = extract({**emg, **{name: channel(samples) for name, samples in off_v.items()}}, force)
    assert trials.sign_doubt == ""
    assert trials.verdict.tolist() == ["rejected"] * 4
    assert all(f"{name} is as silent as at rest" in reason for name in dead for reason in trials.reasons)


def test_one_muscle_quieter_than_at_rest_is_no_wrong_sign():
    emg, force = recorded(force_of(*[RISE] * 3))
    emg["EDC"] = replace(emg["EDC"], samples=quieter(emg["EDC"].samples))
    assert extract(emg, force).sign_doubt == ""


def test_a_held_grip_with_short_rests_is_no_wrong_sign():
    held = [(0, 0), (2.0, 7.6), (12.0, 7.6), (12.5, 0)]
    trials = extract(*recorded(force_of(*[held] * 3, rest_s=0.8)))
    assert trials.sign_doubt == ""
    assert trials.verdict.tolist() == ["ok"] * 3


def test_the_tare_says_how_many_rests():
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
def test_verdicts_on_force(press, verdict, reason):
    force_n = force_of(press, RISE, RISE, rest_s=3.0)
    trials = extract(*recorded(force_n))
    assert trials.verdict.tolist() == [verdict, "ok", "ok"]
    assert reason in trials.reasons[0]
    assert trials.reasons[0].startswith(reason) or verdict == "rejected"


def test_missing_force_rejects_the_trial_that_holds_it():
    def lose(samples):
        samples[3000:3004] = np.nan
        return samples

    trials = one_press(change_force=lose)
    assert trials.verdict.tolist() == ["rejected"]
    assert "force misses 4 samples" in trials.reasons[0]


def test_emg_that_ends_early_does_not_cover_the_trial():
    emg, force = recorded(force_of(RISE, RISE))
    short = {name: replace(c, samples=c.samples[:9000]) for name, c in emg.items()}
    trials = extract(short, force)
    assert trials.verdict.tolist() == ["ok", "rejected"]
    assert "does not cover" in trials.reasons[1]
    none = extract({name: replace(c, samples=c.samples[:7000]) for name, c in emg.items()}, force)
    assert none.offsets[2] == none.offsets[1]
    assert none.verdict.tolist() == ["ok", "rejected"]


def test_a_record_that_begins_in_its_only_ramp():
    ramp = np.interp(np.arange(0, 6, 1 / FS_HZ), [0, 3, 4, 6], [1.5, 8, 8, 7.5])
    emg, force = recorded(ramp - 0.3)
    trials = extract(emg, force)
    assert trials.verdict.tolist() == ["warned"]
    assert "record begins at 1.5" in trials.reasons[0]
    assert trials.start_s.tolist() == [0.0]
    assert trials.rest_force_n == 0
    assert np.isnan(trials.snr_db).all()
    assert any("tare impossible" in note for note in trials.notes)


def test_expected_number_of_presses():
    emg, force = recorded(force_of(RISE, RISE))
    trials = extract(emg, force, window=WindowSettings(expected_trials=3))
    assert any("2 found, 3 expected" in note for note in trials.notes)


def test_no_press_gives_no_trials_and_says_so():
    trials = extract(*recorded(np.zeros(5000)))
    assert trials.verdict.shape == (0,)
    assert trials.offsets.tolist() == [0]
    assert trials.envelopes_v.shape == (2, 0)
    assert any("presses: none" in note for note in trials.notes)


def test_the_nyquist_rule_is_in_the_notes():
    trials = one_press(filters=FilterSettings(band_hz=(10.0, 500.0)))
    assert any(note.startswith("NYQUIST RULE") for note in trials.notes)


def test_one_muscle():
    force_n = force_of(RISE)
    trials = extract(*recorded(force_n, emg={"FDS": emg_of(force_n, 1.0, 5)}))
    assert np.array_equal(trials.activity, trials.envelopes_v[0])
    with pytest.raises(SettingError, match="rudolph"):
        extract(
            *recorded(force_n, emg={"FDS": emg_of(force_n, 1.0, 5)}),
            cocontraction=CocontractionSettings(index="rudolph"),
        )


@pytest.mark.parametrize("n", [1, 3, 10])
def test_records_too_short(n):
    with pytest.raises(SignalError, match="at least"):
        extract(*recorded(np.zeros(n)))


def test_hostile_channels():
    emg, force = recorded(force_of(RISE))
    with pytest.raises(SignalError, match="finite"):
        extract(emg, replace(force, samples=np.full(force.samples.size, np.nan)))
    with pytest.raises(SignalError, match="at least one channel"):
        extract({}, force)
    with pytest.raises(SignalError, match="sensor system"):
        extract({**emg, "FDS": replace(emg["FDS"], fs_hz=2000.0)}, force)
    constant = extract(emg, replace(force, samples=np.full(force.samples.size, 3.0)))
    assert constant.verdict.size == 0


def test_the_same_twice():
    emg, force = recorded(force_of(RISE, RISE))
    first, second = extract(emg, force), extract(emg, force)
    assert first.activity.tobytes() == second.activity.tobytes()
    assert first.notes == second.notes


def test_openhdemg_ramp(shared_data):
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
    late = extract(emg, force, window=WindowSettings(force_n=(1.0, 24.0)))
    assert "record begins at 1.6" in late.reasons[0]
    assert any("tare impossible" in note for note in late.notes)


def test_novainstrumentation_grip(shared_data):
    emg_file, force_file = (shared_data(f"emg/emg_force/novainstrumentation_{name}.txt") for name in ("emg", "force"))
    emg = {"grip": channel(1e-3 * np.loadtxt(emg_file)[1])}
    force = channel(np.loadtxt(force_file)[1], "N")
    trials = extract(emg, force, window=WindowSettings(force_n=(30.0, 85.0), min_duration_s=0.2))
    assert trials.verdict.size == 1
    assert 1.2 < trials.start_s[0] < 1.7
    assert np.corrcoef(trials.force_n, trials.activity)[0, 1] > 0


def test_c3d_force_plate(shared_data):
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
