"""``emg2vsa rig dry-run``: may the rig do it, and what would it do? Nothing is sent."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.rig.choice import add_choice, add_rig, runs_chosen

if TYPE_CHECKING:
    from emg2vsa.rig.executor.dry_run import DryRun, Leg


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "dry-run",
        run,
        "Check runs against the limits of the rig file and list what they would send. No device is opened.",
        "Exit status 0: all runs keep the limits; 1: some break a limit; 2: the rig file or the schedules are "
        "unusable. The device also has limits of its own: emg2vsa rig run reads and checks them before "
        "anything moves.",
    )
    add_rig(parser)
    add_choice(parser)
    parser.add_argument(
        "--details", action="store_true", help="list every part of a press: ramps, rests and force steps"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.dry_runs import dry_run, limits
    from emg2vsa.rig.executor.guards import laxer_guards
    from emg2vsa.rig_file import load_rig
    from emg2vsa.rig_file.sequence import ordered

    file = load_rig(arguments.rig)
    order = ordered(file.experiment)
    told = {run.name: found for run, found in dry_run(file, runs_chosen(arguments, file)).items()}
    good = {name: found for name, found in told.items() if not isinstance(found, str)}
    if arguments.json:
        runs = {name: asdict(good[name]) if name in good else {"problem": found} for name, found in told.items()}
        sequence = {"order": order.order, "seed": order.seed, "sequence": list(told)}
        print_json({"limits": limits(file), "runs": runs} | sequence)
        return int(len(good) < len(told))
    lines = [f"{name}: {value}" for name, value in limits(file).items()]
    lines += [f"order of the runs: {order}", *laxer_guards(file.rig), "", *([] if arguments.details else [_row()])]
    for name, found in told.items():
        text = _table if arguments.details else _row
        lines.append(text(name, good[name]) if name in good else f"{name}: not possible. {found}")
    seconds = sum(found.at_most_s for found in good.values())
    print("\n".join(lines), f"\n\n{len(told)} runs, at most {seconds / 60:.1f} min; nothing was sent", sep="")
    return int(len(good) < len(told))


def _row(name: str = "", found: DryRun | None = None) -> str:
    columns = ["position, ticks", "preset, ticks", "force, N"]
    first, presses, largest, at_most = "run", "presses", "largest, N", "at most, s"
    if found:
        presets, ticks = [leg.preset_ticks for leg in found.legs], [t for leg in found.legs for t in leg.position_ticks]
        forces = [(0.0, 0.0) if leg.force_n is None else leg.force_n for leg in found.legs]
        ends = (min(ticks), max(ticks)), (min(presets), max(presets)), (forces[0][0], max(high for _, high in forces))
        columns = ["{:g} to {:g}".format(*both) for both in ends[2:]]
        columns = [f"{low} to {high}" for low, high in ends[:2]] + columns
        first, presses, largest, at_most = name, str(found.repetitions), _largest(found), f"{found.at_most_s:.1f}"
    return f"{first:<26}{presses:>8}" + "".join(f"{each:>16}" for each in columns) + f"{largest:>12}{at_most:>12}"


def _largest(found: DryRun) -> str:
    """Unknown where the stiffness of the specimen is."""
    return "unknown" if found.largest_force_n is None else f"{found.largest_force_n:.1f}"


def _table(name: str, found: DryRun) -> str:
    head = f"{name}: {found.repetitions} presses, at most {found.at_most_s:.1f} s"
    columns = f"  {'phase':<10}{'position, ticks':>18}{'preset, ticks':>15}{'force, N':>15}{'at most, s':>12}"
    force = f"  largest force to expect: {_largest(found)} N; at most {found.past_contact_mm:.1f} mm past contact"
    return "\n".join([head, columns, *map(_line, found.legs), force, ""])


def _line(leg: Leg) -> str:
    position = "{} to {}".format(*leg.position_ticks)
    force = "" if leg.force_n is None else "{:g} to {:g}".format(*leg.force_n)
    return f"  {leg.phase:<10}{position:>18}{leg.preset_ticks:>15}{force:>15}{leg.at_most_s:>12.2f}"
