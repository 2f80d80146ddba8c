"""Driver of the rigid motor, the paper's high-stiffness condition: motor 1 of a board that speaks as a qbmove does."""

from __future__ import annotations

from emg2vsa.actuator import Springs
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.errors import DeviceError


class RigidMotor:
    """An actuator without springs.

    Parameters
    ----------
    board : the board, with watchdog, limits and read-back of every qbmove; motor 2 is not connected.
    """

    springs: Springs | None = None

    def __init__(self, board: Qbmove) -> None:
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

    def set_position_stiffness(self, position_ticks: int, preset_ticks: int) -> None:
        """Send the motor there. DeviceError outside the board's limits, or for a preset other than 0."""
        if preset_ticks != 0:
            do = "Use the qbmove for a schedule of stiffness."
            raise DeviceError(self.where, wanted="preset 0: it has no springs", found=f"{preset_ticks} ticks", do=do)
        self._board.set_inputs(position_ticks, 0)

    def position_ticks(self) -> float:
        """Where motor 1 stands, ticks; motor 2, not connected, has no say."""
        return self._board.measurements().motor_1

    def measurements(self) -> Measurements:
        """Encoders in ticks, 8 to a step of the 12 bits; the shaft is motor 1's."""
        at = self._board.measurements()
        return Measurements(at.motor_1, at.motor_2, at.motor_1)

    def currents_ma(self) -> tuple[int, int]:
        """Motor currents, mA."""
        return self._board.currents_ma()

    def current_limit_ma(self) -> float:
        """Largest current of the motor, mA, as the board told at its activation."""
        return self._board.current_limit_ma()
