"""Arguments of several rig commands: the rig file, and which of its runs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import whole_number

if TYPE_CHECKING:
    from emg2vsa.rig_file import RigFile
    from emg2vsa.rig_file.plans import Run

CONDITIONS = ("high-stiffness", "modular", "constant-min", "constant-mean", "constant-max")


def add_rig(parser: argparse.ArgumentParser) -> None:
    """The rig file."""
    parser.add_argument("rig", type=Path, metavar="RIG", help="rig file, for example studies/palpation/rig.toml")


def add_choice(parser: argparse.ArgumentParser) -> None:
    """Which runs."""
    parser.add_argument(
        "--specimen", action="append", default=[], metavar="NAME", help="only this specimen; may be repeated"
    )
    parser.add_argument(
        "--angle",
        action="append",
        default=[],
        type=float,
        metavar="DEG",
        help="only this angle in degrees; may be repeated",
    )
    parser.add_argument(
        "--condition", action="append", default=[], choices=CONDITIONS, help="only this condition; may be repeated"
    )
    parser.add_argument(
        "--mounting",
        action="append",
        default=[],
        type=whole_number,
        metavar="N",
        help="only this mounting, from 1; may be repeated",
    )


def runs_chosen(arguments: argparse.Namespace, file: RigFile) -> tuple[Run, ...]:
    """The runs asked for, or all."""
    from emg2vsa.rig_file.plans import chosen_runs

    return chosen_runs(file, arguments.specimen, arguments.angle, arguments.condition, arguments.mounting)
