"""From goals and gains to a current or a duty, once a millisecond.

Source: ROBOTIS e-Manual, Position PID Gain, Velocity PI Gain, What is the Profile. Current-based Position Control Mode
is worked out. Simplified in the others: position modes put out duty by the same PID, in units of PWM; velocity mode
knows no profile. Both feedforward gains are kept and do nothing. That P, I and D are per pulse, per pulse and
millisecond, and per pulse in a millisecond, and that they put out units of current or PWM, is a guess.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.models import PULSES_PER_TURN

_RATE = 0.229 * PULSES_PER_TURN / 60_000
"""Pulses in a millisecond, of one unit of velocity."""
_GROWTH = 214.577 * PULSES_PER_TURN / 3600 / 1e6
"""Pulses in a millisecond more in each millisecond, of one unit of acceleration."""


class Control:
    """Position and velocity are as the table has them: reversed, and with the homing offset."""

    def __init__(self) -> None:
        self.halted = False
        "Stopped by the watchdog: until the mode's own goal is written."
        self.restart(0)

    def restart(self, position: float) -> None:
        """From a standstill there."""
        self.trajectory, self.rate, self._sum = float(position), 0.0, 0.0
        self._held = self._aim = float(position)
        self._most_rate = self._growth = 0.0

    def halt(self, position: float) -> None:
        """Stop there, without a profile."""
        self.halted = True
        self.restart(position)

    @property
    def arrived(self) -> bool:
        """The profile has ended."""
        return self.trajectory == self._aim

    @property
    def shape(self) -> int:
        """Of the profile: step 0, rectangular 1, trapezoidal 3, as in Moving Status."""
        return 0 if not self._most_rate else 3 if self._growth else 1

    def output(self, values: Mapping[int, int], position: int, rate: float) -> tuple[float | None, float]:
        """Current, units of 2.69 mA, and None else; then duty, units of PWM.

        ``rate``: of the shaft, pulses in a millisecond."""
        mode = values[t.OPERATING_MODE]
        most_pwm = min(abs(values[t.GOAL_PWM]), values[t.PWM_LIMIT])
        most_current = min(abs(values[t.GOAL_CURRENT]), values[t.CURRENT_LIMIT])
        if mode in t.POSITION_MODES:
            self._follow(self._held if self.halted else values[t.GOAL_POSITION], values)
            gains = values[t.POSITION_P] / 128, values[t.POSITION_I] / 65536, values[t.POSITION_D] / 16
            error = self.trajectory - position
            if mode == t.CURRENT_BASED_POSITION:
                return self._pid(gains, error, self.rate - rate, most_current), 0.0
            return None, self._pid(gains, error, self.rate - rate, most_pwm)
        goal = 0 if self.halted else values[t.GOAL_OF_MODE[mode]]
        if mode == t.VELOCITY:
            gains = values[t.VELOCITY_P] / 128, values[t.VELOCITY_I] / 65536, 0.0
            return None, self._pid(gains, goal - rate / _RATE, 0.0, most_pwm)
        return (max(-most_current, min(most_current, goal)), 0.0) if mode == t.CURRENT else (None, goal)

    def _pid(self, gains: tuple[float, float, float], error: float, slowness: float, most: float) -> float:
        proportional, integral, derivative = gains
        wanted = proportional * error + integral * self._sum + derivative * slowness
        if not integral:
            self._sum = 0.0
        elif -most < wanted < most or wanted * error < 0:  # against windup
            self._sum += error
        return max(-most, min(most, wanted))

    def _follow(self, goal: float, values: Mapping[int, int]) -> None:
        if goal != self._aim:
            self._plan(goal, values)
        left = self._aim - self.trajectory
        if not self._most_rate or not left:
            self.trajectory, self.rate = self._aim, 0.0
            return
        growth = self._growth or math.inf
        # so fast that the way left is enough to stop on
        wanted = math.copysign(min(self._most_rate, math.sqrt(2 * growth * abs(left))), left)
        self.rate = max(self.rate - growth, min(self.rate + growth, wanted))
        self.trajectory += self.rate
        if (self._aim - self.trajectory) * left <= 0:
            self.trajectory, self.rate = self._aim, 0.0

    def _plan(self, goal: float, values: Mapping[int, int]) -> None:
        """A new profile, made when the goal changes."""
        self._aim = goal
        velocity, acceleration = values[t.PROFILE_VELOCITY], values[t.PROFILE_ACCELERATION]
        if velocity and values[t.DRIVE_MODE] & t.TIME_BASED:
            begins_ms = min(acceleration, velocity / 2)
            self._most_rate = abs(goal - self.trajectory) / (velocity - begins_ms)
            self._growth = self._most_rate / begins_ms if begins_ms else 0.0
            return
        self._most_rate = velocity * _RATE
        self._growth = acceleration * _GROWTH if velocity else 0.0
