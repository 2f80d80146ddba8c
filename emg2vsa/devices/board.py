"""An actuator as it is opened, and what the openings of actuators have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from emg2vsa.devices.protocols import LogColumns, Measurements, Parameter, Usable
from emg2vsa.errors import DeviceError, SettingError


class Board(Protocol):
    """An actuator for runs and for what people do with it by hand. DeviceError as `Actuator`.

    A device inherits from it, adds what is abstract here and the other methods of an `Actuator`, and replaces what it
    can do better. Within a with statement: its motors go off at the end. where : port and id. rigid : it has no joint.
    creep_deg_per_s : speed of `creep`; 0: it has no such motion.
    """

    where: str = "actuator"
    rigid: bool = False
    creep_deg_per_s: float = 0.0
    columns: LogColumns = LogColumns()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.deactivate()
        except DeviceError as failure:
            if error is None:
                raise
            error.add_note(str(failure))

    @abstractmethod
    def close(self) -> None:
        """Give the line back."""

    @abstractmethod
    def identify(self) -> Any:
        """Its `Identity`. DeviceError: it is silent, or not as the rig file describes it."""

    @abstractmethod
    def usable(self, info: Any) -> Usable:
        """What a run may ask of the device of this identity."""

    @abstractmethod
    def activate(self) -> None:
        """As `Actuator`, and so the next four."""

    @abstractmethod
    def deactivate(self) -> None: ...
    @abstractmethod
    def is_active(self) -> bool: ...
    @abstractmethod
    def measurements(self) -> Measurements: ...
    @abstractmethod
    def currents_a(self) -> tuple[float, ...]: ...

    def pressing(self) -> Any:
        """The `Actuator` that a run commands: itself."""
        return self

    def serial_number(self) -> str:
        """Empty where the device tells none."""
        return ""

    def ask_active(self) -> bool:
        """Motors on, by what the device says? Nothing else is sent."""
        return self.is_active()

    def move_motors(self, motors_deg: Sequence[float]) -> None:
        """Send each motor there, degrees, without feeding the watchdog otherwise; here the joint, at the full
        preset."""
        self.pressing().command(motors_deg[0], 1.0)

    def creep(self, motors_deg: Sequence[float]) -> None:
        """Send each motor there, degrees, once, at a speed that the device keeps by itself. DeviceError where it keeps
        none."""
        wanted, found = "a device that keeps a speed by itself", "one that does not"
        raise DeviceError(self.where, wanted=wanted, found=found, do="Send it positions.")

    def parameters(self) -> Mapping[int, Parameter]:
        """All that it lists, by number."""
        return {}

    def set_parameter(self, number: int, values: tuple[float, ...]) -> Parameter:
        """Set and store one, and read it back. DeviceError where it keeps none."""
        do = "Set it with the program of its maker."
        raise DeviceError(self.where, wanted="a device whose parameters can be set", found="none", do=do)

    def set_zeros(self) -> Measurements:
        """Make the present place of motors and shaft their zero, stored; what is read then. DeviceError where it keeps
        none."""
        do = "Set home_deg of the rig file."
        raise DeviceError(self.where, wanted="a device that keeps its zero", found="one that does not", do=do)


B = TypeVar("B", bound=Board)


def answering(board: B, answers: Callable[[], bool], do: str) -> B:
    """The board. DeviceError, and the line given back, where nobody answers; ``do`` : what may help."""
    try:
        if not answers():
            raise DeviceError(board.where, wanted="a device that answers", found="no answer", do=do)
    except BaseException:
        board.close()
        raise
    return board


def no_address(key: str, wanted: str, do: str) -> SettingError:
    """The error for the ``key`` of the rig file that is absent: no address is ever guessed."""
    do = f"Write it into the rig file, or use the emulated rig (--virtual). {do}"
    return SettingError(key, wanted=wanted, found="none", do=do)


def ids_asked(ids: Sequence[int], every: range) -> Sequence[int]:
    """``ids``, or ``every`` one that a device of a kind can have where none are given. SettingError for one that none
    can have, such as that of all devices at once, which would answer together."""
    if wrong := [each for each in ids if each not in every]:
        wanted = f"ids of {every[0]} to {every[-1]}"
        raise SettingError("--id", wanted=wanted, found=", ".join(map(str, wrong)), do="Leave it out to ask all.")
    return ids or every
