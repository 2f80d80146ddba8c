"""Force from volts, on a virtual clock."""

from __future__ import annotations

import sys
import types

import numpy as np
import pytest

from emg2vsa.ati.cal_file import GaugeCalibration
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.ni_daq.gauges import DaqFt
from emg2vsa.devices.ni_daq.volts import NiVolts
from emg2vsa.errors import DeviceError

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


def test_without_nidaqmx(monkeypatch):
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    with pytest.raises(DeviceError, match="Install nidaqmx"):
        NiVolts("Dev1/ai0:5", (-10, 10))


class FakeNi:
    """As much of nidaqmx as the driver calls, after its reference; notes every call."""

    def __init__(self, rows):
        self.calls = []
        self.rows = rows

    def module(self):
        class Error(Exception):
            pass

        def add(name, **options):
            self.calls.append((name, options))

        def read(number_of_samples_per_channel):
            if self.rows is None:
                raise Error("-200279: samples overwritten")
            return self.rows

        def task():
            return types.SimpleNamespace(
                ai_channels=types.SimpleNamespace(add_ai_voltage_chan=add),
                timing=types.SimpleNamespace(cfg_samp_clk_timing=add),
                start=lambda: self.calls.append("start"),
                read=read,
                close=lambda: self.calls.append("close"),
                number_of_channels=len(self.rows),
            )

        return types.SimpleNamespace(Task=task, errors=types.SimpleNamespace(Error=Error))


def constants():
    return types.SimpleNamespace(
        TerminalConfiguration=types.SimpleNamespace(DIFF="diff"),
        AcquisitionType=types.SimpleNamespace(CONTINUOUS="continuous"),
    )


def test_an_ni_card(monkeypatch):
    fake = FakeNi([[1.0, 2.0], [3.0, 4.0], [0, 0], [0, 0], [0, 0], [5.0, 6.0]])
    monkeypatch.setitem(sys.modules, "nidaqmx", fake.module())
    monkeypatch.setitem(sys.modules, "nidaqmx.constants", constants())
    volts = NiVolts("Dev1/ai0:5", (-10, 10), rate_hz=2000)
    with pytest.raises(DeviceError, match="Start the sensor"):
        volts.read_volts()
    volts.start()
    np.testing.assert_array_equal(volts.read_volts(), [[1, 3, 0, 0, 0, 5], [2, 4, 0, 0, 0, 6]])
    fake.rows = [[], [], [], [], [], []]
    assert volts.read_volts().shape == (0, 6)
    fake.rows = None
    with pytest.raises(DeviceError, match="-200279"):
        volts.read_volts()
    volts.close()
    assert fake.calls == [
        ("Dev1/ai0:5", {"terminal_config": "diff", "min_val": -10, "max_val": 10}),
        (2000, {"sample_mode": "continuous", "samps_per_chan": 8000}),
        "start",
        "close",
    ]


def test_an_ni_card_gives_a_thousand_samples_a_second_unless_told_otherwise(monkeypatch):
    fake = FakeNi([[0.0]] * 6)
    monkeypatch.setitem(sys.modules, "nidaqmx", fake.module())
    monkeypatch.setitem(sys.modules, "nidaqmx.constants", constants())
    NiVolts("Dev1/ai0:5", (-10, 10)).start()
    assert [call[0] for call in fake.calls[:2]] == ["Dev1/ai0:5", 1000.0]


def test_five_channels_are_not_six(monkeypatch):
    monkeypatch.setitem(sys.modules, "nidaqmx", FakeNi([[]] * 5).module())
    monkeypatch.setitem(sys.modules, "nidaqmx.constants", constants())
    with pytest.raises(DeviceError, match="six channels"):
        NiVolts("Dev1/ai0:4", (-10, 10)).start()
