"""``emg2vsa rig info``: ask every device of a rig file for what it knows."""

from __future__ import annotations

import argparse
from functools import partial

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import add_rig


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
    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.cli.rig.states import Telling, board_lines, camera_lines, force_lines
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig_file import load_rig

    file, clock = load_rig(arguments.rig), WallClock()
    devices = file.devices
    titled = {
        f"[{name}] {board.port or 'without a port'}, id {board.id}": partial(board_lines, board, file.rig, clock)
        for name, board in (("actuator", devices.actuator), ("motor", devices.motor))
        if board
    }
    titled["[force]"] = partial(force_lines, devices.force, file.rig.guards, clock)
    if devices.camera:
        titled[f"[camera] {devices.camera.source}"] = partial(camera_lines, devices.camera, file.rig.guards, clock)
    telling = Telling(arguments.json)
    with rig_lock(file.path):
        for title, lines in titled.items():
            telling.say(title, lines)
    return telling.end()
