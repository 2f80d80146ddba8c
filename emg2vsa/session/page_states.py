"""What the two pages show of a session, made anew whenever something has changed."""

from __future__ import annotations

from typing import Literal

from emg2vsa.session.operator_requests import refusal
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.session import Session
from emg2vsa.session.views import REQUESTS, OperatorState, ParticipantState, Request


def _shown(session: Session) -> tuple[PlannedPress | None, Literal["quality", "training", "main"]]:
    """The press that is under way or comes next, and the phase."""
    press = session.running.press if session.running else session.wanted
    return press, "quality" if not session.quality_done else "main" if press is None else press.phase


def participant_state(session: Session) -> ParticipantState:
    own, (press, phase) = session.settings, _shown(session)
    texts = {name: value for name, value in vars(own.texts).items() if name != "language"}
    command = session.command
    text = texts.get(command, own.texts.wait)
    if session.measuring is not None:
        text = own.texts.contract if session.measuring.step == "contraction" else own.texts.relax
    place = of = 0
    if press is not None and press is session.suggested and session.stay is not None:
        place = of = session.presses.place(session.stay)[1] + 1
    elif press is not None:
        place, of = session.presses.place(press)
    until_s = session.pause_until_s if command == "pause" and session.now_s < session.pause_until_s else None
    return ParticipantState(
        command, text, phase, place, of, own.force_n, own.bar_n, own.load_s, own.palette, own.sound,
        own.texts.language, texts, until_s,
    )  # fmt: skip


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
    (press, phase), ended = _shown(session), session.ended
    possible = (name for name in REQUESTS if name in ("check", "note") or not refusal(session, Request(name)))
    safe = "everything is on the disk" if session.record.is_safe else "the last events are being written"
    return OperatorState(
        participant=session.participant,
        study=session.study.title or session.study.name,
        command=session.command,
        awaits=awaits,
        message=message,
        specimen="" if press is None else press.specimen,
        phase=phase,
        press=session.running.view() if session.running else None,
        presses=session.presses.views(),
        checklist=dict(session.checklist),
        devices=(session.emg.view(session.now_s), session.force.view(session.now_s)),
        signals=session.signals,
        fits=tuple(session.fits.values()),
        warnings=tuple(session.warnings),
        commands=tuple(possible) if ended is None else (),
        saved=f"{session.record.folder}: {session.record.lines} events; {session.record.trouble or safe}.",
        ended=": ".join(filter(None, (ended.how, ended.why))) if ended else "",
    )
