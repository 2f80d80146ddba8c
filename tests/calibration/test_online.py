"""Stiffness while a press goes on."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from casr.spread import spread_rate
from emg2vsa.calibration.cut_presses import cut_all, cut_forces, cut_rates, rising
from emg2vsa.calibration.online import (
    NO_GAIN,
    WIDTH_REACHED,
    OnlineCalibration,
    OnlineEstimator,
    reachable_width,
)
from emg2vsa.settings import CalibrationSettings

FORCES_N = np.arange(0.5, 7.05, 0.1)
ONE_MOUNTING = CalibrationSettings(mounting_sd_percent=0.0)


def curves(bench, kappa, rng, presses=10, noise=0.02):
    """Presses whose areas are off by one factor each, and by a little in every frame."""
    area = bench.world.area_mm2(FORCES_N, kappa)
    factors = 1 + noise * rng.standard_normal((presses, 1))
    return [(FORCES_N, a) for a in area * factors * (1 + 0.002 * rng.standard_normal((presses, FORCES_N.size)))]


def calibration_of(bench, rng, settings=ONE_MOUNTING, **presses):
    rates = cut_all([curves(bench, kappa, rng, **presses) for kappa in bench.kappa], 0.5, cut_forces(0.5, 7.0))
    return OnlineCalibration(
        specimens=("S1", "S3", "S5"),
        kappa=bench.kappa,
        kappa_se=np.zeros(3),
        quantity="front",
        area_unit="mm2",
        angle_deg=0.0,
        condition="modular",
        start_n=0.5,
        forces_n=cut_forces(0.5, 7.0),
        rates=rates,
        mounting=np.ones(rates.shape[:2], dtype=np.int64),
        settings=settings,
    )


def estimator(bench, rng, wanted, **presses):
    return OnlineEstimator(calibration_of(bench, rng, **presses), wanted)


def test_presses_are_judged_every_fifth_of_a_newton_up_to_the_last_force():
    forces = cut_forces(0.5, 7.0)
    assert forces[-1] == 7.0
    assert forces[0] == pytest.approx(1.0)
    np.testing.assert_allclose(np.diff(forces), 0.2)


def test_rates_are_those_of_the_power_law_between_the_two_forces():
    stops = np.array([2.0, 7.0, 9.0])
    forces = np.linspace(0.7, 6.9, 63)
    rates = cut_rates(forces, 3 * np.sqrt(forces), 0.5, stops)
    np.testing.assert_allclose(rates[:2], 3 * (np.sqrt(stops[:2]) - np.sqrt(0.5)) / (stops[:2] - 0.5))
    assert np.isnan(rates[2])
    assert np.isnan(cut_rates(FORCES_N[:2], FORCES_N[:2], 0.4, stops)).all()


def test_a_whole_press_has_the_rate_that_casr_gives_it():
    rng = np.random.default_rng(5)
    area = 30 * FORCES_N**0.4 * (1 + 0.01 * rng.standard_normal(FORCES_N.size))
    area[3] *= 1.4
    for n in (3, 4, 7, FORCES_N.size):
        whole = spread_rate(area[:n], FORCES_N[:n], window_n=(0.5, FORCES_N[n - 1])).value
        cut = cut_rates(FORCES_N, area, 0.5, np.array([FORCES_N[n - 1], 99.0]))
        assert cut[0] == pytest.approx(whole, rel=1e-9)
        assert np.isnan(cut[1])


def test_frames_below_an_earlier_force_are_left_out():
    force, area = rising(np.array([0.5, 1.0, 0.8, np.nan, 0.9, 1.5]), np.arange(6.0))
    np.testing.assert_array_equal(force, [0.5, 1.0, 1.5])
    np.testing.assert_array_equal(area, [0.0, 1.0, 5.0])


def test_every_frame_gives_a_state_and_the_interval_ends_up_around_the_truth(hertz):
    rng = np.random.default_rng(0)
    online = estimator(hertz, rng, wanted=0.05)
    states = [online.push(*frame) for frame in zip(*curves(hertz, hertz.kappa_new, rng, 1)[0], strict=True)]
    assert len(states) == FORCES_N.size
    assert np.isnan(states[4].kappa)
    judged = np.array([state.judged_at_n for state in states])
    assert np.nanmin(judged) == pytest.approx(1.0)
    assert np.nanmax(judged) == pytest.approx(7.0)
    assert all(state.judged_at_n <= state.force_n + 1e-9 for state in states if state.judged_at_n > 0)
    assert states[-1].low < hertz.kappa_new < states[-1].high
    assert states[-1].low < states[-1].kappa < states[-1].high


def test_presses_that_are_over_narrow_the_interval(hertz):
    rng = np.random.default_rng(1)
    online = estimator(hertz, rng, wanted=0.05)
    widths = []
    for count, press in enumerate(curves(hertz, hertz.kappa_new, rng, 9), start=1):
        for frame in zip(*press, strict=True):
            state = online.push(*frame)
        assert state.presses == count
        widths.append(state.half_width)
        online.finish_press()
    assert widths[8] < 0.5 * widths[0]


def test_a_force_that_goes_back_tells_nothing_new(hertz):
    rng = np.random.default_rng(2)
    online = estimator(hertz, rng, wanted=0.05)
    force, area = curves(hertz, hertz.kappa_new, rng, 1)[0]
    for frame in zip(force[:30], area[:30], strict=True):
        before = online.push(*frame)
    assert online.push(1.0, 10.0) == before


def test_it_stops_when_the_interval_is_narrow_enough(hertz):
    rng = np.random.default_rng(3)
    online = estimator(hertz, rng, wanted=0.2, noise=0.005)
    for frame in zip(*curves(hertz, hertz.kappa_new, rng, 1, noise=0.005)[0], strict=True):
        state = online.push(*frame)
        if state.stop == WIDTH_REACHED:
            break
    assert state.half_width <= 0.2
    assert state.force_n < 3


def test_the_first_answer_alone_stops_no_press(hertz):
    rng = np.random.default_rng(3)
    online = estimator(hertz, rng, wanted=10.0, noise=0.005)
    force, area = curves(hertz, hertz.kappa_new, rng, 1, noise=0.005)[0]
    states = [online.push(*frame) for frame in zip(force, area, strict=True)]
    known = [state for state in states if np.isfinite(state.kappa)]
    first, second = known[0], next(state for state in known if state.judged_at_n > known[0].judged_at_n)
    assert first.half_width < 10
    assert (first.stop == WIDTH_REACHED, second.stop) == (False, WIDTH_REACHED)


def test_presses_that_stopped_at_different_forces_count_together(hertz):
    """A press that goes further than those before it must not forget them."""
    rng = np.random.default_rng(12)
    calibration = calibration_of(hertz, rng)
    online, widths, presses = OnlineEstimator(calibration), [], []
    for press, stop_n in zip(curves(hertz, hertz.kappa_new, rng, 6), (2, 3, 4, 5, 6, 7), strict=True):
        for force, area in zip(*press, strict=True):
            if force <= stop_n:
                state = online.push(force, area)
        widths.append(state.half_width)
        presses.append(state.presses)
        assert state.judged_at_n <= stop_n
        online.finish_press()
    assert all(after < 1.1 * before for before, after in pairwise(widths)), widths
    assert widths[-1] < 0.75 * widths[0]
    assert presses[-1] > 1


def test_the_width_that_is_promised_before_the_first_press_is_the_one_at_its_end(hertz):
    rng = np.random.default_rng(6)
    calibration = calibration_of(hertz, rng)
    promised = reachable_width(calibration, hertz.kappa_new)
    widths = []
    for press in curves(hertz, hertz.kappa_new, rng, 20):
        online = OnlineEstimator(calibration)
        states = [online.push(*frame) for frame in zip(*press, strict=True)]
        assert states[-1].reachable == pytest.approx(states[-1].half_width, rel=1e-6)
        widths.append(states[-1].half_width)
    assert np.median(widths) == pytest.approx(promised, rel=0.1)
    assert reachable_width(calibration) < promised
    at_3_n = calibration.expected_reach(np.array([hertz.kappa_new]))[calibration.forces_n.tolist().index(3.0), 0]
    expected = calibration.half_width(hertz.kappa_new, float(at_3_n))
    assert reachable_width(calibration, hertz.kappa_new, f_max_n=3.1) == pytest.approx(expected) != promised
    assert np.isnan(reachable_width(calibration, f_max_n=0.8))
    assert reachable_width(calibration, hertz.kappa_new, presses=9) < 0.6 * promised


def test_more_presses_are_never_expected_to_widen_the_interval(hertz):
    # presses that are expected are equal; what rounding makes of them is no correlation
    own = calibration_of(hertz, np.random.default_rng(3), CalibrationSettings(), presses=3)
    kappa = np.array([1.5, 2.5, 4.0])
    sd = np.stack([own.log_sd(kappa, n, 1) for n in range(1, 21)])
    assert np.isfinite(sd).all()
    assert (np.diff(sd, axis=0) <= 1e-9).all()


def test_a_press_may_stop_where_the_rest_would_hardly_narrow_the_interval(hertz):
    rng = np.random.default_rng(7)
    online = estimator(hertz, rng, wanted=0.0)  # the presses differ by one factor each: more force adds little
    states = [online.push(*frame) for frame in zip(*curves(hertz, hertz.kappa_new, rng, 1)[0], strict=True)]
    stopped = next(state for state in states if state.stop)
    assert stopped.stop == NO_GAIN
    assert stopped.force_n < 6
    assert states[-1].half_width > 0.85 * stopped.half_width


def test_mountings_widen_the_interval(hertz):
    one, several = (
        reachable_width(calibration_of(hertz, np.random.default_rng(8), settings), hertz.kappa_new)
        for settings in (ONE_MOUNTING, CalibrationSettings())
    )
    assert several > 1.3 * one


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [0.2, 0.12])
def test_coverage_survives_the_stopping(hertz, wanted):
    rng = np.random.default_rng(4)
    held, last_n, stopped = [], [], 0
    for _ in range(120):
        online = estimator(hertz, rng, wanted)
        for press in curves(hertz, hertz.kappa_new, rng):
            for frame in zip(*press, strict=True):
                state = online.push(*frame)
                if state.stop == WIDTH_REACHED:
                    break
            if state.stop == WIDTH_REACHED:
                stopped += 1
                held.append(state.low <= hertz.kappa_new <= state.high)
                last_n.append(state.force_n)
                break
            online.finish_press()
    assert stopped > 90
    assert np.mean(held) > 0.92
    assert np.median(last_n) < 4
