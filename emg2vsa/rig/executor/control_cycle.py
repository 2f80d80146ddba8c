"""One turn of the control loop: sense, judge, command, log."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import NamedTuple

from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.devices import Devices, ForceSample
from emg2vsa.rig.executor.guards import Moment, tripped
from emg2vsa.rig.executor.motion import Motion, advance
from emg2vsa.rig.force.moving_average import MovingAverage
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import EndRun
from emg2vsa.rig.record.run_log import Row, full_force
from emg2vsa.rig.record.run_record import RunRecord
from emg2vsa.rig.rig_settings import RigSettings

Readings = tuple[int | None, int | None, int | None, int | None, int | None]
"""Motor 1, motor 2 and shaft in ticks, and the two currents in mA; None where the turn did not come so far."""
_UNREAD: Readings = (None, None, None, None, None)


class Force(NamedTuple):
    """Force of one sample along the rig's push axis, N, and its arrival."""

    raw_n: float
    filtered_n: float
    sample: ForceSample


class ControlCycle:
    """What a run remembers from turn to turn. Every method raises EndRun when a device is lost."""

    def __init__(self, plan: RunPlan, rig: RigSettings, devices: Devices, record: RunRecord, clock: Clock) -> None:
        self._plan, self._rig, self._devices, self._record, self._clock = plan, rig, devices, record, clock
        self._average = MovingAverage(rig.filter_samples, rig.rate_hz)
        self._sent: tuple[int, int] | None = None
        self._before: Force | None = None
        self.motion: Motion | None = None
        "Where the run is; None before ``start``."

    def start(self) -> None:
        """Motors on; the run begins where they are."""
        with ending("activation"):
            self._devices.actuator.activate()
            position_ticks = self._devices.actuator.position_ticks()
        self._turned_s = self._asked_s = self._frame_s = self._clock.now_s()
        self._active = True
        self.motion = Motion("home", self._turned_s, self._rig.depth_at(position_ticks))

    def turn(self, now_s: float, late_s: float) -> Motion:
        """One turn; the motion after it. Whatever ends the turn, what was sensed is logged."""
        assert self.motion is not None
        force = self._feel()
        readings = _UNREAD
        try:
            self._look(now_s)
            self._ask(now_s)
            wanted = advance(self.motion, self._plan, force.filtered_n, now_s, now_s - self._turned_s)
            self._judge(force, wanted, now_s, late_s)
            self._enter(wanted, force)
            self._send(wanted)
            self._turned_s, self._before = now_s, force
            with ending("lost device"):
                readings = (*self._devices.actuator.measurements(), *self._devices.actuator.currents_ma())
        finally:
            self._log(now_s, late_s, force, readings)
        return self.motion

    def log_escape(self, position_ticks: int, preset_ticks: int) -> None:
        """A row while the probe is taken away after the end. DeviceError when the disk is full."""
        assert self.motion is not None
        sample: ForceSample | None = None
        with suppress(DeviceError):
            sample = self._devices.force.read()
        time_s, force_n = (sample.time_s, self._rig.pushing_n(sample)) if sample else (None, None)
        row = Row(
            self._clock.now_s(), self.motion.repetition, "escape", time_s, force_n, None, position_ticks, preset_ticks,
            *_UNREAD, self._record.frame_index,
        )  # fmt: skip
        self._record.row(row._replace(**full_force(sample)) if sample else row)
        self._record.all_forces(self._devices.force.read_all)

    def _feel(self) -> Force:
        with ending("stale sensor"):
            sample = self._devices.force.read()
        with ending("recording"):
            self._record.all_forces(self._devices.force.read_all)
        raw_n = self._rig.pushing_n(sample)
        return Force(raw_n, self._average.update(raw_n), sample)

    def _look(self, now_s: float) -> None:
        if self._devices.camera is None:
            return
        with ending("lost camera"):
            frames = self._devices.camera.frames()
        with ending("recording"):
            for frame in frames:
                self._record.frame(frame)
                self._frame_s = now_s

    def _ask(self, now_s: float) -> None:
        if now_s - self._asked_s >= self._rig.guards.motors_every_s:
            with ending("lost device"):
                self._active = self._devices.actuator.is_active()
            self._asked_s = now_s

    def _judge(self, force: Force, wanted: Motion, now_s: float, late_s: float) -> None:
        before = self._before or force
        moment = Moment(
            now_s=now_s, late_s=late_s, period_s=self._rig.period_s,
            force_n=force.raw_n, force_time_s=force.sample.time_s,
            force_before_n=before.raw_n, force_before_s=before.sample.time_s, faults=force.sample.status.faults,
            frame_s=self._frame_s if self._devices.camera else None,
            depth_mm=wanted.depth_mm, travel_mm=self._plan.travel_mm, active=self._active,
        )  # fmt: skip
        if found := tripped(moment, self._rig.guards):
            raise EndRun("guard", *found)

    def _enter(self, wanted: Motion, force: Force) -> None:
        assert self.motion is not None
        begins = wanted.repetition != self.motion.repetition
        self.motion = wanted
        if begins:
            # taken for contact, a wrong zero would press that much harder than the plan
            if abs(force.filtered_n) >= self._plan.f_contact_n:
                raise EndRun("guard", "preload", f"{force.filtered_n:.2f} N before the press, with the probe retracted")
            with ending("recording"):
                self._record.begin_press(wanted.repetition, force.sample.time_s)

    def _send(self, wanted: Motion) -> None:
        command = self._rig.ticks_at(wanted.depth_mm), self._plan.preset_ticks(wanted.step)
        with ending("lost device"):
            self._devices.actuator.set_position_stiffness(*command)
        self._sent = command

    def _log(self, now_s: float, late_s: float, force: Force, readings: Readings) -> None:
        assert self.motion is not None
        position, preset = self._sent or (None, None)
        row = Row(
            now_s, self.motion.repetition, self.motion.phase, force.sample.time_s, force.raw_n, force.filtered_n,
            position, preset, *readings, self._record.frame_index, late_s,
        )._replace(**full_force(force.sample))  # fmt: skip
        with ending("recording"):
            self._record.row(row)


@contextmanager
def ending(cause: str) -> Iterator[None]:
    """A DeviceError in here ends the run for this cause."""
    try:
        yield
    except DeviceError as error:
        raise EndRun("guard", cause, str(error)) from error
