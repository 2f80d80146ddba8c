"""``emg2vsa session finish``: the recordings of a session as BIDS, its verdict, and the participant's page."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY
from emg2vsa.cli.session import PARTICIPANT, REQUIRED

if TYPE_CHECKING:
    from emg2vsa.session import FinishedSession

SUMMARY = "Write the recordings of a session in BIDS, judge them, and make the participant's page."
EPILOG = """
A session that reaches its last press does so by itself. For one that was interrupted and will not be resumed; or again,
after the study file has changed. Exit status 0: good or usable; 1: to repeat, or unreadable; 2: there is no session, or
it cannot be written.
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "finish", run, SUMMARY, EPILOG, f"{STUDY}{PARTICIPANT}{JSON}", participant=REQUIRED)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.cli.progress import progress
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    finished = session.finish(study, arguments.participant, progress=progress(quiet=True))
    answer(arguments.json, as_json(finished), lines(finished))
    return int(not finished.good)


def as_json(finished: FinishedSession) -> dict[str, object]:
    """For programs."""
    from emg2vsa.pipeline import judged_sessions

    return {
        "recordings": [str(path) for path in finished.recordings],
        "left_out": [{"stay": stay, "why": why} for stay, why in finished.left_out],
        "notes": list(finished.notes),
        "verdicts": {verdict.participant: judged_sessions.as_json(verdict) for verdict in finished.verdicts},
        "page": str(finished.page),
    }


def lines(finished: FinishedSession) -> Iterator[str]:
    """For people."""
    from emg2vsa.pipeline.judged_sessions import told

    yield f"recordings: {len(finished.recordings)} in {finished.folder}"
    yield from (f"left out: {stay}: {why}" for stay, why in finished.left_out)
    yield from (f"note: {note}" for note in finished.notes)
    yield from told(finished.verdicts, sys.stdout)
    yield f"page: {finished.page}"
