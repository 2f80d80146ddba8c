"""What the guards know from more than one turn: where motors may be, what springs bear, whether a sensor is alive."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Sequence
from functools import lru_cache
from struct import Struct

import numpy as np

from emg2vsa.devices.protocols import ForceSample, Joint, Measurements, gives_way
from emg2vsa.rig.executor.guards import UNFELT_N, Seen
from emg2vsa.rig.executor.motion import Motion, Phase
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings

_LEAST_N, _LEAST_TURNS = 1.0, 40
"""Of a loading from which the gain of the force is known."""
_CURRENT_TURNS = 10
_AT_REST_S = 0.55
"""Then motors and shaft have come to rest."""
_RESTLESS_S = 0.05
_RESTLESS_CHANGES = 20
_READING = Struct("6d")
"In bytes no number is the same as no number."
DEAD_S = 0.02
"""From a command until a motor begins to follow, at most: bus and firmware."""


class Witnesses:
    """All of them, for one run."""

    def __init__(
        self, rig: RigSettings, joint: Joint | None, at: Measurements, motor_a_per_n: float | None = None
    ) -> None:
        """``at`` : encoders when the motors have just been switched on. motor_a_per_n : of a rigid motor, if known."""
        self._rig, self._joint, self._a_per_n = rig, joint, motor_a_per_n
        self._motors, self._stillness, self._current = SlowMotors(at, joint, rig.guards), Stillness(), MeanCurrent()
        self._at, self._contact_mm, self._lowest_n = at, math.inf, math.inf
        self._free_a = math.inf
        self._gives_way = gives_way(joint)
        self._unmoved_from_n: float | None = None
        self._sent = at.motors_deg[0], 0.0
        self._sent_s: float | None = None
        self._read_s = 0.0
        self._forces: deque[tuple[float, ...]] = deque(maxlen=rig.filter_samples)
        self._loads: list[tuple[float, float]] = []
        self._felt: deque[float] = deque(maxlen=_CURRENT_TURNS)
        self._lags_n: list[float] = []
        self.seen = Seen(told_by="the springs" if joint else "the motor's current")

    @property
    def depth_mm(self) -> float:
        """Depth of the probe, mm, that the motors stand for, when they were last read."""
        return self._rig.depth_at(self._motors_deg(self._at))

    def _motors_deg(self, at: Measurements) -> float:
        return at.motors_deg[0] if self._joint is None else self._joint.position_deg(at)

    @property
    def mean_n(self) -> float:
        """Size, N, of the mean of the last forces, of all three axes: noise of one sample is no contact."""
        return mean_size(self._forces)

    def gain(self) -> float | None:
        """Growth of the felt force over that of the springs, or of the motor's current, in the last loading; None
        without either or of a short one. A wrong zero does not change it, nor does the friction of the shaft."""
        if len(self._loads) < _LEAST_TURNS:
            return None
        felt_n, spring_n = np.array(self._loads).T
        slope = float(np.polyfit(felt_n, spring_n, 1)[0])
        return 1 / slope if slope > 0 else math.inf

    def feel(self, sample: ForceSample, phase: Phase) -> None:
        """The sample of a turn, in the phase that the turn before has led to."""
        self._stillness.see(sample, self.depth_mm, phase)
        self._forces.append(sample.loads[:3])
        rise_n = None
        if phase == "home":
            felt_n = self.mean_n
            self._lowest_n = min(self._lowest_n, felt_n)
            rise_n = felt_n - self._lowest_n
        seen = self.seen
        seen.still_mm, seen.still_s, seen.rise_n = self._stillness.still_mm, self._stillness.still_s, rise_n

    def send(self, position_deg: float, preset: float, now_s: float) -> None:
        """What is commanded at ``now_s``, s: a position, degrees, and a preset."""
        elapsed_s = 0.0 if self._sent_s is None else now_s - self._sent_s
        self._motors.send(position_deg, preset, elapsed_s)
        self._sent, self._sent_s = (position_deg, preset), now_s

    def read(
        self, at: Measurements, currents_a: tuple[float, ...], felt_n: float, motion: Motion, begins: bool
    ) -> None:
        """Encoders and currents, A, right after a command; ``felt_n`` : N along the push axis in the same turn.

        ``motion`` : after the turn, whose phase ``begins`` with it or goes on.
        """
        seen = self.seen
        if self._unmoved_from_n is None or at.shaft_deg != self._at.shaft_deg or not self._gives_way:
            self._unmoved_from_n = felt_n
        seen.unmoved_n, self._at = felt_n - self._unmoved_from_n, at
        seen.at_before, seen.at = seen.at, at
        seen.between_s, self._read_s = (self._sent_s or 0.0) - self._read_s, self._sent_s or 0.0
        spring_n = None
        if self._joint is not None:
            begun_s = (self._sent_s or 0.0) - motion.since_s
            seen.starting = motion.phase == "approach" and begun_s < self._joint.settles_s
            # pressing is positive; friction of the shaft over the lever is part of it, and so is the shaft's motion
            spring_n = -self._rig.push_sign * self._joint.torque_nm(at, *self._sent) / self._rig.lever_m
            if self._gives_way:
                seen.lag_n = self._lag_n(motion, spring_n)
                spring_n -= seen.lag_n if motion.phase in ("approach", "load") else 0.0
        seen.current_a = self._current.see(currents_a)
        if self._joint is None:
            spring_n, felt_n = self._by_current(motion, felt_n, begins=begins)
        if motion.phase == "load" and begins:
            self._loads.clear()
        if motion.phase == "load" and spring_n is not None and felt_n >= _LEAST_N:
            self._loads.append((felt_n, spring_n))
        shaft_mm = self._rig.depth_at(at.shaft_deg)
        if motion.phase == "contact" and begins:
            self._contact_mm = shaft_mm
        seen.astray_deg = self._motors.astray_deg(at)
        seen.spring_n, seen.felt_n = spring_n, felt_n
        seen.spring_rest_n = spring_n if motion.stiff and at_rest(motion, self._sent_s or 0.0) else None
        seen.jumped_deg = 0.0
        if seen.at_before is not None and motion.phase in ("approach", "contact", "load"):
            of_motors = self._motors_deg(at) - self._motors_deg(seen.at_before)
            seen.jumped_deg = abs(at.shaft_deg - seen.at_before.shaft_deg - of_motors)
        seen.approach_mm = shaft_mm if motion.phase == "approach" else None
        seen.past_contact_mm = shaft_mm - self._contact_mm if motion.phase in ("contact", "load") else None

    def _lag_n(self, motion: Motion, spring_n: float) -> float:
        """What a motor that gives way itself seems to bear because it lags its command at this speed: the mean of the
        first turns of the approach in which it runs evenly. Force that comes later, felt or not, is none of that."""
        if motion.phase == "approach" and not self.seen.starting and len(self._lags_n) < _CURRENT_TURNS:
            self._lags_n.append(spring_n)
        return sum(self._lags_n) / len(self._lags_n) if self._lags_n else 0.0

    def _by_current(self, motion: Motion, felt_n: float, *, begins: bool) -> tuple[float | None, float]:
        """Force of a rigid motor by the current that it draws more than in free motion, and the felt one, both means
        over the same turns; the first None where it is not known. In a rest the gear holds, and no current tells."""
        if begins:
            self._felt.clear()
        self._felt.append(felt_n)
        seen = self.seen
        seen.unfelt_a = None
        if len(self._felt) < _CURRENT_TURNS or motion.phase not in ("approach", "load"):
            return None, felt_n
        if motion.phase == "approach":
            self._free_a = min(self._free_a, seen.current_a)
        felt_n = sum(self._felt) / _CURRENT_TURNS
        if felt_n < UNFELT_N:
            seen.unfelt_a = seen.current_a - self._free_a
        return None if self._a_per_n is None else (seen.current_a - self._free_a) / self._a_per_n, felt_n


def at_rest(motion: Motion, now_s: float) -> bool:
    """Whether the probe is retracted, and motors and shaft have come to rest there by ``now_s``, s."""
    return motion.phase in ("home", "pause") and motion.depth_mm == 0 and now_s - motion.since_s >= _AT_REST_S


def mean_size(vectors: Collection[tuple[float, ...]]) -> float:
    """Length of the mean of vectors of three parts."""
    # plain numbers: three at a time are too few for arrays to pay
    many, x, y, z = len(vectors), 0.0, 0.0, 0.0
    for x_n, y_n, z_n in vectors:
        x, y, z = x + x_n, y + y_n, z + z_n
    x, y, z = x / many, y / many, z / many
    return math.sqrt(x * x + y * y + z * z)


class SlowMotors:
    """Where each motor may be: between a slow follower of its commands and the commands themselves.

    The follower is of first order and of limited speed, and begins `DEAD_S` after a command. Where it is set slower
    than usual, the usual one bounds as well: where commands turn back, a quicker motor is still beyond them. A motor
    that is quicker is between them; one that stands still falls behind the follower, and one that runs away is beyond
    the commands.
    """

    def __init__(self, at: Measurements, joint: Joint | None, guards: GuardSettings) -> None:
        self._joint, self._guards = joint, guards
        self._times_s = sorted({guards.following_s, min(guards.following_s, GuardSettings.following_s)}, reverse=True)
        self._motors = 1 if joint is None else len(joint.targets_deg(0.0, 0.0))
        self._slow = [list(at.motors_deg[: self._motors]) for _ in self._times_s]
        self._sent: Sequence[float] | None = None
        self._obeyed: Sequence[float] | None = None
        self._on_their_way: deque[tuple[float, Sequence[float]]] = deque()
        self._now_s = 0.0

    def send(self, position_deg: float, preset: float, elapsed_s: float) -> None:
        """A command, so long after the one before; meanwhile the follower has obeyed what has come to it."""
        self._now_s += elapsed_s
        if self._obeyed is not None:
            most = self._guards.following_deg_per_s * elapsed_s
            for time_s, slow in zip(self._times_s, self._slow, strict=True):
                share = _share(elapsed_s, time_s)
                for motor, command in enumerate(self._obeyed):
                    if step := share * (command - slow[motor]):
                        slow[motor] += -most if step < -most else most if step > most else step
        targets_deg = (position_deg,) if self._joint is None else self._joint.targets_deg(position_deg, preset)
        self._before, self._sent = self._sent or self._slow[0], targets_deg
        self._on_their_way.append((self._now_s + DEAD_S, self._sent))
        while self._on_their_way and self._on_their_way[0][0] <= self._now_s + 1e-9:
            self._obeyed = self._on_their_way.popleft()[1]

    def astray_deg(self, at: Measurements) -> float:
        """How far outside of that, degrees, the farther motor is, read right after the command."""
        if self._sent is None:
            return 0.0
        farthest, motors_deg, before, sent = 0.0, at.motors_deg, self._before, self._sent
        for motor in range(self._motors):
            low = high = before[motor]
            for bound in (sent[motor], *[slow[motor] for slow in self._slow]):
                if bound < low:
                    low = bound
                elif bound > high:
                    high = bound
            at_deg = motors_deg[motor]
            if not low <= at_deg <= high:
                farthest = max(farthest, low - at_deg, at_deg - high)
        return farthest


@lru_cache(maxsize=256)
def _share(elapsed_s: float, time_s: float) -> float:
    """Of its way that a follower of first order goes; turns have few lengths, which differ by their rounding."""
    return 1 - math.exp(-elapsed_s / time_s)


class Stillness:
    """How long, and over how much pressing, all six readings of a force sensor have stayed the same.

    Coarse readings may stay the same at rest for ever, so rest is judged only of a sensor that was restless there.
    """

    def __init__(self) -> None:
        self._last: bytes | None = None
        self._changed_s, self._from_mm, self._changes, self._calm = 0.0, 0.0, 0, False
        self.still_mm = 0.0
        self.still_s: float | None = None

    def see(self, sample: ForceSample, depth_mm: float, phase: Phase) -> None:
        """The sample of a turn, the depth of the motors, mm, and what they do."""
        reading = _READING.pack(*sample.loads)
        if reading != self._last:
            if phase in ("approach", "pause"):
                self._calm = self._calm or (self._last is not None and sample.time_s - self._changed_s > _RESTLESS_S)
                self._changes += 1
            self._last, self._changed_s, self._from_mm = reading, sample.time_s, depth_mm
        if phase != "load":
            self._from_mm = depth_mm
        self.still_mm = depth_mm - self._from_mm
        restless = not self._calm and self._changes >= _RESTLESS_CHANGES
        self.still_s = sample.time_s - self._changed_s if restless else None


class MeanCurrent:
    """Of the last turns, A, of the motor that draws more."""

    def __init__(self) -> None:
        self._currents: list[deque[float]] = []
        "Of each motor."

    def see(self, currents_a: tuple[float, ...]) -> float:
        """One more reading, A of each motor; the mean with it, A, 0 before there are enough."""
        if not self._currents:
            self._currents = [deque(maxlen=_CURRENT_TURNS) for _ in currents_a]
        for newest, current_a in zip(self._currents, currents_a, strict=True):
            newest.append(abs(current_a))
        return max(map(sum, self._currents)) / _CURRENT_TURNS if len(self._currents[0]) == _CURRENT_TURNS else 0.0
