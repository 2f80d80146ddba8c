"""What the pages see of a running session: its newest views, and its ear for what the operator asks for."""

from __future__ import annotations

from collections.abc import Callable

from emg2vsa.devices.clock import Beat, Clock, LoopTiming
from emg2vsa.session import journal
from emg2vsa.session.legal import meant, operator_state, participant_state, refusal
from emg2vsa.session.session import TURN_S, Session
from emg2vsa.session.state import NO_QUALITY, goes_on
from emg2vsa.session.views import (
    ForceMessage,
    OperatorState,
    ParticipantState,
    Request,
    ScreenReport,
    TraceMessage,
)

STATE_S = 1.0
"Devices are looked at so often, though nothing has happened."


class SessionDesk:
    """What a session offers to its pages. Views are whole objects that are replaced, never changed.

    ``turn`` belongs to one thread; every other method may be called from any, and none waits.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._shown = -1
        self._next_s = 0.0
        self._participant, state = self._states()
        self._operator = (1, state)

    def turn(self, now_s: float) -> None:
        """A turn of the session, and what the pages show after it."""
        session = self.session
        with session.lock:
            session.turn(now_s)
            if session.changes == self._shown and now_s < self._next_s:
                return
            self._shown, self._next_s = session.changes, now_s + STATE_S
            self._participant, state = self._states()
        number, before = self._operator
        if state != before:
            self._operator = (number + 1, state)

    def _states(self) -> tuple[ParticipantState, OperatorState]:
        now = self.session.now()
        return participant_state(now), operator_state(now)

    def run(self, clock: Clock, beside: Callable[[float], None] = lambda now_s: None) -> LoopTiming:
        """Turn until the session has ended. beside : called after each turn with the time, s, as by an emulated
        operator."""
        beat = Beat(clock, TURN_S)
        while self.session.state.ended is None:
            now_s, _ = beat.wait()
            self.turn(now_s)
            beside(now_s)
        return beat.timing()

    def participant(self) -> ParticipantState:
        """The newest."""
        return self._participant

    def force(self) -> ForceMessage:
        """The newest."""
        return self.session.force_message

    def operator(self) -> tuple[int, OperatorState]:
        """A number that grows with every change, and the state."""
        return self._operator

    def traces(self, after: int) -> tuple[int, TraceMessage]:
        """What has come after the trace message numbered ``after`` (0: the last ten seconds), and the new number."""
        return self.session.traces.after(after)

    def ask(self, request: Request) -> str:
        """Take a command: "" when taken, else why not, in a sentence."""
        session = self.session
        with session.lock:
            refused = refusal(session.now(), request)
            if not refused:
                _carry_out(session, request)
                session.changes += 1
            return refused

    def screen(self, report: ScreenReport) -> None:
        """Keep what the participant's page says of itself."""
        self.session.screen(report)


def _carry_out(session: Session, request: Request) -> None:
    state, text = session.state, request.text.strip()
    match request.name:
        case "measure-rest" | "measure-contraction":
            session.measure(request.name.removeprefix("measure-"))
        case "check" if state.checklist[request.item]:
            session.write(journal.Unchecked(request.item))
        case "check":
            session.write(journal.Checked(request.item, state.wanted.specimen if state.wanted else ""))
        case "placed":
            session.place()
        case "start":
            session.cycle.start(session.now_s, session.recent.mean_n - session.bar.zero_n)
            session.bar.restart_peak()
            assert session.cycle.attempt is not None
            session.press_begun(session.cycle.attempt)
        case "abort":
            if (attempt := session.cycle.give_up(session.now_s, "aborted", "")) is not None:
                session.over(attempt)
        case "accept" | "repeat" | "skip":
            _decide(session, request)
        case "note":
            tried = meant(state, request)
            session.write(journal.Noted(text, *(tried.key if tried else ())))
        case "pause":
            session.write(journal.Paused("operator"))
        case "continue" if state.paused:
            session.write(journal.Continued())
        case "continue":
            session.write(journal.Told(goes_on(state.suggested.specimen) if state.suggested else NO_QUALITY))
        case "end":
            session.closing = True


def _decide(session: Session, request: Request) -> None:
    state, text = session.state, request.text.strip()
    if (tried := meant(state, request)) is not None:
        key = tried.key
    elif state.suggested is not None:
        session.write(journal.Told(goes_on(state.suggested.specimen)))
        return
    else:  # a press that is not begun is skipped
        press = state.wanted
        assert press is not None
        session.write(begun := state.presses.begin(press))
        key = begun.press, begun.attempt
        session.write(journal.PressEnded(*key, session.now_s, session.now_s, "aborted"))
    decision: journal.Decision = request.name  # type: ignore[assignment]
    if text:
        session.write(journal.Noted(text, *key))
    before = session.state
    session.write(journal.Decided(*key, decision, "operator", text))
    session.tell_suggestion(before)
