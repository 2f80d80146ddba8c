"""Stiffness by the pins while a press goes on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.kappa import CAMERA, Trial, library_without, presses_of
from casr.dome.library import Library
from casr.kappa.estimate import fitted, stated_errors
from casr.kappa.family import families
from casr.kappa.known import KnownSensor
from casr.kappa.presses import KappaPress
from emg2vsa.calibration.cut_presses import cut_forces
from emg2vsa.calibration.next_press import Done, belief, next_press, options
from emg2vsa.calibration.online import NO_GAIN, WIDTH_REACHED, OnlineCalibration, OnlineEstimator, reachable_width
from emg2vsa.calibration.online_pins import NEW, KnownPins
from emg2vsa.calibration_file import open_calibration, write_calibration
from emg2vsa.errors import DataError
from emg2vsa.settings import CalibrationSettings

KAPPA, TRUE = np.array([1.1, 3.35, 7.63]), 5.32
PRESSES = presses_of(Trial("H", 1.0, 0.05, 0.0, (1.1, 3.35, 7.63), TRUE, seed=3))
FORCES_N = cut_forces(0.4, 4.4)


@pytest.fixture(scope="module")
def library() -> Library:
    return library_without("H")


@pytest.fixture(scope="module")
def calibration(library: Library) -> OnlineCalibration:
    labels = fitted(PRESSES[:-2], CAMERA, families(library), stated_errors(CAMERA))
    rates = ((1 / KAPPA + 1 / 4) ** (2 / 3))[:, None, None] * FORCES_N**-0.3 * np.array([[[0.99], [1.01]]])
    return OnlineCalibration(
        specimens=("1.1", "3.35", "7.63"), kappa=KAPPA, kappa_se=np.zeros(3), quantity="front", area_unit="mm2",
        angle_deg=0.0, condition="modular", start_n=0.4, forces_n=FORCES_N, rates=rates,
        mounting=np.ones((3, 2), dtype=np.int64),
        pins=KnownPins(KnownSensor.of(labels), CAMERA, labels.family.digest),
    )  # fmt: skip


def so_far(press: KappaPress, frames: int, mounting: str) -> KappaPress:
    assert press.force_n is not None
    return KappaPress(
        rest_px=press.rest_px, pins_px=press.pins_px[:frames], force_n=press.force_n[:frames], specimen=NEW,
        mounting=mounting,
    )  # fmt: skip


def pressed(online: OnlineEstimator, press: KappaPress):
    return [online.follow_pins(so_far(press, n, online.mounting)) for n in range(5, press.pins_px.shape[0] + 1)]


def test_kappa_is_told_at_every_judged_force_and_presses_join(calibration, library) -> None:
    online = OnlineEstimator(calibration, library=library)
    one = pressed(online, PRESSES[-1])
    online.finish_press()
    two = pressed(online, PRESSES[-2])
    judged = np.array([state.judged_at_n for state in one])
    assert np.diff(judged[np.isfinite(judged)]).min() >= 0
    for state in (*one, *two):
        if np.isfinite(state.kappa):
            assert state.low < TRUE < state.high
            assert state.kappa == pytest.approx(TRUE, rel=0.06)
            assert (state.cues, state.doubt) == ("pins and force", "")
            assert state.reachable <= state.half_width
    assert (one[-1].presses, two[-1].presses) == (1, 2)
    assert two[-1].half_width < one[-1].half_width
    assert one[-1].half_width == pytest.approx(reachable_width(calibration, TRUE), rel=0.05)
    assert next(state for state in one if state.stop).stop == NO_GAIN


def test_confidence_and_mountings_of_the_settings_reach_every_interval(calibration, library) -> None:
    press, found = so_far(PRESSES[-1], 12, "new 1"), []
    for changed in ({}, {"confidence": 0.99}, {"mounting_sd_percent": 12.9}):
        each = replace(calibration, settings=CalibrationSettings(**changed))
        state = OnlineEstimator(each, library=library).follow_pins(press)
        found.append((state.half_width, reachable_width(each, TRUE), state.reachable))
    for usual, sure, apart in zip(*found, strict=True):
        assert sure == pytest.approx(1.37 * usual, rel=0.05)
        assert apart > 1.5 * usual


def test_a_width_stops_at_the_second_force_that_reaches_it(calibration, library) -> None:
    states = pressed(OnlineEstimator(calibration, 0.5, library), PRESSES[-1])
    known = [state for state in states if np.isfinite(state.kappa)]
    later = next(state for state in known if state.judged_at_n > known[0].judged_at_n)
    assert known[0].stop != WIDTH_REACHED
    assert later.stop == WIDTH_REACHED


def test_pins_that_move_as_on_no_dome_are_a_doubt_and_stop_nothing(calibration, library) -> None:
    press = PRESSES[-1]
    wrong = replace(
        press, pins_px=press.pins_px + 3 * np.sin(press.rest_px / 20) * np.linspace(0, 1, 40)[:, None, None]
    )
    last = pressed(OnlineEstimator(calibration, 0.9, library), wrong)[-1]
    assert last.doubt.startswith("the pins move as on no press of the calibration")
    assert last.stop == ""


def test_a_force_that_contradicts_the_pins_is_a_doubt(calibration, library) -> None:
    press = PRESSES[-1]
    last = pressed(OnlineEstimator(calibration, 0.9, library), replace(press, force_n=2 * press.force_n))[-1]
    assert last.doubt.startswith("the press contradicts those of the calibration")
    assert last.stop == ""


def test_other_tables_are_refused(calibration) -> None:
    with pytest.raises(DataError, match="tables of domes: expected those of the calibration, but found others"):
        OnlineEstimator(calibration, library=library_without("C"))


def test_the_file_holds_the_same_doubles(calibration, library, tmp_path: Path) -> None:
    path = write_calibration(tmp_path / "pins.json", calibration)
    again = open_calibration(path)
    assert again.pins is not None
    assert again.pins.camera == CAMERA
    for name in KnownSensor.__dataclass_fields__:
        np.testing.assert_equal(getattr(again.pins.sensor, name), getattr(calibration.pins.sensor, name))
    states = [
        OnlineEstimator(each, library=library).follow_pins(so_far(PRESSES[-1], 12, "new 1"))
        for each in (calibration, again)
    ]
    assert states[0] == states[1]
    assert write_calibration(tmp_path / "again.json", again).read_bytes() == path.read_bytes()


def test_the_next_press_is_chosen_by_what_the_pins_promise(calibration) -> None:
    worse = replace(calibration, pins=replace(calibration.pins, sensor=replace(calibration.pins.sensor, misfit=0.1)))
    found = options([worse, calibration], counts=(1,))
    assert found[0].calibration == 1
    kappa, low, high = 5.3, 4.8, 5.9
    done = {0: Done(1, 1, kappa, low)}
    assert belief([calibration], done).interval(0.95) == pytest.approx((low, high), rel=0.03)
    assert next_press([calibration], done, width=0.5) is None
