"""``emg2vsa rig next``: which press of an unknown specimen would narrow its stiffness most."""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.rig.kappa_options import width

if TYPE_CHECKING:
    from emg2vsa.calibration.next_press import Choice, Done
    from emg2vsa.calibration.online import OnlineCalibration

_SHOWN = 10
_KAPPA_FILE = "kappa.csv"
"In the folder of a run whose presses were judged: a row for each frame."


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "next",
        run,
        "List the presses that would narrow the stiffness of an unknown specimen most.",
        "The command weighs calibrations (stiffness preset and angle), numbers of presses and new mountings by the "
        "information that they are expected to give. Exit status 0: a further press is worthwhile; 1: the width is "
        "reached, or no press would narrow the interval by a tenth; 2: unusable input.",
    )
    parser.add_argument(
        "calibration",
        type=Path,
        nargs="+",
        metavar="CALIBRATION",
        help="calibration files of emg2vsa run, for example reports/palpation/calibrations/modular_0.json",
    )
    parser.add_argument(
        "--done",
        type=Path,
        action="append",
        default=[],
        metavar="RUN",
        help="folder of a run that judged presses of this specimen (rig run --calibration); one folder is one "
        "mounting; may be repeated",
    )
    parser.add_argument(
        "--presses",
        type=_presses,
        action="append",
        default=[],
        metavar="N",
        help="number of presses to weigh; may be repeated (default 1, 2, 3, 5 and 10)",
    )
    parser.add_argument(
        "--stop-at",
        type=width,
        default=0.0,
        metavar="PERCENT",
        help="half width of the interval, as a percentage of kappa, at which no further press is needed",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.calibration.next_press import COUNTS, belief, next_press, options
    from emg2vsa.calibration_file import open_calibration

    calibrations = [open_calibration(path) for path in arguments.calibration]
    done = _done(arguments.done, calibrations, arguments.calibration)
    listed = options(calibrations, done, tuple(sorted(set(arguments.presses))) or COUNTS)
    chosen = next_press(calibrations, done, arguments.stop_at)
    names = [path.name for path in arguments.calibration]
    believed = belief(calibrations, done)
    low, high = believed.interval(calibrations[0].settings.confidence)
    if arguments.json:
        print_json(
            {
                "belief": {"kappa_n_per_mm": believed.middle, "low_n_per_mm": low, "high_n_per_mm": high},
                "next": _document(chosen, names) if chosen else None,
                "options": [_document(choice, names) for choice in listed],
            }
        )
        return int(chosen is None)
    print(f"kappa so far: {believed.middle:.3g} N/mm, from {low:.3g} to {high:.3g}")
    print(f"{'calibration':<28}{'presses':>8}{'mounting':>10}{'half width after':>18}{'information, bits':>19}")
    for choice in listed[:_SHOWN]:
        print(
            f"{names[choice.calibration]:<28}{choice.presses:>8}{'new' if choice.remount else 'same':>10}"
            f"{f'{choice.half_width:.1%}':>18}{choice.bits:>19.2f}"
        )
    if chosen is None:
        print("No further press is needed: the width is reached, or no press would narrow it by a tenth.")
    else:
        again = "Mount the specimen anew and press" if chosen.remount else "Press"
        print(f"Next: {again} by {names[chosen.calibration]}. It gives the most information for each press.")
    return int(chosen is None)


def _document(choice: Choice, names: Sequence[str]) -> dict[str, Any]:
    return asdict(choice) | {"calibration": names[choice.calibration]}


def _presses(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 100:
        raise argparse.ArgumentTypeError(f"expected a number of presses from 1 to 100, but found {text!r}")
    return int(text)


def _done(folders: Sequence[Path], calibrations: Sequence[OnlineCalibration], paths: Sequence[Path]) -> dict[int, Done]:
    """Presses so far, by calibration. DataError where a run fits none, was not judged, or would count twice."""
    from emg2vsa.calibration.next_press import Done
    from emg2vsa.errors import DataError
    from emg2vsa.rig.record.new_folder import PLAN_FILE

    places = [(each.angle_deg, each.condition) for each in calibrations]
    for i, (angle_deg, condition) in enumerate(places):
        if (angle_deg, condition) in places[:i]:
            found_there = f"{paths[places.index(places[i])]} too is of {angle_deg:g}°, {condition}"
            do = "Give one of the two."
            raise DataError(paths[i], wanted="one calibration for each angle and condition", found=found_there, do=do)
    found: dict[int, Done] = {}
    pressed: dict[str, Path] = {}
    seen: set[Path] = set()
    for folder in folders:
        if folder.resolve() in seen:
            raise DataError(folder, wanted="every run once", found="it twice", do="Name it once with --done.")
        seen.add(folder.resolve())
        plan, rows = _plan(folder / PLAN_FILE), last_estimates(folder / _KAPPA_FILE)
        place = plan["angle_deg"], plan["condition"]
        if place not in places:
            there = ", ".join(path.name for path in paths)
            do = "Give the calibration of this angle and condition too."
            raise DataError(
                folder, wanted=f"one of the calibrations {there}", found=f"{place[0]:g}°, {place[1]}", do=do
            )
        pressed.setdefault(plan["specimen"], folder)
        if len(pressed) > 1:
            (one, first), (other, _) = pressed.items()
            do = "Name runs of one specimen only."
            raise DataError(folder, wanted=f"a run of {one}, as {first.name} is", found=f"one of {other}", do=do)
        if not rows:
            do = "Press with rig run --calibration."
            raise DataError(folder / _KAPPA_FILE, wanted="presses that were judged", found="none", do=do)
        index = places.index(place)
        check_judged_by(folder, calibrations[index], paths[index].name)
        found[index] = with_run(found.get(index, Done()), rows, len(rows), new_mounting=True)
    return found


def check_judged_by(folder: Path, calibration: OnlineCalibration, name: str) -> None:
    """DataError where kappa.json names another calibration than the file ``name``; earlier versions do not tell."""
    from emg2vsa.calibration_file import sha256_of
    from emg2vsa.errors import DataError
    from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE

    about = folder / KAPPA_ABOUT_FILE
    try:
        told = json.loads(about.read_text(encoding="utf-8")).get("sha256")
    except FileNotFoundError:
        return
    except (OSError, ValueError, AttributeError) as error:
        do = "Name the folder of a run that rig run made."
        raise DataError(about, wanted="by which calibration presses were judged", found=_why(error), do=do) from error
    if told is not None and told != (own := sha256_of(calibration)):
        do = "Give the calibration that the run was judged by, or press again."
        raise DataError(f"{about}, sha256", wanted=f"that of {name}, {own[:12]}", found=str(told)[:12], do=do)


def with_run(before: Done, rows: Sequence[tuple[float, float, str]], presses: int, *, new_mounting: bool) -> Done:
    """What a further run adds: its presses, and the estimate of its last row where that is the narrower one.

    rows : as ``last_estimates`` has them.
    """
    kappa, low, cues = before.kappa, before.low, before.cues
    if rows and not (before.low > 0 and before.low / before.kappa > rows[-1][1] / rows[-1][0]):
        kappa, low, cues = rows[-1]
    return replace(
        before, presses=before.presses + presses, mountings=before.mountings + new_mounting, kappa=kappa, low=low,
        cues=cues,
    )  # fmt: skip


def last_estimates(path: Path) -> list[tuple[float, float, str]]:
    """kappa, the lower end of its interval and the cues of the last row of each press that tells them."""
    last: dict[str, tuple[float, float, str]] = {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                if row["kappa_n_per_mm"] and row["low_n_per_mm"]:
                    told = float(row["kappa_n_per_mm"]), float(row["low_n_per_mm"]), row["cues"]
                    last[row["repetition"]] = told
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return list(last.values())


def _why(error: Exception) -> str:
    """Without the path, which the message names already."""
    return str((isinstance(error, OSError) and error.strerror) or error)


def _plan(path: Path) -> dict[str, Any]:
    from emg2vsa.errors import DataError

    try:
        plan = json.loads(path.read_text(encoding="utf-8"))["plan"]
        return {
            "specimen": str(plan["specimen"]),
            "angle_deg": float(plan["angle_deg"]),
            "condition": str(plan["condition"]),
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        do = "Name the folder of a run that rig run made."
        raise DataError(path, wanted="the plan of a run", found=_why(error), do=do) from error
