"""One turn of the control loop: sense, judge, command, log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from types import TracebackType
from typing import NamedTuple

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Actuator, Devices, ForceSample, Measurements
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.guards import GUARDS, Check, Moment, tripped
from emg2vsa.rig.executor.motion import Motion, MovingAverage, advance
from emg2vsa.rig.executor.plan_limits import most_past_contact_mm
from emg2vsa.rig.executor.safe_end import Start
from emg2vsa.rig.executor.specimen_witness import SpecimenWitness
from emg2vsa.rig.executor.witnesses import Witnesses, at_rest
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.record.ended import EndRun
from emg2vsa.rig.record.run_log import Row, loads_of
from emg2vsa.rig.record.run_record import RunRecord
from emg2vsa.rig.rig_settings import RigSettings

_LAG_MM = 1.0
"""How far motors are behind their command in ordinary motion, and more."""
GAINS = 0.74, 1.2
"""Range of the felt force over that of the springs: a press beyond is doubtful. Without a fault a stiff specimen under
springs that grow stiffer shows 0.79, as the shaft comes to rest behind the motors."""


_QUESTIONS = 50
"""To the actuator before its motors go on, to time its line."""


_UNWITNESSED = (
    "nothing but the sensor tells its force, for the specimen is not known or the press too short to tell it: press a "
    "reference first, emg2vsa rig commission --motor --reference"
)


class Force(NamedTuple):
    """Force of one sample along the rig's push axis, N, and its arrival."""

    raw_n: float
    filtered_n: float
    sample: ForceSample


class ControlCycle:
    """What a run remembers from turn to turn. Every method raises EndRun when a device is lost."""

    def __init__(
        self,
        plan: RunPlan,
        rig: RigSettings,
        devices: Devices,
        record: RunRecord,
        clock: Clock,
        guards: Mapping[str, Check] = GUARDS,
    ) -> None:
        self._plan, self._rig, self._devices, self._record, self._clock = plan, rig, devices, record, clock
        self._guards = guards
        self._average = MovingAverage(rig.filter_samples, rig.rate_hz)
        self._sent: tuple[float, float] | None = None
        self._stands_at, self._stiffest, self._slew = 0.0, 0.0, 0.0
        self._before: Force | None = None
        self._pressed = False
        self.motion: Motion | None = None
        "Where the run is; None before ``start``."
        self.peak_force_n: float | None = None
        "Largest force felt, of all three axes together, N; None before the first."

    def start(self) -> None:
        """Motors on, where the line is fast enough for the loop; the run begins where they are.

        Raises EndRun : the line is too slow, or the actuator does not switch on.
        """
        actuator = self._devices.actuator
        with ending("activation"):
            took_s = _answers_in_s(actuator, self._clock)
            if took_s > self._rig.period_s / 2:  # a turn of the loop asks several times
                said = f"the actuator answers after {1e3 * took_s:.1f} ms, more than half a turn of the control loop"
                raise EndRun("guard", "slow line", f"{said}. Set the latency timer of its USB adapter to 1 ms.")
            actuator.activate()
            position_deg, at = actuator.position_deg(), actuator.measurements()
            device_a = actuator.current_limit_a()
        limits = self._rig.guards
        self._limits = replace(
            limits,
            current_a=min(limits.current_a, device_a) if device_a > 0 else limits.current_a,
            past_contact_mm=most_past_contact_mm(self._plan, self._rig),
        )
        joint = actuator.joint
        self._witnesses = Witnesses(self._rig, joint, at, self._plan.motor_a_per_n)
        self._specimen = SpecimenWitness(self._plan, self._rig)
        if joint is not None:
            most = joint.preset_per_s * self._rig.period_s
            self._slew, self._stiffest = (
                float(joint.rounded(each)) for each in (most, self._rig.stiffness_percent[1] / 100)
            )
            self._stands_at = min(float(joint.rounded(joint.preset_at(at))), self._stiffest)
        self._turned_s = self._asked_s = self._frame_s = self._clock.now_s()
        self._active = True
        self.motion = Motion("home", self._turned_s, self._rig.depth_at(position_deg))

    def turn(self, now_s: float, late_s: float) -> Motion:
        """One turn at ``now_s``, ``late_s`` after it was due, both s; the motion after it. Whatever ends the turn, what
        was sensed is logged."""
        assert self.motion is not None
        before = self.motion
        force = self._feel()
        at: Measurements | None = None
        currents_a: tuple[float, ...] = ()
        try:
            self._look(now_s)
            growth_n_per_s = self._average.growth_per_s
            wanted = advance(self.motion, self._plan, force.filtered_n, now_s, now_s - self._turned_s, growth_n_per_s)
            if wanted.phase == "load" and self._record.enough(force.filtered_n):
                wanted = wanted._replace(phase="retract", since_s=now_s)
            moment = self._moment(force, wanted, now_s, late_s)
            self._judge(moment)
            if at_rest(wanted, now_s):
                self._free(
                    f"{now_s - wanted.since_s:.1f} s after the press" if wanted.repetition else "before the press"
                )
            self._enter(wanted, force)
            with _DEVICE:
                self._send(wanted)
                self._turned_s, self._before = now_s, force
                at, currents_a = self._devices.actuator.measurements(), self._devices.actuator.currents_a()
            self._witnesses.read(at, currents_a, force.raw_n, wanted, begins=wanted.phase != before.phase)
            self._weigh(wanted, force, at, now_s)
            if (wanted.phase, before.phase) == ("retract", "load"):
                self._compare()
            self._ask(now_s)
            moment.active = self._active
            self._judge(moment)
        finally:
            self._log(now_s, late_s, force, at, currents_a)
        return self.motion

    def retreat_from(self) -> Start | None:
        """Where to begin taking the probe away; None when nothing has been moved.

        That is where the motors were measured, in the eyes of the device, which goes by the same encoders: from there
        it can only be told to go away. No motor is deeper than its command.
        """
        if self.motion is None:
            return None
        plan = self._plan
        return Start(
            depth_mm=min(self.motion.depth_mm, self._measured_mm()),
            preset=self._preset(self.motion),
            softest=min(plan.presets(self._rig.full_preset)),
            contact_n=plan.f_contact_n,
            home_is_free=self._pressed,
        )

    def _measured_mm(self) -> float:
        measured_mm = self._witnesses.depth_mm
        if self.motion is not None and measured_mm < self.motion.depth_mm - _LAG_MM:
            # one wrong reading would send the probe far away
            with suppress(DeviceError):
                measured_mm = max(measured_mm, self._rig.depth_at(self._devices.actuator.position_deg()))
        return measured_mm

    def log_escape(self, position_deg: float, preset: float, notes: list[str]) -> ForceSample | None:
        """A row while the probe is taken away after the end, and the force then; None where the sensor has gone.

        ``notes`` is told when the disk is full."""
        assert self.motion is not None
        sample: ForceSample | None = None
        with suppress(DeviceError):
            sample = self._devices.force.read()
        time_s, force_n = (sample.time_s, self._rig.pushing_n(sample)) if sample else (None, None)
        if sample:
            self._note_peak(sample)
        row = Row(
            self._clock.now_s(), self.motion.repetition, "escape", time_s, force_n, None, position_deg,
            preset * self._rig.full_preset, None, (), self._record.frame_index, None,
            *(loads_of(sample) if sample else ()),
        )  # fmt: skip
        try:
            self._record.row(row)
            if self._rig.record_full_rate_force:
                self._record.all_forces(self._devices.force.read_all())
        except DeviceError as error:
            notes.append(str(error))
        return sample

    def _note_peak(self, sample: ForceSample) -> None:
        felt_n = sample.size_n
        if self.peak_force_n is None or felt_n > self.peak_force_n:  # no number is never larger
            self.peak_force_n = felt_n if math.isfinite(felt_n) else self.peak_force_n

    def _feel(self) -> Force:
        with _STALE:
            sample = self._devices.force.read()
        assert self.motion is not None
        self._note_peak(sample)
        self._witnesses.feel(sample, self.motion.phase)
        if self._rig.record_full_rate_force:
            with _RECORDING:
                self._record.all_forces(self._devices.force.read_all())
        raw_n = self._rig.pushing_n(sample)
        return Force(raw_n, self._average.update(raw_n), sample)

    def _look(self, now_s: float) -> None:
        if self._devices.camera is None:
            return
        with _CAMERA:
            frames = self._devices.camera.frames()
        for frame in frames:
            with _RECORDING:
                self._record.frame(frame)
            self._frame_s = now_s

    def _ask(self, now_s: float) -> None:
        # motors that have gone off do not follow, and that is then the cause
        astray = self._witnesses.seen.astray_deg > self._limits.following_deg
        if astray or now_s - self._asked_s >= self._limits.motors_every_s:
            with _DEVICE:
                self._active = self._devices.actuator.is_active()
            self._asked_s = now_s

    def _moment(self, force: Force, wanted: Motion, now_s: float, late_s: float) -> Moment:
        before = self._before or force
        return Moment(
            now_s=now_s, late_s=late_s, period_s=self._rig.period_s,
            force=force.sample, before=before.sample, force_n=force.raw_n, force_before_n=before.raw_n,
            angle_deg=self._plan.angle_deg, phase=wanted.phase, rating=self._devices.force.rating,
            frame_s=self._frame_s if self._devices.camera else None,
            depth_mm=wanted.depth_mm, travel_mm=self._plan.travel_mm, active=self._active,
            seen=self._witnesses.seen, contact_n=self._plan.f_contact_n,
        )  # fmt: skip

    def _judge(self, moment: Moment) -> None:
        if found := tripped(moment, self._limits, self._guards):
            raise EndRun("guard", *found)

    def _enter(self, wanted: Motion, force: Force) -> None:
        assert self.motion is not None
        begins = wanted.repetition != self.motion.repetition
        self.motion = wanted
        if begins:
            # a zero error above the contact threshold would be mistaken for contact, and add to the press force
            self._free("before the press")
            with _RECORDING:
                self._pressed = True
                self._record.begin_press(wanted.repetition, force.sample.time_s)

    def _compare(self) -> None:
        gain = self._witnesses.gain()
        skin = self._limits.skin_friction * math.sin(math.radians(self._plan.angle_deg))
        if gain is not None and not GAINS[0] - skin <= gain <= GAINS[1] + skin:
            of = f"of the force by {self._witnesses.seen.told_by}"
            why = f"the force sensor feels {gain:.2f} {of}: look at its calibration and at the gear"
            self._record.doubt_press(why, "doubtful")
        kappa = self._specimen.kappa()
        self._record.press_kappa(kappa)
        short = self._plan.condition == RIGID and self._plan.motor_a_per_n is None and kappa is None
        if short or not self._plan.witnessed:
            self._record.doubt_press(_UNWITNESSED, "doubtful")
        if doubt := self._specimen.doubt():
            self._record.doubt_press(doubt, "doubtful")

    def _weigh(self, motion: Motion, force: Force, at: Measurements, now_s: float) -> None:
        """Let the specimen be a witness."""
        off = None
        if motion.phase in ("contact", "load"):
            across_n = math.sqrt(max(0.0, force.sample.size_n**2 - force.raw_n**2))
            loaded_s = now_s - motion.since_s if motion.phase == "load" else None
            off = self._specimen.read(force.raw_n, across_n, self._rig.depth_at(at.shaft_deg), loaded_s)
        self._witnesses.seen.off_specimen = off

    def _free(self, when: str) -> None:
        felt_n = self._witnesses.mean_n
        if felt_n >= self._plan.f_contact_n:
            raise EndRun("guard", "preload", f"{felt_n:.2f} N {when}, with the probe retracted")

    def _send(self, wanted: Motion) -> None:
        command = self._rig.position_at(wanted.depth_mm), self._preset(wanted)
        self._devices.actuator.command(*command)
        self._sent = command
        self._witnesses.send(*command, self._clock.now_s())  # a turn held up before commands later

    def _preset(self, motion: Motion) -> float:
        if motion.stiff and self._sent is not None and self._plan.schedule is not None:
            wanted = self._stiffest
        else:
            wanted = self._plan.preset(motion.step, self._rig.full_preset)
        if self._sent is None:
            return max(wanted, self._stands_at)  # motors that turn back at once would leave the way to their command
        if motion.phase not in ("home", "approach"):
            return wanted
        way = wanted - self._sent[1]
        # to the wanted one itself, which sums of many steps would miss by their rounding
        return wanted if abs(way) <= self._slew else self._sent[1] + math.copysign(self._slew, way)

    def _log(
        self, now_s: float, late_s: float, force: Force, at: Measurements | None, currents_a: tuple[float, ...]
    ) -> None:
        assert self.motion is not None
        sent: tuple[float | None, float | None] = (None, None)
        if self._sent is not None:
            sent = self._sent[0], self._sent[1] * self._rig.full_preset
        row = Row(
            now_s, self.motion.repetition, self.motion.phase, force.sample.time_s, force.raw_n, force.filtered_n,
            *sent, at, currents_a, self._record.frame_index, late_s, *loads_of(force.sample),
        )  # fmt: skip
        with _RECORDING:
            self._record.row(row)


def _answers_in_s(actuator: Actuator, clock: Clock) -> float:
    """How long a question takes. That of the fastest quarter counts: an adapter that keeps bytes slows them all, a busy
    computer some."""
    took_s = []
    for _ in range(_QUESTIONS):
        asked_s = clock.now_s()
        actuator.measurements()
        took_s.append(clock.now_s() - asked_s)
    return sorted(took_s)[_QUESTIONS // 4]


class ending:
    """A DeviceError within ends the run for this cause. Made once: every turn of the loop enters many."""

    __slots__ = ("_cause",)

    def __init__(self, cause: str) -> None:
        self._cause = cause

    def __enter__(self) -> None:
        """Nothing to begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, DeviceError):
            raise EndRun("guard", self._cause, str(error)) from error


_STALE, _RECORDING, _CAMERA, _DEVICE = map(ending, ("stale sensor", "recording", "lost camera", "lost device"))
