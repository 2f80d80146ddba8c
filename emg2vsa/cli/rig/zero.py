"""``emg2vsa rig zero``: the actuator is at zero where it stands."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from casr.command_line import Commands
from emg2vsa.cli.rig.choice import add_hand_command, finish, person_of


def add_to(commands: Commands) -> None:
    add_hand_command(
        commands,
        "zero",
        run,
        "Make the present place of the actuator its zero, and store it in the device.",
        "A qbmove takes it by SET_ZEROS, a Dynamixel as its Homing Offset. The motors must be off, the shaft at rest "
        "without load. home_deg of the rig file counts from this zero: check it then with emg2vsa rig commission. "
        "Exit status 0: the encoders read zero; 1: not asked for.",
        asks=True,
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import zero
    from emg2vsa.lab.device_states import angles
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    done = zero(file, motor=arguments.motor, person=person_of(arguments))
    if done is None:
        return 1
    at, home_deg = f"now {angles(done.after)}, stored", file.rig.home_deg
    check = f"home_deg = {home_deg:g} of {file.path} counts from the new zero: check it"
    return finish(arguments, asdict(done) | {"home_deg": home_deg}, at, check)
