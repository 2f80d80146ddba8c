"""``emg2vsa report``, ``schedule``, ``verify``: the report, the authors' package and its proof, and schedules."""

from __future__ import annotations

import argparse
import datetime
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, add_options, answer, wanted
from emg2vsa.cli.arguments import COUNT, JOBS, ON_STUDY, STUDY, jobs_of, say_not_used, study_of
from emg2vsa.errors import SettingError

if TYPE_CHECKING:
    from emg2vsa.schedules import Schedule

REPORT_SUMMARY = "Update the report of a study and list its files. Only steps that are out of date run."
PACKAGE = """
--paper  write the authors' package: LaTeX tables, numbers, figures and an archive
--out DIR  folder of the package (default: paper/ in the report of the study)
--published DATE  date of publication to write into the archive, YYYY-MM-DD
--licence TEXT  licence of the archive, as an address or a sentence
"""
VERIFY_SUMMARY = "Recompute every number of an authors' package from its data and say which differ."
VERIFY = """
The package's files are held against its manifest, its macros against its numbers, and its numbers, tables and schedules
against those that its study file gives on the data. Nothing is written beside them. Exit status 0: everything agrees;
1: a number differs, or a file was changed; 2: the package cannot be verified, or not all of it, as data are missing.
"""
VERIFY_OPTIONS = f"""
package PACKAGE  folder that emg2vsa report STUDY --paper wrote, or its archive
--data FOLDER  folder of the study file, from which it names its data (default: found in or beside the package)
--keys GLOB = *  compare only numbers with such keys, for example 'fit.*'
--work DIR  recompute in DIR and keep it (default: temporary)
{JOBS}{JSON}
"""
SCHEDULE_SUMMARY = "Export the stiffness schedules of a study (CSV and JSON) for the actuator."
SCHEDULE = """
The command first runs the stale steps up to the schedules. It checks every file against the limits before it writes it.
"""
SCHEDULE_OPTIONS = f"""
{STUDY}
--specimen NAME...  only this specimen; may be repeated
--condition {{modular,constant-min,constant-mean,constant-max}}...  only this condition; may be repeated
--out DIR  folder to write to (default: schedules/ in the report of the study)
{ON_STUDY}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "schedule", schedule, SCHEDULE_SUMMARY, SCHEDULE, SCHEDULE_OPTIONS, COUNT)
    date = wanted("a date as 2026-01-31", lambda text: datetime.date.fromisoformat(text).isoformat())
    parser = add_command(commands, "report", report, REPORT_SUMMARY, "", STUDY)
    add_options(parser.add_argument_group("authors' package"), PACKAGE, {"DATE": date})
    add_options(parser, ON_STUDY, COUNT)
    add_command(commands, "verify", verify, VERIFY_SUMMARY, VERIFY, VERIFY_OPTIONS, COUNT | {"PACKAGE": Path})


def report(arguments: argparse.Namespace) -> int:
    """Update the report of a study, or make its package. SettingError : options of a package that cannot be."""
    from emg2vsa.cli.progress import progress
    from emg2vsa.deposit.crate import UNLICENSED, UNPUBLISHED, Publication
    from emg2vsa.deposit.package import write_package
    from emg2vsa.pipeline.run_study import run_study
    from emg2vsa.pipeline.stage_order import stages_for

    _check_package(arguments)
    study, below = study_of(arguments)
    plan = run_study(
        study, stages=stages_for("report"), jobs=jobs_of(arguments), progress=progress(quiet=arguments.json),
        wait=not arguments.no_wait, below=below,
    )  # fmt: skip
    failed = [message for item, stage, message in plan.failures() if (item, stage) == ("study", "report")]
    paths = {"files": [*plan.files("report"), *plan.files("pages")], "paper": []}
    folder = arguments.out or study.reports / "paper"
    if arguments.paper and not failed:
        publication = Publication(arguments.published or UNPUBLISHED, arguments.licence or UNLICENSED)
        paths["paper"] = write_package(plan, folder, publication)
    if not arguments.json:
        say_not_used(plan)
    package = [f"Authors' package, {len(paths['paper'])} files: {folder}"] if paths["paper"] else []
    told = {name: [str(path) for path in of] for name, of in paths.items()} | {"failed": failed}
    answer(arguments.json, told, [*_listed(paths["files"], plan.files("report")), *package])
    return 1 if failed else 0


def _listed(files: Sequence[Path], of_report: Sequence[Path]) -> Iterator[str]:
    """The page, and each folder with the number of its files."""
    yield from (str(path) for path in of_report if path.name == "index.html")
    for folder, count in Counter(path.parent for path in files).items():
        yield f"{folder}: {count} file{'s' if count != 1 else ''}"


def _check_package(arguments: argparse.Namespace) -> None:
    for name in ("out", "published", "licence"):
        if getattr(arguments, name) and not arguments.paper:
            do = f"Add --paper: --{name} is an option of the authors' package."
            raise SettingError(f"--{name}", wanted="--paper beside this option", found="no --paper", do=do)


def verify(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.deposit.verification import as_json, lines, verify_package

    found = verify_package(
        arguments.package, data=arguments.data, work=arguments.work, keys=arguments.keys, jobs=jobs_of(arguments),
        progress=progress(quiet=arguments.json),
    )  # fmt: skip
    answer(arguments.json, as_json(found), lines(found))
    return found.status


def schedule(arguments: argparse.Namespace) -> int:
    """Write the schedules of the chosen specimens and conditions. ScheduleError : the study gives none."""
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
    files = [path for each in chosen for path in write_schedule(folder, each)]
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

    there = list(dict.fromkeys(getattr(each, what) for each in schedules))
    asked: list[str] = getattr(arguments, what)
    if absent := [name for name in asked if name not in there]:
        wanted, found = f"{what}s with a schedule ({', '.join(there)})", ", ".join(absent)
        raise ScheduleError(arguments.study, wanted=wanted, found=found, do=do)
    return asked or there
