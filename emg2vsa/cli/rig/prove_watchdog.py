"""``emg2vsa rig prove-watchdog``: do the motors of this very device go off when the program is silent?"""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from emg2vsa.cli.rig.choice import add_hand_command, finish, person_of


def add_to(commands: Commands) -> None:
    add_hand_command(
        commands,
        "prove-watchdog",
        run,
        "Try whether the motors go off when the program is silent for longer than watchdog_s, and keep the proof.",
        "It moves the free probe 2.5 degrees away from the specimen and back, is silent, and commands the same "
        "move again: motors that follow are on, whatever the device says. The proof is kept beside the rig file; "
        "emg2vsa rig run says so when there is none for the device at hand. Exit status 0: the motors go off; 1: they "
        "do not; 2: nothing was proven.",
        asks=True,
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import proven_watchdog
    from emg2vsa.rig_file import load_rig

    proof = proven_watchdog(load_rig(arguments.rig), motor=arguments.motor, person=person_of(arguments))
    return 1 if proof is None else finish(arguments, proof, good=proof.verdict == "motors off")
