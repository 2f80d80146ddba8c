"""``emg2vsa report``: bring the report up to date and say where it is."""

from __future__ import annotations

import argparse

from emg2vsa.cli.arguments import (
    Commands,
    add_command,
    add_jobs,
    add_json,
    add_study,
    jobs_of,
    print_json,
    say_not_used,
)


def add_to(commands: Commands) -> None:
    summary = "Bring the report of a study up to date (runs what is stale) and list its files."
    parser = add_command(commands, "report", run, summary)
    add_study(parser)
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.manifest import manifest_files
    from emg2vsa.pipeline.run import run_study
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    board = run_study(study, only="report", jobs=jobs_of(arguments), progress=progress(quiet=arguments.json))
    failed = [message for item, stage, message in board.failures() if (item, stage) == ("study", "report")]
    files = [] if failed else manifest_files(board.result("report/study"))
    pages = [file for page in board.done("pages") for file in manifest_files(page)]
    if arguments.json:
        print_json({"files": [str(path) for path in [*files, *pages]], "failed": failed})
    else:
        say_not_used(board)
        for path in files:
            print(path)
        print(f"and {len(pages)} participant page{'s' if len(pages) != 1 else ''} beside it")
    return 1 if failed else 0
