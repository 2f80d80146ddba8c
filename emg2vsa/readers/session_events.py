"""A recording that a session of emg2vsa made: ``_events.tsv`` says which presses count, and where samples were lost.

Known by its columns ``counts`` and ``decision``, which no other program writes; any other events file is not looked at.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from emg2vsa.errors import RecordingError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.reasons import by_session
from emg2vsa.recordings import Channel

_COLUMNS = ("onset", "duration", "trial_type", "counts", "decision", "reason")
_NOT_ASKED_FOR = "not a press that the screen asked for"


class SessionPress(NamedTuple):
    """An attempt at a press, seconds from the first sample. reason : why it does not count."""

    start_s: float
    stop_s: float
    counts: bool
    reason: str


def session_presses(path: Path) -> tuple[SessionPress, ...]:
    """The attempts in the events file of a session. RecordingError where a row cannot be read."""
    return tuple(_press(path, number, row) for number, row in _rows(path) if row.get("trial_type") == "press")


def with_gaps(path: Path, stream: str, channel: Channel) -> Channel:
    """The channel with NaN where the events file has a gap of its ``stream``, "EMG" or "force": the recording holds a
    line there, rounded to the digits of the file. RecordingError as `session_presses`."""
    samples = channel.samples
    for number, row in _rows(path):
        if row.get("trial_type") == "gap" and row.get("reason") == stream:
            gap = _press(path, number, {**row, "counts": "false"})
            samples = samples.copy() if samples is channel.samples else samples
            samples[round(gap.start_s * channel.fs_hz) : round(gap.stop_s * channel.fs_hz)] = np.nan
    return channel if samples is channel.samples else replace(channel, samples=samples)


def _rows(path: Path) -> list[tuple[int, dict[str, str]]]:
    """The rows of an events file, each with its line."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return list(enumerate(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE), 2))
    except (OSError, ValueError, csv.Error) as error:
        raise RecordingError(
            path, wanted="the events of a session", found=str(error), do="Write them again: emg2vsa session finish."
        ) from error


def _press(path: Path, line: int, row: dict[str, str]) -> SessionPress:
    try:
        onset_s = float(row["onset"])
        duration_s = math.inf if row["duration"] == "n/a" else float(row["duration"])
        counts = {"true": True, "false": False}[row["counts"]]
        reason = row["reason"]
    except (ValueError, KeyError, TypeError) as error:
        missing = [name for name in _COLUMNS if row.get(name) is None]
        raise RecordingError(
            f"{path}, line {line}", wanted="onset and duration in seconds, and counts true or false",
            found=f"no {', '.join(missing)}" if missing else str(error), do="Correct the line.",
        ) from error  # fmt: skip
    return SessionPress(onset_s, onset_s + duration_s, counts, "not well done" if reason == "n/a" else reason)


def only_counted(trials: Trials, presses: Sequence[SessionPress]) -> Trials:
    """The trials with those rejected that do not count in the session: the attempt that a trial shares most of its time
    with does not, or there is none."""
    verdicts, reasons = trials.verdict.tolist(), list(trials.reasons)
    for i, (start_s, stop_s) in enumerate(zip(trials.start_s.tolist(), trials.stop_s.tolist(), strict=True)):
        within = [(min(stop_s, own.stop_s) - max(start_s, own.start_s), own) for own in presses]
        longest_s, own = max(within, key=lambda pair: pair[0], default=(0.0, None))
        if own is not None and longest_s > 0 and own.counts:
            continue
        said = by_session(own.reason if own is not None and longest_s > 0 else _NOT_ASKED_FOR)
        verdicts[i] = "rejected"
        told = not reasons[i] or reasons[i].replace("; ", ", ") in said
        reasons[i] = said if told else f"{said}; {reasons[i]}"
    return replace(trials, verdict=np.array(verdicts, dtype="<U8"), reasons=tuple(reasons))
