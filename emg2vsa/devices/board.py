"""What boards of actuators have in common: motors that go off at the end, and answers of those who keep nothing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from emg2vsa.devices.protocols import LogColumns, Measurements, Parameter
from emg2vsa.errors import DeviceError


class BoardBase(ABC):
    """Of an actuator of its own: `emg2vsa.devices.protocols.Board` but for what only its device knows.

    A device adds ``where``, ``close``, ``identify``, ``usable`` and the methods of an `Actuator`; it replaces what it
    can do better.
    """

    where = "actuator"
    rigid = False
    creep_deg_per_s = 0.0
    columns = LogColumns()

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
    def deactivate(self) -> None:
        """As `Actuator`."""

    @abstractmethod
    def is_active(self) -> bool:
        """As `Actuator`."""

    @abstractmethod
    def command(self, position_deg: float, preset: float) -> None:
        """As `Actuator`."""

    def answers(self) -> bool:
        """Whether the device does."""
        return True

    def answering(self, do: str) -> Self:
        """Itself. DeviceError, and the line given back, where nobody answers; ``do`` : what may help."""
        try:
            if not self.answers():
                raise DeviceError(self.where, wanted="a device that answers", found="no answer", do=do)
        except BaseException:
            self.close()
            raise
        return self

    def pressing(self) -> Any:
        """The actuator that a run commands: itself."""
        return self

    def serial_number(self) -> str:
        """It tells none."""
        return ""

    def ask_active(self) -> bool:
        """Its question changes nothing."""
        return self.is_active()

    def move_motors(self, motors_deg: Sequence[float]) -> None:
        """To a position, at the full preset."""
        self.command(motors_deg[0], 1.0)

    def creep(self, motors_deg: Sequence[float]) -> None:
        """DeviceError: it keeps no speed by itself."""
        raise DeviceError(
            self.where,
            wanted="a device that keeps a speed by itself",
            found="one that does not",
            do="Send it positions.",
        )

    def parameters(self) -> Mapping[int, Parameter]:
        """It lists none."""
        return {}

    def set_parameter(self, number: int, values: tuple[float, ...]) -> Parameter:
        """DeviceError: it keeps none."""
        do = "Set it with the program of its maker."
        raise DeviceError(self.where, wanted="a device whose parameters can be set", found="none", do=do)

    def set_zeros(self) -> Measurements:
        """DeviceError: it keeps none."""
        do = "Set home_deg of the rig file."
        raise DeviceError(self.where, wanted="a device that keeps its zero", found="one that does not", do=do)
