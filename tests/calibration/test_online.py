"""Stiffness while a press goes on."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.online import OnlineEstimator, calibrate_online, cut_rates, rising
from emg2vsa.errors import DataError

FORCES_N = np.arange(0.5, 7.05, 0.1)


def curves(bench, kappa, rng, presses=10, noise=0.02):
    """Presses whose areas are off by one factor each, and by a little in every frame."""
    area = bench.world.area_mm2(FORCES_N, kappa)
    factors = 1 + noise * rng.standard_normal((presses, 1))
    return [(FORCES_N, a) for a in area * factors * (1 + 0.002 * rng.standard_normal((presses, FORCES_N.size)))]


def estimator(bench, rng, wanted, **presses):
    known = [curves(bench, kappa, rng, **presses) for kappa in bench.kappa]
    return OnlineEstimator(calibrate_online(bench.kappa, known), wanted)


def test_slopes_are_those_of_the_curve_between_the_two_forces():
    stops = np.array([2.0, 7.0, 8.0])
    forces = np.linspace(0.5, 7.1, 67)
    np.testing.assert_allclose(cut_rates(forces, 3 + 2 * forces, 0.6, stops)[:2], 2)
    rates = cut_rates(forces, np.sqrt(forces), 0.6, stops)
    assert rates[0] > rates[1]
    assert np.isnan(rates[2])
    assert np.isnan(cut_rates(FORCES_N, FORCES_N, 0.4, stops)).all()


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
    assert not states[-1].enough


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
        if state.enough:
            break
    assert state.half_width <= 0.2
    assert state.force_n < 3


def test_presses_that_do_not_reach_the_forces_are_refused(hertz):
    with pytest.raises(DataError, match="on-line"):
        calibrate_online(hertz.kappa, [[(FORCES_N[:20], FORCES_N[:20])]] * 3)


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
                if state.enough:
                    break
            if state.enough:
                stopped += 1
                held.append(state.low <= hertz.kappa_new <= state.high)
                last_n.append(state.force_n)
                break
            online.finish_press()
    assert stopped > 90
    assert np.mean(held) > 0.92
    assert np.median(last_n) < 4
