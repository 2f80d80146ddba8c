"""Driver of the rigid motor, the paper's high-stiffness condition: motor 1 of a board that speaks as a qbmove does."""

from __future__ import annotations

import math
from types import TracebackType
from typing import Self

from emg2vsa.actuator import TICKS_PER_TURN
from emg2vsa.errors import DeviceError
from emg2vsa.rig.qbmove import Qbmove


class RigidMotor:
    """The probe's position through the rig's gear. As a context manager it switches the motor off at the end.

    Parameters
    ----------
    board : the board, with watchdog, limits and read-back of every qbmove.
    mm_per_degree : way of the probe per turn of the motor, from the rig file; negative when it turns the other way.
    travel_mm : (highest, lowest) position of the probe, down is positive; DeviceError beyond them.
    """

    def __init__(self, board: Qbmove, *, mm_per_degree: float, travel_mm: tuple[float, float]) -> None:
        self._board, self._travel_mm = board, travel_mm
        self.where = f"{board.where}, rigid motor"
        if not (math.isfinite(mm_per_degree) and mm_per_degree):
            do = "Measure the rig's gear."
            raise DeviceError(self.where, wanted="mm per degree other than 0", found=repr(mm_per_degree), do=do)
        self._mm_per_tick = mm_per_degree * 360 / TICKS_PER_TURN

    def __enter__(self) -> Self:
        self._board.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._board.__exit__(kind, error, trace)

    def activate(self) -> None:
        """Watchdog and motor on, read back; the motor stays where it is. DeviceError when the board refuses."""
        self._board.activate()

    def deactivate(self) -> None:
        """Motor off, read back. DeviceError when the board does not confirm."""
        self._board.deactivate()

    def go_to(self, position_mm: float) -> None:
        """Send the probe there, to the nearest tick. DeviceError outside the travel or the board's own limits."""
        highest, lowest = self._travel_mm
        if not highest <= position_mm <= lowest:
            do = "Correct the schedule, or the travel it was made for."
            raise DeviceError(
                self.where, wanted=f"a position of {highest:g} to {lowest:g} mm", found=f"{position_mm:g} mm", do=do
            )
        self._board.set_inputs(round(position_mm / self._mm_per_tick), 0)

    def position_mm(self) -> float:
        """Where the encoder has the probe, in steps of its 12 bits."""
        return self._board.measurements().motor_1 * self._mm_per_tick
