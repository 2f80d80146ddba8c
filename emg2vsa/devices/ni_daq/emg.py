"""EMG from analogue inputs of a National Instruments card, behind an amplifier."""

from __future__ import annotations

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.ni_daq.inputs import NiGroup, Volts, group_of, load_nidaqmx
from emg2vsa.devices.ni_daq.settings import NiEmgSettings
from emg2vsa.devices.registry import Around
from emg2vsa.devices.streams import Block, StreamCounts, StreamInfo
from emg2vsa.errors import DeviceError

FIRST_S = 2.0
"Time in which first samples must come."
_POLL_S = 2e-3


def open_emg(settings: NiEmgSettings, around: Around) -> NiEmg:
    """The source of [session.emg]. DeviceError where nidaqmx is not installed."""
    load_nidaqmx('session.emg.kind = "ni-daq"')
    return NiEmg(settings, group_of(settings, around), around.clock)


class NiEmg:
    """A `Source` of EMG, V at the skin: voltages divided by the gain of the amplifier. ``group`` : see `group_of`."""

    def __init__(self, settings: NiEmgSettings, group: NiGroup, clock: Clock) -> None:
        self._settings, self._group, self._clock = settings, group, clock
        self._info: StreamInfo | None = None
        self._unread: list[Volts] = []
        self._samples = self._next = self._before = 0

    @property
    def info(self) -> StreamInfo:
        if self._info is None:
            raise DeviceError(self._group.name, wanted="a started task", found="none", do="Start the source first.")
        return self._info

    def start(self) -> None:
        settings = self._settings
        self._samples = self._next = 0
        self._group.start()
        end_s = self._clock.now_s() + FIRST_S
        while not (first := self._group.read()):
            if self._clock.now_s() >= end_s:
                do = "Check the card's sample clock."
                raise DeviceError(self._group.name, wanted="samples", found=f"none for {FIRST_S:g} s", do=do)
            self._clock.sleep_until(self._clock.now_s() + _POLL_S)
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
