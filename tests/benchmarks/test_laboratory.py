"""The sessions of many laboratories: what they hold is what was asked for, and the analysis finds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.laboratory import Laboratory, LaboratorySession, activity_v, simulate_session
from emg2vsa.errors import SettingError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.extraction.remedies import remedy_of
from emg2vsa.fits import fit_trials
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, FitSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.bias import BiasBudget, left_in


def analysed(laboratory: Laboratory, seed: int = 1, session: LaboratorySession | None = None, **filters):
    session = session or simulate_session(laboratory, seed)
    emg = {f"M{i}": Channel("E", row, "V", laboratory.fs_hz, 0.0, "") for i, row in enumerate(session.emg_v)}
    force = Channel("F", session.force_n, "N", laboratory.force_fs_hz, 0.0, "")
    return extract_trials(
        emg, force, participant="P", specimen="S", filters=FilterSettings(**filters),
        cocontraction=CocontractionSettings(), window=WindowSettings(), force_channel=ForceChannelSettings(name="F"),
    )  # fmt: skip


def slope(trials) -> float:
    return float(fit_trials(trials, FitSettings(), WindowSettings()).b_v.mean())


def test_the_same_seed_gives_the_same_session_and_no_press_is_refused() -> None:
    one, two = simulate_session(Laboratory(), 3), simulate_session(Laboratory(), 3)
    np.testing.assert_array_equal(one.emg_v, two.emg_v)
    np.testing.assert_array_equal(one.force_n, two.force_n)
    with pytest.raises(SettingError, match="one press or more"):
        simulate_session(Laboratory(presses=0), 3)


@pytest.mark.parametrize("carrier", ["60/120", "laplacian", "units-15"])
def test_the_mean_rectified_emg_is_the_law(carrier) -> None:
    laboratory = Laboratory(carrier=carrier, noise_v=1e-12)
    trials = analysed(laboratory, rest_level="keep", mains="keep")
    truth = activity_v(trials.force_n, laboratory)
    assert trials.activity.mean() == pytest.approx(truth.mean(), rel=0.03)


@pytest.mark.parametrize("ramp", ["linear", "exponential", "saturating", "plateaus", "stairs", "sawtooth", "tremor"])
def test_every_way_of_pressing_is_found_and_good(ramp) -> None:
    trials = analysed(Laboratory(ramp=ramp))
    assert trials.verdict.tolist() == ["ok"] * 10, trials.reasons


@pytest.mark.parametrize(
    "disturbance",
    [
        {"noise_v": 5e-6},
        {"hum_v": 5e-6, "hum_harmonics": (1.0, 0.5, 0.5)},
        {"drift_n_per_min": 3.0},
        {"drift_n_per_min": -3.0},
    ],
)
def test_disturbances_leave_the_slope(disturbance) -> None:
    """Beside the same session without them: the carrier's own chance is the same in both."""
    clean, disturbed = analysed(Laboratory()), analysed(replace(Laboratory(), **disturbance))
    assert disturbed.verdict.tolist() == ["ok"] * 10, disturbed.reasons
    assert slope(disturbed) == pytest.approx(slope(clean), rel=0.012)


def of_cause(trials: Trials, cause: str) -> np.ndarray:
    return trials.bias.b[trials.bias.causes.index(cause)]


def test_what_is_kept_is_told_with_its_size() -> None:
    clean = analysed(Laboratory())
    noisy = analysed(Laboratory(noise_v=10e-6), rest_level="keep")
    seen = slope(noisy) / slope(clean) - 1
    assert -0.1 < seen < -0.04
    assert np.mean(of_cause(noisy, "rest level")) == pytest.approx(seen, abs=0.02)
    assert all("noise at rest lowers b by about" in reason for reason in noisy.reasons)
    corrected = analysed(Laboratory(noise_v=10e-6))
    assert slope(corrected) == pytest.approx(slope(clean), rel=0.02)
    assert all("the rest level that was subtracted raises b by" in reason for reason in corrected.reasons)


def test_a_delay_is_told_with_its_size_or_taken_out() -> None:
    clean, late = analysed(Laboratory()), analysed(Laboratory(delay_s=0.06))
    assert late.lag_s == pytest.approx(0.06, abs=0.01)
    seen = slope(late) / slope(clean) - 1
    assert -0.12 < seen < -0.06
    assert np.mean(of_cause(late, "lag")) == pytest.approx(seen, abs=0.02)
    assert all("force follows EMG by 6" in reason for reason in late.reasons)
    aligned = analysed(Laboratory(delay_s=0.06), align="lag")
    assert slope(aligned) == pytest.approx(slope(clean), rel=0.01)
    assert aligned.verdict.tolist() == ["ok"] * 10
    assert dict(aligned.delay.parts)["force after EMG, estimated"] == aligned.lag_s
    for trials in (late, aligned):  # to a third of the lag, which may be a muscle's own
        assert np.mean(trials.bias.b_se[trials.bias.causes.index("lag")]) == pytest.approx(-0.31 * seen, rel=0.3)
    one = analysed(Laboratory(delay_s=0.06, presses=1), align="lag")
    assert one.lag_s == pytest.approx(0.06, abs=0.02)
    assert np.isnan(one.lag_se_s)
    assert "lag: not certain, force is not moved" in one.notes


def test_lost_packets_leave_a_clock_that_is_known_badly() -> None:
    trials = analysed(Laboratory(lost_share=0.005))
    row = trials.bias.causes.index("clock")
    assert np.all(trials.bias.b[row] < 0)
    assert np.all(trials.bias.b_se[row] > 0.005)


def test_force_and_emg_that_are_far_apart_reject_the_press() -> None:
    far = analysed(Laboratory(delay_s=0.2))
    assert far.verdict.tolist() == ["rejected"] * 10
    assert "shorten the distance to the radio" in remedy_of(far.reasons[0])
    assert analysed(Laboratory(delay_s=0.06)).verdict.tolist() == ["ok"] * 10
    assert analysed(Laboratory(delay_s=0.2), align="lag").verdict.tolist() == ["ok"] * 10


@pytest.mark.parametrize("share", [0.02, 0.05])
def test_radio_frames_that_are_missing_where_they_lie_leave_the_slope(share: float) -> None:
    laboratory = Laboratory(fs_hz=26 / 0.0135)
    session = simulate_session(laboratory, 1)
    frames = np.random.default_rng(2).random(session.emg_v.shape[1] // 26 + 1) < share
    session.emg_v[:, np.repeat(frames, 26)[: session.emg_v.shape[1]]] = np.nan
    fits = fit_trials(analysed(laboratory, session=session), FitSettings(), WindowSettings())
    assert np.mean(fits.b_v) == pytest.approx(laboratory.b_v, rel=0.04)
    assert np.mean((fits.b_lo_v < laboratory.b_v) & (laboratory.b_v < fits.b_hi_v)) >= 0.8


def test_lost_samples_that_may_move_b_by_more_than_it_is_known_to_reject_the_press() -> None:
    trials = analysed(Laboratory())
    lost = left_in("lost samples", np.zeros(10), np.zeros(10), np.full(10, 0.5))
    fits = fit_trials(replace(trials, bias=BiasBudget.of([lost], 10)), FitSettings(), WindowSettings())
    assert fits.verdict.tolist() == ["rejected"] * 10
    assert "shorten the distance to the radio" in remedy_of(fits.reason[0])


def test_a_zero_that_jumps_is_told_of_the_press_and_rejects_it() -> None:
    trials = analysed(Laboratory(step_n=0.4))
    moved = [i for i, reason in enumerate(trials.reasons) if "the zero of force moves by 0.4" in reason]
    assert 1 <= len(moved) <= 2
    assert all(trials.verdict[i] == "rejected" for i in moved)
    assert np.nanmax(trials.zero_shift_n) == pytest.approx(0.4, abs=0.03)


def test_what_lasts_a_moment_is_in_the_budget_and_leaves_the_slope() -> None:
    clean = analysed(Laboratory())
    for cause, disturbance in {
        "spikes and bursts": {"spike_hz": 1.0},
        "lost samples": {"held_s": 0.06},
        "contact artefact": {"artefact_v": 150e-6},
    }.items():
        spoilt = analysed(Laboratory(**disturbance))
        taken = spoilt.bias.corrected[spoilt.bias.causes.index(cause)]
        assert np.count_nonzero(taken) >= 8
        assert slope(spoilt) == pytest.approx(slope(clean), rel=0.04)
    bursts = analysed(Laboratory(burst_v=300e-6))
    assert np.flatnonzero(bursts.bias.corrected[bursts.bias.causes.index("spikes and bursts")]).tolist() == [0, 3, 6, 9]
    missing = analysed(Laboratory(missing_s=0.005))
    assert missing.verdict.tolist() == ["ok"] * 10
    np.testing.assert_allclose(missing.bias.b_se[missing.bias.causes.index("lost samples")], 5 / 2167, rtol=0.01)


def test_saturation_is_in_the_budget_with_its_size() -> None:
    clean, clipped = analysed(Laboratory()), analysed(Laboratory(clip_at=0.4, clip_noise_v=1e-6))
    row = clipped.bias.causes.index("clipping")
    assert -0.3 < np.mean(clipped.bias.corrected[row]) < -0.03
    assert np.all(clipped.bias.b_se[row] > 0)
    assert slope(clipped) == pytest.approx(slope(clean), rel=0.05)


def test_an_amplifier_that_saturates_softly_leaves_no_press_to_use() -> None:
    session = simulate_session(Laboratory(), 1)
    rails = 0.4 * np.abs(session.emg_v).max(axis=1, keepdims=True)
    soft = replace(session, emg_v=rails * np.tanh(session.emg_v / rails))
    trials = analysed(Laboratory(), session=soft)
    assert np.all(trials.bias.b_se[trials.bias.causes.index("clipping")] >= 1)
    assert set(fit_trials(trials, FitSettings(), WindowSettings()).verdict) == {"doubtful"}


def test_hum_that_grows_with_force_raises_b_and_is_taken_out() -> None:
    clean, hummed = analysed(Laboratory()), analysed(Laboratory(touch_hum_v=20e-6, touch_hum_grows=True))
    assert np.mean(hummed.bias.corrected[hummed.bias.causes.index("hum at the touch")]) > 0.05
    assert slope(hummed) == pytest.approx(slope(clean), rel=0.015)
