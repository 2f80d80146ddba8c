"""``emg2vsa inspect``: what recordings hold, and what each channel probably is."""

from __future__ import annotations

import argparse
import dataclasses
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_reading, reading_of

if TYPE_CHECKING:
    from emg2vsa.readers.survey import FileFacts

NOT_RECORDINGS = {
    ".json", ".tsv", ".md", ".toml", ".html", ".py", ".cal", ".pdf", ".docx", ".gitignore", ".bidsignore", ".svg",
    ".tex", ".png",
}  # fmt: skip
"""Files of a folder that are known to be no recordings."""
_LONGEST_REASON, _LONGEST_NAME = 120, 24


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "inspect",
        run,
        "Show what recordings hold: rate, unit, range and noise of every channel, and what it probably is.",
        "For one file the command prints a line per channel, for several files or a folder a line per file. It "
        "guesses the kind of a channel from its unit, name and samples; no other command uses this guess. "
        "Exit status 1: one of several files could not be read. Example: emg2vsa inspect recordings --page "
        "look.html",
    )
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recording, or a folder of recordings")
    parser.add_argument(
        "--fs", type=float, metavar="HZ", help="sampling rate in Hz of channels whose file does not state it"
    )
    parser.add_argument("--page", type=Path, metavar="HTML", help="also write a page with pictures of every channel")
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import RecordingError, SettingError
    from emg2vsa.readers.survey import survey

    if arguments.fs is not None and not 0 < arguments.fs < float("inf"):
        raise SettingError("--fs", wanted="a rate above 0 Hz", found=f"{arguments.fs:g}", do="Give the rate in hertz.")
    paths = recordings_in(arguments.files)
    reading = reading_of(arguments, "inspect")
    alone = len(paths) == 1 and not arguments.files[0].is_dir()
    found: list[FileFacts] = []
    refused: list[RecordingError] = []
    outcomes: list[FileFacts | RecordingError] = []
    for path in paths:
        try:
            facts = survey(path, reading, arguments.fs)
            if arguments.page is None and not alone:
                facts = dataclasses.replace(facts, stored=())  # a folder may be larger than the memory
            found.append(facts)
            outcomes.append(facts)
        except RecordingError as error:
            if alone:
                raise
            refused.append(error)
            outcomes.append(error)
    if arguments.json:
        read = [_json(facts) for facts in found]
        unread = [{"file": error.where, "found": error.found, "do": error.do} for error in refused]
        print_json(read[0] if alone else {"files": read, "refused": unread})
    elif alone:
        _print_file(found[0])
    else:
        _print_folder(paths, outcomes)
    if arguments.page is not None:
        from emg2vsa.report.recording_page import recording_page

        write_text_atomic(arguments.page, recording_page(found, [str(error) for error in refused]))
        if not arguments.json:
            print(f"Page: {arguments.page}")
    return int(bool(refused))


def recordings_in(given: Sequence[Path]) -> list[Path]:
    """The files given, and those below folders that may be recordings, in their order. SettingError where none is."""
    from emg2vsa.errors import SettingError

    paths: list[Path] = []
    for path in given:
        paths += _below(path) if path.is_dir() else [path]
    if not paths:
        raise SettingError(
            given[0], wanted="recordings", found="a folder without any", do="Name the folder that holds the files."
        )
    return paths


def _below(folder: Path) -> Iterator[Path]:
    """The files that may be recordings. Folders inside it that hold a report or results of this program have none."""
    from emg2vsa.pipeline.ledger import LEDGER_FILE
    from emg2vsa.pipeline.places import OWNER_FILE

    found = sorted(folder.rglob("*"))
    made = {path.parent for path in found if path.name in (OWNER_FILE, LEDGER_FILE)} - {folder}
    for path in found:
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        named = path.stem.upper().startswith(("LICENSE", "README", "SOURCES"))
        kept = not hidden and not named and path.suffix.lower() not in NOT_RECORDINGS and made.isdisjoint(path.parents)
        if kept and (path.is_file() or not path.exists()):  # a link to nothing is told as unreadable
            yield path


def _json(facts: FileFacts) -> dict[str, Any]:
    channels = [{**vars(channel), "duration_s": channel.duration_s} for channel in facts.channels]
    return {"file": str(facts.path), "format": facts.format, "channels": channels, "notes": list(facts.notes)}


def _print_file(facts: FileFacts) -> None:
    from emg2vsa.report.recording_page import HEADS, cells

    n = len(facts.channels)
    longest = max((c.duration_s for c in facts.channels if c.fs_hz > 0), default=float("nan"))
    print(f"{facts.path}: {facts.format}, {n} channel{'s' if n != 1 else ''}, {longest:.1f} s")
    _print_table([HEADS, *(cells(channel) for channel in facts.channels)], left=(0, 1, len(HEADS) - 1))
    for note in facts.notes:
        print(f"note: {note}")
    if facts.emg and facts.force:
        emg = " ".join(f"--emg {shlex.quote(channel.name)}" for channel in facts.emg[:4])
        sign = " --sign -1" if facts.force.sign < 0 else ""
        print(f"To fit: emg2vsa fit {shlex.quote(str(facts.path))} {emg} --force {shlex.quote(facts.force.name)}{sign}")


def _print_folder(paths: Sequence[Path], outcomes: Sequence[FileFacts | Exception]) -> None:
    from emg2vsa.errors import RecordingError

    rows = [("file", "format", "channels", "seconds", "force", "EMG")]
    for path, outcome in zip(paths, outcomes, strict=True):
        if isinstance(outcome, RecordingError):
            reason = f"{outcome.found}. {outcome.do}"
            rows.append((str(path), "not read", "", "", "", _shortened(reason, _LONGEST_REASON)))
            continue
        assert not isinstance(outcome, Exception)
        longest = max((c.duration_s for c in outcome.channels if c.fs_hz > 0), default=float("nan"))
        emg = [_shortened(channel.name, _LONGEST_NAME) for channel in outcome.emg]
        listed = ", ".join(emg[:3]) + (f" and {len(emg) - 3} more" if len(emg) > 3 else "")
        force, span = outcome.force, "none found"
        if force is not None:
            name = _shortened(force.name, _LONGEST_NAME)
            span = f"{name}: {force.low:.3g} to {force.high:.3g} {force.unit or ''}".rstrip()
        seconds = f"{longest:.1f}" if longest == longest else "rate unknown"
        rows.append((str(path), outcome.format, str(len(outcome.channels)), seconds, span, listed or "none found"))
    _print_table(rows, left=(0, 1, 4, 5))
    bad = sum(isinstance(outcome, Exception) for outcome in outcomes)
    print(f"{len(paths) - bad} of {len(paths)} files read")


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."


def _print_table(rows: Sequence[Sequence[str]], left: Sequence[int]) -> None:
    """Columns as wide as their longest cell; ``left``: those that are no numbers."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        cells = [
            cell.ljust(width) if i in left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())
