"""One press after another: what the participant is told, from the force of the bar and the operator's word."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from emg2vsa.session.views import Command, Speed
from emg2vsa.session_settings import SessionSettings

LIFTED_S = 0.1
"The finger has been lifted when the force has stayed low for so long ..."
RELEASED_S = 0.3
"... and before STOP, when a bounce of the finger is still the same press, for so long."
SPEED_FROM_N = 0.3
"The speed is judged once the force has risen by so much over the lower force."

Ending = Literal["lifted", "released", "not begun", "aborted", "interrupted"]
"""How an attempt ended. released: before STOP. interrupted: a device was lost, or the session ended."""


@dataclass
class Attempt:
    """One try at a press; times in seconds on the session's clock, None while it has not happened.

    start_s : START, or for an early press when it began. begun_s : force at the lower force. stop_s : STOP.
    end_s : the finger was lifted, or the attempt was given up. zero_n : mean force before START.
    """

    start_s: float
    early: bool = False
    begun_s: float | None = None
    stop_s: float | None = None
    end_s: float | None = None
    peak_n: float = 0.0
    zero_n: float = 0.0
    ending: Ending | None = None
    why: str = ""

    @property
    def reaction_s(self) -> float | None:
        """Time from START to the lower force, s; None for an early press or before it."""
        return None if self.early or self.begun_s is None else self.begun_s - self.start_s


class PressCycle:
    """Commands from wait to stop and back to rest, while a specimen is there to be pressed.

    ``turn`` is called with every new force, and hands over an attempt once it has ended.
    """

    def __init__(self, settings: SessionSettings, longest_s: float) -> None:
        """longest_s : after so long a press is told to stop."""
        self._settings, self._longest_s = settings, longest_s
        self.command: Command = "wait"
        self.attempt: Attempt | None = None
        self.hold = False
        "The rest goes on: the operator has something to do first."
        self.between = False
        "The specimen has been pressed while the operator has something to do first: no attempt, until it is let go."
        self.rest_until_s = 0.0
        "START is not given sooner."
        self._low_since_s: float | None = None

    # what the operator decides

    def open(self, now_s: float, rest_s: float = 0.0) -> None:
        """A specimen is there: presses may be asked for after a rest."""
        self.command, self.rest_until_s = "rest", now_s + rest_s
        self._low_since_s = None

    def close(self, command: Command) -> None:
        """No presses: wait, pause or done."""
        self.command = command

    def start(self, now_s: float, zero_n: float) -> None:
        """START at ``now_s``, s. zero_n : mean force before, N."""
        self.command, self.between = "start", False
        self.attempt = Attempt(now_s, zero_n=zero_n, peak_n=zero_n)
        self._low_since_s = None

    def give_up(self, now_s: float, ending: Ending, why: str) -> Attempt | None:
        """End the attempt at ``now_s``, s; the participant is told to lift the finger."""
        ended = self._end(now_s, ending, why)
        if ended is not None:
            self.command = "stop"
            self._low_since_s = None
        return ended

    # what the force decides

    def turn(self, now_s: float, force_n: float) -> Attempt | None:
        """The next command at ``now_s``, s, and this force, N; the attempt that has ended at this moment, if one
        has."""
        if self.attempt is not None:
            self.attempt.peak_n = max(self.attempt.peak_n, force_n)
        low = force_n < self._settings.ready_n
        if not low:
            self._low_since_s = None
        elif self._low_since_s is None:
            self._low_since_s = now_s
        match self.command:
            case "rest" | "ready":
                self._waiting(now_s, force_n)
            case "start":
                return self._started(now_s, force_n)
            case "press":
                return self._pressing(now_s, force_n)
            case "stop":
                return self._lifting(now_s)
        return None

    def _waiting(self, now_s: float, force_n: float) -> None:
        pressed = force_n >= self._settings.force_n[0]
        self.between = (pressed and (self.hold or self.between)) or (self.between and force_n >= self._settings.ready_n)
        if pressed and not self.between:
            self.attempt = Attempt(now_s, early=True, begun_s=now_s, stop_s=now_s, peak_n=force_n)
            self.command = "stop"
        else:
            self.command = "rest" if self.hold or now_s < self.rest_until_s else "ready"

    def _started(self, now_s: float, force_n: float) -> Attempt | None:
        assert self.attempt is not None
        if force_n >= self._settings.force_n[0]:
            self.attempt.begun_s = now_s
            self.command = "press"
            return self._pressing(now_s, force_n)
        if now_s - self.attempt.start_s > self._settings.limits.reaction_s[1]:
            return self.give_up(now_s, "not begun", "")
        return None

    def _pressing(self, now_s: float, force_n: float) -> Attempt | None:
        assert self.attempt is not None
        assert self.attempt.begun_s is not None
        too_long = now_s - self.attempt.begun_s > self._longest_s
        if force_n >= self._settings.force_n[1] or too_long:
            self.attempt.stop_s = now_s
            self.command = "stop"
        elif self._low_for(now_s, RELEASED_S):
            return self._lifted(now_s, "released")
        return None

    def _lifting(self, now_s: float) -> Attempt | None:
        return self._lifted(now_s, "lifted") if self._low_for(now_s, LIFTED_S) else None

    def _low_for(self, now_s: float, seconds: float) -> bool:
        return self._low_since_s is not None and now_s - self._low_since_s >= seconds

    def _lifted(self, now_s: float, ending: Ending) -> Attempt | None:
        """It ended when the force became low, and the rest began."""
        lifted_s = now_s if self._low_since_s is None else self._low_since_s
        self.command, self.rest_until_s = "rest", lifted_s + self._settings.rest_s
        return self._end(lifted_s, ending, "")

    def _end(self, now_s: float, ending: Ending, why: str) -> Attempt | None:
        ended, self.attempt = self.attempt, None
        if ended is not None:
            ended.end_s, ended.ending, ended.why = now_s, ending, why
        return ended

    # what the pages show of it

    def speed(self, now_s: float, force_n: float) -> Speed:
        """Whether the press, at ``now_s``, s, and this force, N, is on its way to leave the band of loading times."""
        if self.command != "press" or self.attempt is None or self.attempt.begun_s is None:
            return ""
        (lower_n, upper_n), (shortest_s, longest_s) = self._settings.force_n, self._settings.load_s
        risen, took_s = (force_n - lower_n) / (upper_n - lower_n), now_s - self.attempt.begun_s
        if force_n - lower_n > SPEED_FROM_N and took_s < risen * shortest_s:
            return "too fast"
        return "too slow" if took_s > max(risen, 0.1) * longest_s else ""

    def overdue_s(self, now_s: float) -> float:
        """How long, s, the finger has been on the specimen since it was to be lifted; 0 when it is lifted in time."""
        stop_s = None if self.attempt is None else self.attempt.stop_s
        if self.command != "stop" or stop_s is None:
            return 0.0
        return max(0.0, now_s - stop_s - self._settings.limits.lift_s)
