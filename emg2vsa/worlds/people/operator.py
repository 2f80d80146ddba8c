"""An emulated operator: asks for what the session awaits, and puts specimens under the participant's finger."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from emg2vsa.session.views import OperatorState, Request

THINKING_S, START_S = 0.3, 1.0
"Between two looks at the page; and from a participant who is ready to START: sooner, no press could be early."


class Asked(Protocol):
    """What the operator works with."""

    def operator(self) -> tuple[int, OperatorState]:
        """The newest state, and its number."""

    def ask(self, request: Request) -> str:
        """Ask for something; why it is refused, or ""."""


class EmulatedOperator:
    """Call ``turn`` often. A rejected press is repeated as long as that is allowed, and accepted then.

    place : puts a specimen on the table. most_presses : ends the session after so many attempts; None: when all are
    done.
    """

    def __init__(self, desk: Asked, place: Callable[[str], None], most_presses: int | None = None) -> None:
        self._desk, self._place, self._most_presses = desk, place, most_presses
        self._seen = -1
        self._act_at_s = 0.0
        self._on_table = ""
        self._ready_s: float | None = None

    def turn(self, now_s: float) -> None:
        """Do what is due."""
        if now_s < self._act_at_s:
            return
        self._act_at_s = now_s + THINKING_S
        _, state = self._desk.operator()
        if state.command != "ready":
            self._ready_s = None
        elif self._ready_s is None:
            self._ready_s = now_s
        if state.ended:
            return
        begun = sum(bool(press.verdict) for press in state.presses)
        if self._most_presses is not None and begun >= self._most_presses and state.awaits != "verdict":
            self._desk.ask(Request("end"))
            return
        match state.awaits:
            case "quality":
                self._desk.ask(Request("measure-rest"))
            case "contraction":
                self._desk.ask(Request("measure-contraction"))
            case "specimen":
                self._put(state.specimen)
            case "checklist":
                for item in (item for item, done in state.checklist.items() if not done):
                    self._desk.ask(Request("check", item=item))
            case "start" if self._ready_s is not None and now_s - self._ready_s >= START_S:
                self._desk.ask(Request("start"))
            case "verdict":
                if self._desk.ask(Request("repeat")):
                    self._desk.ask(Request("accept"))
            case "end":
                self._desk.ask(Request("end"))
            case _ if "continue" in state.commands and state.command == "pause":
                self._desk.ask(Request("continue"))

    def _put(self, specimen: str) -> None:
        """Put it there, and confirm it once the hands are off."""
        if self._on_table != specimen:
            self._on_table = specimen
            self._place(specimen)
        else:
            self._desk.ask(Request("placed"))
