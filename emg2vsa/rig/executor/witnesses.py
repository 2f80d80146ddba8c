"""What the guards know from more than one turn: where motors may be, what springs bear, whether a sensor is alive."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from functools import lru_cache

import numpy as np

from emg2vsa.actuator import RAD_PER_TICK, Springs, equilibrium_and_preset, motor_positions
from emg2vsa.devices.protocols import ForceSample, Measurements
from emg2vsa.rig.executor.guards import Seen
from emg2vsa.rig.executor.motion import Motion, Phase
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings

_LEAST_N, _LEAST_TURNS = 1.0, 40
"""Of a loading from which the gain of the force is known."""
_CURRENT_TURNS = 10
_AT_REST_S = 0.55
"""Then motors and shaft have come to rest."""
_RESTLESS_S = 0.05
_RESTLESS_CHANGES = 20
DEAD_S = 0.02
"""From a command until a motor begins to follow, at most: bus and firmware."""


class Witnesses:
    """All of them, for one run."""

    def __init__(self, rig: RigSettings, springs: Springs | None, at: Measurements) -> None:
        """``at`` : encoders when the motors have just been switched on."""
        self._rig, self._springs = rig, springs
        self._motors, self._stillness, self._current = SlowMotors(at, springs, rig.guards), Stillness(), MeanCurrent()
        self._at, self._contact_mm, self._lowest_n = at, math.inf, math.inf
        self._sent_s: float | None = None
        self._forces: deque[tuple[float, ...]] = deque(maxlen=rig.filter_samples)
        self._loads: list[tuple[float, float]] = []
        self.seen = Seen()

    @property
    def depth_mm(self) -> float:
        """Depth of the probe that the motors stand for, when they were last read."""
        at = self._at
        return self._rig.depth_at(
            at.motor_1 if self._springs is None else equilibrium_and_preset(at.motor_1, at.motor_2)[0]
        )

    @property
    def mean_n(self) -> float:
        """Size of the mean of the last forces, of all three axes: noise of one sample is no contact."""
        return mean_size(self._forces)

    def gain(self) -> float | None:
        """Growth of the felt force over that of the springs in the last loading; None without springs or of a short
        one. A wrong zero does not change it, nor does the friction of the shaft."""
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

    def send(self, position_ticks: int, preset_ticks: int, now_s: float) -> None:
        """What is commanded now."""
        elapsed_s = 0.0 if self._sent_s is None else now_s - self._sent_s
        self._motors.send(position_ticks, preset_ticks, elapsed_s)
        self._sent_s = now_s

    def read(self, at: Measurements, currents_ma: tuple[int, int], felt_n: float, motion: Motion, begins: bool) -> None:
        """Encoders and currents right after a command; ``felt_n`` : along the push axis in the same turn. ``motion`` :
        after the turn, whose phase ``begins`` with it or goes on."""
        self._at = at
        spring_n = None if self._springs is None else spring_force_n(at, self._springs, self._rig)
        if motion.phase == "load" and begins:
            self._loads.clear()
        if motion.phase == "load" and spring_n is not None and felt_n >= _LEAST_N:
            self._loads.append((felt_n, spring_n))
        shaft_mm = self._rig.depth_at(at.shaft)
        if motion.phase == "contact" and begins:
            self._contact_mm = shaft_mm
        seen = self.seen
        seen.astray_ticks = self._motors.astray_ticks(at)
        seen.spring_n, seen.felt_n = spring_n, felt_n
        seen.spring_rest_n = spring_n if motion.stiff and at_rest(motion, self._sent_s or 0.0) else None
        seen.current_ma = self._current.see(currents_ma)
        seen.approach_mm = shaft_mm if motion.phase == "approach" else None
        seen.past_contact_mm = shaft_mm - self._contact_mm if motion.phase in ("contact", "load") else None


def at_rest(motion: Motion, now_s: float) -> bool:
    """Whether the probe is retracted, and motors and shaft have come to rest there."""
    return motion.phase in ("home", "pause") and motion.depth_mm == 0 and now_s - motion.since_s >= _AT_REST_S


def mean_size(vectors: Collection[tuple[float, ...]]) -> float:
    """Length of the mean of vectors of three parts."""
    # plain numbers: three at a time are too few for arrays to pay
    many = len(vectors)
    x, y, z = [sum(parts) / many for parts in zip(*vectors, strict=True)]
    return math.sqrt(x * x + y * y + z * z)


class SlowMotors:
    """Where each motor may be: between a slow follower of its commands and the commands themselves.

    The follower is of first order and of limited speed, and begins `DEAD_S` after a command. Where it is set slower
    than usual, the usual one bounds as well: where commands turn back, a quicker motor is still beyond them. A motor
    that is quicker is between them; one that stands still falls behind the follower, and one that runs away is beyond
    the commands.
    """

    def __init__(self, at: Measurements, springs: Springs | None, guards: GuardSettings) -> None:
        self._rigid, self._guards = springs is None, guards
        self._times_s = sorted({guards.following_s, min(guards.following_s, GuardSettings.following_s)}, reverse=True)
        self._slow = [list(self._seen(at)) for _ in self._times_s]
        self._sent: list[float] | None = None
        self._obeyed: list[float] | None = None
        self._on_their_way: deque[tuple[float, list[float]]] = deque()
        self._now_s = 0.0

    def send(self, position_ticks: int, preset_ticks: int, elapsed_s: float) -> None:
        """A command, so long after the one before; meanwhile the follower has obeyed what has come to it."""
        self._now_s += elapsed_s
        if self._obeyed is not None:
            most = self._guards.following_ticks_per_s * elapsed_s
            for time_s, slow in zip(self._times_s, self._slow, strict=True):
                share = _share(elapsed_s, time_s)
                for motor, command in enumerate(self._obeyed):
                    step = share * (command - slow[motor])
                    slow[motor] += -most if step < -most else most if step > most else step
        first, second = map(float, motor_positions(position_ticks, preset_ticks))
        self._before, self._sent = self._sent or self._slow[0], [first] if self._rigid else [first, second]
        self._on_their_way.append((self._now_s + DEAD_S, self._sent))
        while self._on_their_way and self._on_their_way[0][0] <= self._now_s + 1e-9:
            self._obeyed = self._on_their_way.popleft()[1]

    def astray_ticks(self, at: Measurements) -> float:
        """How far outside of that the farther motor is, read right after the command."""
        if self._sent is None:
            return 0.0
        farthest = 0.0
        for motor, (seen, before, sent) in enumerate(zip(self._seen(at), self._before, self._sent, strict=True)):
            low, high = (before, sent) if before < sent else (sent, before)
            for slow in self._slow:
                bound = slow[motor]
                low, high = bound if bound < low else low, bound if bound > high else high
            farthest = max(farthest, low - seen, seen - high)
        return farthest

    def _seen(self, at: Measurements) -> tuple[float, ...]:
        return (at.motor_1,) if self._rigid else (at.motor_1, at.motor_2)


@lru_cache(maxsize=256)
def _share(elapsed_s: float, time_s: float) -> float:
    """Of its way that a follower of first order goes; turns have few lengths, which differ by their rounding."""
    return 1 - math.exp(-elapsed_s / time_s)


class Stillness:
    """How long, and over how much pressing, all six readings of a force sensor have stayed the same.

    Coarse readings may stay the same at rest for ever, so rest is judged only of a sensor that was restless there.
    """

    def __init__(self) -> None:
        self._last: tuple[bytes, bytes] | None = None
        self._changed_s, self._from_mm, self._changes, self._calm = 0.0, 0.0, 0, False
        self.still_mm = 0.0
        self.still_s: float | None = None

    def see(self, sample: ForceSample, depth_mm: float, phase: Phase) -> None:
        """The sample of a turn, the depth of the motors, and what they do."""
        reading = sample.force_n.tobytes(), sample.torque_nm.tobytes()
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
    """Of the last turns, mA, of the motor that draws more."""

    def __init__(self) -> None:
        self._first: deque[int] = deque(maxlen=_CURRENT_TURNS)
        self._second: deque[int] = deque(maxlen=_CURRENT_TURNS)

    def see(self, currents_ma: tuple[int, int]) -> float:
        """One more reading; the mean with it, 0 before there are enough."""
        self._first.append(abs(currents_ma[0]))
        self._second.append(abs(currents_ma[1]))
        if len(self._first) < _CURRENT_TURNS:
            return 0.0
        return max(sum(self._first), sum(self._second)) / _CURRENT_TURNS


def spring_force_n(at: Measurements, springs: Springs, rig: RigSettings) -> float:
    """Force along the probe that the springs bear, pressing is positive, N, by the model of `emg2vsa.actuator`.

    It differs from that on the specimen by the friction of the shaft over the lever, and while the shaft moves.
    """
    first, second = RAD_PER_TICK * (at.shaft - at.motor_1), RAD_PER_TICK * (at.shaft - at.motor_2)
    torque_nm = springs.k1_nm * _sinh(springs.a1_per_rad * first) + springs.k2_nm * _sinh(springs.a2_per_rad * second)
    return -rig.push_sign * torque_nm / rig.lever_m


def _sinh(x: float) -> float:
    # encoders that have lost their turns may be anywhere
    return math.sinh(max(-100.0, min(100.0, x)))
