"""Driver of the rigid motor, the paper's high-stiffness condition: motor 1 of a board that speaks as a qbmove does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from emg2vsa.devices.protocols import LogColumns, Measurements
from emg2vsa.devices.qbmove.ticks import LOG_COLUMNS
from emg2vsa.errors import DeviceError


class MotorBoard(Protocol):
    """What it needs of a board: a `Qbmove`."""

    where: str

    def activate(self) -> None: ...
    def deactivate(self) -> None: ...
    def is_active(self) -> bool: ...
    def move_motors(self, motors_deg: Sequence[float]) -> None: ...
    def measurements(self) -> Measurements: ...
    def currents_a(self) -> tuple[float, float]: ...
    def current_limit_a(self) -> float: ...


class RigidMotor:
    """An actuator without springs.

    Parameters
    ----------
    board : the board, with watchdog, limits and read-back of every qbmove; motor 2 is not connected.
    """

    joint = None
    columns: LogColumns = LOG_COLUMNS

    def __init__(self, board: MotorBoard) -> None:
        self._board = board
        self.where = f"{board.where}, rigid motor"

    def activate(self) -> None:
        """Watchdog and motor on, read back; the motor stays where it is. DeviceError when the board refuses."""
        self._board.activate()

    def deactivate(self) -> None:
        """Motor off, read back. DeviceError when the board does not confirm."""
        self._board.deactivate()

    def is_active(self) -> bool:
        """Motor on? The question also feeds the watchdog."""
        return self._board.is_active()

    def command(self, position_deg: float, preset: float) -> None:
        """Send the motor there. DeviceError outside the board's limits, or for a preset other than 0."""
        if preset != 0:
            do = "Use the qbmove for a schedule of stiffness."
            raise DeviceError(self.where, wanted="preset 0: it has no springs", found=f"{preset:g}", do=do)
        self._board.move_motors((position_deg, 0.0))

    def position_deg(self) -> float:
        """Where motor 1 stands; motor 2, not connected, has no say."""
        return self._board.measurements().motors_deg[0]

    def measurements(self) -> Measurements:
        """Encoders; the shaft is motor 1's."""
        at = self._board.measurements()
        return Measurements(at.motors_deg, at.motors_deg[0])

    def currents_a(self) -> tuple[float, float]:
        """Motor currents."""
        return self._board.currents_a()

    def current_limit_a(self) -> float:
        """Largest current of the motor as the board told at its activation."""
        return self._board.current_limit_a()
