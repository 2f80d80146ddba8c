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
"""Of the gearbox's output at full PWM: a guess. The paper names the motor (Maxon DCX8, GPX8 35:1, 12 V) without it."""
MOTOR_BOARD = replace(MAKER_PRO, supply_mv=12000, motor_speed_rad_per_s=MOTOR_SPEED_RAD_PER_S)


def motor_board(world: World, clock: Clock, home_ticks: int = 0) -> QbmoveFirmware:
    """The board, of id 1, turning a world whose ``springs`` are None; at the start its motor reads ``home_ticks``."""
    return QbmoveFirmware(MOTOR_BOARD, world, clock, memory=MOTOR_BOARD.factory((home_ticks, 0, home_ticks)))
