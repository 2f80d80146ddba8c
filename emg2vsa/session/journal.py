"""The journal of a session: a line of JSON for everything that happened, each on the disk itself before the next.

A line holds its number from 1, the sitting (a session that was interrupted and resumed has several, each with a clock
of its own), the time on the session's clock, date and time of day, the kind of the event, what is of its kind, and a
CRC-32 of the text before it. Only the last line can be torn; it is cut off when the journal is opened.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from casr.terminal import finite
from emg2vsa.errors import DataError
from emg2vsa.session.views import ScreenReport
from emg2vsa.session_settings import TriggerMark

JOURNAL_FILE = "journal.jsonl"
Decision = Literal["", "accept", "repeat", "skip"]
Verdict = Literal["ok", "warned", "rejected"]


@dataclass(frozen=True)
class Begun:
    """A sitting begins. resumed : whether an earlier one was interrupted. changes : of the study file since then."""

    participant: str
    study: str
    software: str
    computer: str
    ethics: str = ""
    resumed: bool = False
    changes: tuple[str, ...] = ()


@dataclass(frozen=True)
class StreamOpened:
    """A source delivers. name : of the stream in this sitting. file : of its samples. Then as ``StreamInfo``."""

    name: str
    file: str
    kind: str
    channels: tuple[str, ...]
    unit: str
    fs_hz: float
    range_max: float | None
    delay_s: float
    facts: dict[str, str] = field(default_factory=dict)
    frame: int = 1
    stamped: bool = False


@dataclass(frozen=True)
class ClockFitted:
    """Time of sample i of a stream: start_s + i / fs_hz, to within se_s; the fixed delay is taken off."""

    stream: str
    start_s: float
    fs_hz: float
    se_s: float
    samples: int


@dataclass(frozen=True)
class SamplesLost:
    """Samples of a stream that did not come, or that a full disk did not take."""

    stream: str
    first: int
    count: int
    why: str = ""


@dataclass(frozen=True)
class Commanded:
    """What the participant was told. press, attempt : 0 where it is about none."""

    command: str
    press: int = 0
    attempt: int = 0


@dataclass(frozen=True)
class PressBegun:
    """START was given. number : of the plan; attempt : from 1."""

    press: int
    attempt: int
    specimen: str
    phase: Literal["training", "main"]
    repetition: int
    stay: int


@dataclass(frozen=True)
class PressEnded:
    """The press is over. start_s, stop_s : of the press on the session's clock. how : "complete" or "aborted".

    peak_n : None for a press that was left out before it began. zero_n : mean force before START. lost_share : of the
    samples of the worse stream. age_ms : of the force on the participant's page (95 %), None without a page.
    hidden : whether that page was. uneven : samples came twice, so that their times are not known.
    """

    press: int
    attempt: int
    start_s: float
    stop_s: float
    how: Literal["complete", "aborted"] = "complete"
    peak_n: float | None = None
    load_s: float | None = None
    zero_n: float | None = None
    lost_share: float = 0.0
    age_ms: float | None = None
    hidden: bool = False
    uneven: bool = False


@dataclass(frozen=True)
class Judged:
    """The verdict on the execution of a press. problems : (what was found, what to do).

    samples : of each stream the first one and one past the last one that the judge was given.
    """

    press: int
    attempt: int
    verdict: Verdict
    problems: tuple[tuple[str, str], ...] = ()
    values: dict[str, float | None] = field(default_factory=dict)
    samples: dict[str, tuple[int, int]] = field(default_factory=dict)


@dataclass(frozen=True)
class Decided:
    """What is to become of a press. by : "operator", or "session" for what its settings decide."""

    press: int
    attempt: int
    decision: Decision
    by: Literal["operator", "session"] = "operator"
    reason: str = ""


@dataclass(frozen=True)
class Interrupted:
    """Found on resume: the press ran when the sitting before this one ended. It counts as not done."""

    press: int
    attempt: int


@dataclass(frozen=True)
class PressAdded:
    """A press beyond the plan, as a planned one; why : the rule of ``stop = "width"`` that suggested it."""

    number: int
    phase: Literal["training", "main"]
    specimen: str
    repetition: int
    stay: int
    why: str


@dataclass(frozen=True)
class Noted:
    """A note of the operator. press : 0 where it is about none."""

    text: str
    press: int = 0
    attempt: int = 0


@dataclass(frozen=True)
class Paused:
    """The session rests. why : "operator", ``BETWEEN``, "disk", "device"."""

    why: str


@dataclass(frozen=True)
class Continued:
    """The session goes on after a pause."""


BETWEEN = "between specimens"
"""``Paused`` for the break between two specimens, which ends by itself."""
PLACED = "specimen placed"
"""Item of ``Checked`` when the specimen is on the table, and no hand on it."""


@dataclass(frozen=True)
class Checked:
    """The operator confirmed an item of the checklist, or that a specimen is in place."""

    item: str
    specimen: str = ""


@dataclass(frozen=True)
class Unchecked:
    """The operator took the confirmation of an item of the checklist back."""

    item: str


@dataclass(frozen=True)
class Measuring:
    """The measurement of the signal quality at rest or at maximum contraction begins."""

    step: Literal["rest", "contraction"]


@dataclass(frozen=True)
class QualityMeasured:
    """Signal quality before the session. step : "rest" or "contraction". levels_v : by muscle."""

    step: Literal["rest", "contraction"]
    levels_v: dict[str, float]
    problems: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Triggered:
    """A mark was written to the serial port at the time of the line. code : the byte; 1 for a control line.

    press, attempt : 0 where it is about none.
    """

    mark: TriggerMark
    code: int
    press: int = 0
    attempt: int = 0


@dataclass(frozen=True)
class Told:
    """A message of the session to its operator: a device lost, a disk full, a suggestion."""

    text: str


@dataclass(frozen=True)
class Ended:
    """The sitting ends. how : "completed", "ended" by the operator, "failed"; killed ones have no such line."""

    how: Literal["completed", "ended", "failed"]
    why: str = ""


Event = (
    Begun | StreamOpened | ClockFitted | SamplesLost | Commanded | PressBegun | PressEnded | Judged | Decided
    | Interrupted | PressAdded | Noted | Paused | Continued | Checked | Unchecked | Measuring | QualityMeasured
    | ScreenReport | Triggered | Told | Ended
)  # fmt: skip
KINDS: dict[str, type[Event]] = {
    "begun": Begun, "stream-opened": StreamOpened, "clock-fitted": ClockFitted, "samples-lost": SamplesLost,
    "commanded": Commanded, "press-begun": PressBegun, "press-ended": PressEnded, "judged": Judged, "decided": Decided,
    "interrupted": Interrupted, "press-added": PressAdded, "noted": Noted, "paused": Paused, "continued": Continued,
    "checked": Checked, "unchecked": Unchecked, "measuring": Measuring, "quality-measured": QualityMeasured,
    "screen-told": ScreenReport, "triggered": Triggered, "told": Told, "ended": Ended,
}  # fmt: skip
"""Name in the journal to class."""
_NAMES = {kind: name for name, kind in KINDS.items()}
_SEAL = ', "crc": "'
TIME_DIGITS = 6
"""Decimals of the time of a line."""


@dataclass(frozen=True)
class Line:
    """number : from 1. sitting : from 1. time_s : on the session's clock. at : date and time of day, ISO 8601."""

    number: int
    sitting: int
    time_s: float
    at: str
    event: Event


def line_bytes(line: Line) -> bytes:
    """A line as it stands in the journal. UnicodeEncodeError : one of its texts cannot be written."""
    content = {
        "line": line.number, "sitting": line.sitting, "time_s": round(line.time_s, TIME_DIGITS), "at": line.at,
        "kind": _NAMES[type(line.event)], "event": asdict(line.event),
    }  # fmt: skip
    text = json.dumps(finite(content), ensure_ascii=False, allow_nan=False)[:-1]
    return f'{text}{_SEAL}{zlib.crc32(text.encode()):08x}"}}\n'.encode()


def now_text() -> str:
    """Date and time of day with the zone, to a millisecond."""
    return datetime.now().astimezone().isoformat("T", "milliseconds")


def read_journal(path: Path) -> tuple[tuple[Line, ...], int]:
    """All whole lines, and how many bytes they are: what follows them is a torn last line.

    A number that no line has is passed over, for `gaps` to tell.
    DataError : a line before the last is damaged, out of order, or of a kind that this version does not know.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DataError(
            path, wanted="the journal of a session", found=error.strerror or str(error),
            do="Put the file back from a copy.",
        ) from error  # fmt: skip
    lines: list[Line] = []
    at = 0
    while (end := content.find(b"\n", at) + 1) > 0:
        line = _line(content[at : end - 1], lines[-1].number if lines else 0)
        if isinstance(line, str):
            if b"\n" not in content[end:]:
                break
            raise DataError(
                f"{path}, line {len(lines) + 1}", wanted="a line of the journal that matches its checksum", found=line,
                do="Put the file back from a copy; lines are never changed.",
            )  # fmt: skip
        lines.append(line)
        at = end
    return tuple(lines), at


def gaps(lines: Sequence[Line]) -> list[str]:
    """Numbers that no line of the journal has, each gap in a sentence."""
    numbers = [0, *(line.number for line in lines)]
    return [
        f"The journal has no line between {then} and {number}. All its other lines fit their checksums."
        for then, number in pairwise(numbers)
        if number != then + 1
    ]


def _line(content: bytes, before: int) -> Line | str:
    """The line after one with a number, or what is wrong with it."""
    text, seal, checksum = content.rpartition(_SEAL.encode())
    if not seal or checksum != f'{zlib.crc32(text):08x}"}}'.encode():
        return f"{content[:40]!r}..., which does not"
    try:
        stated: dict[str, Any] = json.loads(text + b"}")
        number, sitting, time_s, at = (stated[key] for key in ("line", "sitting", "time_s", "at"))
        event = KINDS[stated["kind"]](**{key: _as_tuple(value) for key, value in stated["event"].items()})
    except (ValueError, KeyError, TypeError) as error:
        return f"one that this version does not know ({error})"
    if type(number) is not int or number <= before:
        return f"line {number} after line {before}"
    return Line(number, sitting, time_s, at, event)


def _as_tuple(value: Any) -> Any:
    """Arrays of JSON as tuples, as the events have them."""
    if isinstance(value, list):
        return tuple(map(_as_tuple, value))
    return {key: _as_tuple(own) for key, own in value.items()} if isinstance(value, Mapping) else value
