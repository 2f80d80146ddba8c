"""What the operator asks for, carried out where the table of what is legal does not refuse it."""

from __future__ import annotations

from emg2vsa.session import journal
from emg2vsa.session.legal import meant, refusal
from emg2vsa.session.session import Session
from emg2vsa.session.state import NO_QUALITY, goes_on
from emg2vsa.session.views import Request


def ask(session: Session, request: Request) -> str:
    """Take a command: "" when taken, else why not, in a sentence. Any thread may call it."""
    with session.lock:
        refused = refusal(session.now(), request)
        if not refused:
            _carry_out(session, request)
            session.changes += 1
        return refused


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
