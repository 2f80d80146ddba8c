"""``emg2vsa rig dry-run``: may the rig do it, and what would it do? Nothing is sent."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import add_choice, add_rig, finish, runs_chosen

if TYPE_CHECKING:
    from emg2vsa.rig.executor.dry_run import DryRun

_COLUMNS = "position, deg", "preset, %", "force, N"
_HEAD = f"{'run':<26}{'presses':>8}" + "".join(map("{:>16}".format, _COLUMNS)) + f"{'largest, N':>12}{'at most, s':>12}"


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
    every = "list every part of a press: ramps, rests and force steps"
    parser.add_argument("--details", action="store_true", help=every)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.dry_runs import dry_run, limits
    from emg2vsa.rig.executor.guards import laxer_guards
    from emg2vsa.rig_file import load_rig
    from emg2vsa.rig_file.sequence import ordered

    file = load_rig(arguments.rig)
    order, bounds = ordered(file.experiment), limits(file)
    told = {run.name: found for run, found in dry_run(file, runs_chosen(arguments, file)).items()}
    good = {name: found for name, found in told.items() if not isinstance(found, str)}
    runs = {name: asdict(good[name]) if name in good else {"problem": found} for name, found in told.items()}
    lines = [f"{name}: {value}" for name, value in bounds.items()]
    lines += [f"order of the runs: {order}", *laxer_guards(file.rig), "" if arguments.details else f"\n{_HEAD}"]
    text = _table if arguments.details else _row
    lines += [text(name, good[name]) if name in good else f"{name}: not possible. {why}" for name, why in told.items()]
    minutes = sum(each.at_most_s for each in good.values()) / 60
    lines.append(f"\n{len(told)} runs, at most {minutes:.1f} min; nothing was sent")
    result = {"limits": bounds, "runs": runs, "order": order.order, "seed": order.seed, "sequence": list(told)}
    return finish(arguments, result, *lines, good=len(good) == len(told))


def _row(name: str, found: DryRun) -> str:
    presets = [100 * leg.preset for leg in found.legs]
    angles = [angle_deg for leg in found.legs for angle_deg in leg.position_deg]
    low_n, high_n = found.legs[0].force_n or (0.0, 0.0)
    high_n = max([high_n, *(leg.force_n[1] for leg in found.legs if leg.force_n)])
    ranges = (min(angles), max(angles)), (min(presets), max(presets)), (low_n, high_n)
    columns = [f"{low:.4g} to {high:.4g}" for low, high in ranges]
    ends = f"{_largest(found):>12}{found.at_most_s:>12.1f}"
    return f"{name:<26}{found.repetitions:>8}" + "".join(f"{column:>16}" for column in columns) + ends


def _largest(found: DryRun) -> str:
    return "unknown" if (force_n := found.largest_force_n) is None else f"{force_n:.1f}"


def _table(name: str, found: DryRun) -> str:
    lines = [f"{name}: {found.repetitions} presses, at most {found.at_most_s:.1f} s"]
    lines.append(f"  {'phase':<10}{'position, deg':>18}{'preset, %':>15}{'force, N':>15}{'at most, s':>12}")
    for leg in found.legs:
        position, force = "{:.4g} to {:.4g}".format(*leg.position_deg), "{:g} to {:g}".format(*leg.force_n or (0, 0))
        ends = f"{force if leg.force_n else '':>15}{leg.at_most_s:>12.2f}"
        lines.append(f"  {leg.phase:<10}{position:>18}{100 * leg.preset:>15.4g}{ends}")
    past = f"at most {found.past_contact_mm:.1f} mm past contact"
    return "\n".join([*lines, f"  largest force to expect: {_largest(found)} N; {past}", ""])
