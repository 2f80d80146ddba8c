"""``emg2vsa session replay``: what the pages of a session showed, and its verdicts judged again, from its folder."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY

if TYPE_CHECKING:
    from emg2vsa.session import ReplayedSession

SUMMARY = "Rebuild a session from its folder: its pages, and every verdict judged again from the samples."
EPILOG = """
FOLDER is sourcedata/sub-CODE/TASK below the root of the recordings. It is read and never changed, also while the
session runs. Exit status 0: every verdict is the one of the journal; 1: one is not, or the journal lacks a line; 2:
study file or folder are unusable.
"""
OPTIONS = """\
folder FOLDER  of the session, with plan.json and journal.jsonl
--line N  show the pages as they were after this line of the journal (default: the last)
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "replay", run, SUMMARY, EPILOG, f"{STUDY}{OPTIONS}{JSON}", {"N": int})


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.study_file import load_study

    replayed = session.replay(load_study(arguments.study), arguments.folder, line=arguments.line)
    answer(arguments.json, as_json(replayed), lines(replayed))
    return int(not replayed.same)


def as_json(replayed: ReplayedSession) -> dict[str, object]:
    """For programs."""
    presses = [{**asdict(press), "differences": press.differences} for press in replayed.presses]
    return {
        "folder": str(replayed.folder), "line": replayed.line, "same": replayed.same, "notes": replayed.notes,
        "presses": presses, "operator": asdict(replayed.operator), "participant": asdict(replayed.participant),
    }  # fmt: skip


def lines(replayed: ReplayedSession) -> Iterator[str]:
    """For people."""
    state, page = replayed.operator, replayed.participant
    yield f"line {replayed.line} of {replayed.folder}"
    yield f"operator:    {state.message}"
    where = f" ({page.phase}, press {page.press} of {page.presses})" if page.press else ""
    yield f"participant: {page.text}{where}"
    yield from (f"note: {note}" for note in replayed.notes)
    row = "{:>5} {:>7} {:<8} {:<9} {:<9} {}"
    yield row.format("press", "attempt", "specimen", "journal", "replayed", "").rstrip()
    for press in replayed.presses:
        own = press.before
        same = "; ".join(press.differences) or "same"
        yield row.format(own.press, own.attempt, press.specimen, own.verdict, press.again.verdict, same)
