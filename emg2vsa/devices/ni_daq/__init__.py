"""A card of National Instruments: the gauges of an ATI transducer ([force] of a rig), the EMG of an amplifier."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Annotated, Literal

from emg2vsa.devices.device_settings import Channels, ForceSettings, Text, alike, not_like
from emg2vsa.devices.registry import Kind, Wrong
from emg2vsa.session_settings import EmgSettings
from emg2vsa.settings import Ge, Le
from emg2vsa.settings_class import settings_class

_INPUT = r"[A-Za-z][\w-]*/ai\d+"


@settings_class
class NiGaugeSettings(ForceSettings):
    """An ATI transducer whose gauges are wired to a card of National Instruments."""

    kind: Literal["ni-daq"] = "ni-daq"
    channels: Text
    "Six differential channels in the order of the gauges: Dev1/ai0:5."
    cal_file: Text
    "The transducer's .cal file, relative to the folder of the rig file."


@settings_class
class NiEmgSettings(EmgSettings):
    """An amplifier behind analogue inputs of a card of National Instruments."""

    kind: Literal["ni-daq"] = "ni-daq"
    channels: Channels
    "Muscle role (EDC, FDS) to its input: Dev1/ai0."
    gain: Annotated[float, Ge(0.1), Le(1_000_000)] = 1.0
    "Gain of the amplifier, by which volts are divided (Bagnoli: 100, 1000 or 10000)."
    fs_hz: Annotated[float, Ge(200), Le(100_000)] = 1000.0
    "Sampling rate."
    range_v: Annotated[float, Ge(0.01), Le(100)] = 5.0
    "Largest voltage of the inputs, before the gain."


def _wrong(emg: NiEmgSettings) -> Iterator[Wrong]:
    yield from alike(emg.channels, lambda name: re.sub(r"/ai0+(?=[0-9])", "/ai", name).casefold())
    yield from not_like(emg.channels, _INPUT, "an analogue input, such as 'Dev1/ai0'")


GAUGES = Kind("force", NiGaugeSettings, open="ni_daq.gauges:open_gauges", facts="ni_daq.gauges:facts")
EMG = Kind("emg", NiEmgSettings, open="ni_daq.inputs:open_emg", check=_wrong)
