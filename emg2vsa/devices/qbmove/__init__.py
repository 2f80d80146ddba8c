"""The qbmove on its serial line, and the board that stands in for it with a rigid motor: the same packets.

Here: how they are reached, the tables [actuator] and [motor] of rig.toml.
"""

from __future__ import annotations

from typing import Annotated, Literal

from emg2vsa.devices.device_settings import ActuatorSettings, Text, WatchdogS
from emg2vsa.devices.registry import Kind
from emg2vsa.settings import Ge, Le, Positive
from emg2vsa.settings_class import settings_class

Generation = Literal["v6", "v7"]
"""Generation of a qbmove's firmware. Generations differ in acknowledgements, and in replies that do not fit one length
byte.
"""
Model = Literal["maker-pro", "advanced"]
Baud = Literal[2_000_000, 460_800]
"""Rate of the serial line: that of generations 6 and 7, and that of generation 5 and of whoever sets it
(SET_BAUDRATE).
"""
BAUD: Baud = 2_000_000
DeviceId = Annotated[int, Ge(1), Le(255)]
REPLY_S = 0.016
"""Three attempts of it, and a turn of the loop before them, name a dead board within 60 ms."""


@settings_class
class _Board:
    """A board that speaks as a qbmove does."""

    port: Text | None = None
    """Serial port, as emg2vsa rig scan lists it: /dev/ttyUSB0, COM3; actuator and motor may share one where their ids
    differ. Omitted: only the emulated rig can run."""
    serial_number: Text | None = None
    """Serial number as emg2vsa rig info prints it; another device on the port is refused before anything moves.
    Firmware before 7.1 tells none: then that of the USB adapter.
    """
    id: DeviceId = 1
    "Device id, as emg2vsa rig scan lists it."
    baud: Baud = BAUD
    "Bits a second on the serial line; devices of generation 5 have 460800."
    generation: Generation = "v6"
    "Generation of the firmware: the first digit of its version."
    reply_s: Positive = REPLY_S
    "How long each of three attempts waits for a reply."


@settings_class
class QbmoveSettings(_Board, ActuatorSettings):
    """The qbmove."""

    kind: Literal["qbmove"] = "qbmove"
    model: Model = "maker-pro"
    "The Advanced counts its encoders the other way round."

    @property
    def joint(self) -> str:
        """The springs of the model."""
        return f"qbmove-{self.model}"


@settings_class
class MotorSettings(_Board):
    """The rigid motor of the condition high-stiffness: motor 1 of a board that speaks as a qbmove does."""

    watchdog_s: WatchdogS = 0.5
    "The board is told to switch its motor off when the program has been silent for so long; as for [actuator]."


QBMOVE = Kind(
    "actuator", QbmoveSettings, open="qbmove.opening:open_qbmove", about="qbmove.opening:about",
    scan="qbmove.conversation:answers", joints=("qbmove-advanced", "qbmove-maker-pro"), full_key="max_preset_ticks",
    export="emg2vsa.devices.qbmove.springs:EXPORT",
)  # fmt: skip
