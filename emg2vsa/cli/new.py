"""``emg2vsa new``: a study file drafted from a folder of recordings, with what no file tells asked of a person."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from casr.command_line import Commands, add_command, add_json, add_options, answer
from emg2vsa.cli.arguments import add_reading, check_rate, reading_of

if TYPE_CHECKING:
    from emg2vsa.settings import ReadingSettings
    from emg2vsa.study_file.drafting import Found

_T = TypeVar("_T")

SUMMARY = "Write a first study file from a folder of recordings: people, specimens, channels, units and rates."
EPILOG = """
The command guesses everything from the names and the contents of the files, and marks each guess. On a terminal it asks
for what no file tells; otherwise it marks the line FILL IN. A page beside the study file shows one recording as the
study file has it. It replaces no file but an older page of its own. Example: emg2vsa new recordings --stiffness
hard=6.0 --stiffness soft=1.5
"""
OPTIONS = """
folder FOLDER  folder of recordings
--out FILE  study file to write (default: FOLDER/study.toml)
--name NAME  name of the study (default: the name of the folder)
--stiffness NAME=K...  stiffness of a specimen in N/mm; may be repeated
--fs HZ  sampling rate, Hz, where the files state none
"""
QUESTIONS = """
--ask  ask even where no terminal is, and take the answers from standard input, a line each
--no-questions  ask nothing, even on a terminal
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "new", run, SUMMARY, EPILOG, OPTIONS)
    add_options(parser.add_mutually_exclusive_group(), QUESTIONS)
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Draft a study file and its page. SettingError : no folder, or a file in the way."""
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import SettingError
    from emg2vsa.pipeline.places import recordings_in
    from emg2vsa.report.draft_page import is_draft_page
    from emg2vsa.study_file.dialogue import ask_about
    from emg2vsa.study_file.draft import FILL
    from emg2vsa.study_file.drafting import by_specimen, look, stiffness_of, study_name

    folder, out = arguments.folder, arguments.out or arguments.folder / "study.toml"
    if not folder.is_dir():
        raise SettingError(folder, wanted="a folder of recordings", found="no folder", do="Check the path.")
    page = out.with_suffix(".html")
    if page == out:
        do = "Choose another name with --out."
        raise SettingError(out, wanted="a name such as study.toml", found="that of a page", do=do)
    for file in (out, page):
        if file.exists() and not (file == page and is_draft_page(page)):
            do = "Choose another name with --out, or move the file away."
            raise SettingError(file, wanted="a new file", found="an existing one", do=do)
    check_rate(arguments.fs)
    stiffness, reading, presses = stiffness_of(arguments.stiffness), reading_of(arguments, "new"), None
    found = look(folder, recordings_in([folder]), out.parent, reading, arguments.fs, stiffness)
    stiffness = by_specimen(stiffness, found.specimens)
    is_terminal = sys.stdin is not None and sys.stdin.isatty()
    if arguments.ask or (is_terminal and not (arguments.no_questions or arguments.json)):
        print(f"{found.named} recordings. Enter takes the guess in brackets; Ctrl-C writes nothing.", file=sys.stderr)
        found, stiffness, presses = ask_about(found, stiffness, _asked)
    text = found.text(arguments.name or study_name(folder), stiffness, presses)
    write_text_atomic(out, text)
    write_text_atomic(page, _page(found, text, out, reading))
    to_fill = [number for number, line in enumerate(text.splitlines(), 1) if FILL in line and number > 1]
    channels = [*found.emg_channels.values(), *([found.force_channel] if found.force_channel else [])]
    lines = [
        f"{out}: {found.named} of {len(found.files)} recordings, from {folder}",
        *(f"  {channel.name}: {channel.said}" for channel in channels),
        *(f"  {hint}" for hint in found.hints),
        *(f"  not read: {one}" for one in found.unread),
        *([f"{FILL}: line{'s' if len(to_fill) > 1 else ''} {', '.join(map(str, to_fill))}"] if to_fill else []),
        f"Page of one recording: {page}",
        f"Then: emg2vsa check {out}",
    ]
    told = {
        "study": str(out), "page": str(page), "recordings": len(found.files), "fill_in_lines": to_fill,
        "not_read": found.unread,
    }  # fmt: skip
    answer(arguments.json, told, lines)
    return 0


def _page(found: Found, text: str, out: Path, reading: ReadingSettings) -> str:
    """The page of the drafted study, with the presses of one recording where the study file can be used as it is."""
    from emg2vsa.errors import Emg2vsaError
    from emg2vsa.pipeline.stages.trials import trials_of
    from emg2vsa.report.draft_page import draft_page
    from emg2vsa.study_file import load_study

    try:
        study = load_study(out)
        looked_at = os.path.abspath(found.emg.path)
        entry = next((e for e in study.recordings if os.path.abspath(e.emg_file) == looked_at), study.recordings[0])
        trials = trials_of(
            entry.emg_file, entry.force_file, entry.participant, entry.specimen, channels=entry.channels,
            filters=entry.filters, window=entry.window, cocontraction=study.cocontraction, reading=reading,
        )  # fmt: skip
    except Emg2vsaError as error:
        return draft_page(found, text, out, str(error).replace(f"{out.parent.resolve()}{os.sep}", ""))
    return draft_page(found, text, out, (entry, trials))


def _asked(question: str, guess: str, parse: Callable[[str], _T], wanted: str) -> _T:
    """The answer that is typed; on standard error, as standard output may be for programs."""
    from emg2vsa.errors import SettingError

    print(f"\n{question}{f' (Enter: {guess})' if guess else ''}", file=sys.stderr)
    if isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(errors="replace")  # what cannot be decoded is a wrong answer
    while True:
        print("> ", end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline() if sys.stdin is not None else ""
        if not line:
            do = "Answer on a terminal, or give a line for each question. Nothing was written."
            raise SettingError("--ask", wanted="an answer to every question", found="the end of the input", do=do)
        try:
            return parse(line.strip() or guess)
        except ValueError:
            print(f"Expected {wanted}, but found {line.strip()!r}.", file=sys.stderr)
