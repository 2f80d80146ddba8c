"""What the two pages show of a session, made anew whenever something has changed."""

from __future__ import annotations

from emg2vsa.session.operator_requests import refusal
from emg2vsa.session.session import Session
from emg2vsa.session.views import OperatorState, ParticipantState, Request


def participant_state(session: Session) -> ParticipantState:
    own, wanted = session.settings, session.running.press if session.running else session.wanted
    texts = {name: value for name, value in vars(own.texts).items() if name != "language"}
    command = session.command
    text = texts.get(command, own.texts.wait)
    if session.measuring is not None:
        text = own.texts.contract if session.measuring.step == "contraction" else own.texts.relax
    place, of = (0, 0) if wanted is None else session.presses.place(wanted) if wanted is not session.suggested else (
        session.presses.place(session.stay)[1] + 1, session.presses.place(session.stay)[1] + 1,  # type: ignore[arg-type]
    )  # fmt: skip
    phase = "quality" if not session.quality_done else "main" if wanted is None else wanted.phase
    until_s = session.pause_until_s if command == "pause" and session.now_s < session.pause_until_s else None
    return ParticipantState(
        command, text, phase, place, of, own.force_n, own.bar_n, own.load_s, own.palette, own.sound,
        own.texts.language, texts, until_s,
    )  # type: ignore[arg-type]  # fmt: skip


def _awaits(session: Session) -> tuple[str, str]:
    """What the operator is to do now, and the same in a sentence."""
    wanted = session.wanted
    if session.ended is not None:
        return "", "The session has ended."
    if session.measuring is not None:
        return "", f"The {session.measuring.step} is being measured."
    if session.paused:
        return "", {"device": "A device is lost.", "disk": "The disk is full."}.get(session.paused, "Paused.")
    if not session.quality_done:
        if "rest" not in session.measured:
            return "quality", "Ask the participant to relax the arm, then measure the rest."
        return "contraction", "Ask the participant to tense the forearm for 3 s, then measure."
    if session.busy:
        return "", "A press is under way."
    if session.judging:
        return "", "The verdict is being written to the disk." if session.writing else "The press is being judged."
    if (tried := session.presses.undecided) is not None:
        return "verdict", f"Press {tried.press.number} is rejected: repeat, accept or skip it."
    if wanted is None:
        return "end", "Every press is done. End the session."
    if not session.placed:
        return "specimen", f"Place specimen {wanted.specimen}. Nobody may touch it when you confirm."
    if not session.all_checked:
        return "checklist", "Confirm the checklist."
    if wanted is session.suggested:
        return "start", f"{session.fits[wanted.specimen].suggestion} START for one more, or continue without."
    if session.now_s < session.pause_until_s:
        return "", f"Break: {session.pause_until_s - session.now_s:.0f} s."
    return "start", f"Press {wanted.number} on {wanted.specimen}: give START."


def operator_state(session: Session) -> OperatorState:
    awaits, message = _awaits(session)
    wanted = session.running.press if session.running else session.wanted
    now_s = session.now_s
    names = (
        "measure-rest", "measure-contraction", "placed", "start", "abort", "accept", "repeat", "skip", "pause",
        "continue", "end",
    )  # fmt: skip
    possible = [name for name in names if not refusal(session, Request(name))] + ["check", "note"]
    running = session.running.view() if session.running else None
    safe = "everything is on the disk" if session.record.is_safe else "the last events are being written"
    return OperatorState(
        participant=session.participant,
        study=session.study.title or session.study.name,
        command=session.command,
        awaits=awaits,
        message=message,
        specimen="" if wanted is None else wanted.specimen,
        phase="quality" if not session.quality_done else "main" if wanted is None else wanted.phase,
        press=running,
        presses=session.presses.views(),
        checklist=dict(session.checklist),
        devices=(session.emg.view(now_s), session.force.view(now_s)),
        signals=session.signals,
        fits=tuple(session.fits.values()),
        warnings=tuple(session.warnings),
        commands=tuple(possible) if session.ended is None else (),
        saved=f"{session.record.folder}: {session.record.lines} events; {session.record.trouble or safe}.",
        ended=""
        if session.ended is None
        else f"{session.ended.how}{': ' if session.ended.why else ''}{session.ended.why}",
    )
