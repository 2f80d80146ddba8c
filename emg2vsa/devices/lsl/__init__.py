"""Streams of the Lab Streaming Layer: tables [session.emg] and [session.force] of a study file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from emg2vsa.devices.device_settings import Channels, alike
from emg2vsa.devices.registry import Kind, Wrong
from emg2vsa.session_settings import EmgSettings, SessionForceSettings, Text
from emg2vsa.settings_class import settings_class


@settings_class
class LslEmgSettings(EmgSettings):
    """EMG from a stream of the Lab Streaming Layer."""

    kind: Literal["lsl"] = "lsl"
    channels: Channels
    "Muscle role (EDC, FDS) to the label of its channel in the stream."
    stream: Text | None = None
    "Name of the stream; omitted: the only one of type EMG."


@settings_class
class LslForceSettings(SessionForceSettings):
    """Force from a stream of the Lab Streaming Layer."""

    kind: Literal["lsl"] = "lsl"
    stream: Text | None = None
    "Name of the stream; omitted: the only one of type Force."
    channel: Text | None = None
    "Label of the channel; omitted: the only one."


def _wrong(emg: LslEmgSettings) -> Iterator[Wrong]:
    yield from alike(emg.channels)


EMG = Kind("emg", LslEmgSettings, open="lsl.driver:open_lsl", check=_wrong)
FORCE = Kind("session-force", LslForceSettings, open="lsl.driver:open_lsl")
