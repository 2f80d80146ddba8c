"""Slow moves of the probe outside a run: every move ends at a force of any direction, and trusts no setting of the rig.

Speeds are degrees of the shaft a second, since the gear of the rig file may be wrong; forces are lengths of the whole
vector, since its push axis may be wrong.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Devices, ForceSample, Joint, gives_way
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.witnesses import MeanCurrent
from emg2vsa.rig.rig_settings import RigSettings

DEG_PER_S = 5.0
"""1 mm/s with the paper's gear; no move by hand is faster than `FASTEST_DEG_PER_S`, nor than the rig may move."""
FASTEST_DEG_PER_S = 25.0
TOUCH_N = 0.5
LIMIT_N = 2.0
"""Force, above that at the start, at which a move that is to stay free ends."""
_AVERAGED = 5
_LOOK_S = 0.2
_FOLLOWING_DEG, _FOLLOWING_S = 0.8, 0.1
"""Motors so far behind their references, and so long times their speed, do not follow, or their encoder errs; on their
way at 25 degrees a second they are 1.1 behind."""
_FROZEN_DEG = 0.4
"""Way of a command over which a motor's encoder that stays the same is frozen: four of its steps."""
_RESTS_DEG = 5.0
"""Most that the shaft may turn as the motors go on: springs that were bent by hand."""
_BACK_DEG = 20.0
_FRICTION_NM = 0.03
"""Friction of shaft and guide together: three times the shaft's (guess)."""
_GAP_N = 3.0
"""How much more than the sensor feels the springs may bear beyond friction; a sound rig shows 1 N at most."""
LIMIT_SHARE = 0.5
"""Share of guards.force_n: the largest force that a move by hand may be told to end at."""
_CURRENT_SHARE = 0.3
"""Share of guards.current_a, over ten turns: 0.45 A, at which the emulated rigid motor presses with 8.5 N (a guess)."""
_LAG_S = 0.3
"""So long after a retreat has begun the force may still rise: a sensor may lag."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where a move has ended.

    shaft_deg : of the probe. force_n : (3,) above the force at the start, N. touched : a force ended it.
    """

    shaft_deg: float
    force_n: Floats
    touched: bool

    @property
    def size_n(self) -> float:
        """Length of the force, N."""
        return float(np.linalg.norm(self.force_n))


class Turn(NamedTuple):
    """One turn of a move: shaft, force above the zero, and current of the motor that draws more."""

    shaft_deg: float
    felt_n: float
    current_a: float


class HandMotion:
    """Slow moves of an actuator that is switched off when they begin; its user switches it off again.

    Parameters
    ----------
    devices : opened, force sensor started. rig : with the limits of the device.

    Raises
    ------
    DeviceError : from every move: a device is lost, the force sensor reports a fault, the motors do not follow or draw
    too much, or the springs bear more than is felt. The probe has then gone back the way it came, by 20 degrees of the
    shaft at most and for as long as that does not raise the force; the motors hold it there.
    """

    def __init__(self, devices: Devices, rig: RigSettings, clock: Clock) -> None:
        self._rig, self._clock = rig, clock
        self._actuator, self._force = devices.actuator, devices.force
        self.preset = 0.0
        """The softest that the rig may have: what is touched by mistake is pressed least. 0 until the motors are on.
        Another one holds from the next command on."""
        self.at_deg = 0.0
        "Position that is commanded."
        self._zero_n: Floats = np.zeros(3)
        self._rest_n = 0.0
        self._limit_n = math.inf
        self._current = MeanCurrent()
        self._currents_a: tuple[float, ...] = ()
        self._behind_deg = 0.0
        self._moves, self._seen = True, dict[int, tuple[float, float]]()

    def start(self) -> Place:
        """Motors on where they are; the force at this moment is the zero of all moves. DeviceError, and motors off,
        where it does not rest meanwhile: an encoder that is frozen or has another zero drives them."""
        first_deg, forces = self.shaft_deg(), list[Floats]()
        self._begin()
        end_s = self._clock.now_s() + _LOOK_S
        while self._clock.now_s() < end_s or not forces:
            forces.append(self._read().force_n)
            grown_n = float(np.linalg.norm(forces[-1] - forces[0]))
            turned_deg = abs(self.shaft_deg() - first_deg)
            if grown_n > LIMIT_N or turned_deg > _RESTS_DEG:
                self._actuator.deactivate()
                do = "Check the encoders with emg2vsa rig info; the probe may still press."
                found = f"{turned_deg:.1f} degrees and {grown_n:.2f} N more"
                raise DeviceError("probe", wanted="a shaft that rests as the motors go on", found=found, do=do)
            self._hold()
        self._zero_n, self._rest_n = np.asarray(np.mean(forces, axis=0)), self._springs_n()
        return self.place()

    @property
    def joint(self) -> Joint | None:
        """Joint of the actuator, once its motors have been switched on."""
        return self._actuator.joint

    def _begin(self) -> None:
        self._actuator.activate()
        if (joint := self._actuator.joint) is not None and self.preset == 0:
            self.preset = float(joint.rounded(self._rig.stiffness_percent[0] / 100))
        self.at_deg = self._actuator.position_deg()
        self._command(self.at_deg)

    @contextmanager
    def resting(self) -> Iterator[None]:
        """Motors off while a person is asked: nobody feeds the watchdog meanwhile. They go on where they are then."""
        self._actuator.deactivate()
        yield
        self._begin()

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
        return Place(self.shaft_deg(), self.felt_n(), touched)

    def shaft_deg(self) -> float:
        """Where the shaft is now, degrees, also while the hand rests."""
        return self._actuator.measurements().shaft_deg

    def go(
        self, to_deg: float, *, until_n: float = LIMIT_N, deg_per_s: float = DEG_PER_S, from_zero: bool = True,
        turns: list[Turn] | None = None, until_deg: float = math.inf,
    ) -> Place:  # fmt: skip
        """Move evenly to the position ``to_deg``, degrees, and end as soon as the force is ``until_n``, N, above the
        zero.

        from_zero : False compares lengths of the whole force instead, for a probe that may stand pressed: moving it
            away changes the force, and must only not raise it.
        turns : to be filled with what was read on the way. until_deg : the shaft ends the move there, too, wherever the
            command is by then.
        DeviceError : a position beyond the limits; and as every move.
        """
        low, high = self._rig.position_deg
        if not low <= to_deg <= high:
            do = "Choose a shorter move, or correct position_deg in the rig file."
            wanted = f"a position of {low:.6g} to {high:.6g} degrees"
            raise DeviceError("probe", wanted=wanted, found=f"{to_deg:.2f}", do=do)
        begin = self.at_deg
        try:
            return self._go(to_deg, until_n, deg_per_s, turns, until_deg, from_zero=from_zero)
        except DeviceError:
            if from_zero and self._moves:  # else it may have begun pressed, or drives on without end
                self._retreat(begin)
            raise

    def _go(
        self, to_deg: float, until_n: float, deg_per_s: float, turns: list[Turn] | None, until_deg: float, *,
        from_zero: bool,
    ) -> Place:  # fmt: skip
        step = self._step_deg(deg_per_s)
        self._limit_n = math.inf
        before_n = float(np.linalg.norm(self.felt_n() + self._zero_n))
        force_n = self._rig.guards.force_n
        self._limit_n = force_n if from_zero else max(force_n, before_n + LIMIT_N)
        recent: deque[Floats] = deque(maxlen=_AVERAGED)
        self._current, self._currents_a = MeanCurrent(), self._actuator.currents_a()
        self._behind_deg = _FOLLOWING_DEG + _FOLLOWING_S * step / self._rig.period_s
        self._moves, self._seen, begin_deg = True, {}, self.at_deg
        while self.at_deg != to_deg:
            recent.append(self._read().force_n)
            mean_n = np.mean(recent, axis=0)
            felt_n = float(np.linalg.norm(mean_n - self._zero_n))
            size_n = felt_n if from_zero else float(np.linalg.norm(mean_n)) - before_n
            if len(recent) == _AVERAGED and size_n >= until_n:
                return self.place(touched=True)
            self._judge(felt_n, relaxing=not from_zero)
            if turns is not None:
                turns.append(Turn(self.shaft_deg(), felt_n, max(map(abs, self._currents_a))))
                if abs(turns[-1].shaft_deg - begin_deg) >= abs(until_deg - begin_deg):
                    return self.place(touched=True)
            self.at_deg += math.copysign(min(step, abs(to_deg - self.at_deg)), to_deg - self.at_deg)
            self._hold(look=True)
        return self.place()

    def away(self, from_deg: float) -> Place:
        """After a force has ended a move: back towards ``from_deg``, degrees, until it is below half of a touch."""
        sign, end = self._back(from_deg)
        place = self.place()
        while (place.size_n > TOUCH_N / 2 or self._borne_n() > TOUCH_N) and self.at_deg != end:
            step = min(0.5, abs(end - self.at_deg))
            self.at_deg += sign * step
            self._hold()
            place = self.place()
        return place

    def _retreat(self, from_deg: float) -> None:
        """After an error: back towards ``from_deg``, whatever is felt, unless it raises the force."""
        sign, end = self._back(from_deg)
        step, begin_s = self._step_deg(FASTEST_DEG_PER_S), self._clock.now_s()
        first_n: float | None = None
        self._limit_n = math.inf
        with suppress(DeviceError):
            off_deg = self._actuator.position_deg() - self.at_deg
            if not gives_way(self._actuator.joint) and abs(off_deg) > self._behind_deg:
                # an encoder that jumped, and not the motors: these go off, and on again where they read to be
                self._actuator.deactivate()
                self._begin()
                end += off_deg
        with suppress(DeviceError):  # the error that began it is the one to tell
            while self.at_deg != end:
                load_n = max(self._borne_n(), self._felt_anyhow_n())
                first_n = load_n if first_n is None else first_n
                old = self._clock.now_s() - begin_s > _LAG_S
                if load_n > first_n + TOUCH_N and (old or load_n > self._rig.guards.force_n):
                    return
                self.at_deg += sign * min(step, abs(end - self.at_deg))
                self._hold()
            self._clock.sleep_until(self._clock.now_s() + _LOOK_S)

    def _back(self, from_deg: float) -> tuple[float, float]:
        """Sign and end of the way back towards ``from_deg``."""
        way = from_deg - self.at_deg
        sign = math.copysign(1.0, way)
        return sign, self.at_deg + sign * min(_BACK_DEG, abs(way))

    def _step_deg(self, deg_per_s: float) -> float:
        fastest = min(FASTEST_DEG_PER_S, self._rig.max_mm_per_s / self._rig.gear_mm_per_degree)
        return min(deg_per_s, fastest) * self._rig.period_s

    def _hold(self, *, look: bool = False) -> None:
        """One turn of the loop: command, ask, wait. look : at the currents, too, right after the command as in a run:
        they fall as the motors come to it."""
        self._command(self.at_deg)
        if look:
            self._currents_a = self._actuator.currents_a()
        if not self._actuator.is_active():
            do = "Check its supply; prove the watchdog with emg2vsa rig prove-watchdog."
            raise DeviceError("probe", wanted="motors on", found="motors off: reset, or watchdog", do=do)
        self._clock.sleep_until(self._clock.now_s() + self._rig.period_s)

    def _command(self, position_deg: float) -> None:
        self._actuator.command(position_deg, self.preset)

    def _read(self) -> ForceSample:
        sample = self._force.read()
        size_n = float(np.linalg.norm(sample.force_n))
        if sample.status.faults or not size_n <= self._limit_n:
            found = "; ".join(sample.status.faults) or f"{size_n:.2f} N"
            do = "Check the sensor; emg2vsa rig home takes the probe away."
            wanted = f"a sound force of at most {self._limit_n:g} N" if self._limit_n < math.inf else "a sound force"
            raise DeviceError("force", wanted=wanted, found=found, do=do)
        return sample

    def _felt_anyhow_n(self) -> float:
        """The newest force above the zero; 0 where the sensor gives none."""
        try:
            return float(np.linalg.norm(self._read().force_n - self._zero_n))
        except DeviceError:
            return 0.0

    def _judge(self, felt_n: float, *, relaxing: bool) -> None:
        """``relaxing`` : springs may bear less than at the zero, and the motors draw what a pressed probe needs."""
        joint = self._actuator.joint
        # of a motor that gives way its torque tells it
        if not gives_way(joint):
            self._judge_encoders()
        behind_deg = 0.0 if gives_way(joint) else abs(self._actuator.position_deg() - self.at_deg)
        if behind_deg > self._behind_deg:
            do = "Look for what holds the gear or the probe, and check supply and encoders."
            found = f"{behind_deg:.1f} degrees off"
            wanted = f"motors within {self._behind_deg:.2g} degrees of their command"
            raise DeviceError("probe", wanted=wanted, found=found, do=do)
        do = "Check the force sensor, its calibration, and what the probe stands against."
        borne_n = self._borne_n(relaxing=relaxing)
        if borne_n > felt_n + _GAP_N:
            found = f"springs that press with {borne_n:.1f} N or more, and {felt_n:.2f} N felt"
            raise DeviceError("probe", wanted="a force felt where the springs give way", found=found, do=do)
        mean_a = self._current.see(self._currents_a)
        most_a = (1.0 if relaxing else _CURRENT_SHARE) * self._rig.guards.current_a
        if mean_a > most_a:
            found = f"{mean_a:.3f} A, and {felt_n:.2f} N felt"
            raise DeviceError("probe", wanted=f"motors that draw at most {most_a:.3g} A", found=found, do=do)

    def _judge_encoders(self) -> None:
        """DeviceError, and motors off, where a motor's encoder stays the same while the motors are told to go."""
        joint = self._actuator.joint
        many = 1 if joint is None else len(joint.targets_deg(0.0, 0.0))
        for motor, now_deg in enumerate(self._actuator.measurements().motors_deg[:many], 1):
            seen_deg, from_deg = self._seen.get(motor, (math.nan, 0.0))
            if now_deg != seen_deg:
                self._seen[motor] = now_deg, self.at_deg
            elif abs(self.at_deg - from_deg) > max(_FROZEN_DEG, self._behind_deg / 2):
                self._moves = False
                self._actuator.deactivate()
                do = "Look for what holds the gear, and at the encoder; the probe may still press."
                found = f"{now_deg:.2f} degrees of motor {motor} all the time"
                raise DeviceError("probe", wanted="motors whose encoders move with them", found=found, do=do)

    def _borne_n(self, *, relaxing: bool = False) -> float:
        """Change of the springs' force on the probe since the zero, beyond friction, N."""
        now_n = self._springs_n()
        if relaxing and abs(now_n) <= abs(self._rest_n):
            return 0.0
        return max(0.0, abs(now_n - self._rest_n) - _FRICTION_NM / self._rig.lever_m)

    def _springs_n(self) -> float:
        """Force that the joint bears on the probe, N; 0 of a rigid motor."""
        joint = self._actuator.joint
        if joint is None:
            return 0.0
        return joint.torque_nm(self._actuator.measurements(), self.at_deg, self.preset) / self._rig.lever_m
