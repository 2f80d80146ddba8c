"""``emg2vsa sample``: small data for the commands and snippets of the documentation."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import Commands, add_command, add_json, print_json

NAMES = ("recordings", "plate", "slopes", "presses", "study")


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "sample",
        run,
        "Write small simulated data, on which the commands and snippets of the documentation run.",
        "recordings: EMG and force of two people on two specimens; plate: plate indentation logs; slopes: a table for "
        "emg2vsa stats; presses: two tactile presses for casr score; study: a study file with its recordings. "
        "The same name gives the same bytes. Example: emg2vsa sample study",
    )
    parser.add_argument("name", choices=NAMES, metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder to write to (default: NAME)")
    parser.add_argument("--overwrite", action="store_true", help="replace files of the same names")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.sample_data import SAMPLES, write_sample

    folder = arguments.out or Path(arguments.name)
    made = write_sample(arguments.name, folder, overwrite=arguments.overwrite)
    if arguments.json:
        print_json({"sample": arguments.name, "folder": str(folder), "files": [str(path) for path in made]})
        return 0
    print(f"{folder}: {SAMPLES[arguments.name][0]}")
    for path in made:
        print(f"  {path}")
    return 0
