"""What the rig wants of its devices, and no more: drivers, emulators' drivers and tests all fit."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:  # a run with nothing to do knows folders of runs without loading NumPy
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from emg2vsa.arrays import Floats


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


_NO_FAULT = SensorStatus()


@dataclass(frozen=True, eq=False, init=False)
class ForceSample:
    """One reading.

    time_s : when it arrived, on the rig's clock.
    force_n, torque_nm : (3,) along x, y, z of the sensor, N and N·m.
    status : of this reading.
    sequence : the sensor's own number of it: another reading has another number. None where it counts none.
    loads : the six of force and torque as plain numbers, as a turn of the loop looks at them many times.
    size_n, torque_size_nm : lengths of force and torque.
    """

    time_s: float
    loads: tuple[float, ...]
    status: SensorStatus
    sequence: int | None
    size_n: float = field(repr=False)
    torque_size_nm: float = field(repr=False)

    def __init__(
        self, time_s: float, force_n: Iterable[float], torque_nm: Iterable[float], status: SensorStatus = _NO_FAULT,
        sequence: int | None = None,
    ) -> None:  # fmt: skip
        self._take(time_s, (*map(float, force_n), *map(float, torque_nm)), status, sequence)

    @classmethod
    def of_loads(
        cls, time_s: float, loads: tuple[float, ...], status: SensorStatus, sequence: int | None
    ) -> ForceSample:
        """Of six plain numbers."""
        sample = cls.__new__(cls)
        sample._take(time_s, loads, status, sequence)
        return sample

    def _take(self, time_s: float, loads: tuple[float, ...], status: SensorStatus, sequence: int | None) -> None:
        fx, fy, fz, tx, ty, tz = loads
        own, sqrt = self.__dict__, math.sqrt  # a frozen dataclass
        own["time_s"], own["loads"], own["status"], own["sequence"] = time_s, loads, status, sequence
        own["size_n"], own["torque_size_nm"] = sqrt(fx * fx + fy * fy + fz * fz), sqrt(tx * tx + ty * ty + tz * tz)

    @cached_property
    def force_n(self) -> NDArray[np.float64]:
        """(3,) N."""
        return _array(self.loads[:3])

    @cached_property
    def torque_nm(self) -> NDArray[np.float64]:
        """(3,) N·m."""
        return _array(self.loads[3:])


def _array(values: tuple[float, ...]) -> NDArray[np.float64]:
    import numpy as np  # noqa: PLC0415  (who only looks at folders of runs does without)

    return np.array(values, dtype=np.float64)


class ForceCounts(NamedTuple):
    """What has come from a force sensor since it was started, and what has not; all are numbers of records."""

    records: int = 0
    "Records that came in their order."
    lost: int = 0
    "Records that had not come when a later one did, less those that came late after all."
    late: int = 0
    "Records that came after a later one; their force is not used."
    duplicated: int = 0
    refused: int = 0
    "Records that make no sense: of a wrong length, or numbered more than a second away from the newest."


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

    def force(self, time_s: float, force_n: float) -> None:
        """A reading that was kept of the press."""

    def frame(self, repetition: int, frame: Frame) -> None:
        """A frame that was kept of the press."""

    def stop(self, repetition: int) -> str:
        """Why this press may stop now; empty while it is to go on."""

    def press_over(self) -> None:
        """No more of this press is kept."""


class Measurements(NamedTuple):
    """Encoder readings, degrees of the joint."""

    motors_deg: tuple[float, ...]
    "Position of each motor, connected or not."
    shaft_deg: float
    "Motor 1's where the shaft has no encoder of its own."


class Joint(Protocol):
    """What gives way between a command and the shaft: springs between two motors, or the position gain of one.

    A preset is a share of the full preset, 0 to 1; ``full_preset`` says how much that is in the joint's own unit.
    Joints of one model differ in it alone.
    """

    @property
    def name(self) -> str:
        """Name of the model, as a study and its schedules write it."""

    @property
    def full_preset(self) -> float:
        """Springs: degrees of each motor from their middle. A gain: its stiffness, N m/rad."""

    @property
    def measured_key(self) -> str | None:
        """Key of [actuator] that a measurement of the stiffness gives; None where a model tells it."""

    @property
    def settles_s(self) -> float:
        """So long, s, after the start of a motion its deflection tells of inertia, and of no torque outside."""

    @property
    def preset_per_s(self) -> float:
        """How fast the preset may change while nothing is pressed, 1/s."""

    def targets_deg(self, position_deg: float, preset: float) -> tuple[float, ...]:
        """Where each motor goes, degrees. Empty where a motor itself gives way, and no command tells where it will
        stand."""

    def torque_nm(self, at: Measurements, position_deg: float, preset: float) -> float:
        """External torque, N m, that the joint bears with this command (degrees and preset) in force; above 0: to
        larger angles."""

    def position_deg(self, at: Measurements) -> float:
        """Position, degrees, for which the motors stand there."""

    def preset_at(self, at: Measurements) -> float:
        """Preset for which the motors stand there; 0 where they do not tell."""

    def stiffness_nm_per_rad(self, preset: ArrayLike) -> Floats:
        """At zero load, N m/rad, of presets of any shape."""

    def percent_for(self, stiffness_nm_per_rad: ArrayLike) -> Floats:
        """Preset, percent of the full one, of a stiffness at zero load; any shape. ScheduleError beyond what can be."""

    def rounded(self, preset: ArrayLike) -> Floats:
        """The nearest presets that the device can be sent; any shape."""


def gives_way(joint: Joint | None) -> bool:
    """Whether the motor itself does under load: no command tells where it will stand."""
    return joint is not None and not joint.targets_deg(0.0, 0.0)


class LogColumns(NamedTuple):
    """The columns of an actuator in log.csv: position and preset as commanded, motors 1 and 2, shaft, two currents.

    per_degree, per_preset, per_ampere : of their units in a degree, in the joint's unit of a preset, and in an ampere.
    whole : they hold whole numbers.
    """

    names: tuple[str, ...] = (
        "position_deg", "preset", "motor_1_deg", "motor_2_deg", "shaft_deg", "current_1_a", "current_2_a"
    )  # fmt: skip
    per_degree: float = 1.0
    per_preset: float = 1.0
    per_ampere: float = 1.0
    whole: bool = False


class Actuator(Protocol):
    """A position with a stiffness. Every method raises DeviceError when the device is lost or refuses.

    joint : what gives way; None is a rigid motor, whose shaft is motor 1's.
    columns : of its runs in log.csv.
    """

    columns: LogColumns

    @property
    def joint(self) -> Joint | None:
        """Joint of the device, once it is known, or of the model that it stands for."""

    def activate(self) -> None:
        """Motors on, where they are."""

    def deactivate(self) -> None:
        """Motors off."""

    def is_active(self) -> bool:
        """Are the motors on? They go off by themselves after a reset or when the watchdog has run out."""

    def command(self, position_deg: float, preset: float) -> None:
        """Equilibrium, degrees, and stiffness preset, 0 to 1; a rigid motor has only the preset 0."""

    def position_deg(self) -> float:
        """Where the motors stand, as the position of a command, degrees."""

    def measurements(self) -> Measurements:
        """Encoders of motors and shaft; what each motor means for the position is the joint's to say."""

    def currents_a(self) -> tuple[float, ...]:
        """Current of each motor, A."""

    def current_limit_a(self) -> float:
        """What the device says a motor may draw, A; asked once the motors are on, and answered from memory."""


class Usable(NamedTuple):
    """What a run may ask of an actuator. position_deg : first and last. full_preset : in its joint's own unit."""

    position_deg: tuple[float, float]
    full_preset: float


class Parameter(NamedTuple):
    """One parameter as a device lists it. form : of each value, as ``struct`` names it."""

    number: int
    name: str
    values: tuple[float, ...]
    form: str


class Identity(Protocol):
    """What a device says of itself: a dataclass of its kind, which the record of a run keeps."""

    @property
    def firmware(self) -> str: ...
    @property
    def device_id(self) -> int: ...


@dataclass(frozen=True)
class Devices:
    """The devices of one run, started by the caller and closed by it; the executor only switches the motors."""

    actuator: Actuator
    force: ForceSensor
    camera: Camera | None = None
