"""Analogue inputs of a National Instruments card: EMG, the gauges of a force sensor, or both on one card, which has one
sample clock for all its inputs."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.ati import read_calibration
from emg2vsa.devices.clock import Clock, awaited
from emg2vsa.devices.ni_daq import NiEmgSettings, NiGaugeSettings
from emg2vsa.devices.registry import Around
from emg2vsa.devices.streams import Block, SourceBase, StreamCounts, StreamInfo
from emg2vsa.errors import DeviceError, install_extra

BUFFER_S = 30.0
"Samples kept by the driver while nobody reads."
FIRST_S = 2.0
"Time in which first samples of EMG must come."
_POLL_S = 2e-3
OVERFLOWS = (-200279, -200361)
"Codes of NI's driver for samples that were overwritten before they were read: in its buffer, and in the card's."
SILENT_S = 1.0
"A card that has given nothing for so long has stopped."
GAUGES_HZ = 1000.0
"Rate of gauges that have a card of their own."


class Volts(NamedTuple):
    """Consecutive samples of a group: (n, channels) V; running number of the first; when they were read."""

    volts: NDArray[np.float64]
    first: int
    arrived_s: float


class NiInputs:
    """One continuous task of a card. Every group of channels is read by its own user.

    fs_hz : wanted rate; once started, that of the card. begins_anew : when samples were overwritten because nobody read
    in time, and the samples between are counted as lost, by the clock; else that is a DeviceError.
    """

    def __init__(self, fs_hz: float, clock: Clock, *, begins_anew: bool = True) -> None:
        self.fs_hz, self._clock, self._begins_anew = fs_hz, clock, begins_anew
        self._wanted_hz = fs_hz
        self._groups: list[NiGroup] = []
        self._users: set[NiGroup] = set()
        self._ni: Any = None
        self._task: Any = None
        self._next = 0
        self._read_s = 0.0
        "When the last sample was read, or the task was started."

    def add(self, channels: Sequence[str], count: int, range_v: tuple[float, float], *, differential: bool) -> NiGroup:
        """Channels of the task, such as Dev1/ai0 or Dev1/ai0:5, ``count`` in all, before it starts. range_v : lowest
        and highest, V."""
        group = NiGroup(self, tuple(channels), count, range_v, differential)
        self._groups.append(group)
        return group

    def start(self, user: NiGroup) -> None:
        """Begin for a group; what it has not read is forgotten."""
        self._users.add(user)
        user.waiting.clear()
        if self._task is None:
            self._next = 0
            self._begin()

    def read(self) -> None:
        """Give every group what has come. DeviceError when the card is gone."""
        if self._task is None:
            do = "Start the source first."
            raise DeviceError(self._name, wanted="a started task", found="none", do=do)
        try:
            # -1: all that is there, and no waiting
            lists = self._task.read(number_of_samples_per_channel=-1)
        except self._ni.errors.Error as error:
            if not self._begins_anew or getattr(error, "error_code", None) not in OVERFLOWS:
                self._end()
                raise self._trouble(error) from error
            last_s = self._read_s
            self._end()
            self._begin()
            self._next += max(1, round((self._read_s - last_s) * self.fs_hz))
            return
        rows = np.array(lists, dtype=np.float64).reshape(self._columns, -1).T
        now_s = self._clock.now_s()
        if len(rows):
            for group in self._groups:
                group.waiting.append(Volts(rows[:, group.columns], self._next, now_s))
            self._next += len(rows)
            self._read_s = now_s
        elif now_s - self._read_s > SILENT_S:
            do = "Check the card's cable, its power and its sample clock."
            found = f"none for {now_s - self._read_s:.1f} s"
            raise DeviceError(self._name, wanted=f"{self.fs_hz:g} samples a second", found=found, do=do)

    def close(self, user: NiGroup) -> None:
        """The task ends with its last user."""
        self._users.discard(user)
        if not self._users:
            self._end()

    def _begin(self) -> None:
        ni = self._ni = load_nidaqmx(self._name)
        constants = import_module("nidaqmx.constants")
        kinds = constants.TerminalConfiguration
        try:
            self._task = ni.Task()
            self._columns = 0
            for group in self._groups:
                low_v, high_v = group.range_v
                terminals = kinds.DIFF if group.differential else kinds.DEFAULT
                how = {"terminal_config": terminals, "min_val": low_v, "max_val": high_v}
                for channel in group.channels:
                    self._task.ai_channels.add_ai_voltage_chan(channel, **how)
                group.columns = slice(self._columns, self._task.number_of_channels)
                self._columns = self._task.number_of_channels
                group.check_count()
                group.waiting.clear()
            kept, mode = int(BUFFER_S * self._wanted_hz), constants.AcquisitionType.CONTINUOUS
            self._task.timing.cfg_samp_clk_timing(self._wanted_hz, sample_mode=mode, samps_per_chan=kept)
            self.fs_hz = float(self._task.timing.samp_clk_rate)
            for group in self._groups:
                group.rate_hz = self.fs_hz
            self._task.start()
        except ni.errors.Error as error:
            self._end()
            raise self._trouble(error) from error
        except DeviceError:
            self._end()
            raise
        self._read_s = self._clock.now_s()

    def _end(self) -> None:
        if self._task is not None:
            self._task.close()
            self._task = None

    @property
    def _name(self) -> str:
        return ", ".join(channel for group in self._groups for channel in group.channels)

    def _trouble(self, error: Exception) -> DeviceError:
        found = " ".join(str(error).split())
        do = "Check the card, the names of its channels and NI's driver (NI MAX shows them)."
        return DeviceError(self._name, wanted="voltages of these inputs", found=found, do=do)


class NiGroup:
    """Channels of a task, read by one user."""

    def __init__(
        self, inputs: NiInputs, channels: tuple[str, ...], count: int, range_v: tuple[float, float], differential: bool
    ) -> None:
        self.inputs, self.channels, self.range_v, self.differential = inputs, channels, range_v, differential
        self._count = count
        self.name = ", ".join(channels)
        self.rate_hz = inputs.fs_hz
        self.columns = slice(0, 0)
        self.waiting: deque[Volts] = deque()

    def start(self) -> None:
        self.inputs.start(self)

    def read(self) -> list[Volts]:
        """What came since the last call."""
        self.inputs.read()
        taken = list(self.waiting)
        self.waiting.clear()
        return taken

    def check_count(self) -> None:
        """DeviceError where the card makes more or fewer channels of the names."""
        if (found := self.columns.stop - self.columns.start) != self._count:
            do = "Name each input once, such as Dev1/ai0, or Dev1/ai0:5 for six."
            raise DeviceError(self.name, wanted=f"{self._count} channels", found=f"{found}", do=do)

    def read_volts(self) -> NDArray[np.float64]:
        """Samples (n, channels), V, that have come since the last call; n may be 0."""
        taken = [each.volts for each in self.read()]
        return np.concatenate(taken) if taken else np.empty((0, self.columns.stop - self.columns.start))

    def close(self) -> None:
        self.inputs.close(self)


def group_of(settings: NiEmgSettings | NiGaugeSettings, around: Around) -> NiGroup:
    """The inputs of one device, which last as long as ``around.kept``.

    Those of EMG and gauges on one card are two groups of one task: every channel of a task is named before it starts,
    whichever of the two starts first. A session goes on where samples are lost, and counts them; a run of the rig ends.
    """
    made: dict[type, NiGroup] = around.kept.setdefault("ni-daq", {})
    if type(settings) not in made:
        beside = (each for role, each in around.others.items() if role in ("emg", "force"))
        together = [settings, *(each for each in beside if _on_one_card(settings, each))]
        together.sort(key=lambda each: isinstance(each, NiGaugeSettings))  # the columns of the EMG come first
        fs_hz = next((each.fs_hz for each in together if isinstance(each, NiEmgSettings)), GAUGES_HZ)
        inputs = NiInputs(fs_hz, around.clock, begins_anew=bool(around.others))
        made |= {type(each): _added(each, inputs) for each in together}
    return made[type(settings)]


def _on_one_card(one: NiEmgSettings | NiGaugeSettings, other: object) -> bool:
    """Are these EMG and gauges of one card?"""
    if not isinstance(other, (NiEmgSettings, NiGaugeSettings)) or type(one) is type(other):
        return False
    return not _cards(one).isdisjoint(_cards(other))


def _cards(settings: NiEmgSettings | NiGaugeSettings) -> set[str]:
    inputs = [settings.channels] if isinstance(settings, NiGaugeSettings) else settings.channels.values()
    return {name.partition("/")[0] for name in inputs}


def _added(settings: NiEmgSettings | NiGaugeSettings, inputs: NiInputs) -> NiGroup:
    """EMG is wired in the card's own way, which is differential where it can."""
    if isinstance(settings, NiEmgSettings):
        names = tuple(settings.channels.values())
        return inputs.add(names, len(names), (-settings.range_v, settings.range_v), differential=False)
    return inputs.add((settings.channels,), 6, read_calibration(settings.cal_file).range_v, differential=True)


def load_nidaqmx(channels: str) -> Any:
    """The package nidaqmx, wanted for some channels. DeviceError when it is absent."""
    try:
        return import_module("nidaqmx")
    except ImportError as error:
        wanted = "the package nidaqmx, which speaks to NI cards"
        do = f"Install nidaqmx ({install_extra('daq')}) and NI's DAQmx driver."
        raise DeviceError(channels, wanted=wanted, found="none", do=do) from error


def open_emg(settings: NiEmgSettings, around: Around) -> NiEmg:
    """The source of [session.emg]. DeviceError where nidaqmx is not installed."""
    load_nidaqmx('session.emg.kind = "ni-daq"')
    return NiEmg(settings, group_of(settings, around), around.clock)


class NiEmg(SourceBase):
    """A `Source` of EMG, V at the skin: voltages divided by the gain of the amplifier. ``group`` : see `group_of`."""

    _started = "task"

    def __init__(self, settings: NiEmgSettings, group: NiGroup, clock: Clock) -> None:
        self._settings, self._group, self._clock = settings, group, clock
        self._where = group.name
        self._unread: list[Volts] = []
        self._samples = self._next = self._before = 0

    def start(self) -> None:
        """Start the card and wait for samples. DeviceError : none come."""
        settings = self._settings
        self._samples = self._next = 0
        self._group.start()
        if not (first := awaited(self._clock, FIRST_S, _POLL_S, self._group.read)):
            do = "Check the card's sample clock."
            raise DeviceError(self._group.name, wanted="samples", found=f"none for {FIRST_S:g} s", do=do)
        self._unread, self._before = first, first[0].first
        facts = {"device": "National Instruments analogue inputs", "gain": f"{settings.gain:g}"}
        facts["range"] = f"±{settings.range_v:g} V before the gain is divided out"
        facts |= {f"{role}, input": name for role, name in settings.channels.items()}
        self._info = StreamInfo(
            "emg", tuple(settings.channels), "V", self._group.rate_hz,
            range_max=settings.range_v / settings.gain, delay_s=settings.delay_s, facts=facts,
        )  # fmt: skip

    def read(self) -> list[Block]:
        taken = self._unread + self._group.read()
        self._unread = []
        for each in taken:
            self._samples += len(each.volts)
            self._next = each.first + len(each.volts) - self._before
        gain, before = self._settings.gain, self._before
        return [Block(each.volts / gain, each.first - before, each.arrived_s) for each in taken]

    def counts(self) -> StreamCounts:
        return StreamCounts(self._samples, self._next - self._samples)

    def close(self) -> None:
        self._group.close()
