"""A Trigno system of Delsys, behind the Trigno Control Utility: table [session.emg] of a study file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from emg2vsa.devices.device_settings import Channels, alike, not_like
from emg2vsa.devices.registry import Kind, Wrong
from emg2vsa.session_settings import EmgSettings, Port, Text
from emg2vsa.settings_class import settings_class

COMMAND_PORT, EMG_PORT = 50040, 50043
"""Ports of the Trigno Control Utility (SDK guide MAN-025); the legacy ports 50041 and 50042 are not read."""
OTHER_PORTS = (50041, 50042, 50044)
"""Legacy and auxiliary ports, on which no EMG of every sensor comes."""
SENSOR = r"(1[0-6]|[1-9])(?:\.([1-9]))?"
"""How a channel is written: number of the sensor, and which of its EMG channels (Quattro)."""


@settings_class
class TrignoSettings(EmgSettings):
    """Sensors of a Trigno system, which the Trigno Control Utility serves."""

    kind: Literal["trigno"] = "trigno"
    channels: Channels
    "Muscle role (EDC, FDS) to the number of its sensor, 1 to 16, or 3.2 for channel 2 of a Quattro sensor."
    host: Text = "127.0.0.1"
    "Computer on which the Trigno Control Utility runs."
    command_port: Port = COMMAND_PORT
    "Command port."
    emg_port: Port = EMG_PORT
    "Port of the EMG of every sensor."


def _wrong(emg: TrignoSettings) -> Iterator[Wrong]:
    if emg.command_port == emg.emg_port:
        yield Wrong(("emg_port",), "another port than command_port", str(emg.emg_port))
    elif emg.emg_port in OTHER_PORTS:
        do = f"The EMG of every sensor is on port {EMG_PORT}."
        yield Wrong(("emg_port",), "no legacy or auxiliary port", str(emg.emg_port), do)
    yield from alike(emg.channels, lambda name: name.removesuffix(".1"))
    wanted = "the number of a sensor, '1' to '16' (or '3.2' for channel 2 of sensor 3)"
    yield from not_like(emg.channels, SENSOR, wanted)


TRIGNO = Kind("emg", TrignoSettings, open="trigno.driver:open_trigno", check=_wrong)
