"""Intervals that know their limits: each defect is drawn into a world whose stiffness is known.

How many specimens and presses are enough.
"""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.design import Situation, smallest, try_designs
from emg2vsa.calibration.left_out import left_out
from emg2vsa.calibration.presses import far_off, without_outliers
from emg2vsa.calibration.repeats import repeat_interval
from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.calibration.unknown import estimate
from emg2vsa.cli import main
from emg2vsa.errors import SettingError
from emg2vsa.settings import CalibrationSettings
from emg2vsa.statistics.serial import serial_correlation
from emg2vsa.worlds.tactile import ContactWorld

QUICK = CalibrationSettings(resamples=2)
EXPERIMENTS = 2000


def autoregression(rng, shape, rho):
    """Unit normal noise whose neighbours along the last axis have the correlation ``rho``."""
    x = rng.standard_normal(shape)
    for i in range(1, shape[-1]):
        x[..., i] = rho * x[..., i - 1] + np.sqrt(1 - rho**2) * x[..., i]
    return x


def coverage(bench, found):
    return np.mean((found.low <= bench.kappa_new) & (bench.kappa_new <= found.high))


def correlated(bench, rho, d=EXPERIMENTS, noise=0.01):
    scores = bench.casr([*bench.kappa, bench.kappa_new])[:, None]
    scores = scores * (1 + noise * autoregression(np.random.default_rng(1), (d, 4, 10), rho))
    return scores[:, :3], scores[:, 3]


def test_independent_presses_are_rarely_called_correlated():
    x = np.random.default_rng(2).standard_normal((4000, 4, 10))
    found = serial_correlation(x)
    assert 0.04 < np.mean(found.p < 0.05) < 0.065
    plain = found.rho == 0
    np.testing.assert_array_equal(found.effective_n[plain], 10)
    assert np.mean(plain) > 0.7


@pytest.mark.parametrize("rho", [0.4, 0.6])
def test_presses_count_as_fewer_where_they_are_correlated(rho):
    x = autoregression(np.random.default_rng(3), (3000, 12, 10), rho)
    found = serial_correlation(x)
    assert np.mean(found.p < 0.05) > 0.9
    assert np.median(found.rho) == pytest.approx(rho, abs=0.03)
    of_mean = np.median(np.mean(x.var(axis=-1, ddof=1) / found.effective_n, axis=1))
    assert of_mean == pytest.approx(x.mean(axis=-1).var(), rel=0.1)


def test_a_drift_from_press_to_press_is_a_correlation_and_too_few_presses_have_none():
    drift = np.linspace(0, 3, 10) + np.random.default_rng(4).standard_normal((200, 4, 10))
    assert np.mean(serial_correlation(drift).p < 0.05) > 0.8
    few = serial_correlation(np.random.default_rng(5).random((3, 4, 3)))
    assert np.isnan(few.p).all()
    np.testing.assert_array_equal(few.effective_n, 3)


def test_equal_presses_say_nothing_of_serial_correlation():
    drift = np.cumsum(np.random.default_rng(6).standard_normal((1, 2, 12)), axis=-1)
    found = serial_correlation(np.concatenate((drift, np.full((1, 1, 12), 4.2)), axis=1))
    alone = serial_correlation(drift)
    assert alone.rho[0] > 0.3
    np.testing.assert_array_equal((found.rho, found.p), (alone.rho, alone.p))


def test_a_missing_press_does_not_hide_the_correlation_and_the_unit_does_not_matter():
    x = autoregression(np.random.default_rng(6), (1, 4, 12), 0.7)
    held = np.insert(x, 5, np.nan, axis=-1)
    for scores in (held, 1e-200 * x):
        assert serial_correlation(scores).p[0] == pytest.approx(serial_correlation(x).p[0], rel=1e-9)


@pytest.mark.parametrize(("rho", "least", "as_if_independent"), [(0.0, 0.935, 0.975), (0.4, 0.91, 0.87)])
def test_coverage_of_correlated_presses(hertz, rho, least, as_if_independent):
    known, new = correlated(hertz, rho)
    found = repeat_interval(calibrate(hertz.kappa, known, casr_unit="mm2/N"), new)
    assert least < coverage(hertz, found) < 0.97
    shuffled = np.random.default_rng(7).permuted(new, axis=1), np.random.default_rng(8).permuted(known, axis=2)
    blind = repeat_interval(calibrate(hertz.kappa, shuffled[1], casr_unit="mm2/N"), shuffled[0])
    assert coverage(hertz, blind) < as_if_independent


def test_correlated_presses_are_said(hertz):
    known, new = correlated(hertz, 0.8, d=20)
    found = estimate(calibrate(hertz.kappa, known, QUICK, casr_unit="mm2/N"), new)
    i = int(np.argmin(found.repeats.serial.p))
    assert any("successive presses are correlated" in note for note in found.notes(i))


def test_mountings_are_assumed_and_named_and_cover(hertz):
    known, new = hertz.presses(9, d=EXPERIMENTS, noise=0.005)
    off = 1 + 0.025 * np.random.default_rng(9).standard_normal((EXPERIMENTS, 4, 1))
    moved, new = known * off[:, :3], new * off[:, 3]
    blind = repeat_interval(calibrate(hertz.kappa, moved, casr_unit="mm2/N"), new)
    told = calibrate(hertz.kappa, moved, casr_unit="mm2/N", mounting_sd=0.025)
    assert coverage(hertz, blind) < 0.4
    assert 0.935 < coverage(hertz, repeat_interval(told, new)) < 0.975
    one = estimate(calibrate(hertz.kappa, moved[0], QUICK, casr_unit="mm2/N", mounting_sd=0.025), new[0])
    assert any(note.startswith("assumed: CASR differs by 2.5 %") for note in one.notes())


def test_a_law_that_its_own_test_rejects_has_wider_intervals_that_hold_the_truth(bench_of):
    """Contacts that grow unlike Hertz's: without noise to hide behind, the law is wrong, and its test says so."""
    bench = bench_of(ContactWorld(exponent=0.2, sensor_modulus_mpa=0.8))
    known, new = bench.presses(10, d=500, noise=0.001)
    calibration = calibrate(bench.kappa, known, casr_unit="mm2/N")
    assert np.mean(left_out(calibration).law_p < 0.05) > 0.99
    assert coverage(bench, repeat_interval(calibration, new)) < 0.05
    assert coverage(bench, bench.interval(calibration, new)) > 0.95
    said = estimate(calibrate(bench.kappa, known[0], QUICK, casr_unit="mm2/N"), new[0]).notes()
    assert any(note.startswith("the known specimens reject the law") for note in said)


def test_a_law_that_holds_is_rarely_widened(hertz):
    known, new = hertz.presses(11, d=EXPERIMENTS, noise=0.01)
    found = hertz.interval(calibrate(hertz.kappa, known, casr_unit="mm2/N"), new)
    assert np.mean(found.widened > 1) < 0.06


def test_a_calibration_that_is_not_monotone_gives_no_stiffness(hertz):
    """Spread rates as one recorded design had them: 229, 190 and 222 mm2/N from the stiffest to the softest."""
    scatter = 1 + 0.05 * np.random.default_rng(12).standard_normal((4, 10))
    scores = np.array([229.0, 190.0, 222.0, 205.0])[:, None] * scatter
    for law in ("compliance", "exponential"):
        fit = calibrate(hertz.kappa, scores[:3], CalibrationSettings(law=law, resamples=20), casr_unit="mm2/N")
        found = estimate(fit, scores[3])
        assert not fit.monotone[0]
        values = (found.kappa, found.repeats.low, found.repeats.high, found.bootstrap_low, found.bootstrap_high)
        assert np.isnan(values).all()
        assert any(note.startswith("no stiffness: CASR does not change") for note in found.notes())


def test_noise_alone_does_not_make_a_calibration_of_many_specimens_not_monotone(hertz):
    kappa = np.geomspace(1.1, 7.6, 8)
    noise = 1 + 0.04 * np.random.default_rng(13).standard_normal((500, 8, 10))
    fit = calibrate(kappa, hertz.casr(kappa)[:, None] * noise, casr_unit="mm2/N")
    assert np.mean(np.any(np.diff(fit.mean_casr, axis=1) < 0, axis=1)) > 0.01
    assert np.mean(fit.monotone) > 0.95
    alike = calibrate([5.0, 5.05, 1.1], [[3.0, 3.01], [2.9, 2.91], [4.0, 4.01]], casr_unit="mm2/N", kappa_se=0.1)
    assert alike.monotone[0]


def test_at_most_two_of_ten_presses_are_outliers():
    quiet = np.array([1.0, 1.01, 0.99, 1.02, 0.98, 1.005, 0.995])
    two = np.append(quiet, [1.0, 3.0, 4.0])[None]
    three = np.append(quiet, [2.0, 3.0, 4.0])[None]
    assert np.count_nonzero(far_off(three, 5)) == 3
    np.testing.assert_array_equal(without_outliers(three, 5), three)
    assert np.count_nonzero(np.isnan(without_outliers(two, 5))) == 2
    five = np.append(quiet[:4], 3.0)[None]
    assert np.count_nonzero(np.isnan(without_outliers(five, 5))) == 1


def test_presses_that_are_kept_although_far_off_are_said(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5", "S_new")]
    casr = runs[1].casr | {"front": runs[1].casr["front"] * np.r_[np.ones(7), 0.5, 0.6, 0.7]}
    runs[1] = dataclasses.replace(runs[1], casr=casr)
    at = calibrate_runs(runs, stiffness_n_per_mm, "S_new", QUICK).conditions[0].algorithms["front"].chosen
    assert "presses kept although more than 5" in at.notes[0]
    assert at.notes[0].endswith("3 of S3")


PAPER = Situation(kappa=5.32, kappa_range=(1.11, 7.63), noise=0.02, sensor_n_per_mm=4.0)


def test_more_presses_narrow_the_interval_by_their_root():
    few, many = try_designs(PAPER, (3,), (10, 40))
    assert few.half_width / many.half_width == pytest.approx(2, rel=0.1)
    assert many.error < few.error
    assert few.presses == 40


def test_intervals_of_every_design_cover():
    designs = try_designs(PAPER, (3, 6), (5, 20), experiments=2000)
    assert all(0.93 < design.coverage < 0.975 for design in designs)


def test_noise_that_is_twice_as_large_takes_four_times_the_presses():
    noisy = dataclasses.replace(PAPER, noise=0.04)
    (quiet,), (loud,) = try_designs(PAPER, (4,), (10,)), try_designs(noisy, (4,), (40,))
    assert loud.half_width == pytest.approx(quiet.half_width, rel=0.1)


def test_errors_of_the_known_stiffnesses_set_a_floor():
    off = dataclasses.replace(PAPER, kappa_error=0.03)
    (design,) = try_designs(off, (3,), (100,))
    assert design.half_width > 0.03
    assert 0.93 < design.coverage < 0.97


def test_mountings_set_a_floor_that_presses_do_not_lower():
    mounted = dataclasses.replace(PAPER, mounting_sd=0.025)
    few, many = try_designs(mounted, (3,), (10, 40), experiments=2000)
    assert few.half_width / many.half_width == pytest.approx(1, rel=0.1)
    assert many.half_width > 2 * try_designs(PAPER, (3,), (40,))[0].half_width
    assert 0.93 < many.coverage < 0.98


def test_the_smallest_design_that_is_good_enough():
    designs = try_designs(PAPER, (3, 4), (3, 10, 20), experiments=300)
    chosen = smallest(designs, 0.07)
    assert chosen is not None
    assert (chosen.specimens, chosen.repetitions) == (3, 10)
    assert smallest(designs, 0.001) is None


@pytest.mark.parametrize(
    "change",
    [{"noise": 0.0}, {"mounting_sd": -0.1}, {"mounting_sd": 0.6}, {"kappa_range": (2.0, 1.0)}, {"kappa": np.nan}],
)
def test_situations_that_cannot_be_are_named(change):
    with pytest.raises(SettingError, match="design"):
        dataclasses.replace(PAPER, **change)
    with pytest.raises(SettingError, match="2 or more"):
        try_designs(PAPER, (1,), (10,))


def test_the_command_prints_a_table_and_the_smallest(capsys):
    assert main(["tools", "design", "--experiments", "100", "--precision", "0.07"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("specimens  presses each")
    assert "smallest design for 7%: 3 specimens, 10 presses" in said
    assert main(["tools", "design", "--experiments", "50", "--precision", "0.0001", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["smallest"] is None
    assert main(["tools", "design", "--noise", "-1"]) == 2
    assert "noise above 0" in capsys.readouterr().err
    assert main(["tools", "design", "--mounting", "0.7"]) == 2
    assert "a spread of mountings from 0 to below 0.5" in capsys.readouterr().err
    assert main(["tools", "design", "--experiments", "50", "--mounting", "0.025"]) == 0
    assert "every specimen is mounted once" in capsys.readouterr().out
