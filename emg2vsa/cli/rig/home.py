"""``emg2vsa rig home``: the probe slowly to its retracted position."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_json, print_json
from emg2vsa.cli.rig.hand import add_hand_command, hand_rig

_RISE_N = 0.5


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "home",
        run,
        "Move the probe slowly to its retracted position, home_ticks; also one that stands pressed.",
        "The move ends where the force is 0.5 N above that at the start. The motors are off afterwards. Exit status 0: "
        "at home and free; 1: a force ended the move, or remains; 2: nothing has moved, or a device is lost.",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.rig.commissioning.hand_motion import TOUCH_N
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    with hand_rig(arguments, file) as ready:
        ready.hand.start()
        place = ready.hand.go(file.rig.home_ticks, until_n=_RISE_N, from_zero=False)
        force_n = ready.opened.devices.force.read().force_n
    remains = float(abs(force_n).max()) > TOUCH_N
    depth_mm = file.rig.depth_at(place.shaft_ticks)
    if arguments.json:
        print_json(
            {
                "shaft_ticks": place.shaft_ticks,
                "from_home_mm": depth_mm,
                "force_n": list(map(float, force_n)),
                "touched": place.touched,
                "force_remains": remains,
            }
        )
        return int(place.touched or remains)
    print(f"shaft at {place.shaft_ticks} ticks, {depth_mm:.2f} mm from home; motors off")
    print("force {:.2f}, {:.2f}, {:.2f} N".format(*force_n))
    if place.touched:
        print("the force rose on the way: is home_ticks right? emg2vsa rig commission checks it")
    elif remains:
        print("a force remains: tare the sensor if the probe is free, else check home_ticks")
    return int(place.touched or remains)
