"""How the shaft follows the motors: through springs, with friction, or rigidly.

Quasi-static: at rest the springs (`SpringJoint`), the specimen and the friction are in balance. On its way there
the shaft comes nearer by a first-order law, which is exact for any duration and never passes its rest.
"""

from __future__ import annotations

import math
from typing import Protocol

from emg2vsa.devices.qbmove.springs import Springs
from emg2vsa.worlds.bench.probe import Probe

Motors = tuple[float, float]

_ARRIVED_RAD = 1e-9
_STEPS = 200
_SOLVED_RAD = 1e-8
"""A step of Newton's so small is the last: as they converge, the one after it would be below 1e-13."""
_SURELY = 1 - 1e-9
"Share of the friction: torques on the way are rounded otherwise than those at its ends."


class Joint(Protocol):
    """Between motors and shaft."""

    def moved(self, shaft_rad: float, duration_s: float, motors_rad: Motors, probe: Probe) -> float:
        """Shaft angle, rad, that long after it was at ``shaft_rad``, with the motors where they are; the same angle
        when it rests. The probe's step of that length begins here, and ends with its ``settle``."""

    def free(self, shaft_rad: float, before_rad: Motors, motors_rad: Motors, probe: Probe) -> float | None:
        """Shaft angle, rad, after the motors' even way from ``before_rad``, where that is known without steps: nothing
        is touched on it. None of any other way."""

    def loads_nm(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> Motors:
        """Torque, N m, that each motor must do to turn on to larger angles."""


class RigidJoint:
    """The shaft is motor 1's, and no load moves it."""

    def moved(self, shaft_rad: float, duration_s: float, motors_rad: Motors, probe: Probe) -> float:
        """Angle of the shaft, rad, after ``duration_s``, s: that of motor 1."""
        probe.begin(duration_s)
        return motors_rad[0]

    def free(self, shaft_rad: float, before_rad: Motors, motors_rad: Motors, probe: Probe) -> float | None:
        """Angle of the shaft, rad, while nothing is touched on the way; None where something may be."""
        return motors_rad[0] if max(shaft_rad, before_rad[0], motors_rad[0]) <= probe.touch_rad else None

    def loads_nm(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> Motors:
        """Torque of the specimen on motor 1, N m; none on motor 2."""
        return probe.load_nm(motors_rad[0]), 0.0


class SpringJoint:
    """Two springs between motors and shaft.

    friction_nm : Coulomb friction of the shaft. settling_s : time constant on the way to rest; 0 is at once.
    """

    def __init__(self, springs: Springs, friction_nm: float, settling_s: float) -> None:
        self.springs, self.friction_nm, self.settling_s = springs, friction_nm, settling_s
        s = springs
        # half of k e^x, once for both sinh and cosh
        self._halves = s.a1_per_rad, s.k1_nm / 2, s.k1_nm**2 / 4, s.a2_per_rad, s.k2_nm / 2, s.k2_nm**2 / 4
        self._least_growth = s.a1_per_rad * s.k1_nm + s.a2_per_rad * s.k2_nm

    def moved(self, shaft_rad: float, duration_s: float, motors_rad: Motors, probe: Probe) -> float:
        """Angle of the shaft, rad, ``duration_s``, s, later with the motors at ``motors_rad``, rad."""
        probe.begin(duration_s)
        a1, half_1, quarter_1, a2, half_2, quarter_2 = self._halves
        exp, touch_rad, (first_rad, second_rad) = math.exp, probe.touch_rad, motors_rad

        # torque that would hold the shaft there against springs and specimen, N m, and its growth, N m/rad; in line
        # here and below, as every millisecond of a run asks for it several times
        up_1, up_2 = half_1 * exp(a1 * (shaft_rad - first_rad)), half_2 * exp(a2 * (shaft_rad - second_rad))
        down_1, down_2 = quarter_1 / up_1, quarter_2 / up_2
        load_nm, load_growth = probe.torque_nm(shaft_rad) if shaft_rad > touch_rad else (0.0, 0.0)
        needed_nm = up_1 - down_1 + up_2 - down_2 + load_nm
        if abs(needed_nm) <= self.friction_nm:
            return shaft_rad

        # friction holds the rest, so the shaft stops where springs and specimen still ask for that much: Newton's
        # steps, within a bracket that always holds the root; the growth is nowhere less than that of springs at rest
        torque_nm = math.copysign(self.friction_nm, needed_nm)
        margin = self.friction_nm / self._least_growth
        low, high = min(first_rad, second_rad, touch_rad) - margin, max(first_rad, second_rad) + margin
        angle = shaft_rad
        for _ in range(_STEPS):
            if needed_nm > torque_nm:
                high = angle
            else:
                low = angle
            growth = a1 * (up_1 + down_1) + a2 * (up_2 + down_2) + load_growth
            before, angle = angle, angle - (needed_nm - torque_nm) / growth
            if not low <= angle <= high:
                angle = (low + high) / 2
            if -_SOLVED_RAD < angle - before < _SOLVED_RAD:
                break
            up_1, up_2 = half_1 * exp(a1 * (angle - first_rad)), half_2 * exp(a2 * (angle - second_rad))
            down_1, down_2 = quarter_1 / up_1, quarter_2 / up_2
            load_nm, load_growth = probe.torque_nm(angle) if angle > touch_rad else (0.0, 0.0)
            needed_nm = up_1 - down_1 + up_2 - down_2 + load_nm

        if abs(angle - shaft_rad) < _ARRIVED_RAD:
            return shaft_rad
        left = exp(-duration_s / self.settling_s) if self.settling_s else 0.0
        return angle + (shaft_rad - angle) * left

    def free(self, shaft_rad: float, before_rad: Motors, motors_rad: Motors, probe: Probe) -> float | None:
        """Angle of the shaft, rad, that friction holds where it is: motors at rest hunt for their reference by a few
        ticks. None where it may move, or touches."""
        if shaft_rad > probe.touch_rad:
            return None
        a1, half_1, quarter_1, a2, half_2, quarter_2 = self._halves
        exp = math.exp
        # each spring pulls the more the farther its motor is, so that it is at its most and least at the two ends
        up_1, later_1 = half_1 * exp(a1 * (shaft_rad - before_rad[0])), half_1 * exp(a1 * (shaft_rad - motors_rad[0]))
        up_2, later_2 = half_2 * exp(a2 * (shaft_rad - before_rad[1])), half_2 * exp(a2 * (shaft_rad - motors_rad[1]))
        low_1, high_1 = (up_1, later_1) if up_1 < later_1 else (later_1, up_1)
        low_2, high_2 = (up_2, later_2) if up_2 < later_2 else (later_2, up_2)
        least_nm = low_1 - quarter_1 / low_1 + low_2 - quarter_2 / low_2
        most_nm = high_1 - quarter_1 / high_1 + high_2 - quarter_2 / high_2
        held_nm = self.friction_nm * _SURELY
        return shaft_rad if -held_nm <= least_nm and most_nm <= held_nm else None

    def loads_nm(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> Motors:
        """Torque of its spring on each motor, N m."""
        s = self.springs
        return (
            s.k1_nm * math.sinh(s.a1_per_rad * (motors_rad[0] - shaft_rad)),
            s.k2_nm * math.sinh(s.a2_per_rad * (motors_rad[1] - shaft_rad)),
        )
