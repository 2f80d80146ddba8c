"""The 1 kHz loop of a qbmove against a clock: references handed on turn by turn, motors, watchdog."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.qbmove.memory import Memory
from emg2vsa.worlds.far_ends.qbmove.motors import Motors, Pair, Torques
from emg2vsa.worlds.far_ends.qbmove.switches import Switches

_WATCHDOG_COUNT_S = 0.04096
_NEVER_MS = 1 << 62
Loads = Callable[[Torques], Torques]
"""Torque on each motor, N m, that it must do to go on the way it counts, with the motors at these angles, rad."""


def no_loads(motors_rad: Torques) -> Torques:
    """Motors that nothing holds back."""
    return 0.0, 0.0


class Shaft(Protocol):
    """What the motors pull at: springs, shaft, and whatever the shaft touches."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        """Angle of the shaft, rad, with the motors there since ``time_s``; times never go back."""


class References(NamedTuple):
    """Where the motors are to go, internal ticks, and whether they are on."""

    ticks: Pair = (0, 0)
    on: int = 0


class Loop:
    """Motors and references of one device."""

    def __init__(
        self,
        switches: Switches,
        shaft: Shaft,
        clock: Clock,
        motors_rad: tuple[float, float],
        loads: Loads,
        latency_s: float = 0.0,
    ) -> None:
        """``latency_s``: from a command until the loop knows of it."""
        self._switches, self._shaft, self._clock, self._loads = switches, shaft, clock, loads
        start_s = clock.now_s()
        self.motors = Motors(switches, (*motors_rad, shaft.shaft_rad(start_s, motors_rad)))
        self._now_ms = int(start_s * 1000)
        self.new = self.current = self.old = References()
        self.bridge_on: int | None = None
        "What the motors go by after a watchdog that has cleared no more than the flag, until the next ACTIVATE."
        self._watchdog_ms = _NEVER_MS
        self._latency_ms = round(latency_s * 1000)
        self._commanded: deque[tuple[int, Pair]] = deque()

    def command(self, ticks: Pair) -> None:
        """Where the motors are to go, once that is known here."""
        if self._latency_ms:
            self._commanded.append((self._now_ms + self._latency_ms, ticks))
        else:
            self.new = self.new._replace(ticks=ticks)

    def activate(self, references: References) -> None:
        """At once, and instead of what has been commanded before."""
        self._commanded.clear()
        self.new = references

    def advance(self, current: Memory, shadow: Memory) -> None:
        """Run up to the clock. ``current`` settings move the motors, ``shadow`` ones scale and shift the encoders."""
        until_ms = int(self._clock.now_s() * 1000 + 1e-6)
        if until_ms <= self._now_ms:
            return
        strained = self.motors.strained
        while self._now_ms < until_ms:
            if self._now_ms >= self._watchdog_ms:
                self.bridge_on = self.current.on if self.motors.faults.flag_only else None
                self.new, self._watchdog_ms = self.new._replace(on=0), _NEVER_MS
            while self._commanded and self._commanded[0][0] <= self._now_ms:
                self.new = References(self._commanded.popleft()[1], self.new.on)
            # only the watchdog, a command, or a load that may stall a motor, comes between
            plain = not (strained or current.input_mode or self.current.on != self.new.on)
            next_ms = self._commanded[0][0] if self._commanded else until_ms
            turns = max(1, min(until_ms, self._watchdog_ms, next_ms) - self._now_ms) if plain else 1
            self._turns(turns, current, shadow)
            self._now_ms += turns
            if strained:
                self._turn_shaft()
                strained = self.motors.strained
        self._turn_shaft()

    def feed_watchdog(self, counts: int) -> None:
        """Something was heard. Periods of 0 counts are taken as no watchdog: what they mean is unknown."""
        self._watchdog_ms = self._now_ms + int(counts * _WATCHDOG_COUNT_S * 1000) if counts else _NEVER_MS

    def restart(self, on: int) -> None:
        """Power comes back: references 0."""
        self._commanded.clear()
        self.new = self.current = self.old = References(on=on)
        self.bridge_on = None
        self.motors.pwm = [0, 0]

    def _turn_shaft(self) -> None:
        angles_rad = self.motors.angles_rad()
        self.motors.turn_shaft(self._shaft.shaft_rad(self._now_ms / 1000, angles_rad))
        self.motors.loads_nm = self._loads(angles_rad)

    def _turns(self, turns: int, current: Memory, shadow: Memory) -> None:
        """So many turns: the motors follow the newest references from the second on."""
        ticks = self.current.ticks
        if current.input_mode:
            shaft = self.motors.measured(shadow)[2]
            ticks = limited(shaft, 0, current), limited(shaft, 1, current)
        on = self.current.on if self.bridge_on is None else self.bridge_on
        powered = (on > 0, on > 0) if self._switches.both_motors_or_none else (bool(on & 1), bool(on & 2))
        self.motors.run([(1, ticks), (turns - 1, self.new.ticks)], current, shadow, powered)
        self.old, self.current = self.current if turns == 1 else self.new, self.new


def limited(ticks: int, motor: int, memory: Memory) -> int:
    """Clamped to the position limits of motor 0 or 1, when those are on."""
    low, high = memory.limits[2 * motor : 2 * motor + 2]
    return max(low, min(high, ticks)) if memory.limits_active else ticks
