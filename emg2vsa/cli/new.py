"""``emg2vsa new``: a study file drafted from a folder of recordings, with what no file tells asked of a person."""

from __future__ import annotations

import argparse
import io
import os
import shlex
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
    parser.set_defaults(stopped="Nothing was written.")
    add_options(parser.add_mutually_exclusive_group(), QUESTIONS)
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Draft a study file and its page. SettingError : no folder, or a file in the way."""
    from emg2vsa.errors import SettingError
    from emg2vsa.pipeline.places import recordings_in
    from emg2vsa.study_file.dialogue import ask_about
    from emg2vsa.study_file.draft_channel import FILL
    from emg2vsa.study_file.drafting import by_specimen, look, stiffness_of, study_name

    folder, out = arguments.folder, arguments.out or arguments.folder / "study.toml"
    if not folder.is_dir():
        raise SettingError(folder, wanted="a folder of recordings", found="no folder", do="Check the path.")
    _refuse_names(folder, out, arguments.name)
    _refuse_existing(out)
    check_rate(arguments.fs)
    stiffness, reading, presses = stiffness_of(arguments.stiffness), reading_of(arguments, "new"), None
    found = look(folder, recordings_in([folder]), out.parent, reading, arguments.fs, stiffness)
    stiffness = by_specimen(stiffness, found.specimens)
    is_terminal = sys.stdin is not None and sys.stdin.isatty()
    if arguments.ask or (is_terminal and not (arguments.no_questions or arguments.json)):
        start = f"{found.named} recordings. Enter takes the guess in brackets; ? asks again; Ctrl-C writes nothing."
        print(start, file=sys.stderr)
        found, stiffness, presses = ask_about(found, stiffness, _asked)
    text = found.text(arguments.name or study_name(folder), stiffness, presses)
    page, shown = out.with_suffix(".html"), _page(found, text, out, reading)
    with _unstopped():
        _write_pair(out, text, page, shown)
        arguments.stopped = "The study file and its page are written."
    to_fill = [number for number, line in enumerate(text.splitlines(), 1) if FILL in line and number > 1]
    channels = [*found.emg_channels.values(), *([found.force_channel] if found.force_channel else [])]
    lines = [
        f"{out}: {found.named} of {len(found.files)} recordings, from {folder}",
        *(f"  {one}" for one in found.told),
        *(f"  {channel.name}: {channel.said}" for channel in channels),
        *(f"  {hint}" for hint in found.hints),
        *([f"  --fs {arguments.fs:g}: left aside, as the files state their rates"] if found.needs_no_rate else []),
        *(f"  not read: {one}" for one in found.unread),
        *([f"{FILL}: line{'s' if len(to_fill) > 1 else ''} {', '.join(map(str, to_fill))}"] if to_fill else []),
        f"Page of one recording: {page}",
        f"Then: emg2vsa check {_typed(out)}",
    ]
    told = {
        "study": str(out), "page": str(page), "recordings": len(found.files), "fill_in_lines": to_fill,
        "not_read": found.unread,
    }  # fmt: skip
    answer(arguments.json, told, lines)
    return 0


def _typed(path: Path) -> str:
    """The path as a shell takes it, and as no option."""
    return shlex.quote(f"./{path}" if str(path).startswith("-") else str(path))


def _refuse_names(folder: Path, out: Path, name: str | None) -> None:
    """SettingError : --out is no name of a study file, a path cannot be written as text, or --name is no study's."""
    from emg2vsa.errors import SettingError, StudyError
    from emg2vsa.study_file.problems import checked
    from emg2vsa.study_file.tables import Name

    if out.suffix.lower() != ".toml":
        do = "Name the study file with --out, such as --out study.toml."
        raise SettingError("--out", wanted="a name that ends in .toml", found=repr(str(out)), do=do)
    for path in (folder, out):
        try:
            os.path.abspath(path).encode()
        except UnicodeEncodeError:
            do = "Rename the folder or the file."
            shown = os.fsencode(path).decode(errors="backslashreplace")
            raise SettingError(shown, wanted="a path in UTF-8", found="other bytes", do=do) from None
    if name is not None and (problems := checked(Name, name, ("--name",))[1]):
        raise StudyError(tuple(map(str, problems)))


def _refuse_existing(out: Path) -> None:
    """SettingError : a study file is there, or a page beside it that is no older draft's."""
    from emg2vsa.report.draft_page import is_draft_page

    page = out.with_suffix(".html")
    for file in (out, page):
        if file.exists() and not (file == page and is_draft_page(page)):
            raise _in_the_way(file)


def _in_the_way(file: Path) -> Exception:
    from emg2vsa.errors import SettingError

    do = "Choose another name with --out, or move the file away."
    return SettingError(file, wanted="a new file", found="an existing one", do=do)


@contextmanager
def _unstopped() -> Iterator[None]:
    """Ctrl-C waits until what is done within is done, which may take milliseconds only."""
    if threading.current_thread() is not threading.main_thread():  # Ctrl-C goes to the main thread alone
        yield
        return
    pressed: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt


def _write_pair(out: Path, text: str, page: Path, shown: str) -> None:
    """Write the study file and then its page, or neither. SettingError : a file is in the way by now."""
    from casr.atomic import write_bytes_atomic, write_new
    from emg2vsa.report.draft_page import is_draft_page

    made = False
    try:
        write_new(out, text.encode())  # of two commands at once one gets the name
        made = True
        is_older = page.exists() and is_draft_page(page)
        (write_bytes_atomic if is_older else write_new)(page, shown.encode(errors="backslashreplace"))
    except BaseException as error:
        if made:
            out.unlink(missing_ok=True)
        if isinstance(error, FileExistsError):
            raise _in_the_way(page if made else out) from None
        raise


def _page(found: Found, text: str, out: Path, reading: ReadingSettings) -> str:
    """The page of the drafted study, with the presses of one recording where the study file can be used as it is."""
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import Emg2vsaError
    from emg2vsa.pipeline.stages.trials import trials_of
    from emg2vsa.report.draft_page import draft_page
    from emg2vsa.study_file import load_study

    whole = out.with_name(f".{out.stem}-{os.getpid()}.toml")  # paths in it count from its folder
    try:
        write_text_atomic(whole, text)
        study = load_study(whole)
        looked_at = os.path.abspath(found.emg.path)
        entry = next((e for e in study.recordings if os.path.abspath(e.emg_file) == looked_at), study.recordings[0])
        trials = trials_of(
            entry.emg_file, entry.force_file, entry.participant, entry.specimen, channels=entry.channels,
            filters=entry.filters, window=entry.window, cocontraction=study.cocontraction, reading=reading,
        )  # fmt: skip
    except Emg2vsaError as error:
        told = str(error).replace(f"{out.parent.resolve()}{os.sep}", "").replace(whole.name, out.name)
        return draft_page(found, text, out, told)
    except OSError as error:
        if error.filename == str(whole):
            error.filename = str(out)
        raise
    finally:
        whole.unlink(missing_ok=True)
    return draft_page(found, text, out, (entry, trials))


def _asked(question: str, guess: str, parse: Callable[[str], _T], wanted: str) -> _T:
    """The answer that is typed; on standard error, as standard output may be for programs."""
    from emg2vsa.errors import SettingError

    whole_question = f"\n{question}{f' (Enter: {guess})' if guess else ''}"
    print(whole_question, file=sys.stderr)
    if isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(errors="replace")  # what cannot be decoded is a wrong answer
    while True:
        print("> ", end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline() if sys.stdin is not None else ""
        if not line:
            do = "Answer on a terminal, or give a line for each question. Nothing was written."
            raise SettingError("--ask", wanted="an answer to every question", found="the end of the input", do=do)
        if line.strip() == "?":
            print(f"{whole_question}\nWanted: {wanted}.", file=sys.stderr)
            continue
        try:
            return parse(line.strip() or guess)
        except ValueError:
            print(f"Expected {wanted}, but found {line.strip()!r}.", file=sys.stderr)
