"""What the pages see of a session: its newest views, and its ear. Nothing here waits for a turn to end but a request."""

from __future__ import annotations

from emg2vsa.session.run import Session
from emg2vsa.session.views import (
    ForceMessage,
    OperatorState,
    ParticipantState,
    Request,
    ScreenReport,
    TraceMessage,
)


class SessionDesk:
    """`emg2vsa.session.views.Desk` of a running session. Views are whole objects that are replaced, never changed."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def participant(self) -> ParticipantState:
        """The newest."""
        return self._session.participant_state

    def force(self) -> ForceMessage:
        """The newest."""
        return self._session.force_message

    def operator(self) -> tuple[int, OperatorState]:
        """A number that grows with every change, and the state."""
        return self._session.operator_state

    def traces(self, after: int) -> tuple[int, TraceMessage]:
        """What has come after the trace message numbered ``after``, and the new number."""
        return self._session.traces.after(after)

    def ask(self, request: Request) -> str:
        """Take a command: "" when taken, else why not."""
        return self._session.ask(request)

    def screen(self, report: ScreenReport) -> None:
        """Keep what the participant's page says of itself."""
        self._session.screen(report)
