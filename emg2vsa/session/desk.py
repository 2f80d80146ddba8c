"""What the pages see of a running session: its newest views, and its ear."""

from __future__ import annotations

from collections.abc import Callable

from emg2vsa.devices.clock import Beat, Clock, LoopTiming
from emg2vsa.session.operator_requests import ask
from emg2vsa.session.page_states import operator_state, participant_state
from emg2vsa.session.session import TURN_S, Session
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
    """`emg2vsa.session.views.Desk` of a session. Views are whole objects that are replaced, never changed.

    ``turn`` belongs to one thread; every other method may be called from any.
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
        """Turn until the session has ended. beside : called after each turn, as by an emulated operator."""
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
        """What has come after the trace message numbered ``after``, and the new number."""
        return self.session.traces.after(after)

    def ask(self, request: Request) -> str:
        """Take a command: "" when taken, else why not."""
        return ask(self.session, request)

    def screen(self, report: ScreenReport) -> None:
        """Keep what the participant's page says of itself."""
        self.session.screen(report)
