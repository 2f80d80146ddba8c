"""``emg2vsa rig tare``: the present load is the zero of the force sensor."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import add_rig, finish


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "tare",
        run,
        "Set the zero of the force sensor to the present load. The probe must touch nothing.",
        "A Net F/T box keeps this zero until its power is switched off. A National Instruments card keeps no zero: "
        "set [force] bias = true instead. Exit status 0: the force is zero; 1: the force is not zero, and "
        "the command prints it.",
    )
    add_rig(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import tare
    from emg2vsa.rig_file import load_rig

    found = tare(load_rig(arguments.rig))
    before = "before: {:.3f}, {:.3f}, {:.3f} N".format(*found.before_n)
    return finish(arguments, found, before, "now: {:.3f}, {:.3f}, {:.3f} N".format(*found.force_n), good=found.good)
