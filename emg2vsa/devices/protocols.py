"""What the rig wants of its devices, and no more: drivers, emulators' drivers and tests all fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:  # a run with nothing to do knows folders of runs without loading NumPy
    import numpy as np
    from numpy.typing import NDArray

    from emg2vsa.actuator import Springs


@dataclass(frozen=True)
class SensorStatus:
    """What the sensor says of itself.

    code : its status word; 0 when all is well.
    faults : why the force is not to be trusted.
    warnings : what a reader ought to know of a force that is good.
    """

    code: int = 0
    faults: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class ForceSample:
    """One reading.

    time_s : when it arrived, on the rig's clock.
    force_n, torque_nm : (3,) along x, y, z of the sensor, N and N·m.
    status : of this reading.
    sequence : the sensor's own number of it: another reading has another number. None where it counts none.
    loads : the six of force and torque as plain numbers: a turn of the loop looks at them many times.
    size_n, torque_size_nm : lengths of both.
    """

    time_s: float
    force_n: NDArray[np.float64]
    torque_nm: NDArray[np.float64]
    status: SensorStatus = SensorStatus()
    sequence: int | None = None
    loads: tuple[float, ...] = field(init=False, repr=False)
    size_n: float = field(init=False, repr=False)
    torque_size_nm: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        fx, fy, fz = force = self.force_n.tolist()
        tx, ty, tz = torque = self.torque_nm.tolist()
        size_n, torque_size_nm = math.sqrt(fx * fx + fy * fy + fz * fz), math.sqrt(tx * tx + ty * ty + tz * tz)
        # a frozen dataclass
        self.__dict__.update(loads=(*force, *torque), size_n=size_n, torque_size_nm=torque_size_nm)


class ForceCounts(NamedTuple):
    """What has come from a force sensor since it was started, and what has not; all are numbers of records."""

    records: int = 0
    "That came in their order."
    lost: int = 0
    "That had not come when a later one did, less those that came late after all."
    late: int = 0
    "That came after a later one; their force is not used."
    duplicated: int = 0
    refused: int = 0
    "That make no sense: of a wrong length, or numbered more than a second away from the newest."


class Rating(NamedTuple):
    """Largest load a force sensor is made for, along x, y, z of the sensor."""

    force_n: tuple[float, float, float]
    torque_nm: tuple[float, float, float]


class ForceSensor(Protocol):
    """A sensor that measures by itself once started. It is never biased unless `bias` is called.

    rating : None where the sensor does not tell. rate_hz : readings a second.
    """

    name: str
    rating: Rating | None
    rate_hz: float

    def start(self) -> None:
        """Begin, and return once a first sample has come. DeviceError when none comes."""

    def read(self) -> ForceSample:
        """The newest sample; everything older is dropped, so a slow loop never lags. DeviceError when it is too old
        or has not changed for too long."""

    def read_all(self) -> list[ForceSample]:
        """All samples up to that of the last `read` which this has not given yet, oldest first; at most those of the
        last second."""

    def counts(self) -> ForceCounts:
        """Since the start."""

    def bias(self) -> None:
        """Make the present load the new zero."""

    def close(self) -> None:
        """Stop measuring and give the device back."""


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture.

    time_s : when it was taken, on the rig's clock.
    image : (H, W) grey levels.
    dropped : frames missing before it.
    """

    time_s: float
    image: NDArray[np.uint8]
    dropped: int = 0


class Camera(Protocol):
    """A camera that takes frames by itself once started.

    delay_s : from the exposure of a frame, which is its time, until it can be had.
    """

    name: str
    shape: tuple[int, int]
    delay_s: float

    def start(self) -> None:
        """Begin, and return once a first frame has come. DeviceError when none comes."""

    def frames(self) -> list[Frame]:
        """Frames since the last call, oldest first; never waits. DeviceError when the camera is lost."""

    def close(self) -> None:
        """Stop and give the device back."""


class PressJudge(Protocol):
    """Looks on while presses are recorded, and never waits: every method returns at once and raises nothing."""

    def force(self, time_s: float, force_n: float, depth_mm: float) -> None:
        """A reading that was kept of the press, and the depth of the shaft then; NaN except in loading."""

    def frame(self, repetition: int, frame: Frame) -> None:
        """A frame that was kept of the press."""

    def stop(self, repetition: int) -> str:
        """Why this press may stop now; empty while it is to go on."""

    def press_over(self) -> None:
        """No more of this press is kept."""


class Measurements(NamedTuple):
    """Encoder readings, ticks."""

    motor_1: int
    motor_2: int
    shaft: int


class Actuator(Protocol):
    """A position with a stiffness. Every method raises DeviceError when the device is lost or refuses.

    Where it has springs, motor 1 is sent to position + preset and motor 2 to position - preset; without, motor 1 to the
    position and motor 2 nowhere.

    springs : between motors and shaft; None is a rigid motor, whose shaft is motor 1's.
    """

    @property
    def springs(self) -> Springs | None:
        """Of the device, or of the model it stands for."""

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

    def current_limit_ma(self) -> float:
        """What the device says a motor may draw, mA; asked once the motors are on, and answered from memory."""


@dataclass(frozen=True)
class Devices:
    """The devices of one run, started by the caller and closed by it; the executor only switches the motors."""

    actuator: Actuator
    force: ForceSensor
    camera: Camera | None = None
