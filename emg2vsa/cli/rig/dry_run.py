"""``emg2vsa rig dry-run``: may the rig do it, and what would it do? Nothing is sent."""

from __future__ import annotations

import argparse
import dataclasses
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.rig.choice import add_choice, add_rig, runs_chosen

if TYPE_CHECKING:
    from emg2vsa.rig.executor.dry_run import DryRun, Leg
    from emg2vsa.rig.plan import RunPlan
    from emg2vsa.rig.rig_settings import RigSettings


_HEAD = (
    f"{'run':<26}{'presses':>8}{'position, ticks':>16}{'preset, ticks':>16}{'force, N':>16}{'largest, N':>12}"
    f"{'at most, s':>12}"
)


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
    from emg2vsa.rig.executor.guards import laxer_guards
    from emg2vsa.rig_file import load_rig
    from emg2vsa.rig_file.plans import plans_of
    from emg2vsa.rig_file.sequence import ordered

    file = load_rig(arguments.rig)
    order, runs = ordered(file.experiment), runs_chosen(arguments, file)
    plans = dict(zip(runs, plans_of(file, runs), strict=True))
    told = {run.name: _tried(plans[run], file.rig) for run in order.runs if run in plans}
    if arguments.json:
        described = {name: _document(found) for name, found in told.items()}
        sequence = {"order": order.order, "seed": order.seed, "sequence": list(described)}
        print_json({"limits": _limits(file.rig), "runs": described} | sequence)
    else:
        print("\n".join(f"{name}: {value}" for name, value in _limits(file.rig).items()))
        print(f"order of the runs: {order}")
        for line in laxer_guards(file.rig):
            print(line)
        print("" if arguments.details else f"\n{_HEAD}")
        for name, found in told.items():
            if isinstance(found, str):
                print(f"{name}: not possible. {found}")
            else:
                print(_table(name, found) if arguments.details else _row(name, found))
        seconds = sum(found.at_most_s for found in told.values() if not isinstance(found, str))
        print(f"\n{len(told)} runs, at most {seconds / 60:.1f} min; nothing was sent")
    return int(any(isinstance(found, str) for found in told.values()))


def _tried(plan: RunPlan, rig: RigSettings) -> DryRun | str:
    from emg2vsa.errors import InputError
    from emg2vsa.rig.executor.dry_run import dry_run

    try:
        return dry_run(plan, rig)
    except InputError as error:
        return str(error)


def _limits(rig: RigSettings) -> dict[str, str]:
    from emg2vsa.actuator import ticks_of_percent

    low, high = ticks_of_percent(rig.stiffness_percent, rig.max_preset_ticks)
    percent = "{:g} to {:g} %".format(*rig.stiffness_percent)
    return {
        "positions": "{} to {} ticks".format(*rig.position_ticks),
        "presets": f"{low} to {high} ticks, {percent} of {rig.max_preset_ticks}",
        "travel": f"{rig.travel_mm:g} mm, {rig.ticks_at(rig.travel_mm) - rig.home_ticks:+d} ticks from home",
        "force": f"{rig.guards.force_n:g} N, {rig.guards.force_rate_n_per_s:g} N/s",
    }


def _document(found: DryRun | str) -> dict[str, Any]:
    return {"problem": found} if isinstance(found, str) else dataclasses.asdict(found)


def _row(name: str, found: DryRun) -> str:
    presets = [leg.preset_ticks for leg in found.legs]
    ticks = [tick for leg in found.legs for tick in leg.position_ticks]
    low_n, high_n = found.legs[0].force_n or (0.0, 0.0)
    high_n = max([high_n, *(leg.force_n[1] for leg in found.legs if leg.force_n)])
    columns = f"{min(ticks)} to {max(ticks)}", f"{min(presets)} to {max(presets)}", f"{low_n:g} to {high_n:g}"
    return (
        f"{name:<26}{found.repetitions:>8}"
        + "".join(f"{column:>16}" for column in columns)
        + f"{_largest(found):>12}{found.at_most_s:>12.1f}"
    )


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
