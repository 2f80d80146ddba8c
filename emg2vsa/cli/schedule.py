"""``emg2vsa schedule``: export the stiffness schedules of a study for the actuator."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, answer
from emg2vsa.cli.arguments import COUNT, ON_STUDY, STUDY, jobs_of, say_not_used, study_of

if TYPE_CHECKING:
    from emg2vsa.schedules import Schedule

SUMMARY = "Export the stiffness schedules of a study (CSV and JSON) for the actuator."
EPILOG = """
The command first runs the stale steps up to the schedules. It checks every file against the limits before it writes it.
"""
OPTIONS = f"""
{STUDY}
--specimen NAME...  only this specimen; may be repeated
--condition {{modular,constant-min,constant-mean,constant-max}}...  only this condition; may be repeated
--out DIR  folder to write to (default: schedules/ in the report of the study)
{ON_STUDY}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "schedule", run, SUMMARY, EPILOG, OPTIONS, COUNT)


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
        plan = run_study(
            study, stages=stages_for("schedules"), jobs=jobs_of(arguments), progress=progress(quiet=arguments.json),
            wait=not arguments.no_wait, below=below,
        )  # fmt: skip
        made = plan.done("schedules")
        if not made:
            do = "; ".join(text for item, _, text in plan.failures() if item == "study")
            do = do or "Run emg2vsa status --explain."
            raise ScheduleError(arguments.study, wanted="schedules", found="none", do=do)
        schedules = artifacts.load(made[0])
    specimens = _chosen(arguments, "specimen", schedules, "See specimens and new_specimen of its [profile] table.")
    conditions = _chosen(arguments, "condition", schedules, "See conditions of its [schedule] table.")
    chosen = [s for s in schedules if s.specimen in specimens and s.condition in conditions]
    files = [path for schedule in chosen for path in write_schedule(folder, schedule)]
    if not arguments.json:
        say_not_used(plan)
    lines = [
        f"{s.specimen:<8} {s.condition:<14} {s.stiffness_percent.size:>3} steps, {s.stiffness_percent.min():.1f} to "
        f"{s.stiffness_percent.max():.1f} % of preset"
        for s in chosen
    ]
    answer(arguments.json, {"files": [str(path) for path in files]}, [*lines, f"{len(files)} files in {folder}"])
    return 0


def _chosen(arguments: argparse.Namespace, what: str, schedules: Sequence[Schedule], do: str) -> list[str]:
    """The specimens or conditions asked for, or all; ScheduleError where the study has no schedule of one."""
    from emg2vsa.errors import ScheduleError

    there = list(dict.fromkeys(getattr(schedule, what) for schedule in schedules))
    asked: list[str] = getattr(arguments, what)
    if absent := [name for name in asked if name not in there]:
        wanted, found = f"{what}s with a schedule ({', '.join(there)})", ", ".join(absent)
        raise ScheduleError(arguments.study, wanted=wanted, found=found, do=do)
    return asked or there
