"""The one table of what a session's state allows: what it awaits of the operator, and what it refuses, with the reason.

Several rows may hold at once. The operator sees the first one that says what is going on; a request is refused by the
first one that refuses it, and is legal where none does. What is asked about one press, item or text is looked at after
the table. Below it, what the two pages show: functions of the state at a moment.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.presses import Tried
from emg2vsa.session.state import SessionState
from emg2vsa.session.views import REQUESTS, DeviceView, OperatorState, ParticipantState, Request


@dataclass(frozen=True)
class Now:
    """A state at a moment, with what is known of that beside the journal. time_s : on the session's clock.

    force_n : of the bar. steady : whether the force has been for half a second; None where none came. rest_until_s :
    end of the rest between two presses. lost : a device is. writing : a verdict is on its way to the disk. saved : how
    much is on the disk, in a sentence.
    """

    state: SessionState
    time_s: float
    force_n: float = 0.0
    steady: bool | None = None
    rest_until_s: float = 0.0
    lost: bool = False
    writing: bool = False
    devices: tuple[DeviceView, ...] = ()
    saved: str = ""

    @property
    def measuring(self) -> bool:
        """Whether the signal quality is being measured."""
        own = self.state.measuring
        return own is not None and self.time_s < own.until_s

    @property
    def judging(self) -> bool:
        """Whether a press, or the signal quality, waits for its judge, or a verdict for the disk."""
        return self.state.judging or self.writing or (self.state.measuring is not None and not self.measuring)

    @property
    def rest_measured(self) -> bool:
        own = self.state.measuring
        return self.state.rest_measured or (own is not None and own.step == "rest" and not self.measuring)

    @property
    def break_s(self) -> float:
        """Left of the break between specimens, s."""
        return self.state.break_until_s - self.time_s

    @property
    def rest_s(self) -> float:
        """Left of the rest between presses, s."""
        return self.rest_until_s - self.time_s

    @property
    def suggestion(self) -> str:
        own = self.state.suggested
        return "" if own is None else self.state.fits[own.specimen].suggestion

    @property
    def unchecked(self) -> str:
        return ", ".join(self.state.unchecked)


class Row(NamedTuple):
    """What holds, what is refused meanwhile, and what the operator is to do: its word and a sentence; "" where it says
    nothing of that. ``{now...}`` in a sentence is of `Now`."""

    name: str
    holds: Callable[[Now], bool]
    refuses: Mapping[str, str]
    awaits: str = ""
    message: str = ""


_MEASURE = ("measure-rest", "measure-contraction")
_BUSY = dict.fromkeys((*_MEASURE, "placed"), "A press is under way, or being judged.")
_ABORT_FIRST = dict.fromkeys(("pause", "end"), "A press is under way; abort it first.")
_PAUSED = {"start": "The session is paused; continue first.", "pause": "The session is paused already."}
_JUDGED = _BUSY | {"start": "The last press is being judged."}
_MEASURE_FIRST = {"placed": "Measure the signals at rest and at maximum contraction first, or continue without."}
_NO_PRESS = dict.fromkeys(("placed", "start"), "No press is left.")
TABLE = (
    Row("ended", lambda now: now.state.ended is not None, dict.fromkeys(REQUESTS, "The session has ended."),
        message="The session has ended."),
    Row("measuring", lambda now: now.measuring, dict.fromkeys(_MEASURE, "A measurement is under way."),
        message="The {now.state.measuring.step} is being measured."),
    Row("lost", lambda now: now.lost, dict.fromkeys(_MEASURE, "A device is lost.")
        | {"placed": "The force sensor sends nothing.", "continue": "The device is still lost."} | _PAUSED,
        message="A device is lost."),
    Row("device", lambda now: now.state.paused == "device", _PAUSED, message="The lost device is back. Go on."),
    Row("disk", lambda now: now.state.paused == "disk",
        _PAUSED | {"continue": "The disk does not take the recording. Free some disk space."},
        message="The disk is full."),
    Row("operator", lambda now: bool(now.state.paused), _PAUSED, message="Paused."),
    Row("quality", lambda now: not (now.state.quality_done or now.rest_measured), _MEASURE_FIRST,
        "quality", "Ask the participant to relax the arm, then measure the rest."),
    Row("contraction", lambda now: not now.state.quality_done, _MEASURE_FIRST,
        "contraction", "Ask the participant to tense the forearm for 3 s, then measure."),
    Row("pressing", lambda now: now.state.running is not None,
        _BUSY | _ABORT_FIRST, message="A press is under way."),
    Row("writing", lambda now: now.writing, _JUDGED, message="The verdict is being written to the disk."),
    Row("judging", lambda now: now.judging, _JUDGED, message="The press is being judged."),
    Row("verdict", lambda now: now.state.presses.undecided is not None,
        {"start": "Press {now.state.presses.undecided.press.number} was rejected: repeat, accept or skip it first."},
        "verdict", "Press {now.state.presses.undecided.press.number} is rejected: repeat, accept or skip it."),
    Row("done", lambda now: now.state.wanted is None, _NO_PRESS, "end", "Every press is done. End the session."),
    Row("placing", lambda now: not now.state.here, {"start": "Place specimen {now.state.wanted.specimen} first."},
        "specimen", "Place specimen {now.state.wanted.specimen}. Nobody may touch it when you confirm."),
    Row("checklist", lambda now: bool(now.state.unchecked), {"start": "Confirm first: {now.unchecked}."},
        "checklist", "Confirm the checklist."),
    Row("suggested", lambda now: now.state.suggested is not None, {},
        "start", "{now.suggestion} START for one more, or continue without."),
    Row("break", lambda now: now.break_s > 0, {"start": "The break lasts {now.break_s:.0f} s longer."},
        message="Break: {now.break_s:.0f} s."),
    Row("start", lambda now: True, {},
        "start", "Press {now.state.wanted.number} on {now.state.wanted.specimen}: give START."),
    # what says nothing of itself
    Row("unmeasured", lambda now: not now.rest_measured, {"measure-contraction": "Measure the rest first."}),
    Row("on the table", lambda now: now.state.placed,
        {"measure-rest": "The signals are measured before a specimen is placed."}),
    Row("closed", lambda now: now.state.command not in ("rest", "ready") or now.state.running is not None,
        {"start": "START is not possible while the participant is told {now.state.command!r}."}),
    Row("touched", lambda now: now.force_n > now.state.rules.settings.ready_n,
        {"start": "The force is {now.force_n:.2f} N, above {now.state.rules.settings.ready_n:g} N. "
         "Ask the participant to lift the finger, or place the specimen again to take a new zero."}),
    Row("resting", lambda now: now.rest_s > 0, {"start": "The rest lasts {now.rest_s:.1f} s longer."}),
    Row("silent", lambda now: now.steady is None, {"placed": "The force sensor sends nothing."}),
    Row("unsteady", lambda now: now.steady is False,
        {"placed": "The force is not steady. Take all hands off the specimen."}),
    Row("idle", lambda now: now.state.running is None, {"abort": "No press is under way."}),
    Row("going on", lambda now: not now.state.paused and now.state.suggested is None
        and (now.state.quality_done or now.state.measuring is not None), {"continue": "Nothing is paused."}),
)  # fmt: skip
"""The states that tell the operator something stand in the order in which the operator is to know of them."""


def shown(now: Now) -> Row:
    """What is going on, as the operator is to know it."""
    return next(row for row in TABLE if row.message and row.holds(now))


def refusal(now: Now, request: Request) -> str:
    """Why a request is not possible now, in a sentence; "" where it is."""
    for row in TABLE:
        if request.name in row.refuses and row.holds(now):
            return row.refuses[request.name].format(now=now)
    match request.name:
        case "check" if request.item not in now.state.checklist:
            return f"The checklist has no {request.item!r}, but: {', '.join(now.state.checklist)}."
        case "note":
            return "The note is empty." if not request.text.strip() else _unfit(now, request)
        case "accept" | "repeat" | "skip":
            return _unfit(now, request) or _refuses_decision(now, request)
    return "" if request.name in REQUESTS else f"There is no command {request.name!r}."


def meant(state: SessionState, request: Request) -> Tried | None:
    """The press that a decision or a note is about: the one that is named, the undecided one, or the last."""
    if request.press is not None:
        return state.presses.find(request.press)
    over = [tried for tried in state.presses.tried if tried.over]
    return state.presses.undecided or (over[-1] if over and request.name != "skip" else None)


def _unfit(now: Now, request: Request) -> str:
    """Why a text of the operator cannot be kept, or is about a press that there is not."""
    if not all(sign.isprintable() or sign in "\t\n\r" for sign in request.text):
        return "The text has signs that cannot be written. Type it again."
    known = request.press is None or now.state.presses.find(request.press) is not None
    return "" if known else f"Press {request.press} has not begun."


def _refuses_decision(now: Now, request: Request) -> str:
    state, tried = now.state, meant(now.state, request)
    if tried is None and request.name == "skip":
        possible = state.placed and state.wanted is not None and state.running is None
        return "" if possible else "No press can be skipped now."
    if tried is None or not tried.over:
        return "There is no finished press to decide on."
    number = tried.press.number
    if now.judging:
        return "The last press is being judged."
    if not tried.complete:
        return "" if request.name == "skip" else f"Press {number} was not complete; it is repeated anyway."
    if request.name == "repeat":
        if state.running is not None:
            return "A press is under way."
        if state.stay is None or not state.placed or tried.press.stay != state.stay.stay:
            return f"Specimen {tried.press.specimen} is no longer on the table."
        if tried.verdict == "ok" and not (tried.notes or request.text.strip()):
            return f"Press {number} is well done. To repeat it, give the reason as a note."
        if state.presses.repeats(tried.press) >= (most := state.rules.settings.most_repeats):
            return f"{most} presses on this specimen were repeated, which is the most: accept or skip it."
    return ""


def _shown(state: SessionState) -> tuple[PlannedPress | None, Literal["quality", "training", "main"]]:
    """The press that is under way or comes next, and the phase."""
    press = state.running.press if state.running else state.wanted
    return press, "quality" if not state.quality_done else "main" if press is None else press.phase


def participant_state(now: Now) -> ParticipantState:
    state, own = now.state, now.state.rules.settings
    press, phase = _shown(state)
    texts = {name: value for name, value in vars(own.texts).items() if name != "language"}
    command, text = state.command, texts.get(state.command, own.texts.wait)
    if state.measuring is not None and now.measuring:
        text = own.texts.contract if state.measuring.step == "contraction" else own.texts.relax
    place = of = 0
    if press is not None and press == state.suggested and state.stay is not None:
        place = of = state.presses.place(state.stay)[1] + 1
    elif press is not None:
        place, of = state.presses.place(press)
    until_s = state.break_until_s if command == "pause" and now.break_s > 0 else None
    return ParticipantState(
        command, text, phase, place, of, own.force_n, own.bar_n, own.load_s, own.palette, own.sound,
        own.texts.language, texts, until_s,
    )  # fmt: skip


def operator_state(now: Now) -> OperatorState:
    state = now.state
    row, (press, phase), ended = shown(now), _shown(state), state.ended
    possible = (name for name in REQUESTS if name in ("check", "note") or not refusal(now, Request(name)))
    return OperatorState(
        participant=state.rules.participant,
        study=state.rules.title,
        command=state.command,
        awaits=row.awaits,
        message=row.message.format(now=now),
        specimen="" if press is None else press.specimen,
        phase=phase,
        press=state.running.view() if state.running else None,
        presses=state.presses.views(),
        checklist=dict(state.checklist),
        devices=now.devices,
        signals=state.signals,
        fits=tuple(state.fits.values()),
        warnings=state.warnings,
        commands=tuple(possible) if ended is None else (),
        saved=now.saved,
        ended=": ".join(filter(None, (ended.how, ended.why))) if ended else "",
    )
