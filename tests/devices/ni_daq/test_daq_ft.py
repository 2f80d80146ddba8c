"""Force from volts, on a virtual clock."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from emg2vsa.ati import GaugeCalibration
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.ni_daq import NiGaugeSettings
from emg2vsa.devices.ni_daq.gauges import DaqFt, open_gauges
from emg2vsa.devices.ni_daq.inputs import BUFFER_S, NiInputs
from emg2vsa.devices.registry import Around
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response
from tests.devices.ni_daq.emulated_card import EmulatedNi

CALIBRATION = GaugeCalibration("FT1", np.diag([1.0, 2, 3, 4, 5, 6]), (-10.0, 10.0))


class Volts:
    """A source on the clock: six voltages that grow by one volt a second, from a base that tests change."""

    name, rate_hz = "volts", 1000.0

    def __init__(self, clock):
        self.clock, self.base_v, self.slope, self.mute = clock, np.zeros(6), 1.0, False
        self._read = 0

    def start(self):
        pass

    def read_volts(self):
        due = int(self.clock.now_s() * self.rate_hz + 1e-6)
        times_s = np.arange(self._read + 1, due + 1) / self.rate_hz
        self._read = due
        return np.empty((0, 6)) if self.mute else self.base_v + self.slope * times_s[:, None]

    def close(self):
        self.mute = True


@pytest.fixture
def clock():
    return VirtualClock()


@pytest.fixture
def volts(clock):
    return Volts(clock)


@pytest.fixture
def sensor(clock, volts):
    sensor = DaqFt(volts, CALIBRATION, clock)
    sensor.start()
    return sensor


def test_the_newest_sample(clock, sensor):
    clock.sleep_until(0.5)
    sample = sensor.read()
    np.testing.assert_allclose(sample.force_n, [0.5, 1.0, 1.5])
    np.testing.assert_allclose(sample.torque_nm, [2.0, 2.5, 3.0])
    assert (sample.time_s, sample.status.faults) == (0.5, ())


def test_bias_only_when_asked(clock, volts, sensor):
    volts.slope, volts.base_v = 0.0, np.full(6, 0.25)
    clock.sleep_until(0.01)
    np.testing.assert_allclose(sensor.read().force_n, [0.25, 0.5, 0.75])
    sensor.bias()
    clock.sleep_until(0.2)
    np.testing.assert_allclose(sensor.read().force_n, 0, atol=1e-12)


@pytest.mark.parametrize("rail_v", [10.0, -10.0, 9.99, 10.4, np.nan])
def test_a_gauge_at_its_rail_is_a_fault(clock, volts, sensor, rail_v):
    volts.slope, volts.base_v = 0.0, np.array([0, 0, rail_v, 0, 0, 9.8])
    clock.sleep_until(0.01)
    status = sensor.read().status
    assert status.faults == ("gauge 2 saturated",)
    assert status.code == 0b100


def test_voltages_that_stop(clock, volts, sensor):
    volts.mute = True
    clock.sleep_until(0.04)
    sensor.read()
    clock.sleep_until(0.1)
    with pytest.raises(DeviceError, match="none for 99 ms"):
        sensor.read()
    with pytest.raises(DeviceError, match="none for 100 ms"):
        sensor.bias()


def test_voltages_that_never_start(clock, volts):
    volts.mute = True
    with pytest.raises(DeviceError, match="none for 1000 ms"):
        DaqFt(volts, CALIBRATION, clock).start()


def test_reading_before_start(clock, volts):
    with pytest.raises(DeviceError, match="Start the sensor"):
        DaqFt(volts, CALIBRATION, clock).read()


def test_without_nidaqmx(monkeypatch, clock):
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    with pytest.raises(DeviceError, match="Install nidaqmx"):
        NiInputs(1000.0, clock).add(["Dev1/ai0:5"], 6, (-10, 10), differential=True).start()


@pytest.fixture
def card(clock, monkeypatch):
    person = Person(name="P1", responses={"S1": Response(42e-6, 20e-6, 7.6)}, muscle_share={"EDC": 1.0})
    card = EmulatedNi(EmulatedParticipant(person), {"Dev1/ai7": "EDC"}, clock)
    monkeypatch.setitem(sys.modules, "nidaqmx", card)
    monkeypatch.setitem(sys.modules, "nidaqmx.constants", card.constants)
    return card


def gauges_of(path, clock, channels="Dev1/ai0:5", **around):
    return open_gauges(NiGaugeSettings(channels=channels, cal_file=str(path)), Around(clock, 0.1, **around))


def test_gauges_of_a_rig_have_a_card_of_their_own(card, clock, cal_file):
    sensor = gauges_of(cal_file, clock)
    sensor.start()
    assert (sensor.rate_hz, sensor.name) == (1000.0, "FT1 on Dev1/ai0:5")
    clock.sleep_until(clock.now_s() + 0.05)
    sensor.read()
    assert sensor.counts().records == len(sensor.read_all()) >= 50
    sensor.close()


def test_five_channels_are_not_six(card, clock, cal_file):
    with pytest.raises(DeviceError, match="expected 6 channels, but found 5"):
        gauges_of(cal_file, clock, "Dev1/ai0:4").start()


def test_a_run_of_the_rig_ends_where_samples_are_lost_and_a_session_goes_on(card, clock, cal_file):
    for others, lost in (({}, True), ({"session-force": None}, False)):
        sensor = gauges_of(cal_file, clock, others=others)
        sensor.start()
        clock.sleep_until(clock.now_s() + BUFFER_S + 10.0)
        with pytest.raises(DeviceError, match="-200279" if lost else "none for"):
            sensor.read()
        sensor.close()
