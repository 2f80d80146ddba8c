"""The next best press."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.cut_presses import cut_forces
from emg2vsa.calibration.next_press import Done, belief, next_press, options
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.errors import DataError
from emg2vsa.settings import CalibrationSettings

FORCES_N = cut_forces(0.5, 7.0)[[-3, -1]]


def calibration_of(bench, noise, mounting_sd_percent=0.0, seed=0, presses=20):
    casr = bench.casr(bench.kappa)[:, None, None] * FORCES_N**-0.3
    rates = casr * (1 + noise * np.random.default_rng(seed).standard_normal((3, presses, 1)))
    return OnlineCalibration(
        specimens=("S1", "S3", "S5"), kappa=bench.kappa, kappa_se=np.zeros(3), quantity="edge", area_unit="mm2",
        angle_deg=0.0, condition="modular", start_n=0.5, forces_n=FORCES_N, rates=rates,
        mounting=np.ones((3, presses), dtype=np.int64),
        settings=CalibrationSettings(mounting_sd_percent=mounting_sd_percent),
    )  # fmt: skip


def done_of(bench, calibration, presses=1, mountings=1):
    rates = bench.casr(bench.kappa_new)[:, None] * FORCES_N**-0.3
    rates = np.tile(rates, (presses, 1))
    labels = 1 + np.arange(presses) % mountings
    found = calibration.judged(rates[:, 1:], np.array([1]), labels)
    return Done(presses, mountings, float(found.kappa[0]), float(found.low[0]))


def test_the_quieter_condition_is_pressed_first_and_more_presses_tell_more(hertz):
    noisy, quiet = calibration_of(hertz, 0.04), calibration_of(hertz, 0.01)
    found = options([noisy, quiet])
    assert found[0].calibration == 1
    assert found[0].presses == 10
    assert all(choice.remount for choice in found)  # nothing is mounted yet
    one = {choice.calibration: choice for choice in found if choice.presses == 1}
    assert one[1].bits > one[0].bits + 0.5
    assert one[1].half_width < one[0].half_width
    assert next_press([noisy, quiet]).calibration == 1


def test_where_mountings_differ_a_new_one_tells_more_than_a_second_press(hertz):
    calibration = calibration_of(hertz, 0.005, mounting_sd_percent=3.0)
    found = options([calibration], {0: done_of(hertz, calibration, presses=3)}, counts=(3,))
    again, anew = sorted(found, key=lambda choice: choice.remount)
    assert anew.bits > 3 * again.bits
    assert anew.worthwhile
    assert not again.worthwhile
    assert next_press([calibration], {0: done_of(hertz, calibration, presses=3)}).remount


def test_nothing_is_pressed_once_the_width_is_reached_or_cannot_be_narrowed(hertz):
    calibration = calibration_of(hertz, 0.01)
    done = {0: done_of(hertz, calibration)}
    assert next_press([calibration], done, width=0.0) is not None
    assert next_press([calibration], done, width=0.5) is None
    rough = calibration_of(hertz, 0.01, presses=3)
    assert next_press([rough], {0: done_of(hertz, rough, presses=64)}) is None


def test_belief_is_flat_at_first_and_agrees_with_the_interval_of_a_good_press(hertz):
    calibration = calibration_of(hertz, 0.005)
    first = belief([calibration], {})
    assert first.weight == pytest.approx(np.full(first.kappa.size, 1 / first.kappa.size))
    done = done_of(hertz, calibration)
    low, high = belief([calibration], {0: done}).interval(0.95)
    assert low == pytest.approx(done.low, rel=0.02)
    assert low < hertz.kappa_new < high


def test_two_conditions_narrow_it_more_than_one(hertz):
    both = [calibration_of(hertz, 0.02, seed=seed) for seed in (0, 1)]
    one = {0: done_of(hertz, both[0])}
    assert belief(both, one | {1: done_of(hertz, both[1])}).variance < 0.8 * belief(both, one).variance


@pytest.mark.parametrize(("calibrations", "counts"), [(0, (1,)), (1, ()), (1, (0,))])
def test_options_need_a_calibration_and_a_press(hertz, calibrations, counts):
    with pytest.raises(DataError, match="next press: expected a calibration and 1 press or more"):
        options([calibration_of(hertz, 0.02)] * calibrations, counts=counts)
