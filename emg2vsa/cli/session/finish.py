"""``emg2vsa session finish``: the recordings of a session as BIDS, its verdict, and the participant's page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from casr.command_line import Commands, add_command
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


def run(arguments: argparse.Namespace) -> int:
    return finish(arguments.study, arguments.participant)


def finish(study_file: Path, participant: str) -> int:
    """Exit status as above."""
    from emg2vsa.cli.check import judge, of_participants, told
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.run import run_study
    from emg2vsa.session.dataset import write_dataset
    from emg2vsa.session.open_session import folder_of, settings_of
    from emg2vsa.study_file import load_study

    study = load_study(study_file)
    settings_of(study, participant)
    written = write_dataset(folder_of(study, participant), study)
    print(f"recordings: {len(written.files)} in {study.data / f'sub-{participant}'}")
    for stay, why in written.left_out:
        print(f"left out: {stay}: {why}")
    for note in written.notes:
        print(f"note: {note}")
    whole = load_study(study_file)  # whose recordings are there now
    own = of_participants(whole, [participant])
    verdicts = judge(own, whole, 1, progress(quiet=True), None)
    for line in told(verdicts, sys.stdout):
        print(line)
    run_study(own, stages=("trials", "fits", "pages"), jobs=1, progress=progress(quiet=True))
    print(f"page: {own.reports / 'participants' / f'{participant}.html'}")
    return int(bool(written.left_out) or any(each.verdict in ("repeat", "unreadable") for each in verdicts))
