"""The rigid motor on the emulated bench: motor 1 of a board that speaks as a qbmove does."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.ticks import to_ticks
from emg2vsa.worlds.bench.far_end import FarEnd, Place
from emg2vsa.worlds.bench.wire_faults import WIRE_FAULTS
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.far_ends.qbmove.far_end import DEVICE_ID, driver
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.frames import QbmoveFrames
from emg2vsa.worlds.far_ends.qbmove.motor_faults import MOTOR_FAULTS
from emg2vsa.worlds.far_ends.qbmove.switches import MAKER_PRO

MOTOR_SPEED_RAD_PER_S = 3.0
"""Of the gearbox's output at full PWM: a guess. The paper names the motor (Maxon DCX8, GPX8 35:1, 12 V) without it."""
MOTOR_TORQUE_NM, MOTOR_CURRENT_MA = 0.3, 1500.0
"""At which the rigid motor stalls, 26 N at the probe with the gear of the emulated rig: guesses. The catalogue's motor
could not press with 7 N through that gear, which is a guess too."""
MOTOR_BOARD = replace(
    MAKER_PRO,
    supply_mv=12000,
    motor_speed_rad_per_s=MOTOR_SPEED_RAD_PER_S,
    stall_torque_nm=MOTOR_TORQUE_NM,
    stall_current_ma=MOTOR_CURRENT_MA,
)


def motor_board(world: World, clock: Clock, home_ticks: int = 0, latency_s: float = 0.0) -> QbmoveFirmware:
    """The board of the rigid motor: a qbrobotics board with one motor and one AS5045 encoder (paper, section V.A).

    Which firmware it runs is not published; it is taken to be the qbmove's, with motor 1 connected and motor 2 not.
    It has id 1, and turns a world whose ``springs`` are None; at the start its motor reads ``home_ticks``."""
    memory = MOTOR_BOARD.factory((home_ticks, 0, home_ticks))
    return QbmoveFirmware(MOTOR_BOARD, world, clock, memory=memory, loads=world.loads_nm, latency_s=latency_s)


def _device(place: Place) -> QbmoveFirmware:
    return motor_board(place.world, place.clock, to_ticks(place.rig.home_deg), place.latency_s)


FAR_END = FarEnd(
    springs=lambda emulated: None,
    device=_device,
    driver=partial(driver, rigid=True),
    table=lambda place: {"id": DEVICE_ID, "generation": "v6"},
    faults=WIRE_FAULTS | MOTOR_FAULTS,
    frames=QbmoveFrames(),
)
