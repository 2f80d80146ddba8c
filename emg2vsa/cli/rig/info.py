"""``emg2vsa rig info``: ask every device of a rig file for what it knows."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import add_rig, finish, person_of


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "info",
        run,
        "Ask each device of a rig file for its firmware, limits, parameters and readings. The motors are not switched.",
        "Exit status 0: all devices can be used; 1: some cannot be used; 2: the rig file has problems, or another "
        "run or command is using the rig and would lose its force sensor and camera.",
    )
    add_rig(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.device_states import info
    from emg2vsa.rig_file import load_rig

    devices = info(load_rig(arguments.rig), person_of(arguments))
    result = {"devices": [asdict(each) for each in devices]}
    return finish(arguments, result, good=all(each.usable for each in devices))
