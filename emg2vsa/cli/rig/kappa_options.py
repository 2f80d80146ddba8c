"""Options of rig run that judge a press while it goes on: the calibrations, and the width at which a press may stop."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Group

if TYPE_CHECKING:
    from emg2vsa.lab.judging import Judging

_WIDTHS = (0.5, 100.0)


def add_kappa(parser: Group) -> None:
    """Kappa while the finger presses."""
    add, beside = parser.add_argument, "with --calibration"
    judge = "judge the stiffness of the specimen while it is pressed, by this calibration of emg2vsa run"
    rows = "repeat it for other angles and conditions. kappa.csv in the folder of the run has a row for each frame"
    add("--calibration", type=Path, action="append", default=[], metavar="FILE", help=f"{judge}; {rows}")
    stop = (
        "end the loading of a press when the 95 %% interval of kappa reaches no more than this share of kappa to "
        "either side, or when the rest of the press would narrow it by less than a tenth. Such a press counts as done, "
        "and is marked as stopped"
    )
    add("--stop-at", type=width, metavar="PERCENT", help=f"{beside}: {stop}")
    adaptive = (
        "choose stiffness preset, angle and number of presses of each next run as emg2vsa rig next does, until "
        "--stop-at is reached or no press would narrow the interval by a tenth. Judged presses of the specimen in the "
        "folder of the runs count along. The command asks where an angle or a mounting must be changed by hand"
    )
    add("--adaptive", action="store_true", help=f"{beside} and one --specimen: {adaptive}")
    camera = "camera.toml of the tactile camera (default: camera.toml beside the rig file; an emulated rig has its own)"
    add("--camera", type=Path, metavar="FILE", help=f"{beside}: {camera}")


def width(text: str) -> float:
    """``5`` or ``5%`` as 0.05."""
    try:
        percent = float(text.removesuffix("%").strip())
    except ValueError:
        percent = float("nan")
    low, high = _WIDTHS
    if not low <= percent <= high:
        raise argparse.ArgumentTypeError(
            f"expected a percentage of kappa from {low:g} to {high:g}, such as 5, but found {text!r}"
        )
    return percent / 100


def judging_of(arguments: argparse.Namespace) -> Judging:
    """How presses are to be judged."""
    from emg2vsa.lab.judging import Judging

    return Judging(tuple(arguments.calibration), arguments.stop_at, arguments.camera)
