"""What happened in a stay at a specimen: commands, presses, pauses, gaps and notes, as events of its recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from emg2vsa.arrays import runs_of
from emg2vsa.bids.recording import Event, event_columns
from emg2vsa.bids.tables import Column
from emg2vsa.session.journal import (
    Commanded,
    Continued,
    Decided,
    Judged,
    Line,
    Noted,
    Paused,
    PressBegun,
    PressEnded,
)
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.record import Progress
from emg2vsa.session.stays import StaySignals, StayWindow

EVENT_COLUMNS = event_columns(
    onset="From the first sample of the recording.",
    duration="Its length; n/a for what has none.",
    kind=Column(
        "What the row is of.",
        levels={
            "command_start": "The screen tells the participant to press.",
            "command_stop": "The screen tells the participant to lift the finger.",
            "press": "One attempt at a press, from the first touch until the finger is lifted.",
            "rest": "Rest between presses.",
            "pause": "The session is paused.",
            "gap": "Samples that did not come; interpolated linearly here.",
            "operator_note": "A note of the operator, in the column note.",
        },
    ),
    own={
        "specimen": Column("The specimen that was pressed."),
        "phase": Column("Practice or not.", levels={"training": "Practice.", "main": "Counts."}),
        "press": Column("Number of the press in the session's order, from 1."),
        "repetition": Column("Number of the press on this specimen, from 1."),
        "attempt": Column("From 1; a press that was not well done is done again."),
        "verdict": Column(
            "Verdict on the execution of the press, given within a second of its end.",
            levels={"ok": "As asked.", "warned": "With a remark.", "rejected": "Not as asked; see reason."},
        ),
        "decision": Column(
            "What the operator decided; n/a where nothing was to be decided.",
            levels={"accept": "Keep it.", "repeat": "Do it again.", "skip": "Go on without it."},
        ),
        "counts": Column(
            "Whether the press is one of the study's, by its execution alone.",
            levels={"true": "It is analysed.", "false": "It is not analysed, for the reason that is given."},
        ),
        "reason": Column("Reasons of verdict and decision."),
        "peak_force": Column("Largest force of the press.", "N"),
        "load_time": Column("Time from the lower to the upper force.", "s"),
        "note": Column("What the operator wrote."),
    },
)


@dataclass
class PressAttempt:
    """One attempt, as the journal has it."""

    begun: PressBegun
    begun_s: float
    ended: PressEnded | None = None
    judged: Judged | None = None
    decided: Decided | None = None
    counts: bool = False
    superseded_by: int | None = None
    "A later attempt that counts."
    notes: list[str] = field(default_factory=list)


def press_attempts(lines: Sequence[Line], planned: tuple[PlannedPress, ...]) -> dict[tuple[int, int], PressAttempt]:
    """Every attempt by press and attempt."""
    found: dict[tuple[int, int], PressAttempt] = {}
    progress = Progress(planned)
    for line in lines:
        progress.take(line)
        event = line.event
        if isinstance(event, PressBegun):
            found[event.press, event.attempt] = PressAttempt(event, line.time_s)
        if isinstance(event, (PressEnded, Judged, Decided, Noted)):
            own = found.get((event.press, event.attempt))
            if own is None:
                continue
            if isinstance(event, PressEnded):
                own.ended = event
            elif isinstance(event, Judged):
                own.judged = event
            elif isinstance(event, Decided):
                own.decided = event
            else:
                own.notes.append(event.text)
    for attempt in progress.attempts:
        own = found[attempt.press, attempt.attempt]
        last = progress.counting.get(attempt.press)
        own.counts = attempt.attempt == last
        own.superseded_by = last if attempt.counts and not own.counts else None
    return found


def stay_events(
    window: StayWindow, signals: StaySignals, lines: Sequence[Line], presses: Mapping[tuple[int, int], PressAttempt]
) -> list[Event]:
    """In time order, all within the recording."""
    last_s = signals.duration_s
    events: list[Event] = []

    def add(kind: str, start_s: float, stop_s: float | None, **cells: object) -> None:
        onset = signals.onset_s(start_s)
        if 0 <= onset < last_s:
            length = None if stop_s is None else round(min(signals.onset_s(stop_s), last_s) - onset, 6)
            events.append(Event(round(onset, 6), length, kind, cells))

    for key in window.presses:
        own = presses[key]
        ended = own.ended
        start_s, stop_s = (own.begun_s, None) if ended is None else (ended.start_s, ended.stop_s)
        add("press", start_s, stop_s, **_press_cells(own))
    named = {"start": "command_start", "stop": "command_stop", "rest": "rest"}
    commands = [line for line in lines if isinstance(line.event, Commanded)]
    for i, line in enumerate(commands):
        assert isinstance(line.event, Commanded)
        if line.event.command in named:
            rests = line.event.command == "rest"
            until_s = commands[i + 1].time_s if rests and i + 1 < len(commands) else None
            add(named[line.event.command], line.time_s, until_s, specimen=window.specimen, phase=window.phase)
    for i, line in enumerate(lines):
        if isinstance(line.event, Paused):
            ends = (after.time_s for after in lines[i:] if isinstance(after.event, Continued))
            add("pause", line.time_s, next(ends, None), reason=_cell(line.event.why))
        elif isinstance(line.event, Noted):
            number = line.event.press or "n/a"
            add("operator_note", line.time_s, None, press=number, note=_cell(line.event.text))
    for missing, fs_hz in (
        (np.any(np.isnan(signals.emg_v), axis=1), signals.emg_fs_hz),
        (np.isnan(signals.force_n), signals.force_fs_hz),
    ):
        firsts, stops = runs_of(np.asarray(missing))
        for first, stop in zip(firsts.tolist(), stops.tolist(), strict=True):
            events.append(Event(round(first / fs_hz, 6), round((stop - first) / fs_hz, 6), "gap"))
    return sorted(events, key=lambda event: event.onset_s)


def _press_cells(press: PressAttempt) -> dict[str, object]:
    begun, judged, decided = press.begun, press.judged, press.decided
    problems = "; ".join(found for found, _ in judged.problems) if judged else ""
    if press.ended is None:
        reason = "interrupted"
    elif judged is None:
        reason = "interrupted before its verdict"
    elif press.ended.how == "aborted":
        reason = ": ".join(filter(None, ("aborted", problems)))
    elif press.superseded_by is not None:
        reason = "; ".join(filter(None, (f"superseded by attempt {press.superseded_by}", problems)))
    elif decided and decided.decision in ("repeat", "skip"):
        reason = ": ".join(filter(None, (decided.by, decided.decision, decided.reason or problems)))
    else:
        reason = problems
    load_s = judged.values.get("load_s") if judged else None
    peak_n = press.ended.peak_n if press.ended else None
    return {
        "specimen": begun.specimen, "phase": begun.phase, "press": begun.press, "repetition": begun.repetition,
        "attempt": begun.attempt, "verdict": (judged.verdict if judged else "") or "n/a",
        "decision": (decided.decision if decided else "") or "n/a", "counts": "true" if press.counts else "false",
        "reason": _cell(reason), "peak_force": "n/a" if peak_n is None else f"{peak_n:.4g}",
        "load_time": "n/a" if load_s is None else f"{load_s:.4g}", "note": _cell("; ".join(press.notes)),
    }  # fmt: skip


def _cell(text: str) -> str:
    """A text as a cell of a table: no tab and no line feed in it."""
    return " ".join(text.split()) or "n/a"
