"""What the two pages of a session show, and what the operator's page may ask for: plain data, sent as JSON.

The participant's view says nothing of the specimen. Names of fields are the names in the JSON.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

Command = Literal["wait", "ready", "start", "press", "stop", "rest", "pause", "done"]
"""Task of the participant. start: the finger is not yet on the specimen; press: force rises; stop: lift it."""
Direction = Literal["none", "rising", "steady", "falling"]
DEVICE_NAMES = {"emg": "EMG", "force": "Force"}
"""Names of the streams on the pages."""
Speed = Literal["", "too slow", "too fast"]


class ForceMessage(NamedTuple):
    """200 times a second: the newest force. sequence : of the message; time_s : on the session's clock.

    command_s : when the command was given.
    """

    sequence: int
    time_s: float
    force_n: float
    direction: Direction
    speed: Speed
    command: Command
    command_s: float = 0.0


@dataclass(frozen=True)
class ParticipantState:
    """Whenever it changes, and first of all to a page that connects. phase : practice or the real thing.

    press, presses : number of the press of all of this phase. remaining_s : of a pause, on the clock's ``time_s``.
    """

    command: Command
    text: str
    phase: Literal["quality", "training", "main"]
    press: int
    presses: int
    force_n: tuple[float, float]
    bar_n: float
    load_s: tuple[float, float]
    palette: Literal["paper", "safe"]
    sound: bool
    language: str
    texts: dict[str, str] = field(default_factory=dict)
    pause_until_s: float | None = None


@dataclass(frozen=True)
class PressView:
    """A press in the operator's list. number : in the order of pressing, from 1; attempt : from 1.

    verdict : "", while it is planned or runs; "ok", "warned" or "rejected". decision : "", "repeat", "accept", "skip".
    problems : (what was found, what to do).
    """

    number: int
    specimen: str
    phase: Literal["training", "main"]
    repetition: int
    attempt: int
    verdict: str = ""
    decision: str = ""
    problems: tuple[tuple[str, str], ...] = ()
    peak_n: float | None = None
    load_s: float | None = None
    note: str = ""


@dataclass(frozen=True)
class DeviceView:
    """A stream beside its promises. state : "good", "doubtful" or "lost"; text : the same in a sentence."""

    name: str
    state: Literal["good", "doubtful", "lost"]
    text: str
    fs_hz: float
    measured_hz: float | None
    clock_se_s: float | None
    samples: int
    lost: int


@dataclass(frozen=True)
class SignalView:
    """Signal quality of a muscle. rest_v, contraction_v : mean level at rest and at maximum contraction."""

    muscle: str
    rest_v: float | None = None
    contraction_v: float | None = None
    snr_db: float | None = None
    problems: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class SpecimenFit:
    """After a specimen: presses used, mean b and its interval, volts per ln N. suggestion : if stop = "width"."""

    specimen: str
    presses: int
    b_v: float
    low_v: float
    high_v: float
    suggestion: str = ""


@dataclass(frozen=True)
class OperatorState:
    """Whenever something in it changes, and first of all to a page that connects.

    awaits : what the operator is to do now: "quality", "contraction", "checklist", "specimen", "start", "verdict",
    "end"; "" for nothing. specimen : the one to place next, or on the table. checklist : item to whether it is done.
    commands : names of the commands that would be taken now.
    """

    participant: str
    study: str
    command: Command
    awaits: str
    message: str
    specimen: str
    phase: Literal["quality", "training", "main"]
    press: PressView | None
    presses: tuple[PressView, ...] = ()
    checklist: dict[str, bool] = field(default_factory=dict)
    devices: tuple[DeviceView, ...] = ()
    signals: tuple[SignalView, ...] = ()
    fits: tuple[SpecimenFit, ...] = ()
    warnings: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()
    saved: str = ""
    "Where, and how much, in a sentence."
    ended: str = ""
    "How the session ended; empty while it goes on."


@dataclass(frozen=True)
class TraceMessage:
    """About 20 times a second to the operator: what came since the last one, thinned for the eye.

    time_s : (k,) on the session's clock. force_n : (k,). envelopes_v, low_v, high_v : muscle to (k,): envelope, and the
    smallest and largest raw sample around each time.
    """

    time_s: list[float]
    force_n: list[float]
    envelopes_v: dict[str, list[float]]
    low_v: dict[str, list[float]]
    high_v: dict[str, list[float]]


@dataclass(frozen=True)
class Request:
    """A command of the operator's page. name : one of ``REQUESTS``; press : number of the press it is about.

    item : of the checklist. text : of a note.
    """

    name: str
    press: int | None = None
    item: str = ""
    text: str = ""


REQUESTS = (
    "measure-rest", "measure-contraction", "check", "placed", "start", "abort", "accept", "repeat", "skip", "note",
    "pause", "continue", "end",
)  # fmt: skip


@dataclass(frozen=True)
class ScreenReport:
    """Once a second from the participant's page, for the record. age_ms : of the force when it was drawn.

    command_ms : of each new command, from the session to the frame that shows it, by the page's own frame times.
    """

    frames_per_s: float
    age_p50_ms: float
    age_p95_ms: float
    longest_frame_ms: float
    hidden: bool
    more: dict[str, Any] = field(default_factory=dict)
    "Size of the screen, pixel ratio, refresh rate."
    command_ms: tuple[float, ...] = ()
