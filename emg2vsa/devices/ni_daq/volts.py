"""Gauge voltages from a National Instruments card."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import DeviceError

BUFFER_S = 4.0
"Samples kept by the driver while nobody reads."


class NiVolts:
    """A `VoltageSource`: six differential channels of one card, hardware timed.

    Parameters
    ----------
    channels : in the order of the gauges, e.g. ``"Dev1/ai0:5"``.
    range_v : (least, greatest) voltage, from the calibration.

    Raises
    ------
    DeviceError : the package nidaqmx or NI's driver is absent.
    """

    def __init__(self, channels: str, range_v: tuple[float, float], *, rate_hz: float = 1000.0) -> None:
        self.name, self.rate_hz = channels, rate_hz
        self._range_v = range_v
        self._ni = load_nidaqmx(channels)
        self._task: Any = None

    def start(self) -> None:
        constants = import_module("nidaqmx.constants")
        low_v, high_v = self._range_v
        try:
            self._task = self._ni.Task()
            self._task.ai_channels.add_ai_voltage_chan(
                self.name, terminal_config=constants.TerminalConfiguration.DIFF, min_val=low_v, max_val=high_v
            )
            self._check_six()
            self._task.timing.cfg_samp_clk_timing(
                self.rate_hz,
                sample_mode=constants.AcquisitionType.CONTINUOUS,
                samps_per_chan=int(BUFFER_S * self.rate_hz),
            )
            self._task.start()
        except self._ni.errors.Error as error:
            raise self._trouble(error) from error

    def read_volts(self) -> NDArray[np.float64]:
        if self._task is None:
            raise DeviceError(self.name, wanted="a started task", found="none", do="Start the sensor first.")
        try:
            # -1: all that is there, and no waiting
            rows = self._task.read(number_of_samples_per_channel=-1)
        except self._ni.errors.Error as error:
            raise self._trouble(error) from error
        return np.array(rows, dtype=np.float64).reshape(6, -1).T

    def close(self) -> None:
        if self._task is not None:
            self._task.close()
            self._task = None

    def _check_six(self) -> None:
        if (found := self._task.number_of_channels) != 6:
            raise DeviceError(
                self.name,
                wanted="six channels",
                found=f"{found}",
                do="Name them in the order of the gauges: Dev1/ai0:5.",
            )

    def _trouble(self, error: Exception) -> DeviceError:
        return DeviceError(
            self.name, wanted="six voltages", found=str(error), do="Check the card, its channels and NI's driver."
        )


def load_nidaqmx(channels: str) -> Any:
    """The package nidaqmx, wanted for some channels. DeviceError when it is absent."""
    try:
        return import_module("nidaqmx")
    except ImportError as error:
        raise DeviceError(
            channels,
            wanted="the package nidaqmx, which speaks to NI cards",
            found="none",
            do='Install nidaqmx (pip install "emg2vsa[daq]") and NI\'s DAQmx driver.',
        ) from error
