"""``emg2vsa session finish``: the recordings of a session as BIDS, its verdict, and the participant's page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_study


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "finish",
        run,
        "Write the recordings of a session in BIDS, judge them, and make the participant's page.",
        "A session that reaches its last press does so by itself. For one that was interrupted and will not be "
        "resumed; or again, after the study file has changed. Exit status 0: good or usable; 1: to repeat, or "
        "unreadable; 2: there is no session, or it cannot be written.",
    )
    add_study(parser)
    parser.add_argument("--participant", required=True, metavar="CODE", help="a code of [participants]: P03")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    return finish(arguments.study, arguments.participant, as_json=arguments.json)


def finish(study_file: Path, participant: str, *, as_json: bool = False) -> int:
    """Exit status as above."""
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline import judged_sessions as check
    from emg2vsa.pipeline.run_study import run_study
    from emg2vsa.session.dataset import write_dataset
    from emg2vsa.session.open_session import folder_of, settings_of
    from emg2vsa.study_file import load_study

    study = load_study(study_file)
    settings_of(study, participant)
    written = write_dataset(folder_of(study, participant), study)
    folder = study.data / f"sub-{participant}"
    whole = load_study(study_file)  # whose recordings are there now
    own = check.of_participants(whole, [participant])
    verdicts = check.judge(own, whole, 1, progress(quiet=True), None)
    run_study(own, stages=("trials", "fits", "pages"), jobs=1, progress=progress(quiet=True))
    page = own.reports / "participants" / f"{participant}.html"
    if as_json:
        print_json(
            {
                "recordings": [str(path) for path in written.files],
                "left_out": [{"stay": stay, "why": why} for stay, why in written.left_out],
                "notes": list(written.notes),
                "verdicts": {verdict.participant: check.as_json(verdict) for verdict in verdicts},
                "page": str(page),
            }
        )
    else:
        print(f"recordings: {len(written.files)} in {folder}")
        for stay, why in written.left_out:
            print(f"left out: {stay}: {why}")
        for note in written.notes:
            print(f"note: {note}")
        for line in check.told(verdicts, sys.stdout):
            print(line)
        print(f"page: {page}")
    return int(bool(written.left_out) or any(each.verdict in ("repeat", "unreadable") for each in verdicts))
