"""``emg2vsa session finish``: the recordings of a session as BIDS, its verdict, and the participant's page."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, add_options, print_json
from emg2vsa.cli import check
from emg2vsa.cli.arguments import add_study
from emg2vsa.cli.session import PARTICIPANT, REQUIRED

if TYPE_CHECKING:
    from emg2vsa.session import FinishedSession


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
    add_options(parser, PARTICIPANT, participant=REQUIRED)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.cli.progress import progress
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    finished = session.finish(study, arguments.participant, progress=progress(quiet=True))
    if arguments.json:
        print_json(as_json(finished))
    else:
        say(finished)
    return int(not finished.good)


def as_json(finished: FinishedSession) -> dict[str, object]:
    """For programs."""
    return {
        "recordings": [str(path) for path in finished.recordings],
        "left_out": [{"stay": stay, "why": why} for stay, why in finished.left_out],
        "notes": list(finished.notes),
        "verdicts": {verdict.participant: check.as_json(verdict) for verdict in finished.verdicts},
        "page": str(finished.page),
    }


def say(finished: FinishedSession) -> None:
    """For people."""
    print(f"recordings: {len(finished.recordings)} in {finished.folder}")
    for stay, why in finished.left_out:
        print(f"left out: {stay}: {why}")
    for note in finished.notes:
        print(f"note: {note}")
    for line in check.told(finished.verdicts, sys.stdout):
        print(line)
    print(f"page: {finished.page}")
