"""What the operator asks for: whether it is possible now, why not, and what it does."""

from __future__ import annotations

import numpy as np

from emg2vsa.session import journal
from emg2vsa.session.press_list import Tried
from emg2vsa.session.session import Session
from emg2vsa.session.views import Request

STEADY_N = 0.2
"The force must not change by more while its zero is taken."


def ask(session: Session, request: Request) -> str:
    """Take a command: "" when taken, else why not, in a sentence. Any thread may call it."""
    with session.lock:
        refused = refusal(session, request)
        if not refused:
            _carry_out(session, request)
            session.changes += 1
        return refused


def refusal(session: Session, request: Request) -> str:
    if session.ended is not None:
        return "The session has ended."
    match request.name:
        case "measure-rest" | "measure-contraction":
            return _refuses_measuring(session, request.name)
        case "check":
            known = ", ".join(session.checklist)
            return "" if request.item in session.checklist else f"The checklist has no {request.item!r}, but: {known}."
        case "placed":
            return _refuses_placing(session)
        case "start":
            return _refuses_start(session)
        case "abort":
            return "" if session.cycle.attempt is not None else "No press is under way."
        case "accept" | "repeat" | "skip":
            return _refuses_decision(session, request)
        case "note":
            return _refuses_note(session, request)
        case "pause":
            if session.paused:
                return "The session is paused already."
            return "A press is under way; abort it first." if session.busy else ""
        case "continue":
            return _refuses_continuing(session)
        case "end":
            return "A press is under way; abort it first." if session.busy else ""
    return f"There is no command {request.name!r}."


def _refuses_measuring(session: Session, name: str) -> str:
    if session.busy or session.judging:
        return "A press is under way, or being judged."
    if session.measuring is not None:
        return "A measurement is under way."
    if session.placed and name == "measure-rest":
        return "The signals are measured before a specimen is placed."
    if session.lost:
        return "A device is lost."
    return "Measure the rest first." if name == "measure-contraction" and "rest" not in session.measured else ""


def _refuses_placing(session: Session) -> str:
    if not session.quality_done:
        return "Measure the signals at rest and at maximum contraction first, or continue without."
    if session.busy or session.judging:
        return "A press is under way, or being judged."
    if session.wanted is None:
        return "No press is left."
    if session.lost or not session.recent:
        return "The force sensor sends nothing."
    newton = np.concatenate([newton for _, newton in session.recent])
    size = max(1, newton.size // 10)
    means = newton[: newton.size // size * size].reshape(-1, size).mean(axis=1)
    if not np.isfinite(means).all() or float(np.ptp(means)) > STEADY_N:
        return "The force is not steady. Take all hands off the specimen."
    return ""


def _refuses_start(session: Session) -> str:
    if session.paused:
        return "The session is paused; continue first."
    if session.judging:
        return "The last press is being judged."
    if (tried := session.presses.undecided) is not None:
        return f"Press {tried.press.number} was rejected: repeat, accept or skip it first."
    wanted = session.wanted
    if wanted is None:
        return "No press is left."
    if not session.placed or session.stay is None or wanted.stay != session.stay.stay:
        return f"Place specimen {wanted.specimen} first."
    if not session.all_checked:
        return f"Confirm first: {', '.join(item for item, done in session.checklist.items() if not done)}."
    if session.now_s < session.pause_until_s:
        return f"The break lasts {session.pause_until_s - session.now_s:.0f} s longer."
    return session.cycle.refuses_start(session.now_s, session.bar.force_n)


def _refuses_decision(session: Session, request: Request) -> str:
    if unfit := _unfit(request.text) or _not_begun(session, request):
        return unfit
    tried = _meant(session, request)
    if tried is None and request.name == "skip":
        return (
            "" if session.placed and session.wanted is not None and not session.busy else "No press can be skipped now."
        )
    if tried is None or not tried.over:
        return "There is no finished press to decide on."
    number = tried.press.number
    if session.judging:
        return "The last press is being judged."
    if not tried.complete:
        return "" if request.name == "skip" else f"Press {number} was not complete; it is repeated anyway."
    if request.name == "repeat":
        if session.busy:
            return "A press is under way."
        if session.stay is None or not session.placed or tried.press.stay != session.stay.stay:
            return f"Specimen {tried.press.specimen} is no longer on the table."
        if tried.verdict == "ok" and not (tried.note or request.text.strip()):
            return f"Press {number} is well done. To repeat it, give the reason as a note."
        if session.presses.repeats(tried.press) >= session.settings.most_repeats:
            most = session.settings.most_repeats
            return f"{most} presses on this specimen were repeated, which is the most: accept or skip it."
    return ""


def _refuses_note(session: Session, request: Request) -> str:
    if not request.text.strip():
        return "The note is empty."
    return _unfit(request.text) or _not_begun(session, request)


def _unfit(text: str) -> str:
    """Why a text of the operator cannot be kept, or ""."""
    if all(sign.isprintable() or sign in "\t\n\r" for sign in text):
        return ""
    return "The text has signs that cannot be written. Type it again."


def _not_begun(session: Session, request: Request) -> str:
    if request.press is None or session.presses.find(request.press) is not None:
        return ""
    return f"Press {request.press} has not begun."


def _refuses_continuing(session: Session) -> str:
    if session.paused == "device" and session.lost:
        return "The device is still lost."
    if session.paused == "disk":
        return "The disk does not take the recording. Free some disk space."
    if session.paused or session.suggested is not None:
        return ""
    return (
        ""
        if not session.quality_done and session.measuring is None and not session.judge.asked
        else "Nothing is paused."
    )


def _meant(session: Session, request: Request) -> Tried | None:
    """The press that a decision is about: the one that is named, the undecided one, or the last."""
    if request.press is not None:
        return session.presses.find(request.press)
    over = [tried for tried in session.presses.tried if tried.over]
    return session.presses.undecided or (over[-1] if over and request.name != "skip" else None)


def _carry_out(session: Session, request: Request) -> None:
    match request.name:
        case "measure-rest" | "measure-contraction":
            session.measure(request.name.removeprefix("measure-"))
        case "check":
            session.checklist[request.item] = not session.checklist[request.item]
            if session.checklist[request.item]:
                session.write(journal.Checked(request.item, session.wanted.specimen if session.wanted else ""))
        case "placed":
            session.place()
        case "start":
            session.cycle.start(session.now_s, session.mean_force() - session.bar.zero_n)
            session.bar.restart_peak()
            assert session.cycle.attempt is not None
            session.press_begun(session.cycle.attempt)
        case "abort":
            if (attempt := session.cycle.give_up(session.now_s, "aborted", "")) is not None:
                session.over(attempt)
        case "accept" | "repeat" | "skip":
            _decide(session, request)
        case "note":
            tried = _meant(session, request)
            press, attempt_number = (tried.press.number, tried.attempt) if tried else (0, 0)
            session.write(journal.Noted(request.text.strip(), press, attempt_number))
        case "pause":
            session.pause("operator")
        case "continue":
            _continue(session)
        case "end":
            session.closing = "ended"


def _decide(session: Session, request: Request) -> None:
    tried = _meant(session, request)
    if tried is None:  # a press that is not begun is skipped
        press = session.wanted
        assert press is not None
        if press is session.suggested:
            session.declined.add(press.specimen)
            session.suggested = None
            return
        number = session.presses.attempts(press) + 1
        session.write(
            journal.PressBegun(press.number, number, press.specimen, press.phase, press.repetition, press.stay)
        )
        session.write(journal.PressEnded(press.number, number, session.now_s, session.now_s, "aborted"))
        tried = session.presses.find(press.number, number)
        assert tried is not None
    decision: journal.Decision = request.name  # type: ignore[assignment]
    if request.text.strip():
        session.write(journal.Noted(request.text.strip(), tried.press.number, tried.attempt))
    session.write(journal.Decided(tried.press.number, tried.attempt, decision, "operator", request.text.strip()))
    if session.stay is not None:
        session.renew_fits()


def _continue(session: Session) -> None:
    if session.paused:
        session.go_on()
    elif session.suggested is not None:
        session.write(journal.Told(f"{session.suggested.specimen}: the operator goes on without a further press."))
        session.declined.add(session.suggested.specimen)
        session.suggested = None
    else:
        session.write(journal.Told("The session begins without a measurement of the signal quality."))
        session.quality_done = True
