"""What the executor wants of the rig's devices, and no more: drivers, emulators' drivers and tests all fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from emg2vsa.rig.camera import Frame
from emg2vsa.rig.force_sensor import ForceSample
from emg2vsa.rig.qbmove import Measurements


class Actuator(Protocol):
    """A position with a stiffness. Every method raises DeviceError when the device is lost or refuses."""

    def activate(self) -> None:
        """Motors on, where they are."""

    def deactivate(self) -> None:
        """Motors off."""

    def is_active(self) -> bool:
        """Are the motors on? They go off by themselves after a reset or when the watchdog has run out."""

    def set_position_stiffness(self, position_ticks: int, preset_ticks: int) -> None:
        """Equilibrium and stiffness preset; a rigid motor has only the preset 0."""

    def position_ticks(self) -> float:
        """Where the motors stand, as the position that ``set_position_stiffness`` would command to keep them there."""

    def measurements(self) -> Measurements:
        """Encoders of both motors and of the shaft; what each motor means for the position is the device's to say."""

    def currents_ma(self) -> tuple[int, int]:
        """Currents of both motors, mA."""


class ForceReader(Protocol):
    """A force sensor that has been started."""

    def read(self) -> ForceSample:
        """The newest sample. DeviceError when there is none."""


class FrameSource(Protocol):
    """A camera that has been started; ``delay_s`` is from the exposure of a frame until it can be had."""

    shape: tuple[int, int]
    delay_s: float

    def frames(self) -> list[Frame]:
        """Frames since the last call; never waits. DeviceError when the camera is lost."""


@dataclass(frozen=True)
class Devices:
    """The devices of one run, started by the caller and closed by it; the executor only switches the motors."""

    actuator: Actuator
    force: ForceReader
    camera: FrameSource | None = None
