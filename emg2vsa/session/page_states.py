"""What the two pages of a session show: functions of its state at a moment."""

from __future__ import annotations

from typing import Literal

from emg2vsa.session.legal import Now, refusal, shown
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.state import SessionState
from emg2vsa.session.views import REQUESTS, OperatorState, ParticipantState, Request


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
