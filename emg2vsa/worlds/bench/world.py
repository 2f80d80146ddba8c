"""The one physical world that all emulated devices share: motors, springs, shaft, probe, sensor and specimen.

The actuator's firmware tells where its motors are; the force sensor and the camera ask for the force. They come in any
order and with times of their own, one at a time. A time that the actuator has not reached yet is answered with its
motors held still, so whoever joins the devices lets the firmware ``advance`` first.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.bench.actuator_joint import Joint, Motors, RigidJoint, SpringJoint
from emg2vsa.worlds.bench.probe import APART, Force, Probe, Touch, WorldSettings

_REMEMBERED = 60_000
"""Points kept at least: a minute of motion in steps of 1 ms, and any length of rest."""


class ShaftPath:
    """Where the shaft has been and what the probe touched, over time, straight between points.

    Devices read the world at times of their own, some of them a little in the past.

    end_s, end_rad : newest time, s, and angle, rad.
    """

    def __init__(self, time_s: float, angle_rad: float) -> None:
        self._times_s, self._angles_rad, self._touches = [time_s], [angle_rad], [APART]
        self.end_s, self.end_rad = time_s, angle_rad

    def append(self, time_s: float, angle_rad: float, touch: Touch = APART) -> None:
        """One more point, s and rad, later than the last."""
        times_s, angles_rad, touches = self._times_s, self._angles_rad, self._touches
        self.end_s, self.end_rad = time_s, angle_rad
        if len(times_s) > 1 and angles_rad[-2] == angles_rad[-1] == angle_rad and touches[-2] == touches[-1] == touch:
            times_s[-1] = time_s
            return
        times_s.append(time_s)
        angles_rad.append(angle_rad)
        touches.append(touch)
        if len(times_s) > 2 * _REMEMBERED:
            del times_s[:_REMEMBERED], angles_rad[:_REMEMBERED], touches[:_REMEMBERED]

    def angle_rad(self, time_s: float) -> float:
        """Angle, rad, at a time, s, not after the end. DeviceError before what is remembered."""
        after, share = self._place(time_s)
        angle_rad = self._angles_rad[after]
        return (
            angle_rad if share == 1 else self._angles_rad[after - 1] + share * (angle_rad - self._angles_rad[after - 1])
        )

    def touch(self, time_s: float) -> Touch:
        """Contact at a time, s, not after the end. DeviceError before what is remembered."""
        if self._touches[-2:] == [APART, APART] and time_s >= self._times_s[-2]:  # most often
            return APART
        after, share = self._place(time_s)
        touch = self._touches[after]
        if share == 1 or touch is (before := self._touches[after - 1]):
            return touch
        normal_n, shear_n, elastic_n, sheared_mm = before
        return Touch(
            normal_n + share * (touch.normal_n - normal_n),
            shear_n + share * (touch.shear_n - shear_n),
            elastic_n + share * (touch.elastic_n - elastic_n),
            sheared_mm + share * (touch.sheared_mm - sheared_mm),
        )

    def _place(self, time_s: float) -> tuple[int, float]:
        """The point not before a time, and the share of the way to it from the one before."""
        times_s = self._times_s
        if time_s < times_s[0]:
            raise DeviceError(
                "emulated world",
                wanted=f"a time from {times_s[0]:.3f} s on",
                found=f"{time_s:.3f} s",
                do="Read the devices more often.",
            )
        after = bisect_left(times_s, time_s)
        if times_s[after] == time_s:
            return after, 1.0
        return after, (time_s - times_s[after - 1]) / (times_s[after] - times_s[after - 1])


STEP_S = 1e-3
"""Longest step while something moves."""
_GROWING = 0.1
"Of the time that the motors have stood still: so long may a step become, as a contact then creeps ever more slowly."
LOADING_STEP_N = 0.02
"From point to point of the loadings that are kept."
_NO_FORCE = (0.0, 0.0, 0.0)
CLEAR_MM = 1.0
"""A probe so far off the specimen has ended its press: nobody asks for times in contact any more."""


class World:
    """Begins at the clock's time, shaft at 0; the first motors that are told find the shaft at rest between them."""

    def __init__(
        self,
        clock: Clock,
        settings: WorldSettings | None = None,
        *,
        next_press: Callable[[int], WorldSettings] | None = None,
    ) -> None:
        """``next_press``: probe and specimen for press number 1, 2, ..., put in place as soon as the press before is
        ``CLEAR_MM`` behind; actuator and gear stay. Without it all presses are alike."""
        self.settings = settings or WorldSettings()
        self.press = 0
        "Which press comes or goes on."
        self._next_press, self._touched = next_press, False
        self._rests = False
        "Whether the shaft was found at rest, off contact, with the motors where they were last."
        self._probe = Probe(self.settings)
        self._joint = _joint(self.settings)
        self._path = ShaftPath(clock.now_s(), 0.0)
        self._motors_rad: Motors | None = None
        self.loadings: list[list[tuple[float, Touch]]] = [[]]
        """Of each press so far: force down the probe's axis, N, and contact, while that force was larger than ever
        before in that press."""

    def shaft_rad(self, time_s: float, motors_rad: Motors) -> float:
        """Shaft angle, rad, with the motors there at ``time_s``, after an even motion from where they last were."""
        # seen from the other side of the gear: springs and friction are the same both ways round
        side = self.settings.turns_to_push
        motors_rad = side * motors_rad[0], side * motors_rad[1]
        if self._motors_rad is None:
            start_rad = self._joint.moved(sum(motors_rad) / 2, math.inf, motors_rad, self._probe)
            self._motors_rad, self._path = motors_rad, ShaftPath(self._path.end_s, start_rad)
        self._run(time_s, motors_rad)
        return side * self._path.end_rad

    def loads_nm(self, motors_rad: Motors) -> Motors:
        """Torque, N m, that each motor must do to go on the way it counts, with the motors there and the shaft where it
        is."""
        side, shaft_rad = self.settings.turns_to_push, self._path.end_rad
        first, second = self._joint.loads_nm(shaft_rad, (side * motors_rad[0], side * motors_rad[1]), self._probe)
        return side * first, side * second

    def probe_mm(self, time_s: float) -> float:
        """Way of the probe from where the shaft is at 0, mm, down is positive."""
        return self._probe.position_mm(self._shaft_at(time_s))

    def force_n(self, time_s: float) -> NDArray[np.float64]:
        """(3,) force on the specimen and on the sensor under it, N: x the way the surface falls off, z down."""
        return np.array(self.forces_n([time_s])[0])

    def forces_n(self, times_s: Sequence[float]) -> list[Force]:
        """Force, N, at each of several times, s, as plain numbers: three at a time are too few for arrays to pay."""
        force_n = self._probe.force_n
        return [_NO_FORCE if (touch := self.touch(time_s)) is APART else force_n(touch) for time_s in times_s]

    def normal_force_n(self, time_s: float) -> float:
        """Force along the normal of the surface, N."""
        return self.touch(time_s).normal_n

    def touch(self, time_s: float) -> Touch:
        """The contact at a time, s, which the camera sees."""
        if time_s > self._path.end_s:
            self._run(time_s, self._motors_rad)
        if self._probe.remembers:
            return self._path.touch(time_s)
        return self._probe.elastic_touch(self._path.angle_rad(time_s))

    def _shaft_at(self, time_s: float) -> float:
        self._run(time_s, self._motors_rad)
        return self._path.angle_rad(time_s)

    def _run(self, until_s: float, motors_rad: Motors | None) -> None:
        before_rad, start_s = self._motors_rad, self._path.end_s
        self._motors_rad = motors_rad
        if until_s <= start_s:
            return
        if self._rests and before_rad == motors_rad:
            self._path.append(until_s, self._path.end_rad)
            return
        self._rests = False
        if before_rad is None or motors_rad is None:
            self._path.append(until_s, self._path.end_rad)
            return
        self._change_press()
        still, probe, joint, path = before_rad == motors_rad, self._probe, self._joint, self._path
        angle_rad, (first_rad, second_rad) = path.end_rad, before_rad
        if not still and (end_rad := joint.free(angle_rad, before_rad, motors_rad, probe)) is not None:
            path.append(until_s, end_rad)
            return
        first_moved_rad, second_moved_rad = motors_rad[0] - first_rad, motors_rad[1] - second_rad
        for end_s, share, step_s in _steps(start_s, until_s, growing=still and probe.remembers):
            from_rad, now_rad = angle_rad, motors_rad
            if not still:
                now_rad = first_rad + share * first_moved_rad, second_rad + share * second_moved_rad
            angle_rad = joint.moved(from_rad, step_s, now_rad, probe)
            touch = probe.settle(angle_rad)
            if still and angle_rad == from_rad and (not probe.remembers or probe.above_mm(angle_rad) >= 0):
                path.append(until_s, angle_rad, touch)
                self._rests = touch is APART
                return
            path.append(end_s, angle_rad, touch)
            if touch.normal_n > 0:
                self._keep(touch)

    def _keep(self, touch: Touch) -> None:
        force_n, loading = self._probe.along_n(touch.normal_n, touch.shear_n), self.loadings[-1]
        if force_n >= (loading[-1][0] if loading else 0.0) + LOADING_STEP_N:
            loading.append((force_n, touch))

    def _change_press(self) -> None:
        above_mm = self._probe.above_mm(self._path.end_rad)
        if above_mm < 0:
            self._touched = True
        elif self._touched and above_mm > CLEAR_MM and self._next_press:
            self.press, self._touched = self.press + 1, False
            self.settings = self._next_press(self.press)
            self._probe = Probe(self.settings)
            self.loadings.append([])


def _joint(settings: WorldSettings) -> Joint:
    if settings.springs is None:
        return RigidJoint()
    return SpringJoint(settings.springs, settings.friction_nm, settings.settling_s)


def _steps(start_s: float, until_s: float, *, growing: bool) -> Iterator[tuple[float, float, float]]:
    """End, share of the whole time and length of even steps, or of steps that grow with the time since the start."""
    whole_s, end_s = until_s - start_s, start_s
    if growing:
        while end_s < until_s:
            step_s = max(STEP_S, _GROWING * (end_s - start_s))
            step_s, end_s = min(step_s, until_s - end_s), min(end_s + step_s, until_s)
            yield end_s, 1.0, step_s
        return
    steps = max(1, math.ceil(whole_s / STEP_S - 1e-6))
    step_s = whole_s / steps
    for k in range(1, steps + 1):
        yield until_s if k == steps else start_s + k * step_s, k / steps, step_s
