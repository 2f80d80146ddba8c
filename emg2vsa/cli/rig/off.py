"""``emg2vsa rig off``: motors off, whatever state the rig is in."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command

if TYPE_CHECKING:
    from emg2vsa.rig.device_settings import ActuatorSettings, MotorSettings


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "off",
        run,
        "Switch the motors off in any state, and end the program that is using the rig.",
        "A run is asked to stop, which takes the probe away. A program that is silent for 1 s is ended, by the process "
        "id in the rig's lock. Then the motors are switched off and asked. The probe stays where it is: emg2vsa rig "
        "home takes it away. It replaces no emergency stop. Exit status 0: motors off; 1: not confirmed, switch the "
        "power off.",
    )
    parser.add_argument("rig", type=Path, nargs="?", metavar="RIG", help="rig file")
    parser.add_argument("--port", metavar="PORT", help="serial port to use when there is no usable rig file")
    parser.add_argument("--id", type=int, default=1, metavar="N", help="device id with --port (default 1)")


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.rig.rig_lock import end_user, stop_unnamed_run
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.device_settings import ActuatorSettings
    from emg2vsa.rig_file import load_rig

    if bool(arguments.rig) == bool(arguments.port):
        do = "Name one of them."
        raise SettingError("rig off", wanted="a rig file or --port", found="both or neither", do=do)
    if arguments.port:
        return int(not _off("device", ActuatorSettings(port=arguments.port, id=arguments.id)))
    # the lock needs no more of the rig file than its name: a file with problems must not keep a run going
    say = partial(print, file=sys.stderr, flush=True)
    end_user(arguments.rig, say)
    file = load_rig(arguments.rig)
    stop_unnamed_run(file.runs, say)
    boards = {"actuator": file.devices.actuator, "motor": file.devices.motor}
    good = [_off(name, board) for name, board in boards.items() if board]
    return int(not all(good))


def _off(name: str, settings: ActuatorSettings | MotorSettings) -> bool:
    from emg2vsa.errors import DeviceError
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.open_rig import open_board

    try:
        with open_board(settings, (0.0, 100.0), WallClock()) as board:
            board.deactivate()
            at = board.measurements()
    except DeviceError as error:
        print(f"[{name}] NOT confirmed off: {error}")
        return False
    print(f"[{name}] motors off; motors at {at.motor_1} and {at.motor_2} ticks, shaft at {at.shaft}")
    return True
