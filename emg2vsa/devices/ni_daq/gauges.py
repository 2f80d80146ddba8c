"""Force from a DAQ transducer: six gauge voltages and its .cal file."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.ati import GaugeCalibration, read_calibration
from emg2vsa.devices.clock import Clock, awaited
from emg2vsa.devices.ni_daq import NiGaugeSettings
from emg2vsa.devices.ni_daq.inputs import NiGroup, group_of, load_nidaqmx
from emg2vsa.devices.protocols import ForceCounts, ForceSample, Rating, SensorStatus
from emg2vsa.devices.registry import Around
from emg2vsa.errors import DeviceError

FIRST_S = 1.0
"Time in which started voltages must come."
BIAS_S = 0.1
"Length of the mean that becomes the zero."
NEAR_RAIL = 0.005
"Part of the range next to its ends that counts as saturated: an amplifier at its rail reads just inside the range."
_POLL_S = 1e-3


def open_gauges(settings: NiGaugeSettings, around: Around) -> DaqFt:
    """The sensor of [force]. DeviceError where nidaqmx is not installed, or the calibration cannot be read."""
    calibration = read_calibration(settings.cal_file)
    load_nidaqmx('force.kind = "ni-daq"')
    return DaqFt(group_of(settings, around), calibration, around.clock, stale_s=around.lost_s)


def facts(sensor: DaqFt, settings: NiGaugeSettings) -> dict[str, Any]:
    """Whose calibration it is, for the record of a run."""
    return {"calibration_serial": sensor.calibration.serial}


class DaqFt:
    """A `ForceSensor` on gauge voltages: wrench = matrix (V - bias).

    The bias is 0 V until `bias` is called. A gauge at the end of its range is a fault of that sample: its force is
    wrong however harmless it looks.
    """

    def __init__(self, source: NiGroup, calibration: GaugeCalibration, clock: Clock, *, stale_s: float = 0.05) -> None:
        self.name = f"{calibration.serial} on {source.name}"
        self.calibration = calibration
        self.rating, self.rate_hz = None, source.rate_hz
        if calibration.largest is not None:
            fx, fy, fz, tx, ty, tz = calibration.largest
            self.rating = Rating((fx, fy, fz), (tx, ty, tz))
        self._source, self._clock, self._stale_s = source, clock, stale_s
        self._bias_v = np.zeros(6)
        self._newest: tuple[NDArray[np.float64], float] | None = None
        self._unread: deque[tuple[NDArray[np.float64], float, int]] = deque(maxlen=max(1, round(source.rate_hz)))
        self._records = 0

    def start(self) -> None:
        """Start the inputs and wait for samples. DeviceError : none come."""
        self._source.start()
        if not awaited(self._clock, FIRST_S, _POLL_S, lambda: len(self._arrived())):
            raise self._silent(FIRST_S)

    def read(self) -> ForceSample:
        """The newest sample. DeviceError : not started, or it is too old."""
        self._arrived()
        return self._sample(*self._fresh(), self._records)

    def read_all(self) -> list[ForceSample]:
        samples = [self._sample(*each) for each in self._unread]
        self._unread.clear()
        return samples

    def counts(self) -> ForceCounts:
        # the card's driver refuses to go on when it has lost a sample
        return ForceCounts(records=self._records)

    def bias(self) -> None:
        """Take the mean voltages of a short while as zero. DeviceError : no samples come."""
        self._arrived()
        self._clock.sleep_until(self._clock.now_s() + BIAS_S)
        volts = self._arrived()
        if not len(volts):
            raise self._silent(BIAS_S)
        self._bias_v = volts.mean(axis=0)

    def close(self) -> None:
        self._source.close()

    def _arrived(self) -> NDArray[np.float64]:
        volts = self._source.read_volts()
        if len(volts):
            now_s = self._clock.now_s()
            self._newest = volts[-1], now_s
            for row in range(len(volts)):
                self._records += 1
                self._unread.append((volts[row], now_s - (len(volts) - 1 - row) / self._source.rate_hz, self._records))
        return volts

    def _fresh(self) -> tuple[NDArray[np.float64], float]:
        if self._newest is None:
            raise DeviceError(self.name, wanted="running voltages", found="none", do="Start the sensor first.")
        age_s = self._clock.now_s() - self._newest[1]
        if age_s > self._stale_s:
            raise self._silent(age_s)
        return self._newest

    def _silent(self, age_s: float) -> DeviceError:
        wanted, found = f"{self._source.rate_hz:g} samples a second", f"none for {1e3 * age_s:.0f} ms"
        do = "Check cable, power and the sample clock of the DAQ card."
        return DeviceError(self.name, wanted=wanted, found=found, do=do)

    def _sample(self, volts: NDArray[np.float64], time_s: float, sequence: int) -> ForceSample:
        wrench = self.calibration.wrench_per_volt @ (volts - self._bias_v)
        return ForceSample(time_s, wrench[:3].tolist(), wrench[3:].tolist(), self._status(volts), sequence)

    def _status(self, volts: NDArray[np.float64]) -> SensorStatus:
        low_v, high_v = self.calibration.range_v
        margin_v = NEAR_RAIL * (high_v - low_v)
        railed = (volts < low_v + margin_v) | (volts > high_v - margin_v) | ~np.isfinite(volts)
        if not railed.any():
            return SensorStatus()
        gauges = np.flatnonzero(railed)
        return SensorStatus(int((1 << gauges).sum()), tuple(f"gauge {gauge} saturated" for gauge in gauges))
