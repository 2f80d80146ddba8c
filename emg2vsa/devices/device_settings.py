"""What every kind of actuator, force sensor and camera has: tables [actuator], [force] and [camera] of rig.toml; and
which channel of a source of EMG is which muscle's.

The keys of one kind stand in its folder. The facts that drivers and settings share stand here, so that a rig file is
read without loading a driver.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated

from emg2vsa.devices.registry import Wrong
from emg2vsa.settings import Ge, Gt, Le, MinLen, Positive
from emg2vsa.settings_class import settings_class

RATE_HZ = 20.0
"""Frames a second of the tactile camera."""
SHAPE = (300, 300)
"""(height, width) of the paper's frames, px."""
LOST_S = 0.5
"""A camera that gives no frame for so long is lost."""
LARGEST_PRESS_BYTES = 2**32 - 1
"""Frames of a press are one TIFF, whose offsets have 32 bits."""

Text = Annotated[str, MinLen(1)]
WatchdogS = Annotated[float, Ge(0.06), Le(5)]
"""Steps of 20 ms, at most 250; 1 and 2 are rounded to a period of 0, whose meaning is unknown (cmd_set_watchdog)."""
Channels = Annotated[dict[str, Text], MinLen(1)]
"""Muscle role of the study (EDC, FDS) to the source's name of its channel."""
NetPort = Annotated[int, Ge(1), Le(65535)]


@settings_class
class ActuatorSettings:
    """An actuator of any kind."""

    kind: str
    "Kind of the device; each kind has keys of its own."
    port: Text | None = None
    "Serial port, as emg2vsa rig scan lists it: /dev/ttyUSB0, COM3. Omitted: only the emulated rig can run."
    serial_number: Text | None = None
    """Serial number as emg2vsa rig info prints it; another device on the port is refused before anything moves. Of a
    device that tells none: that of its USB adapter.
    """
    id: Annotated[int, Ge(0), Le(255)] = 1
    "Device id, as emg2vsa rig scan lists it."
    baud: Annotated[int, Gt(0)] = 2_000_000
    "Bits a second on the serial line."
    watchdog_s: WatchdogS = 0.5
    """The device is told to switch its motors off when the program has been silent for so long. Whether it does is
    unknown until emg2vsa rig prove-watchdog has shown it on this very device."""

    @property
    def joint(self) -> str:
        """Name of the joint, for which schedules are made: of the kind, where its models do not differ."""
        return self.kind

    @property
    def full_preset(self) -> float | None:
        """Full preset in the joint's own unit; None where [rig] or the device says it."""
        return None

    @property
    def unmeasured(self) -> str:
        """Key that a measurement must give before a schedule can run; empty where there is none."""
        return ""


@settings_class
class ForceSettings:
    """The force sensor under the specimen, of any kind."""

    kind: str
    "Kind of the device; each kind has keys of its own."
    serial_number: Text | None = None
    "Serial number as emg2vsa rig info prints it, of a Net F/T box its calibration's; another sensor is refused."
    bias: bool = False
    "true: the load on the sensor when a run begins becomes its zero; needed where the sensor has no zero of its own."


@settings_class
class CameraSettings:
    """The tactile camera, of any kind."""

    kind: str
    "Kind of the device; each kind has keys of its own."
    serial_number: Text | None = None
    "Serial number as emg2vsa rig info prints it, where the kind tells one; another camera is refused."
    height: Annotated[int, Gt(0)] = SHAPE[0]
    "Rows of the frames that are kept, pixels."
    width: Annotated[int, Gt(0)] = SHAPE[1]
    "Columns of the frames that are kept, pixels."
    rate_hz: Positive = RATE_HZ
    "Frames kept a second; a faster camera is thinned out."
    delay_s: Annotated[float, Ge(0), Le(0.5)] = 0.0
    "Time from exposure to arrival, as rig camera-delay measures it; frames are timed so much earlier."


def alike(channels: Mapping[str, str], spelt: Callable[[str], str] = str) -> Iterator[Wrong]:
    """Muscles with the channel of another one. ``spelt`` : one way of writing a channel that has several."""
    first: dict[str, str] = {}
    for role, name in channels.items():
        if (same := first.setdefault(spelt(name), role)) != role:
            yield Wrong(("channels", role), "a channel of its own for each muscle", f"{name!r}, as for {same}")


def not_like(channels: Mapping[str, str], pattern: str, wanted: str) -> Iterator[Wrong]:
    """Channels that are not written as the source writes them."""
    for role, name in channels.items():
        if not re.fullmatch(pattern, name):
            yield Wrong(("channels", role), wanted, repr(name))
