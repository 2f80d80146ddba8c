"""``emg2vsa schedule``: export the stiffness schedules of a study for the actuator."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_jobs, add_study, add_wait, add_work, jobs_of, say_not_used, study_of

if TYPE_CHECKING:
    from emg2vsa.schedules import Schedule


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "schedule",
        run,
        "Export the stiffness schedules of a study (CSV and JSON) for the actuator.",
        "The command first runs the stale steps up to the schedules. It checks every file against the limits before "
        "it writes it.",
    )
    add_study(parser)
    parser.add_argument(
        "--specimen", action="append", default=[], metavar="NAME", help="only this specimen; may be repeated"
    )
    parser.add_argument(
        "--condition",
        action="append",
        default=[],
        choices=("modular", "constant-min", "constant-mean", "constant-max"),
        help="only this condition; may be repeated",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder to write to (default: schedules/ in the report of the study)"
    )
    add_work(parser)
    add_wait(parser)
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import artifacts
    from emg2vsa.cli.progress import progress
    from emg2vsa.errors import ScheduleError
    from emg2vsa.pipeline.places import own_report, writable_or_temporary
    from emg2vsa.pipeline.run_study import run_study
    from emg2vsa.pipeline.stage_order import stages_for
    from emg2vsa.schedule_files import write_schedule

    whole, below = study_of(arguments)
    folder = arguments.out or whole.reports / "schedules"
    if arguments.out is None:
        own_report(whole)
    with writable_or_temporary(whole, below) as (study, below):
        board = run_study(
            study,
            stages=stages_for("schedules"),
            jobs=jobs_of(arguments),
            progress=progress(quiet=arguments.json),
            wait=not arguments.no_wait,
            below=below,
        )
        made = board.done("schedules")
        if not made:
            message = "; ".join(text for item, _, text in board.failures() if item == "study")
            raise ScheduleError(
                arguments.study, wanted="schedules", found="none", do=message or "Run emg2vsa status --explain."
            )
        schedules = artifacts.load(made[0])
    specimens = _chosen(arguments, "specimen", schedules, "See specimens and new_specimen of its [profile] table.")
    conditions = _chosen(arguments, "condition", schedules, "See conditions of its [schedule] table.")
    chosen = [s for s in schedules if s.specimen in specimens and s.condition in conditions]
    files = [path for schedule in chosen for path in write_schedule(folder, schedule)]
    if arguments.json:
        print_json({"files": [str(path) for path in files]})
    else:
        say_not_used(board)
        for schedule in chosen:
            low, high = schedule.stiffness_percent.min(), schedule.stiffness_percent.max()
            steps = schedule.stiffness_percent.size
            print(
                f"{schedule.specimen:<8} {schedule.condition:<14} {steps:>3} steps, {low:.1f} to {high:.1f} % of preset"
            )
        print(f"{len(files)} files in {folder}")
    return 0


def _chosen(arguments: argparse.Namespace, what: str, schedules: Sequence[Schedule], do: str) -> list[str]:
    """The specimens or conditions asked for, or all; ScheduleError where the study has no schedule of one."""
    from emg2vsa.errors import ScheduleError

    there = list(dict.fromkeys(getattr(schedule, what) for schedule in schedules))
    asked: list[str] = getattr(arguments, what)
    absent = [name for name in asked if name not in there]
    if absent:
        wanted, found = f"{what}s with a schedule ({', '.join(there)})", ", ".join(absent)
        raise ScheduleError(arguments.study, wanted=wanted, found=found, do=do)
    return asked or there
