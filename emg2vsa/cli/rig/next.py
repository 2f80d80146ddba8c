"""``emg2vsa rig next``: which press of an unknown specimen would narrow its stiffness most."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from functools import partial
from pathlib import Path

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import finish
from emg2vsa.cli.rig.kappa_options import width

_SHOWN = 10


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
    of_run = "calibration files of emg2vsa run, for example reports/palpation/calibrations/modular_0.json"
    parser.add_argument("calibration", type=Path, nargs="+", metavar="CALIBRATION", help=of_run)
    add = partial(parser.add_argument, action="append", default=[])
    judged = "folder of a run that judged presses of this specimen (rig run --calibration); one folder is one mounting"
    add("--done", type=Path, metavar="RUN", help=f"{judged}; may be repeated")
    weighed = "number of presses to weigh; may be repeated (default 1, 2, 3, 5 and 10)"
    add("--presses", type=_presses, metavar="N", help=weighed)
    reached = "half width of the interval, as a percentage of kappa, at which no further press is needed"
    parser.add_argument("--stop-at", type=width, default=0.0, metavar="PERCENT", help=reached)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.next_press import next_presses

    found = next_presses(arguments.calibration, arguments.done, arguments.presses, arguments.stop_at)
    names, chosen = found.calibrations, found.chosen
    documents = [asdict(each) | {"calibration": names[each.calibration]} for each in found.options]
    named = asdict(chosen) | {"calibration": names[chosen.calibration]} if chosen else None
    lines = [f"kappa so far: {found.belief}"]
    lines.append(f"{'calibration':<28}{'presses':>8}{'mounting':>10}{'half width after':>18}{'information, bits':>19}")
    for choice in found.options[:_SHOWN]:
        mounting, width_after = "new" if choice.remount else "same", f"{choice.half_width:.1%}"
        name = names[choice.calibration]
        lines.append(f"{name:<28}{choice.presses:>8}{mounting:>10}{width_after:>18}{choice.bits:>19.2f}")
    if chosen is None:
        lines.append("No further press is needed: the width is reached, or no press would narrow it by a tenth.")
    else:
        again = "Mount the specimen anew and press" if chosen.remount else "Press"
        by = names[chosen.calibration]
        lines.append(f"Next: {again} by {by}. It gives the most information for each press.")
    result = {"belief": asdict(found.belief), "next": named, "options": documents}
    return finish(arguments, result, *lines, good=chosen is not None)


def _presses(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 100:
        raise argparse.ArgumentTypeError(f"expected a number of presses from 1 to 100, but found {text!r}")
    return int(text)
