"""Force from the force sensor of a rig: every sample it took, along the direction in which a finger pushes."""

from __future__ import annotations

import contextlib
import math

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import ForceSample, ForceSensor
from emg2vsa.devices.registry import Around, known
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.streams import Block, SourceBase, StreamCounts, StreamInfo
from emg2vsa.errors import DeviceError, SettingError

BIAS_S = 0.1
FAULT_S = 1.0
"A sensor that calls its force wrong for so long is lost."


def open_rig_force(settings: RigForceSettings, around: Around) -> RigForce:
    """The source of [session.force]. SettingError where there is no rig file, or it names no sensor that can be
    reached; DeviceError where the sensor does not answer."""
    if (own := around.others.get("force")) is None:
        do = "Name the rig file whose [force] table describes the sensor."
        raise SettingError("session.force.rig", wanted="a rig file", found="none", do=do)
    return RigForce(known("force", own).opened(own, around), settings, around.clock, bias=own.bias)


class RigForce(SourceBase):
    """A `Source` of force, N.

    Parameters
    ----------
    sensor : not started. bias : whether the load at the start becomes its zero.
    """

    _started = "sensor"

    def __init__(self, sensor: ForceSensor, settings: RigForceSettings, clock: Clock, *, bias: bool) -> None:
        self._sensor, self._clock, self._bias = sensor, clock, bias
        self._axis = unit_axis(settings.axis)
        self._delay_s, self._rate_hz = settings.delay_s, sensor.rate_hz
        self._where = sensor.name
        self._last_s: float | None = None
        self._faulty_s: float | None = None
        "Since when no sample has been free of faults."
        self._forget()

    def start(self) -> None:
        self._forget()
        self._sensor.start()
        if self._bias:
            self._sensor.bias()
            # until then samples of the old zero may come
            self._clock.sleep_until(self._clock.now_s() + BIAS_S)
        facts = {"device": self._sensor.name, "biased at the start": "yes" if self._bias else "no"}
        facts["axis"] = " ".join(f"{part:g}" for part in self._axis)
        self._info = StreamInfo("force", ("force",), "N", self._rate_hz, self._range_n(), self._delay_s, facts)
        self._taken()
        self._before = self._so_far()

    def read(self) -> list[Block]:
        """Samples that have come, along the direction. DeviceError : the sensor has reported faults for too long."""
        samples = self._taken()
        if not samples:
            return []
        places = self._places([sample.time_s for sample in samples])
        self._next, self._last_s = int(places[-1]) + 1, samples[-1].time_s
        force_n = np.array([self._force_n(sample) for sample in samples])
        self._good += int(np.isfinite(force_n).sum())
        self._check_faults(samples)
        parts = np.split(np.arange(len(samples)), np.flatnonzero(np.diff(places) > 1) + 1)
        return [Block(force_n[part, None], int(places[part[0]]), samples[part[-1]].time_s) for part in parts]

    def counts(self) -> StreamCounts:
        return StreamCounts(self._good, self._next - self._good)

    def close(self) -> None:
        with contextlib.suppress(DeviceError):
            self._sensor.close()

    def _forget(self) -> None:
        self._next = self._before = self._good = 0
        self._last_s = self._faulty_s = None

    def _taken(self) -> list[ForceSample]:
        self._sensor.read()  # takes what waits; DeviceError when that is too old
        return self._sensor.read_all()

    def _so_far(self) -> int:
        """Records since the sensor's start, and those missing: a record that came late is not handed over either."""
        counts = self._sensor.counts()
        return counts.records + counts.lost + counts.late

    def _places(self, times_s: list[float]) -> NDArray[np.int64]:
        """Running numbers of samples. Those missing among them stand where the time between two is longest."""
        last_s = times_s[0] if self._last_s is None else self._last_s
        waits = np.diff([last_s, *times_s]) * self._rate_hz
        steps = np.ones(len(times_s), dtype=np.int64)
        for _ in range(self._so_far() - self._before - self._next - len(times_s)):
            steps[np.argmax(waits - steps)] += 1
        return self._next - 1 + np.cumsum(steps)

    def _force_n(self, sample: ForceSample) -> float:
        return math.nan if sample.status.faults else float(sample.force_n @ self._axis)

    def _check_faults(self, samples: list[ForceSample]) -> None:
        for sample in samples:
            if not sample.status.faults:
                self._faulty_s = None
            elif self._faulty_s is None:
                self._faulty_s = sample.time_s
            elif sample.time_s - self._faulty_s > FAULT_S:
                found = f"for {FAULT_S:g} s: {', '.join(sample.status.faults)}"
                do = "Take the load off the sensor; check its cable; restart it."
                raise DeviceError(self._sensor.name, wanted="a force that can be trusted", found=found, do=do)

    def _range_n(self) -> float | None:
        """Largest force along the axis that the sensor is made for."""
        if self._sensor.rating is None:
            return None
        parts = zip(self._sensor.rating.force_n, self._axis, strict=True)
        return float(min(largest / abs(part) for largest, part in parts if part))


def unit_axis(axis: tuple[float, float, float]) -> NDArray[np.float64]:
    """The direction (3,), of length 1. SettingError when it has none."""
    length = math.hypot(*axis)
    if not length or not math.isfinite(length):
        do = "Give the direction of a pressing finger in the sensor's axes: [0, 0, -1]."
        raise SettingError("session.force.axis", wanted="a direction", found=f"{list(axis)}", do=do)
    return np.array(axis) / length
