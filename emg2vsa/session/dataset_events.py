"""What happened in a stay at a specimen: commands, presses, pauses, gaps and notes, as events of its recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.arrays import runs_of
from emg2vsa.bids.recording import Event, event_columns
from emg2vsa.bids.tables import Column
from emg2vsa.session.journal import Commanded, Continued, Line, Noted, Paused, Triggered
from emg2vsa.session.presses import Presses, Tried
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
            "gap": "Samples that did not come, of EMG or force as the column reason says; interpolated linearly here.",
            "trigger": "A mark was written to the serial port for other devices; its number is in the column value. "
            "That of the last verdict comes after the end of the recording.",
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
        "reason": Column("Reasons of verdict and decision; of a pause; of a gap the stream: EMG or force."),
        "peak_force": Column("Largest force of the press.", "N"),
        "load_time": Column("Time from the lower to the upper force.", "s"),
        "note": Column("What the operator wrote."),
        "value": Column("Number of the mark of a trigger: the byte, or 1 for a control line."),
    },
)


def stay_events(window: StayWindow, signals: StaySignals, lines: Sequence[Line], presses: Presses) -> list[Event]:
    """In time order, all within the recording, but that a verdict on its last press, and its trigger, come later."""
    last_s = signals.duration_s
    events: list[Event] = []

    def add(kind: str, start_s: float, stop_s: float | None, late: bool = False, /, **cells: object) -> None:
        onset = signals.onset_s(start_s)
        if 0 <= onset < last_s or (kind == "trigger" and onset >= last_s and late):
            length = None if stop_s is None else round(min(signals.onset_s(stop_s), last_s) - onset, 6)
            events.append(Event(round(onset, 6), length, kind, cells))

    for key in window.presses:
        own = presses.find(*key)
        assert own is not None
        start_s, stop_s = (own.begun_s, None) if own.ended is None else (own.ended.start_s, own.ended.stop_s)
        add("press", start_s, stop_s, **_press_cells(own, presses))
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
        elif isinstance(line.event, Triggered):
            late = (line.event.press, line.event.attempt) in window.presses
            add("trigger", line.time_s, None, late, press=line.event.press or "n/a", value=line.event.code)
        elif isinstance(line.event, Noted):
            number = line.event.press or "n/a"
            add("operator_note", line.time_s, None, press=number, note=_cell(line.event.text))
    for missing, fs_hz, stream in (
        (np.any(np.isnan(signals.emg_v), axis=1), signals.emg_fs_hz, "EMG"),
        (np.isnan(signals.force_n), signals.force_fs_hz, "force"),
    ):
        firsts, stops = runs_of(np.asarray(missing))
        for first, stop in zip(firsts.tolist(), stops.tolist(), strict=True):
            events.append(Event(round(first / fs_hz, 6), round((stop - first) / fs_hz, 6), "gap", {"reason": stream}))
    return sorted(events, key=lambda event: event.onset_s)


def _press_cells(tried: Tried, presses: Presses) -> dict[str, object]:
    press, judged, decided = tried.press, tried.judged, tried.decided
    counting = presses.counting.get(press.number)
    problems = "; ".join(found for found, _ in judged.problems) if judged else ""
    if tried.ended is None:
        reason = "interrupted"
    elif judged is None:
        reason = "interrupted before its verdict"
    elif tried.ended.how == "aborted":
        reason = ": ".join(filter(None, ("aborted", problems)))
    elif tried.counts and tried.attempt != counting:
        reason = "; ".join(filter(None, (f"superseded by attempt {counting}", problems)))
    elif decided and decided.decision in ("repeat", "skip"):
        reason = ": ".join(filter(None, (decided.by, decided.decision, decided.reason or problems)))
    else:
        reason = problems
    load_s = judged.values.get("load_s") if judged else None
    peak_n = tried.ended.peak_n if tried.ended else None
    return {
        "specimen": press.specimen, "phase": press.phase, "press": press.number, "repetition": press.repetition,
        "attempt": tried.attempt, "verdict": (judged.verdict if judged else "") or "n/a",
        "decision": tried.decision or "n/a", "counts": "true" if tried.attempt == counting else "false",
        "reason": _cell(reason), "peak_force": "n/a" if peak_n is None else f"{peak_n:.4g}",
        "load_time": "n/a" if load_s is None else f"{load_s:.4g}", "note": _cell("; ".join(tried.notes)),
    }  # fmt: skip


def _cell(text: str) -> str:
    """A text as a cell of a table: no tab and no line feed in it."""
    return " ".join(text.split()) or "n/a"
