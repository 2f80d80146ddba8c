"""The two motors of a qbmove, their encoders and the 1 kHz loop that moves them: ``motor_control`` (v6.1), simplified.

PWM is computed as the firmware does in position, deflection and PWM mode, without the integral, whose gain is 0. A
motor's speed is proportional to it at once, and does not give way to load. In the current modes (2, 3, 5) the motors
stand still: the study never uses them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from emg2vsa.rig.emulated.qbmove_memory import Memory
from emg2vsa.rig.emulated.qbmove_switches import Switches

INTERNAL_PER_TURN = 65536
INTERNAL_PER_RAD = INTERNAL_PER_TURN / (2 * math.pi)
ENCODER_STEP = 16
"""AS5045, 12 bit: 8 wire ticks."""
PWM_MOST = 100
FULL_CURRENT_MA = 1500
"""Current at full PWM: a guess; the real one depends on load."""
_POSITION, _PWM, _DEFLECTION = 0, 1, 4
_SHAFT = 2
_WITHOUT_RATE = 13
"""Parameters of a firmware that knows no greatest PWM rate."""

Pair = tuple[int, int]


class Motors:
    """Positions in internal ticks, in the wire's direction, and what the firmware makes of them."""

    def __init__(self, switches: Switches, angles_rad: Sequence[float]) -> None:
        """``angles_rad``: of motor 1, motor 2 and shaft, at the start."""
        self._full_step = switches.motor_speed_rad_per_s * INTERNAL_PER_RAD / 1000
        self._limits_rate = switches.parameters > _WITHOUT_RATE
        # reversed encoders have reversed gains: in the wire's direction they are the same
        self._sign = -1 if switches.counts_backwards else 1
        self._at = [angle * INTERNAL_PER_RAD for angle in angles_rad]
        self._turns_lost = [0, 0, 0]
        self._seen = [0, 0]
        self.pwm = [0, 0]

    def angles_rad(self) -> tuple[float, float]:
        """Where the motors are."""
        return self._at[0] / INTERNAL_PER_RAD, self._at[1] / INTERNAL_PER_RAD

    def turn_shaft(self, angle_rad: float) -> None:
        """The shaft is where the world has it."""
        self._at[_SHAFT] = angle_rad * INTERNAL_PER_RAD

    def measured(self, memory: Memory) -> tuple[int, int, int]:
        """Encoder readings, internal ticks."""
        first, second, shaft = (self._reading(k, memory) for k in range(3))
        return first, second, shaft

    def forget_turns(self, memory: Memory) -> None:
        """At a start or new zero: an encoder knows its place only within a turn."""
        self._turns_lost = [0, 0, 0]
        half = INTERNAL_PER_TURN // 2
        self._turns_lost = [(value + half) // INTERNAL_PER_TURN for value in self.measured(memory)]

    def step(self, references: Pair, memory: Memory, scale: Memory, powered: tuple[bool, bool]) -> bool:
        """One millisecond; True when another would change nothing. ``scale``: the settings that encoders obey."""
        still = True
        for motor in (0, 1):
            seen = self._reading(motor, scale)
            wanted = self._pwm(motor, references[motor], seen, memory) if powered[motor] else 0
            pwm = self._rate_limited(wanted, self.pwm[motor], memory) if self._limits_rate else wanted
            still = still and pwm == self.pwm[motor] == 0 and seen == self._seen[motor]
            self.pwm[motor], self._seen[motor] = pwm, seen
            self._at[motor] += self._full_step * pwm / PWM_MOST
        return still

    def currents_ma(self) -> Pair:
        """Motor currents, with the sign of the PWM."""
        first, second = (FULL_CURRENT_MA * pwm // PWM_MOST for pwm in self.pwm)
        return first, second

    def _reading(self, sensor: int, memory: Memory) -> int:
        raw = math.floor(self._at[sensor] / ENCODER_STEP) * ENCODER_STEP + memory.offsets[sensor]
        return int((raw - self._turns_lost[sensor] * INTERNAL_PER_TURN) * memory.multipliers[sensor])

    def _pwm(self, motor: int, reference: int, seen: int, memory: Memory) -> int:
        if memory.control_mode == _PWM:
            wanted = reference >> memory.resolutions[motor]
        elif memory.control_mode in (_POSITION, _DEFLECTION):
            shaft = self._reading(_SHAFT, memory) if memory.control_mode == _DEFLECTION else 0
            proportional, derivative = self._sign * memory.position_pid[0], self._sign * memory.position_pid[2]
            wanted = (proportional * (reference + shaft - seen) >> 16) + (derivative * (self._seen[motor] - seen) >> 16)
        else:
            wanted = 0
        return max(-PWM_MOST, min(PWM_MOST, wanted))

    @staticmethod
    def _rate_limited(wanted: int, before: int, memory: Memory) -> int:
        # only a saturated move is held back; from the behaviour of the compiled firmware, not from its source
        if abs(wanted) < PWM_MOST:
            return wanted
        return max(before - memory.max_pwm_rate, min(before + memory.max_pwm_rate, wanted))
