"""What recordings hold, and what each channel probably is: in lines for people, and for programs."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from emg2vsa.errors import RecordingError
from emg2vsa.readers.survey import FileFacts
from emg2vsa.report.recording_page import HEADS, cells

_LONGEST_REASON, _LONGEST_NAME = 120, 24


def as_json(facts: FileFacts) -> dict[str, Any]:
    """One file."""
    channels = [{**vars(channel), "duration_s": channel.duration_s} for channel in facts.channels]
    return {"file": str(facts.path), "format": facts.format, "channels": channels, "notes": list(facts.notes)}


def file_lines(facts: FileFacts) -> Iterator[str]:
    """A line per channel."""
    n = len(facts.channels)
    yield f"{facts.path}: {facts.format}, {n} channel{'s' if n != 1 else ''}, {_longest_s(facts):.1f} s"
    yield from _table([HEADS, *(cells(channel) for channel in facts.channels)], left=(0, 1, len(HEADS) - 1))
    yield from (f"note: {note}" for note in facts.notes)
    if facts.emg and facts.force:
        emg = " ".join(f"--emg {shlex.quote(channel.name)}" for channel in facts.emg[:4])
        sign = " --sign -1" if facts.force.sign < 0 else ""
        yield f"To fit: emg2vsa fit {shlex.quote(str(facts.path))} {emg} --force {shlex.quote(facts.force.name)}{sign}"


def folder_lines(paths: Sequence[Path], outcomes: Sequence[FileFacts | RecordingError]) -> Iterator[str]:
    """A line per file; outcomes : what each holds, or why it cannot be read."""
    rows: list[Sequence[str]] = [("file", "format", "channels", "seconds", "force", "EMG")]
    for path, outcome in zip(paths, outcomes, strict=True):
        if isinstance(outcome, RecordingError):
            reason = f"{outcome.found}. {outcome.do}"
            rows.append((str(path), "not read", "", "", "", _shortened(reason, _LONGEST_REASON)))
        else:
            rows.append((str(path), *_cells(outcome)))
    yield from _table(rows, left=(0, 1, 4, 5))
    bad = sum(isinstance(outcome, RecordingError) for outcome in outcomes)
    yield f"{len(paths) - bad} of {len(paths)} files read"


def _cells(facts: FileFacts) -> tuple[str, ...]:
    longest_s, force, span = _longest_s(facts), facts.force, "none found"
    emg = [_shortened(channel.name, _LONGEST_NAME) for channel in facts.emg]
    listed = ", ".join(emg[:3]) + (f" and {len(emg) - 3} more" if len(emg) > 3 else "")
    if force is not None:
        name = _shortened(force.name, _LONGEST_NAME)
        span = f"{name}: {force.low:.3g} to {force.high:.3g} {force.unit or ''}".rstrip()
    seconds = f"{longest_s:.1f}" if longest_s == longest_s else "rate unknown"
    return facts.format, str(len(facts.channels)), seconds, span, listed or "none found"


def _longest_s(facts: FileFacts) -> float:
    return max((channel.duration_s for channel in facts.channels if channel.fs_hz > 0), default=float("nan"))


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."


def _table(rows: Sequence[Sequence[str]], left: Sequence[int]) -> Iterator[str]:
    """Columns as wide as their longest cell; ``left``: those that are no numbers."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        cut = (c.ljust(w) if i in left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True)))
        yield "  ".join(cut).rstrip()
