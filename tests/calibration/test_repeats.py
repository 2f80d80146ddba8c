"""The interval from repeated presses: its variance, its coverage, and what else it counts.

Mountings as a random effect: estimated where specimens were mounted several times, assumed elsewhere.
"""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import (
    CASR_POWER,
    INDENTATION_POWER,
    casr_exponent,
    eta_of,
    indentation_exponent,
    mount_share,
)
from emg2vsa.calibration.laws import LAWS
from emg2vsa.calibration.left_out import left_out
from emg2vsa.calibration.mountings import mounting_scatter
from emg2vsa.calibration.presses import within
from emg2vsa.calibration.repeats import _noise, by_kappa, by_mean_score, ends_on_law, repeat_interval
from emg2vsa.calibration.unknown import estimate
from emg2vsa.errors import DataError
from emg2vsa.settings import CalibrationSettings
from emg2vsa.worlds.tactile import ContactWorld

EXPERIMENTS = 3000
MEASURED = {0: (0.0189, 0.005, 0.0113, 0.0143), 30: (0.0227, 0.0265, 0.0091, 0.0276), 45: (0.03, 0.027, 0.035, 0.025)}
"""Noise of simulated presses by angle: S1, S3, S5 and the new specimen, as shares of CASR."""


def experiments(bench, noise, d=EXPERIMENTS, seed=1, **given):
    known, new = bench.presses(seed, d=d, noise=noise)
    calibration = calibrate(bench.kappa, known, casr_unit="mm2/N", **given)
    return calibration, repeat_interval(calibration, new)


def coverage(bench, found):
    return np.mean((found.low <= bench.kappa_new) & (bench.kappa_new <= found.high))


@pytest.mark.parametrize("noise", [0.01, 0.02, *MEASURED.values()])
def test_coverage_in_the_simulated_world(ours, noise):
    _, found = experiments(ours, noise)
    assert 0.935 < coverage(ours, found) < 0.965


def test_two_percent_of_noise_err_by_less_than_three(ours):
    _, found = experiments(ours, 0.02)
    assert np.median(np.abs(found.kappa / ours.kappa_new - 1)) < 0.03


@pytest.mark.parametrize("points", ["means", "repetitions"])
@pytest.mark.parametrize("law", ["compliance", "exponential", "power"])
def test_standard_error_is_the_spread_of_estimates(hertz, law, points):
    settings = CalibrationSettings(law=law, points=points)
    known, new = hertz.presses(2, d=EXPERIMENTS, noise=0.005)
    found = repeat_interval(calibrate(hertz.kappa, known, settings, casr_unit="mm2/N"), new)
    plain = found.serial.rho == 0  # correlated by chance: independent of the means, and a wider interval
    assert np.mean(plain) > 0.7
    assert np.sqrt(np.mean(found.eta_se[plain] ** 2)) == pytest.approx(found.eta[plain].std(), rel=0.04)


def test_sensitivities_carry_the_units_through(hertz):
    """Scores or stiffnesses all larger by one share: eta follows as the law says (Euler's theorem)."""
    known, new = hertz.presses(3, noise=0.01)
    calibration = calibrate(hertz.kappa, known, casr_unit="mm2/N")
    mean = new.mean(axis=1)
    found = repeat_interval(calibration, new)
    means = np.append(calibration.mean_casr, mean[:, None], axis=1)
    assert np.sum(found.gradient * means) == pytest.approx(0, abs=1e-9)
    assert np.sum(by_kappa(calibration, mean) * hertz.kappa) == pytest.approx(-found.eta[0], rel=1e-7)
    np.testing.assert_allclose(by_mean_score(calibration, mean), found.gradient[:, :3])


def test_known_stiffnesses_that_are_off_are_counted(hertz):
    rng = np.random.default_rng(4)
    known, new = hertz.presses(4, d=EXPERIMENTS, noise=0.005)
    wrong = hertz.kappa * (1 + 0.03 * rng.standard_normal((EXPERIMENTS, 3)))
    blind = repeat_interval(calibrate(wrong, known, casr_unit="mm2/N"), new)
    told = repeat_interval(calibrate(wrong, known, casr_unit="mm2/N", kappa_se=0.03 * hertz.kappa), new)
    assert coverage(hertz, blind) < 0.7
    assert 0.935 < coverage(hertz, told) < 0.965
    with pytest.raises(DataError, match="standard errors"):
        calibrate(hertz.kappa, known, casr_unit="mm2/N", kappa_se=[0.1, -0.1, 0.1])


def test_mountings_that_differ_are_counted(hertz):
    share = mount_share(INDENTATION_POWER, 45.0, 0.5)
    assert share == pytest.approx(5 / 3 * np.radians(0.5))
    assert mount_share(CASR_POWER, 0.0, 0.5) == 0
    known, new = hertz.presses(5, d=EXPERIMENTS, noise=0.005)
    off = 1 + share * np.random.default_rng(5).standard_normal((EXPERIMENTS, 4, 1))
    moved, new = known * off[:, :3], new * off[:, 3]
    blind = repeat_interval(calibrate(hertz.kappa, moved, casr_unit="mm2/N"), new)
    told = repeat_interval(calibrate(hertz.kappa, moved, casr_unit="mm2/N", angle_share=share), new)
    assert coverage(hertz, blind) < 0.5
    assert 0.935 < coverage(hertz, told) < 0.97


def test_the_growth_of_the_contacts_sizes_the_misfit_of_the_law(bench_of):
    """Where the contact grows unlike Hertz's, and noise hides nothing, the law's own error is what must be covered."""
    bench = bench_of(ContactWorld(exponent=0.2, sensor_modulus_mpa=0.8))
    known, new = bench.presses(9, d=500, noise=0.001)
    blind = repeat_interval(calibrate(bench.kappa, known, casr_unit="mm2/N"), new)
    told = repeat_interval(calibrate(bench.kappa, known, casr_unit="mm2/N", other_exponent=casr_exponent(0.4)), new)
    assert coverage(bench, blind) < 0.05
    assert coverage(bench, told) > 0.9
    np.testing.assert_allclose(told.kappa, blind.kappa)
    np.testing.assert_allclose(1 / (told.eta + told.law_step), bench.kappa_new, rtol=0.01)
    settings = CalibrationSettings(law="power")
    other = calibrate(bench.kappa, known, settings, casr_unit="mm2/N", other_exponent=casr_exponent(0.4))
    np.testing.assert_array_equal(repeat_interval(other, new).law_step, 0)


def test_exponents_follow_from_the_growth():
    assert casr_exponent(2 / 3) == pytest.approx(1.5)
    assert indentation_exponent(2 / 3) == pytest.approx(1.5)
    assert casr_exponent(np.nan) == indentation_exponent(np.nan) == 1.5


def test_a_single_press_borrows_the_noise_of_the_others(hertz):
    known, new = hertz.presses(6, d=EXPERIMENTS)
    calibration = calibrate(hertz.kappa, known, casr_unit="mm2/N")
    one = repeat_interval(calibration, new[:, :1])
    assert 0.93 < coverage(hertz, one) < 0.99
    assert np.all(one.df[one.serial.rho == 0] > 9)  # of a neighbour in score, pressed ten times
    borrowed = repeat_interval(calibration, new, own_noise=False)
    variance = within(known)[0][:, :2]  # S2 lies between S1 and S3
    np.testing.assert_allclose(borrowed.press_variance[:, 3], np.max(variance, axis=1))


def test_a_specimen_that_may_be_rigid_has_no_upper_end(hertz):
    known, _ = hertz.presses(7, noise=0.05, r=4)
    stiff = repeat_interval(calibrate(hertz.kappa, known, casr_unit="mm2/N"), hertz.casr(30.0) * [[0.95, 1.0, 1.05]])
    assert stiff.high[0] == np.inf
    assert 0 < stiff.low[0] < stiff.kappa[0]


def test_presses_that_were_not_repeated_have_no_interval(hertz):
    calibration = calibrate(hertz.kappa, hertz.casr(hertz.kappa)[:, None], casr_unit="mm2/N")
    found = repeat_interval(calibration, hertz.casr(hertz.kappa_new)[None])
    assert np.isfinite(found.kappa[0])
    assert np.isnan([found.low[0], found.high[0]]).all()


def test_a_law_that_holds_is_rejected_as_often_as_stated_and_a_wrong_one_always(hertz):
    known, _ = hertz.presses(8, d=EXPERIMENTS, noise=0.01)
    right = left_out(calibrate(hertz.kappa, known, casr_unit="mm2/N"))
    assert 0.005 < np.mean(right.law_p < 0.05) < 0.06
    assert 0.93 < np.mean(right.p > 0.05) < 0.97
    wrong = CalibrationSettings(law="exponential")
    assert np.mean(left_out(calibrate(hertz.kappa, known[:200], wrong, casr_unit="mm2/N")).law_p < 0.05) > 0.95
    assert np.isnan(left_out(calibrate(hertz.kappa[:2], known[:1, :2], casr_unit="mm2/N")).law_p[0])


def test_p_of_the_estimate_itself_is_one(hertz):
    _, found = experiments(hertz, 0.02, d=3)
    np.testing.assert_allclose(found.p_of(found.eta), 1)
    ends = found.p_of(eta_of("compliance", found.high))
    np.testing.assert_allclose(ends, 0.05)


@pytest.mark.parametrize("presses_of_new", [1, 3])
def test_a_single_press_of_the_new_specimen_has_the_noise_and_freedom_of_its_noisier_neighbour(presses_of_new):
    rng = np.random.default_rng(8)
    groups = np.full((1, 4, 1, 7), np.nan)
    designs = [(1.0, 0.01, 7), (2.0, 0.2, 5), (3.0, 0.05, 6), (2.6, 0.1, presses_of_new)]
    for row, (middle, sd, presses) in enumerate(designs):
        groups[0, row, 0, :presses] = middle + sd * rng.standard_normal(presses)
    means = np.nanmean(groups[:, :, 0], axis=2)
    variance, freedom, count = _noise(groups, means, own_noise=True)
    shown = [0, 1, 2, 1 if presses_of_new == 1 else 3]
    own = [np.nanvar(groups[0, row, 0], ddof=1) for row in shown]
    np.testing.assert_allclose(variance[0], own, rtol=1e-12)
    assert freedom[0].tolist() == [designs[row][2] - 1 for row in shown]
    assert count[0].tolist() == [7, 5, 6, presses_of_new]


D, SD, NOISE = 1000, 0.025, 0.02


def mounted(bench, mountings, presses, seed=0, sd=SD, d=D):
    """Scores (d, 4, mountings * presses), the new specimen last, and labels of a specimen."""
    rng = np.random.default_rng(seed)
    shift = np.repeat(sd * rng.standard_normal((d, 4, mountings)), presses, axis=-1)
    casr = bench.casr([*bench.kappa, bench.kappa_new])[:, None]
    labels = np.repeat(np.arange(1, mountings + 1), presses)
    return casr * (1 + shift + NOISE * rng.standard_normal(shift.shape)), labels


def test_the_scatter_of_mountings_is_that_of_their_means_less_that_of_presses(hertz):
    scores, labels = mounted(hertz, 4, 5)
    found = mounting_scatter(scores[:, :3], np.tile(labels, (3, 1)), 0.1)
    assert found.freedom == pytest.approx(np.full(D, 9))
    assert np.sqrt(np.mean(found.sd**2)) == pytest.approx(SD, rel=0.05)
    assert np.mean(found.of_presses) == pytest.approx(NOISE**2 / 5, rel=0.05)


def test_too_few_mountings_leave_the_assumed_one(hertz):
    scores, labels = mounted(hertz, 2, 5, d=3)
    once = np.ones_like(labels)
    found = mounting_scatter(scores[:, :3], np.stack([labels, labels, once]), 0.1)
    assert found.sd == pytest.approx([0.1, 0.1, 0.1])
    assert not found.freedom.any()


@pytest.mark.parametrize("sd", [0.0, SD, 0.05])
def test_intervals_hold_kappa_whatever_the_mountings_are(hertz, sd):
    scores, labels = mounted(hertz, 3, 4, sd=sd)
    known = calibrate(
        hertz.kappa, scores[:, :3], casr_unit="mm2/N", mounting_sd=0.001, mountings=np.tile(labels, (3, 1))
    )
    of_all = repeat_interval(known, scores[:, 3], mountings=labels)
    of_one = repeat_interval(known, scores[:, 3, :4])
    for found in (of_all, of_one):
        assert coverage(hertz, found) > 0.93
    if sd:
        assert np.median(of_all.eta_se) < 0.8 * np.median(of_one.eta_se)


def test_one_press_of_each_mounting_has_its_whole_scatter_counted_once(hertz):
    scores, labels = mounted(hertz, 10, 1)
    found = mounting_scatter(scores[:, :3], np.tile(labels, (3, 1)), 0.1)
    assert found.freedom == pytest.approx(np.full(D, 27))
    assert not found.of_presses.any()
    assert np.mean(found.sd**2) == pytest.approx(SD**2 + NOISE**2, rel=0.05)
    known = calibrate(hertz.kappa, scores[:, :3], casr_unit="mm2/N", mountings=np.tile(labels, (3, 1)))
    held = repeat_interval(known, scores[:, 3], mountings=labels)
    assert np.isfinite(held.low).all()
    assert 0.93 < coverage(hertz, held) < 0.975


def test_more_mountings_tell_an_order_that_is_wrong(hertz):
    """Two specimens the wrong way round by 3 %: within the scatter of one mounting of 2.5 %, beyond that of nine."""
    rng = np.random.default_rng(1)
    casr = np.array([1.0, 1.103, 1.07])[:, None] * (1 + 0.001 * rng.standard_normal((3, 18)))
    labels = np.tile(np.repeat(np.arange(9), 2), (3, 1))
    once = calibrate([6.0, 4.0, 2.0], casr, casr_unit="u", mounting_sd=0.025)
    shift = 1 + 0.025 * np.tile(np.repeat(np.tile([-1.0, 0, 1], 3), 2), (3, 1))
    several = calibrate([6.0, 4.0, 2.0], casr * shift, casr_unit="u", mountings=labels)
    assert several.mounting.sd[0] == pytest.approx(0.0216, rel=0.1)
    assert once.monotone[0]
    assert not several.monotone[0]


def test_one_mounting_with_a_wrong_assumption_does_not(hertz):
    scores, _ = mounted(hertz, 1, 10, sd=0.05)
    known = calibrate(hertz.kappa, scores[:, :3], casr_unit="mm2/N", mounting_sd=0.001)
    assert coverage(hertz, repeat_interval(known, scores[:, 3])) < 0.6


def test_it_is_said_where_the_scatter_is_from_and_what_it_costs(hertz):
    scores, labels = mounted(hertz, 3, 4, d=1)
    settings = CalibrationSettings(resamples=20)
    several = calibrate(hertz.kappa, scores[0, :3], settings, casr_unit="u", mountings=np.tile(labels, (3, 1)))
    notes = " ".join(estimate(several, scores[0, 3], labels).notes())
    assert "as repeated mountings show (6 degrees of freedom)" in notes
    assert "1 % of CASR is 3." in notes
    once = calibrate(hertz.kappa, scores[0, :3], settings, casr_unit="u", mounting_sd=0.025)
    assert "assumed: CASR differs by 2.5 %" in " ".join(estimate(once, scores[0, 3]).notes())


def test_no_end_of_an_interval_is_below_zero() -> None:
    for law in LAWS:
        low, high = ends_on_law(law, np.array([0.5, 2.0]), np.array([3.0, 50.0]))
        assert (low >= 0).all()
        assert (high > low).all()
