"""The fitting stage: bins and samples of a recording, trials that cannot be fitted, tables of many recordings."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy import signal

from emg2vsa.curves.logarithmic import fit_log
from emg2vsa.errors import DataError
from emg2vsa.extraction import DelayBudget, Trials
from emg2vsa.fits import Fits, concatenate, fit_trials, usable
from emg2vsa.session_verdict import judge_session
from emg2vsa.settings import FitSettings, PressJudgement, WindowSettings
from emg2vsa.signals.bias import BiasBudget, Shift
from tests.made_traits import unknown

A_V, B_V = 30e-6, 15e-6
WINDOW = WindowSettings()


def trials_of(force: list[np.ndarray], activity: list[np.ndarray], **changes: object) -> Trials:
    n = len(force)
    zeros = np.zeros(n)
    offsets = np.cumsum([0, *(f.size for f in force)])
    joined = np.concatenate([*activity, np.empty(0)])
    trials = Trials(
        participant="P01", specimen="S3", muscles=("EDC",), repetition=np.arange(1, n + 1),
        start_s=10.0 * np.arange(n), stop_s=zeros, duration_s=zeros, peak_force_n=zeros, falling_share=zeros,
        snr_db=zeros, verdict=np.full(n, "ok", dtype="<U8"), reasons=("",) * n, fs_hz=100.0, offsets=offsets,
        force_n=np.concatenate([*force, np.empty(0)]), activity=joined, envelopes_v=joined[None], activity_unit="V",
        rest_force_n=0.0, rest_envelope_v=np.zeros(1), mains_ratio=np.zeros(1), clip_share=np.zeros(1),
        overview_time_s=np.empty(0), overview_force_n=np.empty(0), delay=DelayBudget((), 0.0, 0.0, 0.0),
        bias=BiasBudget.of((), n), traits=unknown(("EDC",), n), notes=(),
    )  # fmt: skip
    return dataclasses.replace(trials, **changes)


def noisy(n: int = 10, seed: int = 0, relative_noise: float = 0.35, memory: float = 0.5) -> Trials:
    """Presses of uneven speed; noise grows with the level and is as correlated as a 20 Hz envelope's."""
    rng = np.random.default_rng(seed)
    force, activity = [], []
    for length in rng.integers(200, 300, n):
        ramp = 0.5 + 6.5 * (0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, length)))
        noise = signal.lfilter([(1 - memory**2) ** 0.5], [1, -memory], rng.standard_normal(length + 50))[50:]
        force.append(ramp)
        activity.append((A_V + B_V * np.log(ramp)) * (1 + relative_noise * noise))
    return trials_of(force, activity)


def test_noise_free_law_is_recovered_at_each_stage() -> None:
    for points in ("bins", "samples"):
        fits = fit_trials(noisy(relative_noise=0.0), FitSettings(points=points), WINDOW)
        np.testing.assert_allclose(fits.a_v, A_V, rtol=1e-12)
        np.testing.assert_allclose(fits.b_v, B_V, rtol=1e-12)
        np.testing.assert_allclose(fits.v_max_v, A_V + B_V * np.log(7), rtol=1e-12)
        np.testing.assert_allclose(fits.v_min_v, A_V + B_V * np.log(0.5), rtol=1e-12)
        np.testing.assert_allclose([fits.r2_bins, fits.adj_r2_samples], 1, rtol=1e-12)


def test_paper_mode_is_ordinary_least_squares_on_the_samples() -> None:
    trials = noisy()
    fits = fit_trials(trials, FitSettings(points="samples", weights="none"), WINDOW)
    for i in range(10):
        cut = slice(trials.offsets[i], trials.offsets[i + 1])
        b, a = np.polyfit(np.log(trials.force_n[cut]), trials.activity[cut], 1)
        np.testing.assert_allclose([fits.a_v[i], fits.b_v[i]], [a, b], rtol=1e-10)
    np.testing.assert_array_equal(fits.n_points, np.diff(trials.offsets))
    np.testing.assert_array_equal(fits.adj_r2, fits.adj_r2_samples)


def test_r2_of_each_stage_does_not_depend_on_what_is_reported() -> None:
    trials = noisy()
    bins = fit_trials(trials, FitSettings(), WINDOW)
    paper = fit_trials(trials, FitSettings(points="samples", weights="none", robust=True), WINDOW)
    for name in ("r2_bins", "adj_r2_bins", "r2_samples", "adj_r2_samples", "n_effective", "lag1", "bin_v"):
        np.testing.assert_array_equal(getattr(bins, name), getattr(paper, name))
    assert np.median(bins.r2_bins) > np.median(bins.r2_samples) + 0.05


def test_unweighted_bins_are_the_fit_of_the_bin_means() -> None:
    fits = fit_trials(noisy(), FitSettings(weights="none"), WINDOW)
    peer = fit_log(fits.bin_force_n, fits.bin_v)
    np.testing.assert_array_equal(fits.b_v, peer.b)
    np.testing.assert_array_equal(fits.adj_r2, fits.adj_r2_bins)
    assert fits.bin_edges_n.size == 23
    assert fits.bin_v.shape == (10, 22)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8])
@pytest.mark.parametrize("options", [{}, {"weights": "none"}, {"robust": True}])
def test_intervals_on_bins_cover(memory: float, options: dict[str, Any]) -> None:
    fits = fit_trials(noisy(600, seed=3, memory=memory), FitSettings(**options), WINDOW)
    assert 0.92 < np.mean((fits.b_lo_v < B_V) & (fits.b_hi_v > B_V)) < 0.98
    assert 0.93 < np.mean(fits.b_se_v) / np.std(fits.b_v) < 1.07
    assert 0.92 < np.mean(fits.a_se_v) / np.std(fits.a_v) < 1.08


def test_weighted_bins_are_unbiased_and_better_than_the_papers_fit() -> None:
    trials = noisy(600, seed=4)
    bins = fit_trials(trials, FitSettings(), WINDOW)
    paper = fit_trials(trials, FitSettings(points="samples", weights="none"), WINDOW)
    assert abs(np.mean(bins.b_v) / B_V - 1) < 0.01
    assert np.std(bins.b_v) < 0.95 * np.std(paper.b_v)
    assert np.mean((paper.b_lo_v < B_V) & (paper.b_hi_v > B_V)) < 0.85


def test_samples_are_worth_fewer_than_their_number() -> None:
    fits = fit_trials(noisy(100), FitSettings(), WINDOW)
    assert abs(np.median(fits.lag1) - 0.5) < 0.05
    assert 60 < np.median(fits.n_effective) < 110


def test_robust_resists_a_burst() -> None:
    trials = noisy(50, relative_noise=0.1)
    activity = trials.activity.copy()
    starts = trials.offsets[:-1]
    for k in range(12):
        activity[starts + 30 + k] += 200e-6
    burst = dataclasses.replace(trials, activity=activity)
    plain = fit_trials(burst, FitSettings(points="samples"), WINDOW)
    robust = fit_trials(burst, FitSettings(points="samples", robust=True), WINDOW)
    assert abs(np.mean(robust.b_v) - B_V) < 0.3 * abs(np.mean(plain.b_v) - B_V)


def test_confidence_widens_the_interval() -> None:
    narrow, wide = (fit_trials(noisy(), FitSettings(confidence=c), WINDOW) for c in (0.9, 0.99))
    assert (wide.b_hi_v - wide.b_lo_v > narrow.b_hi_v - narrow.b_lo_v).all()
    assert wide.confidence == 0.99


def test_what_cannot_be_fitted_stays_with_a_reason() -> None:
    ramp = np.linspace(0.5, 7, 100)
    law = A_V + B_V * np.log(ramp)
    short, flat = np.array([0.55, 0.9]), np.full(50, 3.0)
    trials = trials_of(
        [ramp, short, flat, np.empty(0), ramp],
        [law, law[:2], law[:50], np.empty(0), np.full(100, np.nan)],
        reasons=("", "peak 0.9 N", "", "", ""),
        verdict=np.array(["doubtful", "rejected", "ok", "ok", "ok"], dtype="<U8"),
    )
    fits = fit_trials(trials, FitSettings(), WINDOW)
    assert fits.verdict.tolist() == ["doubtful", "rejected", "rejected", "rejected", "rejected"]
    assert fits.reason.tolist()[:4] == [
        "",
        "peak 0.9 N; no fit: 2 force bins",
        "no fit: 1 force bins",
        "no fit: 0 force bins",
    ]
    assert np.isfinite(fits.b_v[0])
    for name in ("a_v", "b_v", "a_se_v", "b_se_v", "b_lo_v", "b_hi_v", "v_min_v", "v_max_v", "adj_r2"):
        assert np.isnan(getattr(fits, name)[1:]).all()
    on_samples = fit_trials(trials, FitSettings(points="samples"), WINDOW)
    assert on_samples.reason[2] == "no fit: force does not change"


def test_a_fit_on_forces_that_hardly_differ_says_how_many_digits_are_left() -> None:
    force = np.linspace(5, 5.004, 40)
    trials = trials_of([force, force], [A_V + B_V * np.log(force)] * 2, reasons=("EDC clipped", ""))
    fits = fit_trials(trials, FitSettings(bin_n=0.0005), WindowSettings(force_n=(4.999, 5.006)))
    said = "ill-conditioned fit: force changes by 0.0008 of itself, b keeps 13 digits"
    assert fits.reason.tolist() == [f"EDC clipped; {said}", said]


def test_rejected_trials_are_fitted_too() -> None:
    trials = dataclasses.replace(noisy(3), verdict=np.array(["ok", "rejected", "doubtful"], dtype="<U8"))
    fits = fit_trials(trials, FitSettings(), WINDOW)
    assert np.isfinite(fits.b_v).all()
    assert fits.verdict.tolist() == ["ok", "rejected", "doubtful"]
    assert usable(fits, "ok").tolist() == [True, False, False]
    assert usable(fits, "ok+doubtful").tolist() == [True, False, True]


@pytest.mark.parametrize("points", ["bins", "samples"])
def test_a_recording_without_presses(points: str) -> None:
    fits = fit_trials(trials_of([], []), FitSettings(points=points), WINDOW)  # type: ignore[arg-type]
    assert fits.b_v.shape == (0,)
    assert fits.bin_v.shape == (0, 22)
    assert fits.participant.shape == (0,)


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_extreme_units(scale: float) -> None:
    trials = noisy(4)
    small = dataclasses.replace(trials, activity=trials.activity / A_V * scale)
    fits, extreme = fit_trials(trials, FitSettings(), WINDOW), fit_trials(small, FitSettings(), WINDOW)
    np.testing.assert_allclose(extreme.b_v / scale, fits.b_v / A_V, rtol=1e-9)
    np.testing.assert_allclose(extreme.n_effective, fits.n_effective, rtol=1e-6)


def test_concatenate_keeps_order_and_shape() -> None:
    first = fit_trials(noisy(3), FitSettings(), WINDOW)
    second = fit_trials(dataclasses.replace(noisy(4, seed=1), participant="Participant 12"), FitSettings(), WINDOW)
    none = fit_trials(trials_of([], []), FitSettings(), WINDOW)
    fits = concatenate([first, none, second])
    assert fits.participant.tolist() == ["P01"] * 3 + ["Participant 12"] * 4
    assert all(
        len(getattr(fits, f.name)) == 7 for f in dataclasses.fields(Fits) if f.name in ("b_v", "bin_v", "reason")
    )
    np.testing.assert_array_equal(fits.b_v, np.concatenate([first.b_v, second.b_v]))


def test_concatenate_refuses_a_mixture() -> None:
    fits = fit_trials(noisy(2), FitSettings(), WINDOW)
    with pytest.raises(DataError, match="points"):
        concatenate([fits, fit_trials(noisy(2), FitSettings(points="samples"), WINDOW)])
    with pytest.raises(DataError, match="bin_edges_n"):
        concatenate([fits, fit_trials(noisy(2), FitSettings(bin_n=0.5), WINDOW)])
    with pytest.raises(DataError, match="at least one"):
        concatenate([])


def spoilt() -> Trials:
    """Press 2 has a burst twenty times its level."""
    trials = noisy(relative_noise=0.2)
    activity = trials.activity.copy()
    begin, end = trials.offsets[1:3].tolist()
    third = (end - begin) // 3
    activity[begin + third : begin + third + 15] *= 20
    return dataclasses.replace(trials, activity=activity)


def test_a_press_whose_fit_is_no_fit_is_rejected_with_the_reason() -> None:
    fits = fit_trials(spoilt(), FitSettings(), WINDOW)
    assert fits.verdict.tolist() == ["ok", "rejected"] + ["ok"] * 8
    assert fits.reason[1].startswith("its fit explains too little (adjusted R2 ")
    loose = FitSettings(min_adj_r2=-1.0, max_b_error=0.0, max_b_error_ratio=0.0)
    free = fit_trials(spoilt(), loose, WINDOW)
    assert set(free.verdict) == {"ok"}
    np.testing.assert_array_equal(free.b_v, fits.b_v)


def test_a_press_that_is_one_of_its_recording_is_kept_though_its_r2_is_low_by_chance() -> None:
    trials = noisy(40, relative_noise=0.6, memory=0.9)
    fits = fit_trials(trials, FitSettings(), WINDOW)
    half, level = (fits.b_hi_v - fits.b_lo_v) / 2, (fits.v_min_v + fits.v_max_v) / 2
    chance = (half > 0.2 * level) & (fits.adj_r2 < FitSettings().min_adj_r2)
    assert chance.sum() >= 5
    assert set(fits.verdict[chance]) == {"ok"}
    # the same presses, of muscles that do not follow: noise of one level
    flat = dataclasses.replace(trials, activity=trials.activity / (A_V + B_V * np.log(trials.force_n)) * 30e-6)
    without = fit_trials(flat, FitSettings(), WINDOW)
    assert np.mean(without.verdict == "rejected") > 0.8


@pytest.mark.parametrize("b_v", [0.0, 1.5e-6, 3e-6])
def test_a_weak_but_known_slope_is_kept(b_v: float) -> None:
    """To reject flat presses would leave the steep ones: of b = 3 uV a fifth was left, with b too large by 42 %."""
    rng = np.random.default_rng(5)
    force = [np.linspace(0.5, 7, 250) for _ in range(40)]
    activity = [(40e-6 + b_v * np.log(one)) * (1 + 0.2 * rng.standard_normal(250)) for one in force]
    fits = fit_trials(trials_of(force, activity), FitSettings(), WINDOW)
    assert np.count_nonzero(fits.adj_r2_bins < 0.3) > 10
    assert set(fits.verdict) == {"ok"}
    assert abs(fits.b_v.mean() - b_v) < 3 * fits.b_v.std() / np.sqrt(40)


def test_a_slope_far_less_certain_than_the_others_is_rejected() -> None:
    trials = noisy(relative_noise=0.1)
    force, activity = (
        [values[i:j] for i, j in zip(trials.offsets[:-1], trials.offsets[1:], strict=True)]
        for values in (trials.force_n, trials.activity)
    )
    late = force[4] > 5.8
    force[4], activity[4] = force[4][late], activity[4][late]
    settings = FitSettings(min_adj_r2=-1.0, max_b_error=0.0)
    fits = fit_trials(trials_of(force, activity), settings, WINDOW)
    assert fits.verdict.tolist() == ["ok"] * 4 + ["rejected"] + ["ok"] * 5
    assert "times less certain than the others" in fits.reason[4]


def judgement(specimen: str, repetition: int | None, *, excludes: bool) -> PressJudgement:
    return PressJudgement("P01", specimen, repetition, "sneezed", excludes)


def test_a_person_has_the_last_word() -> None:
    said = (
        judgement("S3", 1, excludes=True), judgement("S3", 2, excludes=False), judgement("S1", None, excludes=True),
    )  # fmt: skip
    fits = fit_trials(spoilt(), FitSettings(), WINDOW, said)
    assert fits.verdict.tolist() == ["rejected", "ok"] + ["ok"] * 8
    assert fits.reason[0] == "excluded by hand: sneezed"
    assert fits.reason[1].startswith("accepted by hand: sneezed; its fit explains too little")
    everything = fit_trials(spoilt(), FitSettings(), WINDOW, [judgement("S3", None, excludes=True)])
    assert set(everything.verdict) == {"rejected"}


@pytest.mark.parametrize("excludes", [True, False])
def test_the_word_on_a_press_counts_before_that_on_its_recording(excludes: bool) -> None:
    on_press, on_all = judgement("S3", 4, excludes=excludes), judgement("S3", None, excludes=not excludes)
    for listed in ((on_press, on_all), (on_all, on_press)):
        verdicts = fit_trials(noisy(), FitSettings(), WINDOW, listed).verdict.tolist()
        one, others = ("rejected", "ok") if excludes else ("ok", "rejected")
        assert verdicts == [others] * 3 + [one] + [others] * 6


def test_a_fault_is_overruled_for_the_whole_recording_only() -> None:
    fault = "EDC is 35 V during a press; is its unit uV, or its gain 10^6?"
    trials = dataclasses.replace(
        noisy(3), fault=fault, verdict=np.full(3, "rejected", dtype="<U8"), reasons=(fault,) * 3
    )
    wanted: dict[str, int | None] = {"S3": None}
    one = fit_trials(trials, FitSettings(), WINDOW, [judgement("S3", 2, excludes=False)])
    assert set(one.verdict) == {"rejected"}
    assert one.reason[1].startswith("[[accept]] of one press does not overrule a fault of its recording: sneezed; EDC")
    assert judge_session("P01", [trials], {"S3": one}, wanted, {}).verdict == "unreadable"
    said = [judgement("S3", 1, excludes=True), judgement("S3", None, excludes=False)]
    accepted = fit_trials(trials, FitSettings(), WINDOW, said)
    assert accepted.verdict.tolist() == ["rejected", "ok", "ok"]
    assert accepted.reason[2] == f"accepted by hand: sneezed; {fault}"
    whole = fit_trials(trials, FitSettings(), WINDOW, said[1:])
    judged = judge_session("P01", [trials], {"S3": whole}, wanted, {})
    assert judged.verdict == "usable"
    assert judged.advice[0].text == f"S3: presses 1-3 ok: accepted by hand: sneezed; {fault}"


def test_nobody_can_accept_a_press_without_a_fit() -> None:
    short = trials_of([np.array([1.0, 1.2])], [np.array([1e-5, 1e-5])])
    fits = fit_trials(short, FitSettings(), WINDOW, [judgement("S3", 1, excludes=False)])
    assert fits.verdict.tolist() == ["rejected"]
    assert "accepted by hand" in fits.reason[0]
    assert "no fit" in fits.reason[0]


def budgeted(share: float, se: float = 0.0, corrected: float = 0.0) -> Trials:
    trials = noisy(8)
    shift = Shift("lag", np.zeros(8), np.full(8, share), np.full(8, se), np.full(8, corrected))
    return dataclasses.replace(trials, bias=BiasBudget.of([shift], 8))


def test_a_bias_that_is_left_makes_a_press_doubtful_above_a_tenth() -> None:
    for share, verdict in ((-0.05, "ok"), (-0.2, "doubtful"), (0.2, "doubtful")):
        fits = fit_trials(budgeted(share), FitSettings(), WINDOW)
        assert fits.verdict.tolist() == [verdict] * 8
        assert set(fits.cause) == {"lag"}
    assert fits.reason[0] == "b is expected to be 20 % too high: lag"
    assert (fit_trials(budgeted(-0.2), FitSettings(max_bias=0.0), WINDOW).verdict == "ok").all()


def test_the_interval_reaches_to_where_b_would_be_without_the_bias() -> None:
    plain, off = (fit_trials(budgeted(share), FitSettings(), WINDOW) for share in (0.0, -0.05))
    np.testing.assert_allclose(off.b_lo_v, plain.b_lo_v)
    np.testing.assert_allclose(off.b_hi_v - plain.b_hi_v, plain.b_v / 0.95 - plain.b_v)
    unsure = fit_trials(budgeted(0.0, se=0.04, corrected=-0.1), FitSettings(), WINDOW)
    half = (plain.b_hi_v - plain.b_lo_v) / 2
    reach = half * np.hypot(1, 0.04 * plain.b_v / plain.b_se_v)
    np.testing.assert_allclose((unsure.b_hi_v - unsure.b_lo_v) / 2, reach)


def test_a_person_accepts_a_doubtful_press_by_name() -> None:
    accepted = PressJudgement("P01", "S3", 2, "the lag is the muscle's", excludes=False)
    fits = fit_trials(budgeted(-0.3), FitSettings(), WINDOW, [accepted])
    assert fits.verdict.tolist() == ["doubtful", "ok", *["doubtful"] * 6]
