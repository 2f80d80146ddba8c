"""Two cues of the same presses: weights, correlation, agreement."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import CASR_POWER, INDENTATION_POWER, mount_share
from emg2vsa.calibration.fusion import Fusion, calibrate_indentation, fuse, mm_per_n
from emg2vsa.calibration.unknown import estimate
from emg2vsa.settings import CalibrationSettings

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
