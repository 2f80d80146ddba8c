"""``emg2vsa rig jog``: a slow move of the probe by hand."""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from emg2vsa.cli.rig.choice import add_hand_command, finish, person_of


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "jog",
        run,
        "Move the probe slowly by some millimetres or degrees; a force ends the move.",
        "The move ends where a force of any direction is --limit-n above that at the start; the probe then goes back "
        "until it is free, at most 20 degrees of the shaft. It also goes back, while that does not raise the force, "
        "when force, springs or current pass a limit or a device fails. The motors are off afterwards. Exit status 0: "
        "moved; 1: a force ended it; 2: bad input, nothing has moved; or a guard or a device ended the move: the probe "
        "may still press, emg2vsa rig info tells the force.",
    )
    way = parser.add_mutually_exclusive_group(required=True)
    way.add_argument("--mm", type=float, help="distance towards the specimen in mm; negative values move away")
    way.add_argument("--deg", type=float, help="angle of the shaft in degrees, positive towards larger angles")
    parser.add_argument(
        "--deg-per-s", type=float, default=5.0, metavar="V", help="speed of the shaft (default 5; at most 25)"
    )
    parser.add_argument(
        "--limit-n",
        type=float,
        default=2.0,
        metavar="N",
        help="force that ends the move (default 2; at most half of guards.force_n)",
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import jog
    from emg2vsa.rig_file import load_rig

    names = ("mm", "deg", "deg_per_s", "limit_n", "motor")
    chosen = {name: getattr(arguments, name) for name in names}
    done = jog(load_rig(arguments.rig), **chosen, person=person_of(arguments))
    way = f"{done.moved_deg:.2f} degrees, {done.moved_mm:.2f} mm towards the specimen by the gear of the rig file"
    shaft = f"shaft from {done.from_deg:.2f} to {done.shaft_deg:.2f} degrees: {way}"
    force = "force {:.2f}, {:.2f}, {:.2f} N above that at the start; motors off".format(*done.force_n)
    return finish(arguments, done, shaft, force, good=not done.touched)
