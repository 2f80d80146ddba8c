"""How the shaft follows the motors: through springs, with friction, or rigidly.

Quasi-static: at rest the springs (``emg2vsa.actuator``), the specimen and the friction are in balance. On its way there
the shaft comes nearer by a first-order law, which is exact for any duration and never passes its rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from emg2vsa.actuator import Springs
from emg2vsa.rig.emulated.probe import Probe

Motors = tuple[float, float]

_ARRIVED_RAD = 1e-9
_STEPS = 200
_SOLVED_RAD = 1e-8
"""A step of Newton's so small is the last: as they converge, the one after it would be below 1e-13."""


class Joint(Protocol):
    """Between motors and shaft."""

    def moved(self, shaft_rad: float, duration_s: float, motors_rad: Motors, probe: Probe) -> float:
        """Shaft angle, rad, that long after it was at ``shaft_rad``, with the motors where they are; the same angle
        when it rests. The probe's step of that length begins here, and ends with its ``settle``."""

    def loads_nm(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> Motors:
        """Torque, N m, that each motor must do to turn on to larger angles."""


class RigidJoint:
    """The shaft is motor 1's, and no load moves it."""

    def moved(self, shaft_rad: float, duration_s: float, motors_rad: Motors, probe: Probe) -> float:
        probe.begin(duration_s)
        return motors_rad[0]

    def loads_nm(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> Motors:
        return probe.load_nm(motors_rad[0]), 0.0


@dataclass(frozen=True)
class SpringJoint:
    """Two springs between motors and shaft.

    friction_nm : Coulomb friction of the shaft. settling_s : time constant on the way to rest; 0 is at once.
    """

    springs: Springs
    friction_nm: float
    settling_s: float

    def moved(self, shaft_rad: float, duration_s: float, motors_rad: Motors, probe: Probe) -> float:
        probe.begin(duration_s)
        needed = self._needed(shaft_rad, motors_rad, probe)
        if abs(needed[0]) <= self.friction_nm:
            return shaft_rad
        # friction holds the rest, so the shaft stops where springs and specimen still ask for that much
        rest_rad = self._angle_at(math.copysign(self.friction_nm, needed[0]), shaft_rad, needed, motors_rad, probe)
        if abs(rest_rad - shaft_rad) < _ARRIVED_RAD:
            return shaft_rad
        left = math.exp(-duration_s / self.settling_s) if self.settling_s else 0.0
        return rest_rad + (shaft_rad - rest_rad) * left

    def loads_nm(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> Motors:
        s = self.springs
        return (
            s.k1_nm * math.sinh(s.a1_per_rad * (motors_rad[0] - shaft_rad)),
            s.k2_nm * math.sinh(s.a2_per_rad * (motors_rad[1] - shaft_rad)),
        )

    def _needed(self, shaft_rad: float, motors_rad: Motors, probe: Probe) -> tuple[float, float]:
        """Torque that would hold the shaft there against springs and specimen, N m, and its growth, N m/rad."""
        s = self.springs
        # half of k e^x, once for both sinh and cosh
        k1_nm, a1_per_rad, k2_nm, a2_per_rad = s.k1_nm, s.a1_per_rad, s.k2_nm, s.a2_per_rad
        up_1 = k1_nm / 2 * math.exp(a1_per_rad * (shaft_rad - motors_rad[0]))
        up_2 = k2_nm / 2 * math.exp(a2_per_rad * (shaft_rad - motors_rad[1]))
        down_1, down_2 = k1_nm**2 / 4 / up_1, k2_nm**2 / 4 / up_2
        load_nm, load_growth = probe.torque_nm(shaft_rad) if shaft_rad > probe.touch_rad else (0.0, 0.0)
        torque_nm = up_1 - down_1 + up_2 - down_2 + load_nm
        return torque_nm, a1_per_rad * (up_1 + down_1) + a2_per_rad * (up_2 + down_2) + load_growth

    def _angle_at(
        self, torque_nm: float, start_rad: float, at_start: tuple[float, float], motors_rad: Motors, probe: Probe
    ) -> float:
        """Shaft angle at which that torque is needed: Newton's steps, within a bracket that always holds the root.

        ``at_start`` : torque and growth at ``start_rad``."""
        s = self.springs
        # the growth is nowhere less than that of both springs at rest
        margin = abs(torque_nm) / (s.a1_per_rad * s.k1_nm + s.a2_per_rad * s.k2_nm)
        low, high = min(*motors_rad, probe.touch_rad) - margin, max(motors_rad) + margin
        angle, (needed_nm, growth) = start_rad, at_start
        for _ in range(_STEPS):
            low, high = (low, angle) if needed_nm > torque_nm else (angle, high)
            before, angle = angle, angle - (needed_nm - torque_nm) / growth
            if not low <= angle <= high:
                angle = (low + high) / 2
            if abs(angle - before) < _SOLVED_RAD:
                break
            needed_nm, growth = self._needed(angle, motors_rad, probe)
        return angle
