"""``emg2vsa schedule``: export the stiffness schedules of a study for the actuator."""

from __future__ import annotations

import argparse
from pathlib import Path

from emg2vsa.cli.arguments import Commands, add_command, add_jobs, add_json, add_study, jobs_of, print_json


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "schedule", run, "Export stiffness schedules (CSV and JSON) for the actuator.")
    add_study(parser)
    parser.add_argument("--specimen", action="append", default=[], metavar="NAME", help="only these specimens; repeat")
    parser.add_argument(
        "--condition",
        action="append",
        default=[],
        choices=("modular", "constant-min", "constant-mean", "constant-max"),
        help="only these conditions; repeat",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder (default: schedules/ in the study's report)")
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import artifacts
    from emg2vsa.cli.progress import progress
    from emg2vsa.errors import ScheduleError
    from emg2vsa.pipeline.run import run_study
    from emg2vsa.schedule_files import write_schedule
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    board = run_study(study, only="schedules", jobs=jobs_of(arguments), progress=progress(quiet=arguments.json))
    made = board.done("schedules")
    if not made:
        message = "; ".join(text for item, _, text in board.failures() if item == "study")
        raise ScheduleError(
            arguments.study, wanted="schedules", found="none", do=message or "Run emg2vsa status --explain."
        )
    chosen = [
        schedule
        for schedule in artifacts.load(made[0])
        if (not arguments.specimen or schedule.specimen in arguments.specimen)
        and (not arguments.condition or schedule.condition in arguments.condition)
    ]
    if not chosen:
        raise ScheduleError(
            arguments.study, wanted=f"a schedule of {', '.join(arguments.specimen) or 'any specimen'}", found="none",
            do="Name specimens of the study's [profile] table.",
        )  # fmt: skip
    folder = arguments.out or study.reports / "schedules"
    files = [path for schedule in chosen for path in write_schedule(folder, schedule)]
    if arguments.json:
        print_json({"files": [str(path) for path in files]})
    else:
        for schedule in chosen:
            low, high = schedule.stiffness_percent.min(), schedule.stiffness_percent.max()
            steps = schedule.stiffness_percent.size
            print(
                f"{schedule.specimen:<8} {schedule.condition:<14} {steps:>3} steps, {low:.1f} to {high:.1f} % of preset"
            )
        print(f"{len(files)} files in {folder}")
    return 0
