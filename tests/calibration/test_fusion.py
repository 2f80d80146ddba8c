"""Two cues of the same presses: weights, correlation, agreement.

The law from Hertz: exact in a Hertz contact, nearly so in others, where the exponential is not.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from casr.scoring import ScoreSettings, score
from casr.specimens import SPECIMENS
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import (
    CASR_POWER,
    HERTZ,
    INDENTATION_POWER,
    eta_of,
    kappa_of,
    kappa_slope,
    mount_share,
    specimen_share,
    x_of,
    x_slope,
)
from emg2vsa.calibration.fusion import Fusion, calibrate_indentation, fuse, mm_per_n
from emg2vsa.calibration.laws import LAWS, fit_law
from emg2vsa.calibration.left_out import compare_laws
from emg2vsa.calibration.repeats import repeat_interval
from emg2vsa.calibration.unknown import estimate
from emg2vsa.errors import SettingError
from emg2vsa.settings import CalibrationSettings
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, simulate_press

EXPERIMENTS = 3000


def fused(bench, cutaneous, kinesthetic, casr, indent_n_per_mm) -> Fusion:
    """Both cues of a new specimen as the calibration of runs fuses them."""
    area, depth = np.atleast_2d(casr), np.atleast_2d(mm_per_n(indent_n_per_mm))
    c, k = (bench.interval(*each) for each in ((cutaneous, area), (kinesthetic, depth)))
    return fuse(cutaneous, c, area, kinesthetic, k, depth)


def both(bench, *, casr_noise=0.02, indent_noise=0.02, correlation=0.0, bias=1.0, d=EXPERIMENTS, seed=0):
    """Fusion of d experiments of ten presses; the two scores of a press are correlated; bias on the new indentation."""
    rng = np.random.default_rng(seed)
    kappa = [*bench.kappa, bench.kappa_new]
    first, own = rng.standard_normal((2, d, 4, 10))
    second = correlation * first + np.sqrt(1 - correlation**2) * own
    casr = bench.casr(kappa)[:, None] * (1 + casr_noise * first)
    depth = bench.mm_per_n(kappa)[:, None] * (1 + indent_noise * second)
    depth[:, 3] *= bias
    cutaneous = calibrate(bench.kappa, casr[:, :3], casr_unit="mm2/N")
    return fused(bench, cutaneous, calibrate_indentation(bench.kappa, 1 / depth[:, :3]), casr[:, 3], 1 / depth[:, 3])


def coverage(bench, found):
    return np.mean((found.low <= bench.kappa_new) & (bench.kappa_new <= found.high))


def test_indentation_is_exact_in_a_hertz_contact_and_nearly_so_in_ours(hertz, ours):
    for bench, worst in ((hertz, 1e-9), (ours, 0.003)):
        fit = calibrate_indentation(bench.kappa, 1 / bench.mm_per_n(bench.kappa)[:, None])
        found = estimate(fit, bench.mm_per_n(bench.kappa_new)).kappa[0]
        assert found == pytest.approx(bench.kappa_new, rel=worst)


@pytest.mark.parametrize("correlation", [0.4, *(pytest.param(r, marks=pytest.mark.slow) for r in (-0.4, 0.0, 0.9))])
def test_fused_intervals_cover_and_cues_that_agree_are_rarely_doubted(hertz, correlation):
    found = both(hertz, correlation=correlation)
    assert np.mean(found.correlation) == pytest.approx(correlation, abs=0.03)
    assert 0.93 < coverage(hertz, found) < 0.965
    # presses that seem correlated by chance widen an interval; whether they do is independent of their means
    plain = (found.cutaneous.serial.rho == 0) & (found.kinesthetic.serial.rho == 0)
    assert np.mean(plain) > 0.5
    assert 0.03 < np.mean(found.p[plain] < 0.05) < 0.07


def test_the_fused_spread_is_below_that_of_each_cue(hertz):
    found = both(hertz)
    alone = min(np.log(found.cutaneous.kappa).std(), np.log(found.kinesthetic.kappa).std())
    assert np.log(found.kappa).std() < 0.97 * alone
    assert np.all((found.weight >= 0) & (found.weight <= 1))


def test_the_noisier_cue_weighs_less(hertz):
    area, depth = both(hertz, indent_noise=0.06), both(hertz, casr_noise=0.06)
    assert np.median(area.weight) > 0.7
    assert np.median(depth.weight) < 0.3


def test_strongly_correlated_scores_leave_the_better_cue(hertz):
    found = both(hertz, indent_noise=0.005, correlation=0.95, d=50)
    np.testing.assert_array_equal(found.weight, 0)
    np.testing.assert_allclose(found.kappa, found.kinesthetic.kappa)
    assert "better cue alone" in found.notes()[-1]


def test_cues_that_disagree_are_said(hertz):
    found = both(hertz, indent_noise=0.005, casr_noise=0.005, bias=1.05, d=50)
    assert np.all(found.p < 0.05)
    assert "the cues disagree" in found.notes()[0]
    assert "by indentation" in found.notes()[0]


def test_a_cue_without_stiffness_leaves_none(hertz):
    known, new = hertz.presses(1)
    depth = calibrate_indentation(hertz.kappa, 1 / hertz.mm_per_n(hertz.kappa)[:, None] * np.ones(10))
    found = fused(hertz, calibrate(hertz.kappa, known, casr_unit="mm2/N"), depth, new, np.full(10, -1.0))
    assert np.isnan(found.kappa[0])
    assert found.notes() == ("undefined: one of the two cues gives no stiffness",)


def test_a_mounting_moves_both_cues_and_is_counted_in_both(hertz):
    rng = np.random.default_rng(2)
    d, angle_deg, sd_deg = EXPERIMENTS, 45.0, 0.5
    kappa = [*hertz.kappa, hertz.kappa_new]
    tilt = np.cos(np.radians(angle_deg + sd_deg * rng.standard_normal((d, 4, 1))))
    press = 1 + np.reshape([0.02, 0.003], (2, 1, 1, 1)) * rng.standard_normal((2, d, 4, 10))
    casr = hertz.casr(kappa)[:, None] * press[0] * tilt**CASR_POWER
    depth = hertz.mm_per_n(kappa)[:, None] * press[1] * tilt**INDENTATION_POWER
    cutaneous = calibrate(
        hertz.kappa, casr[:, :3], casr_unit="mm2/N", angle_share=mount_share(CASR_POWER, angle_deg, sd_deg)
    )
    kinesthetic = calibrate_indentation(
        hertz.kappa, 1 / depth[:, :3], angle_share=mount_share(INDENTATION_POWER, angle_deg, sd_deg)
    )
    found = fused(hertz, cutaneous, kinesthetic, casr[:, 3], 1 / depth[:, 3])
    assert 0.93 < coverage(hertz, found) < 0.975
    assert 0.02 < np.mean(found.p < 0.05) < 0.07


def test_the_settings_confidence_is_used(hertz):
    known, new = hertz.presses(3)
    depth = 1 / hertz.mm_per_n([*hertz.kappa, hertz.kappa_new])[:, None] * (1 + 0.01 * np.arange(10) % 3)
    half = CalibrationSettings(confidence=0.5)
    wide = fused(
        hertz, calibrate(hertz.kappa, known, casr_unit=""), calibrate_indentation(hertz.kappa, depth[:3]), new, depth[3]
    )
    narrow = fused(
        hertz,
        calibrate(hertz.kappa, known, half, casr_unit=""),
        calibrate_indentation(hertz.kappa, depth[:3], half),
        new,
        depth[3],
    )
    assert narrow.high[0] - narrow.low[0] < 0.5 * (wide.high[0] - wide.low[0])


QUICK = CalibrationSettings(resamples=2)
SKIN = ScoreSettings(quantity="skin")
PAPER = CalibrationSettings(law="exponential", minimise="kappa", resamples=2)


def error(bench, settings, angle_deg=0.0):
    fit = calibrate(bench.kappa, bench.casr(bench.kappa, angle_deg)[:, None], settings, casr_unit="mm2/N")
    return float(estimate(fit, bench.casr(bench.kappa_new, angle_deg)).kappa[0] / bench.kappa_new - 1)


@pytest.mark.parametrize("law", LAWS)
def test_axes_turn_round_and_slope_as_they_say(law):
    values = np.array([0.4, 1.3, 7.7])
    np.testing.assert_allclose(kappa_of(law, eta_of(law, values)), values)
    step = 1e-6
    np.testing.assert_allclose(x_slope(law, values), (x_of(law, values + step) - x_of(law, values - step)) / 2 / step)
    eta = eta_of(law, values)
    numeric = (kappa_of(law, eta + step) - kappa_of(law, eta - step)) / 2 / step
    np.testing.assert_allclose(kappa_slope(law, values), numeric, rtol=1e-6)


@pytest.mark.parametrize("sensor_mpa", [0.1, 0.4, 1.6])
@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
def test_it_is_exact_in_a_hertz_contact_and_a_is_the_sensor(bench_of, sensor_mpa, angle_deg):
    world = ContactWorld(exponent=1 / 3, sensor_modulus_mpa=sensor_mpa)
    bench = bench_of(world)
    assert error(bench, QUICK, angle_deg) == pytest.approx(0, abs=1e-9)
    fit = calibrate(bench.kappa, bench.casr(bench.kappa, angle_deg)[:, None], QUICK, casr_unit="mm2/N")
    assert -1 / fit.fit.parameters[0, 0] == pytest.approx(2 * world.punch_radius_mm * sensor_mpa)


@pytest.mark.parametrize(("exponent", "worst"), [(0.3, 0.0065), (0.25, 0.015), (0.2, 0.023), (0.15, 0.03)])
def test_in_other_worlds_it_errs_little_and_the_exponential_much(bench_of, exponent, worst):
    errors = []
    for sensor_mpa in (0.1, 0.2, 0.4, 0.8, 1.6):
        bench = bench_of(ContactWorld(exponent=exponent, sensor_modulus_mpa=sensor_mpa))
        errors.append(error(bench, QUICK))
        assert error(bench, PAPER) > 0.055
    assert np.abs(errors).max() < worst


def test_it_predicts_unseen_specimens_best_in_our_world(ours):
    comparison = compare_laws(ours.kappa, ours.casr(ours.kappa)[:, None], casr_unit="mm2/N")
    assert comparison.best() == "compliance"
    errors = dict(zip(comparison.laws, comparison.score[:, 0], strict=True))
    assert errors["compliance"] < 0.17
    assert min(errors["exponential"], errors["power"], errors["linear-log"]) > 0.3


def test_it_is_fitted_to_errors_of_casr_alone(hertz):
    scores = hertz.casr(hertz.kappa)[None]
    with pytest.raises(SettingError, match="compliance"):
        fit_law("compliance", "kappa", scores, hertz.kappa[None])


def test_where_no_specimen_is_so_stiff_there_is_no_kappa(hertz):
    fit = calibrate(hertz.kappa, hertz.casr(hertz.kappa)[:, None], QUICK, casr_unit="mm2/N")
    rigid = hertz.casr(1e9)
    assert estimate(fit, rigid).kappa[0] > 1e6
    assert np.isnan(estimate(fit, 0.9 * rigid).kappa[0])
    assert fit.equation().startswith("1/kappa = -0.25 ")


def test_errors_of_casr_weigh_the_specimens_alike(hertz):
    """Fitted with weights, the line through X = CASR^(3/2) is the minimum of the squared errors of CASR itself."""
    known, _ = hertz.presses(0, noise=0.01)
    fit = calibrate(hertz.kappa, known, QUICK, casr_unit="mm2/N").fit

    def squares(level, slope):
        moved = dataclasses.replace(fit, level=fit.level * level, slope=fit.slope * slope)
        x = moved.x0 + (1 / hertz.kappa[None] - moved.level) / moved.slope
        return np.sum((x ** (1 / HERTZ) - known.mean(axis=2)) ** 2)

    for change in (0.98, 1.02):
        assert squares(1, 1) < min(squares(change, 1), squares(1, change))


@pytest.mark.slow
def test_frames_of_simulated_presses_lead_to_the_stiffness_of_the_new_specimen(ours):
    def scored(kappa):
        settings = (PressSettings(stiffness_n_per_mm=kappa, repetition=r, world=ContactWorld()) for r in range(10))
        return [score(simulate_press(each).sequence(), SKIN).rate.value for each in settings]

    known, new = [scored(kappa) for kappa in ours.kappa], scored(SPECIMENS["S2"])
    found = estimate(calibrate(ours.kappa, known, QUICK, casr_unit="mm2/N"), new)
    paper = estimate(calibrate(ours.kappa, known, PAPER, casr_unit="mm2/N"), new)
    assert found.repeats.low[0] < ours.kappa_new < found.repeats.high[0]
    assert abs(found.kappa[0] / ours.kappa_new - 1) < 0.03 < abs(paper.kappa[0] / ours.kappa_new - 1)


@pytest.mark.slow
def test_kappas_interval_holds_it_in_the_world_of_finite_elements():
    """The law is not that world's, and the front is followed by other domes: both are in the interval."""

    def scored(kappa):
        presses = (simulate_press(PressSettings(stiffness_n_per_mm=kappa, repetition=r)) for r in range(4))
        return [score(press.sequence()).rate.value for press in presses]

    known = [scored(SPECIMENS[name]) for name in ("S1", "S3", "S5")]
    kappa = [SPECIMENS[name] for name in ("S1", "S3", "S5")]
    fit = calibrate(kappa, known, QUICK, casr_unit="mm2/N", specimen_share=specimen_share("front"))
    new = scored(SPECIMENS["S2"])
    found = estimate(fit, new)
    assert found.left_out.law_p[0] < 0.05
    assert found.repeats.widened[0] > 1
    assert found.repeats.low[0] < SPECIMENS["S2"] < found.repeats.high[0]
    assert abs(found.kappa[0] / SPECIMENS["S2"] - 1) < 0.15
    unwidened = repeat_interval(fit, np.array([new]))
    assert unwidened.low[0] > found.repeats.low[0], "the law alone would promise more"
