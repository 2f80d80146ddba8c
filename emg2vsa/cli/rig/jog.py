"""``emg2vsa rig jog``: a slow move of the probe by hand."""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from emg2vsa.cli.rig.hand import add_hand_command, hand_rig


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
    way.add_argument("--deg", type=float, help="angle of the shaft in degrees, positive towards more ticks")
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
    from emg2vsa.rig.commissioning.hand_motion import FASTEST_DEG_PER_S, LIMIT_SHARE, TICKS_PER_DEGREE
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    _check("--deg-per-s", arguments.deg_per_s, FASTEST_DEG_PER_S)
    _check("--limit-n", arguments.limit_n, LIMIT_SHARE * file.rig.guards.force_n)
    rig = file.rig
    degrees = arguments.deg if arguments.mm is None else rig.push_sign * arguments.mm / rig.gear_mm_per_degree
    with hand_rig(arguments, file) as ready:
        start = ready.hand.start()
        begin = ready.hand.at_ticks
        target = begin + degrees * TICKS_PER_DEGREE
        place = ready.hand.go(target, until_n=arguments.limit_n, deg_per_s=arguments.deg_per_s)
        touched = place.touched
        if touched:
            print(f"{place.size_n:.2f} N at {place.shaft_ticks} ticks ended the move; back until the probe is free")
            place = ready.hand.away(begin)
    moved = place.shaft_ticks - start.shaft_ticks
    way_mm = moved / TICKS_PER_DEGREE * rig.gear_mm_per_degree * rig.push_sign
    print(
        f"shaft from {start.shaft_ticks} to {place.shaft_ticks} ticks: {moved / TICKS_PER_DEGREE:.2f} degrees,", end=" "
    )
    print(f"{way_mm:.2f} mm towards the specimen by the gear of the rig file")
    print("force {:.2f}, {:.2f}, {:.2f} N above that at the start; motors off".format(*place.force_n))
    return int(touched)


def _check(name: str, value: float, most: float) -> None:
    from emg2vsa.errors import SettingError

    if not 0 < value <= most:
        raise SettingError(
            name, wanted=f"above 0 and at most {most:g}", found=f"{value:g}", do="Choose a value in this range."
        )
