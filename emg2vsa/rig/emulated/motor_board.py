"""The board of the rigid motor: a qbrobotics board with one motor and one AS5045 encoder (paper, section V.A).

Which firmware it runs is not published; it is taken to be the qbmove's, with motor 1 connected and motor 2 not.
"""

from __future__ import annotations

from dataclasses import replace

from emg2vsa.rig.clock import Clock
from emg2vsa.rig.emulated.qbmove_firmware import QbmoveFirmware
from emg2vsa.rig.emulated.qbmove_switches import MAKER_PRO
from emg2vsa.rig.emulated.world import World

MOTOR_SPEED_RAD_PER_S = 3.0
"""Of the gearbox's output at full PWM: a guess; the paper names the motor (Maxon DCX8, GPX8 35:1, 12 V), not its speed."""
MOTOR_BOARD = replace(MAKER_PRO, supply_mv=12000, motor_speed_rad_per_s=MOTOR_SPEED_RAD_PER_S)


class _MotorOne:
    """The world as motor 1 turns it."""

    def __init__(self, world: World) -> None:
        self._world = world

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return self._world.shaft_rad(time_s, (motors_rad[0], motors_rad[0]))


def motor_board(world: World, clock: Clock, *, start_rad: float = 0.0) -> QbmoveFirmware:
    """The board, turning a world without springs, with id 1 and the motor at ``start_rad``."""
    return QbmoveFirmware(MOTOR_BOARD, _MotorOne(world), clock, motors_rad=(start_rad, 0.0))
