"""``emg2vsa report``: update the report and list its files."""

from __future__ import annotations

import argparse
import datetime
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_jobs, add_study, add_wait, add_work, jobs_of, say_not_used, study_of
from emg2vsa.errors import SettingError

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import StepPlan


def add_to(commands: Commands) -> None:
    summary = "Update the report of a study and list its files. Only steps that are out of date run."
    parser = add_command(commands, "report", run, summary)
    add_study(parser)
    package = parser.add_argument_group("authors' package")
    package.add_argument(
        "--paper", action="store_true", help="write the authors' package: LaTeX tables, numbers, figures and an archive"
    )
    package.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the package (default: paper/ in the report of the study)"
    )
    package.add_argument(
        "--published", type=_date, metavar="DATE", help="date of publication to write into the archive, YYYY-MM-DD"
    )
    package.add_argument("--licence", metavar="TEXT", help="licence of the archive, as an address or a sentence")
    add_work(parser)
    add_wait(parser)
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.run_study import run_study
    from emg2vsa.pipeline.stage_order import stages_for

    _check_package(arguments)
    study, below = study_of(arguments)
    plan = run_study(
        study,
        stages=stages_for("report"),
        jobs=jobs_of(arguments),
        progress=progress(quiet=arguments.json),
        wait=not arguments.no_wait,
        below=below,
    )
    failed = [message for item, stage, message in plan.failures() if (item, stage) == ("study", "report")]
    files, pages = plan.files("report"), plan.files("pages")
    folder = arguments.out or study.reports / "paper"
    package = _package(plan, folder, arguments) if arguments.paper and not failed else []
    if arguments.json:
        paths = {"files": [*files, *pages], "paper": package}
        print_json({name: [str(path) for path in of] for name, of in paths.items()} | {"failed": failed})
    else:
        say_not_used(plan)
        for line in _listed(files, pages):
            print(line)
        if package:
            print(f"Authors' package, {len(package)} files: {folder}")
    return 1 if failed else 0


def _listed(files: Sequence[Path], pages: Sequence[Path]) -> Iterator[str]:
    """The page, and each folder with the number of its files."""
    yield from (str(path) for path in files if path.name == "index.html")
    for folder, count in Counter(path.parent for path in (*files, *pages)).items():
        yield f"{folder}: {count} file{'s' if count != 1 else ''}"


def _package(plan: StepPlan, folder: Path, arguments: argparse.Namespace) -> list[Path]:
    from emg2vsa.deposit.crate import UNLICENSED, UNPUBLISHED, Publication
    from emg2vsa.deposit.package import write_package

    publication = Publication(arguments.published or UNPUBLISHED, arguments.licence or UNLICENSED)
    return write_package(plan, folder, publication)


def _check_package(arguments: argparse.Namespace) -> None:
    for name in ("out", "published", "licence"):
        if getattr(arguments, name) and not arguments.paper:
            raise SettingError(
                f"--{name}",
                wanted="--paper beside this option",
                found="no --paper",
                do=f"Add --paper: --{name} is an option of the authors' package.",
            )


def _date(text: str) -> str:
    try:
        return datetime.date.fromisoformat(text).isoformat()
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a date as 2026-01-31, but found {text!r}") from None
