"""Mountings as a random effect: estimated where specimens were mounted several times, assumed elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.mountings import mounting_scatter
from emg2vsa.calibration.repeats import repeat_interval
from emg2vsa.calibration.unknown import estimate
from emg2vsa.settings import CalibrationSettings

D, SD, NOISE = 1000, 0.025, 0.02


def mounted(bench, mountings, presses, seed=0, sd=SD, d=D):
    """Scores (d, 4, mountings * presses), the new specimen last, and labels of a specimen."""
    rng = np.random.default_rng(seed)
    shift = np.repeat(sd * rng.standard_normal((d, 4, mountings)), presses, axis=-1)
    casr = bench.casr([*bench.kappa, bench.kappa_new])[:, None]
    labels = np.repeat(np.arange(1, mountings + 1), presses)
    return casr * (1 + shift + NOISE * rng.standard_normal(shift.shape)), labels


def coverage(bench, found):
    return np.mean((found.low <= bench.kappa_new) & (bench.kappa_new <= found.high))


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
