"""An emulated NI-DAQmx: an object that stands in for the module nidaqmx, with the participant's EMG on its inputs.

As NI's driver: rates are whole fractions of a time base, voltages have 16 bits over the next range that the card has,
a buffer that nobody reads overflows with error -200279.
"""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import EmgSampler

TIME_BASE_HZ = 100e6
RANGES_V = (0.2, 1.0, 5.0, 10.0)
"Of an M-series card."
STEPS = 1 << 16
BUFFERS = ((100.0, 1_000), (10_000.0, 10_000), (1_000_000.0, 100_000))
"Least samples a channel that the driver keeps, by rate."
OVERFLOW, NO_DEVICE, NO_CHANNEL = -200279, -200220, -200170
_INPUTS = 16


class Error(Exception):
    """nidaqmx.errors.Error."""


class DaqError(Error):
    """nidaqmx.errors.DaqError."""

    def __init__(self, message: str, error_code: int) -> None:
        super().__init__(f"{message}\n\nStatus Code: {error_code}")
        self.error_code = error_code


class DaqReadError(DaqError):
    """nidaqmx.errors.DaqReadError."""


class TerminalConfiguration(enum.Enum):
    DEFAULT = -1
    RSE = 10083
    NRSE = 10078
    DIFF = 10106


class AcquisitionType(enum.Enum):
    FINITE = 10178
    CONTINUOUS = 10123


class EmulatedNi:
    """What ``import nidaqmx`` gives, for one card.

    Parameters
    ----------
    participant, clock : whose EMG it is, and its time. wiring : physical channel (Dev1/ai0) to muscle; others are open.
    gain : of the amplifier before the card. clock_error : of the card's time base, as a share.
    """

    def __init__(
        self,
        participant: EmulatedParticipant,
        wiring: Mapping[str, str],
        clock: Clock,
        *,
        gain: float = 1000.0,
        clock_error: float = 2e-5,
    ) -> None:
        self.participant, self.wiring, self.clock = participant, dict(wiring), clock
        self.gain, self.clock_error = gain, clock_error
        self.errors = SimpleNamespace(Error=Error, DaqError=DaqError, DaqReadError=DaqReadError)
        self.constants = SimpleNamespace(
            TerminalConfiguration=TerminalConfiguration, AcquisitionType=AcquisitionType, READ_ALL_AVAILABLE=-1
        )
        self.lost = False

    def Task(self, new_task_name: str = "") -> Task:
        """A task without channels."""
        return Task(self)

    def unplug(self) -> None:
        """The card is gone: every call fails from now on."""
        self.lost = True


class Task:
    """nidaqmx.Task, for voltage inputs that are sampled by the card."""

    def __init__(self, ni: EmulatedNi) -> None:
        self._ni = ni
        self._muscles: list[str] = []
        self.channel_names: list[str] = []
        self._range_v = RANGES_V[-1]
        self._rate_hz, self._buffer = 1000.0, BUFFERS[1][1]
        self._sampler: EmgSampler | None = None
        self.ai_channels = SimpleNamespace(add_ai_voltage_chan=self._add)
        self.timing = SimpleNamespace(cfg_samp_clk_timing=self._set_timing, samp_clk_rate=self._rate_hz)

    @property
    def number_of_channels(self) -> int:
        return len(self._muscles)

    def start(self) -> None:
        """Begin sampling."""
        self._check()
        ni = self._ni
        fs_hz = self._rate_hz * (1 + ni.clock_error)
        self._sampler = EmgSampler(ni.participant, self._muscles, fs_hz, range_v=np.inf, start_s=ni.clock.now_s())

    def stop(self) -> None:
        """End sampling; what was not read is gone."""
        self._sampler = None

    def close(self) -> None:
        """Give the card back."""
        self._sampler, self._muscles, self.channel_names = None, [], []

    def read(self, number_of_samples_per_channel: int) -> Any:
        """-1: lists of all samples that are there, by channel; one list for one channel. DaqReadError on overflow."""
        assert number_of_samples_per_channel == -1
        self._check()
        assert self._sampler is not None
        due = self._sampler.due(self._ni.clock.now_s())
        if due > self._buffer:
            raise DaqReadError("The application is not able to keep up with the hardware acquisition.", OVERFLOW)
        volts = self._sampler.take(due) * self._ni.gain
        step_v = 2 * self._range_v / STEPS
        rows = (np.clip(np.round(volts / step_v), -STEPS // 2, STEPS // 2 - 1) * step_v).T.tolist()
        return rows[0] if len(rows) == 1 else rows

    def _check(self) -> None:
        if self._ni.lost:
            raise DaqError("Device identifier is invalid.", NO_DEVICE)

    def _add(
        self,
        physical_channel: str,
        name_to_assign_to_channel: str = "",
        terminal_config: object = TerminalConfiguration.DEFAULT,
        min_val: float = -5.0,
        max_val: float = 5.0,
        **other: object,
    ) -> None:
        self._check()
        devices = {channel.partition("/")[0] for channel in self._ni.wiring}
        for channel in _channels(physical_channel):
            device, _, input_ = channel.partition("/")
            if device not in devices:
                raise DaqError(f"Device identifier is invalid.\nDevice Specified: {device}", NO_DEVICE)
            number = input_.removeprefix("ai")
            if number == input_ or not number.isdecimal() or int(number) >= _INPUTS:
                raise DaqError(f"Physical channel specified does not exist on this device: {channel}", NO_CHANNEL)
            self._muscles.append(self._ni.wiring.get(channel, ""))
            self.channel_names.append(name_to_assign_to_channel or channel)
        wanted_v = max(abs(min_val), abs(max_val))
        self._range_v = next((range_v for range_v in RANGES_V if range_v >= wanted_v), RANGES_V[-1])

    def _set_timing(
        self, rate: float, source: str = "", active_edge: object = None, sample_mode: object = AcquisitionType.FINITE,
        samps_per_chan: int = 1000,
    ) -> None:  # fmt: skip
        self._check()
        self._rate_hz = self.timing.samp_clk_rate = TIME_BASE_HZ / round(TIME_BASE_HZ / rate)
        least = next((samples for up_to_hz, samples in BUFFERS if rate <= up_to_hz), BUFFERS[-1][1])
        self._buffer = max(least, samps_per_chan)


def _channels(text: str) -> list[str]:
    """Dev1/ai0:2, Dev1/ai5 written out."""
    channels = []
    for part in filter(None, (each.strip() for each in text.split(","))):
        several = re.fullmatch(r"(.+/ai)(\d+):(?:.*/ai|ai)?(\d+)", part)
        if several is None:
            channels.append(part)
        else:
            first, last = int(several[2]), int(several[3])
            step = 1 if last >= first else -1
            channels += [f"{several[1]}{n}" for n in range(first, last + step, step)]
    return channels
