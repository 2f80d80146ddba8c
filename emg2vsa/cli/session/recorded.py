"""``emg2vsa session form``, ``finish`` and ``replay``: an empty form; a session as BIDS, judged; judged again."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY
from emg2vsa.cli.session import PARTICIPANT, REQUIRED

if TYPE_CHECKING:
    from emg2vsa.session import FinishedSession, ReplayedSession

FORM_SUMMARY = "Print an empty form of [session.form] for a participant, in TOML."
FORM = """
Fill it in and give it to emg2vsa session run --form. The answers go into participants.tsv of the data set, and nowhere
else; participants.json says what the columns are. Exit status 2: the study file has no form.
"""
FINISH_SUMMARY = "Write the recordings of a session in BIDS, judge them, and make the participant's page."
FINISH = """
A session that reaches its last press does so by itself. For one that was interrupted and will not be resumed; or again,
after the study file has changed. Exit status 0: good or usable; 1: to repeat, or unreadable; 2: there is no session, or
it cannot be written.
"""
REPLAY_SUMMARY = "Rebuild a session from its folder: its pages, and every verdict judged again from the samples."
REPLAY = """
FOLDER is sourcedata/sub-CODE/TASK below the root of the recordings. It is read and never changed, also while the
session runs. Exit status 0: every verdict is the one of the journal; 1: one is not, or the journal lacks a line; 2:
study file or folder are unusable.
"""
REPLAYED = f"""
{STUDY}folder FOLDER  of the session, with plan.json and journal.jsonl
--line N  show the pages as they were after this line of the journal (default: the last)
{JSON}"""


def add_to(commands: Commands) -> None:
    options = f"{STUDY}--participant CODE  a code of [participants]: P03\n{JSON}"
    add_command(commands, "form", form, FORM_SUMMARY, FORM, options, participant=REQUIRED)
    add_command(commands, "finish", finish, FINISH_SUMMARY, FINISH, f"{STUDY}{PARTICIPANT}{JSON}", participant=REQUIRED)
    add_command(commands, "replay", replay, REPLAY_SUMMARY, REPLAY, REPLAYED, {"N": int})


def form(arguments: argparse.Namespace) -> int:
    """Show an empty form. SettingError : the study has no table [session.form]."""
    from emg2vsa.errors import SettingError
    from emg2vsa.session.form import blank_form
    from emg2vsa.session.open_session import settings_of
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    first = study.at_visit(study.visits[0]) if study.visits else study
    asked = settings_of(first, arguments.participant).form
    if not asked:
        do = "Add one: docs/reference/study-file.md lists its keys."
        raise SettingError(study.path, wanted="a table [session.form]", found="none", do=do)
    text = blank_form(asked, arguments.participant)
    answer(arguments.json, {"participant": arguments.participant, "form": text}, text.splitlines())
    return 0


def finish(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.cli.progress import progress
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    finished = session.finish(study, arguments.participant, visit=arguments.visit, progress=progress(quiet=True))
    answer(arguments.json, finished_json(finished), finished_lines(finished))
    return int(not finished.good)


def finished_json(finished: FinishedSession) -> dict[str, object]:
    """For programs."""
    from emg2vsa.pipeline import judged_sessions

    return {
        "recordings": [str(path) for path in finished.recordings],
        "left_out": [{"stay": stay, "why": why} for stay, why in finished.left_out],
        "notes": list(finished.notes),
        "verdicts": {verdict.participant: judged_sessions.as_json(verdict) for verdict in finished.verdicts},
        "page": str(finished.page),
    }


def finished_lines(finished: FinishedSession) -> Iterator[str]:
    """For people."""
    from emg2vsa.pipeline.judged_sessions import told

    yield f"recordings: {len(finished.recordings)} in {finished.folder}"
    yield from (f"left out: {stay}: {why}" for stay, why in finished.left_out)
    yield from (f"note: {note}" for note in finished.notes)
    yield from told(finished.verdicts, sys.stdout)
    yield f"page: {finished.page}"


def replay(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.study_file import load_study

    replayed = session.replay(load_study(arguments.study), arguments.folder, line=arguments.line)
    answer(arguments.json, _replayed(replayed), _replayed_lines(replayed))
    return int(not replayed.same)


def _replayed(replayed: ReplayedSession) -> dict[str, object]:
    """For programs."""
    presses = [{**asdict(press), "differences": press.differences} for press in replayed.presses]
    return {
        "folder": str(replayed.folder), "line": replayed.line, "same": replayed.same, "notes": replayed.notes,
        "presses": presses, "operator": asdict(replayed.operator), "participant": asdict(replayed.participant),
    }  # fmt: skip


def _replayed_lines(replayed: ReplayedSession) -> Iterator[str]:
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
