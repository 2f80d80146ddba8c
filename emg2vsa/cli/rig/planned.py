"""``emg2vsa rig dry-run`` and ``next``: what would be pressed, within which limits, and what should be."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, wanted, whole
from emg2vsa.cli.rig.choice import CHOICE, RIG, add_rig_command, file_of, finish, runs_chosen, width

if TYPE_CHECKING:
    from emg2vsa.rig.executor.plan_limits import DryRun

DRY_RUN = """
Exit status 0: all runs keep the limits; 1: some break a limit; 2: the rig file or the schedules are unusable. The
device also has limits of its own: emg2vsa rig run reads and checks them before anything moves.
"""
_COLUMNS = "position, deg", "preset, %", "force, N"
_HEAD = f"{'run':<26}{'presses':>8}" + "".join(map("{:>16}".format, _COLUMNS)) + f"{'largest, N':>12}{'at most, s':>12}"
NEXT = """
The command weighs calibrations (stiffness preset and angle), numbers of presses and new mountings by the information
that they are expected to give. Exit status 0: a further press is worthwhile; 1: the width is reached, or no press would
narrow the interval by a tenth; 2: unusable input.
"""
NEXT_OPTIONS = f"""
calibration CALIBRATION...  calibration files of emg2vsa run, for example
  reports/palpation/calibrations/modular_0.json
--done RUN...  folder of a run that judged presses of this specimen (rig run --calibration); one folder is one mounting;
  may be repeated
--presses N...  number of presses to weigh; may be repeated (default 1, 2, 3, 5 and 10)
--stop-at PERCENT  half width of the interval, as a percentage of kappa, at which no further press is needed
{JSON}"""
_SHOWN = 10


def add_to(commands: Commands) -> None:
    summary = "Check runs against the limits of the rig file and list what they would send. No device is opened."
    details = "--details  list every part of a press: ramps, rests and force steps\n"
    add_rig_command(commands, "dry-run", dry_run, summary, DRY_RUN, RIG + CHOICE + details + JSON)
    summary = "List the presses that would narrow the stiffness of an unknown specimen most."
    types = {"CALIBRATION": Path, "N": wanted("a number of presses from 1 to 100", whole(1, 100)), "PERCENT": width}
    add_rig_command(commands, "next", next_press, summary, NEXT, NEXT_OPTIONS, types, stop_at={"default": 0.0})


def dry_run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.pressing import dry_run, limits
    from emg2vsa.rig.executor.guards import laxer_guards
    from emg2vsa.rig_file.plans import ordered

    file = file_of(arguments)
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


def next_press(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.adaptive_runs import next_presses

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
