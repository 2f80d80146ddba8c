"""``emg2vsa rig off``: motors off, whatever state the rig is in."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import finish, person_of


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
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.devices.qbmove.settings import QbmoveSettings
    from emg2vsa.errors import SettingError
    from emg2vsa.lab.motors_off import board_off, off

    if bool(arguments.rig) == bool(arguments.port):
        do = "Name one of them."
        raise SettingError("rig off", wanted="a rig file or --port", found="both or neither", do=do)
    person = person_of(arguments)
    by_port = QbmoveSettings(port=arguments.port, id=arguments.id)
    boards = (board_off("device", by_port, person),) if arguments.port else off(arguments.rig, person)
    result = {"devices": [asdict(each) for each in boards]}
    return finish(arguments, result, good=not any(each.problem for each in boards))
