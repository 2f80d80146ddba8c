"""``emg2vsa rig home``: the probe slowly to its retracted position."""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from emg2vsa.cli.rig.choice import add_hand_command, finish


def add_to(commands: Commands) -> None:
    add_hand_command(
        commands,
        "home",
        run,
        "Move the probe slowly to its retracted position, home_deg; also one that stands pressed.",
        "The move ends where the force is 0.5 N above that at the start. The motors are off afterwards. Exit status 0: "
        "at home and free; 1: a force ended the move, or remains; 2: nothing has moved, or a device is lost.",
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import home
    from emg2vsa.rig_file import load_rig

    at = home(load_rig(arguments.rig), motor=arguments.motor)
    remark = []
    if at.touched:
        remark = ["the force rose on the way: is home_deg right? emg2vsa rig commission checks it"]
    elif at.force_remains:
        remark = ["a force remains: tare the sensor if the probe is free, else check home_deg"]
    where = f"shaft at {at.shaft_deg:.2f} degrees, {at.from_home_mm:.2f} mm from home; motors off"
    return finish(arguments, at, where, "force {:.2f}, {:.2f}, {:.2f} N".format(*at.force_n), *remark, good=not remark)
