"""Slow moves of the probe outside a run: every move ends at a force of any direction, and trusts no setting of the rig.

Speeds are degrees of the shaft a second, since the gear of the rig file may be wrong; forces are lengths of the whole
vector, since its push axis may be wrong.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from emg2vsa.actuator import RAD_PER_TICK, ticks_of_percent
from emg2vsa.arrays import Floats
from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.devices import Devices, ForceSample
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.settings import TICKS_PER_TURN

DEG_PER_S = 5.0
"""1 mm/s with the paper's gear; no move by hand is faster than `FASTEST_DEG_PER_S`."""
FASTEST_DEG_PER_S = 25.0
TOUCH_N = 0.5
LIMIT_N = 2.0
"""Force, above that at the start, at which a move that is to stay free ends."""
TICKS_PER_DEGREE = TICKS_PER_TURN / 360
_AVERAGED = 5
_LOOK_S = 0.2
_FOLLOWING_TICKS = 300
"""Motors so far behind their references do not follow; on their way at 25 degrees a second they are 100 behind."""
_BACK_DEG = 20.0
_FRICTION_NM = 0.03
"""Of shaft and guide together: three times the shaft's (guess)."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where a move has ended.

    shaft_ticks : of the probe. force_n : (3,) above the force at the start, N. touched : a force ended it.
    """

    shaft_ticks: int
    force_n: Floats
    touched: bool

    @property
    def size_n(self) -> float:
        """Length of the force."""
        return float(np.linalg.norm(self.force_n))


class HandMotion:
    """Slow moves of an actuator that is switched off when they begin; its user switches it off again.

    Parameters
    ----------
    devices : opened, force sensor started. rig : with the limits of the device.

    Raises
    ------
    DeviceError : from every move: a device is lost, the force sensor reports a fault, the motors do not follow, or the
    springs give way while no force is felt. The motors then hold where they are.
    """

    def __init__(self, devices: Devices, rig: RigSettings, clock: Clock) -> None:
        self._rig, self._clock = rig, clock
        self._actuator, self._force = devices.actuator, devices.force
        low, _ = ticks_of_percent(rig.stiffness_percent, rig.max_preset_ticks)
        self.preset_ticks = int(low) if self._actuator.springs else 0
        "The softest that the rig may have: what is touched by mistake is pressed least."
        self._at_ticks = 0.0
        self._zero_n: Floats = np.zeros(3)

    def start(self) -> Place:
        """Motors on where they are; the force at this moment is the zero of all moves."""
        self._actuator.activate()
        self._at_ticks = self._actuator.position_ticks()
        self._command(self._at_ticks)
        self.zero()
        return self.place()

    @contextmanager
    def resting(self) -> Iterator[None]:
        """Motors off while a person is asked: nobody feeds the watchdog meanwhile. They go on where they are then."""
        self._actuator.deactivate()
        yield
        self._actuator.activate()
        self._at_ticks = self._actuator.position_ticks()
        self._command(self._at_ticks)

    def zero(self) -> None:
        """The present force is the zero from now on."""
        self._zero_n = np.zeros(3)
        self._zero_n = self.felt_n()

    def felt_n(self) -> Floats:
        """(3,) mean force above the zero, over 0.2 s."""
        end_s = self._clock.now_s() + _LOOK_S
        forces: list[Floats] = []
        while self._clock.now_s() < end_s or not forces:
            forces.append(self._read().force_n)
            self._hold()
        return np.asarray(np.mean(forces, axis=0) - self._zero_n)

    def place(self, *, touched: bool = False) -> Place:
        """Where the probe is, at rest."""
        return Place(self._actuator.measurements().shaft, self.felt_n(), touched)

    def go(
        self, ticks: float, *, until_n: float = LIMIT_N, deg_per_s: float = DEG_PER_S, from_zero: bool = True
    ) -> Place:
        """Move evenly to the position ``ticks``, and end as soon as the force is ``until_n`` above the zero.

        from_zero : False compares lengths of the whole force instead, for a probe that may stand pressed: moving it
        away changes the force, and must only not raise it.
        """
        low, high = self._rig.position_ticks
        if not low <= ticks <= high:
            do = "Choose a shorter move, or correct position_ticks in the rig file."
            raise DeviceError("probe", wanted=f"a position of {low} to {high} ticks", found=f"{ticks:.0f}", do=do)
        step = min(deg_per_s, FASTEST_DEG_PER_S) * TICKS_PER_DEGREE * self._rig.period_s
        before_n = float(np.linalg.norm(self.felt_n() + self._zero_n))
        recent: list[Floats] = []
        while self._at_ticks != ticks:
            recent = [*recent[1 - _AVERAGED :], self._read().force_n]
            mean_n = np.mean(recent, axis=0)
            size_n = float(np.linalg.norm(mean_n - self._zero_n) if from_zero else np.linalg.norm(mean_n) - before_n)
            if len(recent) == _AVERAGED and size_n >= until_n:
                return self.place(touched=True)
            self._judge(size_n)
            self._at_ticks += math.copysign(min(step, abs(ticks - self._at_ticks)), ticks - self._at_ticks)
            self._hold()
        return self.place()

    def away(self, from_ticks: float) -> Place:
        """After a force has ended a move: back towards ``from_ticks`` until it is below half of a touch."""
        sign = math.copysign(1.0, from_ticks - self._at_ticks)
        end = self._at_ticks + sign * min(_BACK_DEG * TICKS_PER_DEGREE, abs(from_ticks - self._at_ticks))
        place = self.place()
        while place.size_n > TOUCH_N / 2 and self._at_ticks != end:
            step = min(TICKS_PER_DEGREE / 2, abs(end - self._at_ticks))
            self._at_ticks += sign * step
            self._hold()
            place = self.place()
        return place

    @property
    def at_ticks(self) -> float:
        """Position that is commanded."""
        return self._at_ticks

    def _hold(self) -> None:
        """One turn of the loop: command, ask, wait."""
        self._command(self._at_ticks)
        if not self._actuator.is_active():
            do = "Check its supply; prove the watchdog with emg2vsa rig prove-watchdog."
            raise DeviceError("probe", wanted="motors on", found="motors off: reset, or watchdog", do=do)
        self._clock.sleep_until(self._clock.now_s() + self._rig.period_s)

    def _command(self, ticks: float) -> None:
        self._actuator.set_position_stiffness(round(ticks), self.preset_ticks)

    def _read(self) -> ForceSample:
        sample = self._force.read()
        size_n = float(np.linalg.norm(sample.force_n))
        limit_n = self._rig.guards.force_n
        if sample.status.faults or not size_n <= limit_n:
            found = "; ".join(sample.status.faults) or f"{size_n:.2f} N"
            do = "Check the sensor; emg2vsa rig home takes the probe away."
            raise DeviceError("force", wanted=f"a sound force of at most {limit_n:g} N", found=found, do=do)
        return sample

    def _judge(self, size_n: float) -> None:
        behind = abs(self._actuator.position_ticks() - self._at_ticks)
        if behind > _FOLLOWING_TICKS:
            do = "Look for what holds the gear or the probe, and check the supply."
            found = f"{behind:.0f} ticks behind"
            raise DeviceError(
                "probe", wanted=f"motors within {_FOLLOWING_TICKS} ticks of their command", found=found, do=do
            )
        if size_n < TOUCH_N and (pull_n := self._springs_n()) > 2 * LIMIT_N:
            found = f"springs that press with {pull_n:.1f} N or more, and {size_n:.2f} N felt"
            do = "Check the force sensor, and what the probe stands against."
            raise DeviceError("probe", wanted="a force felt where the springs give way", found=found, do=do)

    def _springs_n(self) -> float:
        """Force of the springs on the probe beyond what friction may hold, N, by the model of `emg2vsa.actuator`."""
        at, springs = self._actuator.measurements(), self._actuator.springs
        if springs is None:
            return 0.0
        torque_nm = springs.k1_nm * math.sinh(springs.a1_per_rad * (at.shaft - at.motor_1) * RAD_PER_TICK)
        torque_nm += springs.k2_nm * math.sinh(springs.a2_per_rad * (at.shaft - at.motor_2) * RAD_PER_TICK)
        return max(0.0, abs(torque_nm) - _FRICTION_NM) / (math.degrees(self._rig.gear_mm_per_degree) / 1000)
