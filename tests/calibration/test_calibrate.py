"""Calibration of stiffness on CASR: the notes' critique reproduced, coverage, scipy, and designs without an answer."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize, stats

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.laws import LAWS, WAYS
from emg2vsa.calibration.left_out import compare_laws
from emg2vsa.calibration.unknown import estimate
from emg2vsa.errors import DataError, SettingError
from emg2vsa.settings import CalibrationSettings, Law, Minimise

KAPPA, KAPPA_NEW = np.array([7.63, 3.35, 1.11]), 5.32
P, Q = 10.21, -1.567
"The paper's curve at 0 degrees."
UNIT = "mm²/N"
EVERY_WAY: list[tuple[Law, Minimise]] = [(law, way) for law in LAWS for way in WAYS[law]]
PAPER = CalibrationSettings(law="exponential", minimise="kappa", resamples=200)


def true_casr(kappa: Any) -> Any:
    return np.log(np.asarray(kappa) / P) / Q


def presses(seed: int, d: int = 1, cv: float = 0.05, r: int = 10, kappa: Any = KAPPA) -> tuple[np.ndarray, np.ndarray]:
    """Scores of the known specimens (d, S, r) and of the new one (d, r), the law exact."""
    rng = np.random.default_rng(seed)
    known = true_casr(kappa)[:, None] * (1 + cv * rng.standard_normal((d, len(kappa), r)))
    return known, true_casr(KAPPA_NEW) * (1 + cv * rng.standard_normal((d, r)))


def chosen(**changes: Any) -> CalibrationSettings:
    return dataclasses.replace(PAPER, **changes)


def law_of(law: Law, casr: np.ndarray, first: float, second: float) -> np.ndarray:
    if law == "compliance":
        return 1 / (first + second * casr**1.5)
    if law == "exponential":
        return first * np.exp(second * casr)
    return first * casr**second if law == "power" else first + second * np.log(casr)


@pytest.mark.parametrize(("law", "minimise"), EVERY_WAY)
@pytest.mark.parametrize("points", ["means", "repetitions"])
def test_every_way_finds_an_exact_law(law: Law, minimise: Minimise, points: Any) -> None:
    truth = {"exponential": (10.21, -1.567), "compliance": (-0.02, 0.5)}.get(law, (2.0, -0.9))
    casr = np.array([0.2, 0.5, 0.7, 1.4])
    setting = chosen(law=law, minimise=minimise, points=points)
    fit = calibrate(law_of(law, casr, *truth), np.tile(casr[:, None], 5), setting, casr_unit=UNIT)
    np.testing.assert_allclose(fit.fit.parameters[0], truth, rtol=1e-12)
    np.testing.assert_allclose(fit.left_out_error[0], 0, atol=1e-11)
    np.testing.assert_allclose([fit.r2[0], fit.adj_r2[0]], 1, rtol=1e-12)
    new = estimate(fit, [0.3, 0.3])
    assert repr(new).startswith(f"Estimate(kappa {new.kappa[0]:.4g} [")
    assert len(repr(new)) < 200
    np.testing.assert_allclose(new.kappa[0], law_of(law, np.array(0.3), *truth), rtol=1e-12)
    np.testing.assert_allclose([new.bootstrap_low[0], new.bootstrap_high[0]], new.kappa[0], rtol=1e-11)
    assert not new.extrapolated[0]


@pytest.mark.parametrize("law", ["exponential", "power", "linear-log"])
def test_fit_of_kappa_is_scipys(law: Law) -> None:
    kappa = np.array([7.63, 5.0, 3.35, 2.0, 1.11])
    known, _ = presses(1, kappa=kappa)
    fit = calibrate(kappa, known, chosen(law=law), casr_unit=UNIT)
    x = known[0].mean(axis=1)
    parameters, _ = optimize.curve_fit(
        lambda x, a, b: law_of(law, x, a, b), x, kappa, fit.fit.parameters[0], ftol=1e-14, xtol=1e-14
    )
    np.testing.assert_allclose(fit.fit.parameters[0], parameters, rtol=1e-6)
    residual = kappa - law_of(law, x, *parameters)
    unexplained = residual @ residual / np.sum((kappa - kappa.mean()) ** 2)
    np.testing.assert_allclose([fit.r2[0], fit.adj_r2[0]], [1 - unexplained, 1 - unexplained * 4 / 3], rtol=1e-9)


def test_errors_in_casr_are_the_line_of_casr_on_ln_kappa_turned_round() -> None:
    known, new = presses(2, cv=0.1)
    fit = calibrate(KAPPA, known, chosen(minimise="casr", points="repetitions"), casr_unit=UNIT)
    peer = stats.linregress(np.repeat(np.log(KAPPA), 10), known.ravel())
    np.testing.assert_allclose(
        fit.fit.parameters[0], [np.exp(-peer.intercept / peer.slope), 1 / peer.slope], rtol=1e-11
    )
    found = estimate(fit, new)
    np.testing.assert_allclose(found.kappa[0], np.exp((new.mean() - peer.intercept) / peer.slope), rtol=1e-11)


def test_noise_in_casr_flattens_the_direct_fits_and_not_the_inverse() -> None:
    known, _ = presses(3, d=4000, cv=0.3)
    direct, inverse = (
        np.mean(calibrate(KAPPA, known, chosen(minimise=way, points="repetitions"), casr_unit=UNIT).fit.slope)
        for way in ("ln kappa", "casr")
    )
    assert direct > 0.93 * Q  # less steep by 7 % and more
    np.testing.assert_allclose(inverse, Q, rtol=0.04)


def test_adjusted_r2_of_three_random_scores_is_high() -> None:
    scores = np.sort(np.random.default_rng(4).random((20_000, 3)), axis=1)[:, :, None]
    adj_r2 = calibrate(KAPPA, scores, PAPER, casr_unit=UNIT).adj_r2
    np.testing.assert_allclose(np.median(adj_r2), 0.922, atol=0.005)
    np.testing.assert_allclose(np.mean(adj_r2 > 0.8963), 0.61, atol=0.015)
    np.testing.assert_allclose(np.mean(adj_r2 > 0.9753), 0.27, atol=0.015)


def test_a_linear_truth_passes_adjusted_r2_and_fails_when_specimens_are_left_out() -> None:
    fit = calibrate(KAPPA, ((10 - KAPPA) / 10)[:, None], PAPER, casr_unit=UNIT)
    np.testing.assert_allclose(fit.adj_r2[0], 0.946, atol=0.001)
    np.testing.assert_allclose(estimate(fit, [(10 - KAPPA_NEW) / 10]).kappa[0] / KAPPA_NEW - 1, -0.156, atol=0.001)
    np.testing.assert_allclose(np.abs(fit.left_out_error[0]), [2.62, 0.36, 0.96], atol=0.006)


def test_leaving_out_is_refitting_without() -> None:
    known, _ = presses(5)
    for points in ("means", "repetitions"):
        fit = calibrate(KAPPA, known, chosen(points=points), casr_unit=UNIT)
        for s in range(3):
            keep = np.arange(3) != s
            without = calibrate(KAPPA[keep], known[:, keep], chosen(points=points), casr_unit=UNIT)
            np.testing.assert_allclose(fit.left_out[0, s], without.fit.at(known[:, [s]].mean(axis=2))[0, 0], rtol=1e-11)


@pytest.mark.parametrize("law", LAWS)
def test_the_true_law_predicts_unseen_specimens_best(law: Law) -> None:
    casr = np.linspace(0.2, 1.4, 7)
    kappa = law_of(law, casr, 2.0, -0.9)
    scores = casr[:, None] * (1 + 0.01 * np.random.default_rng(6).standard_normal((50, 7, 10)))
    comparison = compare_laws(np.abs(kappa) + 0.01 * (kappa <= 0), scores, casr_unit=UNIT)
    assert np.mean([comparison.best(i) == law for i in range(50)]) > 0.9
    assert comparison.score.shape == (len(LAWS), 50)


@pytest.mark.slow
@pytest.mark.parametrize("cv", [0.03, 0.08])
@pytest.mark.parametrize("points", ["means", "repetitions"])
def test_bootstrap_intervals_cover_as_stated(cv: float, points: Any) -> None:
    known, new = presses(7, d=1200, cv=cv)
    found = estimate(calibrate(KAPPA, known, chosen(points=points, resamples=600), casr_unit=UNIT), new)
    assert 0.90 <= np.mean((found.bootstrap_low <= KAPPA_NEW) & (found.bootstrap_high >= KAPPA_NEW)) <= 0.95


def test_bootstrap_is_the_loop_it_stands_for() -> None:
    known, new = presses(9)
    found = estimate(calibrate(KAPPA, known, chosen(resamples=2000), casr_unit=UNIT), new)
    rng = np.random.default_rng(9)
    values = []
    for _ in range(2000):
        x = np.array([rng.choice(group, 9).mean() for group in known[0]])
        slope, level = np.polyfit(x, np.log(KAPPA), 1, w=KAPPA)  # weighted log-linear: near enough to least squares
        values.append(np.exp(level + slope * rng.choice(new[0], 9).mean()))
    low, high = np.quantile(values, [0.025, 0.975])
    width = high - low
    np.testing.assert_allclose([found.bootstrap_low[0], found.bootstrap_high[0]], [low, high], atol=0.08 * width)


def test_many_calibrations_are_each_as_alone() -> None:
    known, new = presses(10, d=40)
    known[3, 1, 4:], new[3, 7:] = np.nan, np.nan
    together = estimate(calibrate(KAPPA, known, chosen(), casr_unit=UNIT), new)
    for i in (0, 3, 39):
        alone = estimate(calibrate(KAPPA, known[i], chosen(), casr_unit=UNIT), new[i])
        for name in ("kappa", "bootstrap_low", "bootstrap_high"):
            np.testing.assert_allclose(getattr(together, name)[i], getattr(alone, name)[0], rtol=1e-12)
    assert together.n[3] == 7


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 1e3), st.sampled_from(EVERY_WAY))
@settings(max_examples=30, deadline=None)
def test_unit_of_casr_does_not_change_kappa(seed: int, unit: float, way: tuple[Law, Minimise]) -> None:
    known, new = presses(seed, cv=0.03)
    known, new = np.abs(known), np.abs(new)
    setting = chosen(law=way[0], minimise=way[1], resamples=20)
    here = estimate(calibrate(KAPPA, known, setting, casr_unit=UNIT), new)
    there = estimate(calibrate(KAPPA, unit * known, setting, casr_unit="other"), unit * new)
    for name in ("kappa", "bootstrap_low", "bootstrap_high"):
        np.testing.assert_allclose(getattr(there, name), getattr(here, name), rtol=1e-8)
    assert (there.extrapolated == here.extrapolated).all()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_order_of_specimens_and_of_presses_does_not_matter(seed: int) -> None:
    known, _ = presses(seed)
    rng = np.random.default_rng(seed)
    order = rng.permutation(3)
    here = calibrate(KAPPA, known, PAPER, casr_unit=UNIT)
    there = calibrate(KAPPA[order], rng.permuted(known, axis=2)[:, order], PAPER, casr_unit=UNIT)
    np.testing.assert_allclose(there.fit.parameters, here.fit.parameters, rtol=1e-9)
    np.testing.assert_allclose(there.left_out, here.left_out[:, order], rtol=1e-9)


def test_words() -> None:
    known, new = presses(11)
    fit = calibrate(KAPPA, known, PAPER, casr_unit=UNIT, specimens=("S1", "S3", "S5"))
    assert "three specimens and two parameters leave one degree of freedom" in fit.notes()[0]
    assert "12.71 standard errors" in fit.notes()[0]
    assert fit.equation().startswith("kappa = 10.")
    assert fit.equation().endswith(f"(kappa in N/mm, CASR in {UNIT})")
    assert estimate(fit, new).notes()[: len(fit.notes())] == fit.notes()
    more = calibrate(np.arange(6.0, 0, -1), np.arange(1.0, 7)[:, None], chosen(points="repetitions"), casr_unit=UNIT)
    assert more.notes() == ("presses of one specimen are repeats: more of them do not test the law",)
    rising = calibrate(KAPPA, -known, PAPER, casr_unit=UNIT)
    assert "kappa rises with CASR" in rising.notes()[-1]


def test_beyond_the_calibrated_range_is_flagged() -> None:
    known, _ = presses(12)
    fit = calibrate(KAPPA, known, chosen(), casr_unit=UNIT)
    beyond, inside = estimate(fit, [0.01, 0.02]), estimate(fit, [0.4, 0.5])
    assert beyond.extrapolated[0]
    assert beyond.notes()[0].startswith("extrapolated")
    assert not inside.extrapolated[0]


def test_one_press_and_none() -> None:
    known, _ = presses(13)
    fit = calibrate(KAPPA, known, chosen(), casr_unit=UNIT)
    one, none = estimate(fit, [0.4]), estimate(fit, [np.nan, np.inf])
    assert np.isfinite(one.kappa[0])
    assert np.isnan(one.bootstrap_low[0])
    assert one.repeats.low[0] < one.kappa[0] < one.repeats.high[0]
    assert (
        one.notes()[0]
        == "one press: its noise is taken from the calibration's presses, and only that interval is there"
    )
    assert np.isnan([none.kappa[0], none.bootstrap_high[0]]).all()
    assert none.notes()[0] == "undefined: no score"


def test_two_specimens_are_joined_without_a_test() -> None:
    known, new = presses(14)
    fit = calibrate(KAPPA[:2], known[:, :2], chosen(), casr_unit=UNIT)
    found = estimate(fit, new)
    assert np.isfinite([found.kappa[0], found.bootstrap_low[0]]).all()
    assert np.isnan([fit.adj_r2[0], *fit.left_out[0]]).all()
    assert fit.notes() == ("2 specimens: the law passes through them and nothing tests it",)


@pytest.mark.parametrize("law", ["power", "linear-log"])
def test_scores_without_a_logarithm_make_the_law_undefined(law: Law) -> None:
    known, new = presses(15)
    known[0, 0] = -known[0, 0]
    fit = calibrate(KAPPA, known, chosen(law=law), casr_unit=UNIT)
    assert np.isnan(fit.fit.parameters).all()
    assert fit.notes()[0] == "undefined: the law cannot be fitted to these scores"
    assert np.isnan(estimate(fit, new).kappa[0])
    comparison = compare_laws(KAPPA, known, casr_unit=UNIT)
    assert comparison.best() == "exponential"


@pytest.mark.parametrize("value", [0.0, 0.5, np.nan])
def test_equal_or_absent_scores_are_undefined(value: float) -> None:
    fit = calibrate(KAPPA, np.full((3, 4), value), chosen(), casr_unit=UNIT)
    assert np.isnan(fit.fit.parameters).all()
    assert np.isnan([fit.r2[0], estimate(fit, [0.4, 0.5]).kappa[0]]).all()
    assert compare_laws(KAPPA, np.full((3, 4), value), casr_unit=UNIT).best() is None


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_extreme_units_of_casr(scale: float) -> None:
    known, new = presses(16)
    known, new = known / 10, new / 10
    here = estimate(calibrate(KAPPA, known, chosen(), casr_unit=UNIT), new)
    there = estimate(calibrate(KAPPA, known * scale, chosen(), casr_unit=UNIT), new * scale)
    np.testing.assert_allclose(there.kappa, here.kappa, rtol=1e-10)
    np.testing.assert_allclose(there.bootstrap_low, here.bootstrap_low, rtol=1e-10)


@pytest.mark.parametrize(
    ("kappa", "casr", "said"),
    [
        (KAPPA[:2], np.ones((3, 4)), "one value for each of 3"),
        ([1.0, 0.0, 2.0], np.ones((3, 4)), "above 0"),
        ([1.0, np.nan, 2.0], np.ones((3, 4)), "above 0"),
        (KAPPA, np.ones(3), "scores"),
        (KAPPA, np.ones((3, 0)), "scores"),
    ],
)
def test_wrong_input_is_named(kappa: Any, casr: Any, said: str) -> None:
    with pytest.raises(DataError, match=said):
        calibrate(kappa, casr, casr_unit=UNIT)


def test_wrong_scores_and_settings_are_named() -> None:
    known, _ = presses(17, d=3)
    with pytest.raises(DataError, match="unknown specimen"):
        estimate(calibrate(KAPPA, known, PAPER, casr_unit=UNIT), np.ones((2, 5)))
    with pytest.raises(SettingError, match="linear-log"):
        calibrate(KAPPA, known, chosen(law="linear-log", minimise="ln kappa"), casr_unit=UNIT)


def test_a_design_of_nearly_equal_stiffness_says_so() -> None:
    scores = np.array([[2.0], [1.9], [1.7]])
    near = calibrate(0.5 * (1 + 1e-6 * np.arange(3)), scores, casr_unit="mm2/N")
    assert near.notes()[0].startswith("ill-conditioned design: the stiffnesses of the specimens differ by 2e-06")
    assert "keeps 10 digits" in near.notes()[0]
    equal = calibrate([0.5, 0.5, 0.5], scores, casr_unit="mm2/N")
    assert any("keeps 0 digits" in note for note in equal.notes())
    apart = calibrate([0.5, 0.501, 0.502], scores, casr_unit="mm2/N")
    assert not any("ill-conditioned" in note for note in apart.notes())
