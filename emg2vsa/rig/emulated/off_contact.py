"""A run in virtual time that makes short work of the turns in which nothing is near the probe: 90 % of them.

Every guard looks at every turn near the specimen and in contact. Off contact, guards that cannot speak are not asked.
Devices, log and frames are the same either way; ``[emulated] exact = true`` does without.
"""

from __future__ import annotations

from contextlib import suppress
from operator import le
from typing import NamedTuple

from emg2vsa.rig.clock import Beat, Clock
from emg2vsa.rig.devices import Devices, ForceSample, Measurements
from emg2vsa.rig.emulated.camera import EmulatedCamera
from emg2vsa.rig.emulated.direct_drivers import DirectNetFt, Near
from emg2vsa.rig.executor.control_cycle import ControlCycle, Force, Readings, ending
from emg2vsa.rig.executor.guards import AFTER_READING, GAP_AT_REST_N
from emg2vsa.rig.executor.motion import Motion, advance
from emg2vsa.rig.force.rdt import Record
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import EndRun
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.record.run_record import RunRecord
from emg2vsa.rig.rig_settings import RigSettings

_PHASES = ("approach", "retract", "pause")
_TOGETHER_S = 0.5
"Turns of no more than this are written together: the driver of the sensor keeps the records of a second."


class _Turn(NamedTuple):
    now_s: float
    record: Record
    time_s: float
    motion: Motion
    command: tuple[int, int]
    at: Measurements
    currents_ma: tuple[int, int]


class OffContactCycle(ControlCycle):
    """The control loop of such a run.

    Turns are gone through together where the phase goes on, the forces of these turns and of those that the filter
    remembers are far below contact and below every limit, and the motors say that they are on when asked. No guard but
    that of the motors' way can speak in them: a turn in which another might is a full one.

    devices : of a bench, not exact. near : whether anything is near the probe.
    """

    def __init__(
        self, plan: RunPlan, rig: RigSettings, devices: Devices, record: RunRecord, clock: Clock, *, near: Near
    ) -> None:
        super().__init__(plan, rig, devices, record, clock)
        assert isinstance(devices.force, DirectNetFt)
        assert devices.camera is None or isinstance(devices.camera, EmulatedCamera)
        self._force, self._camera, self._near = devices.force, devices.camera, near
        self._calm = 0
        "Turns before this one, without a gap, in which the force was small."
        self._turns: list[_Turn] = []
        "Gone through, and not looked at again yet."
        self._rows: list[Row] = []
        "Not written yet."

    def start(self) -> None:
        """As `ControlCycle.start`."""
        super().start()
        plan, limits, rating = self._plan, self._limits, self._force.rating
        jump_n = limits.force_rate_n_per_s * self._rig.period_s / 2
        # of each axis; all three together are less than twice as much
        forces_n = plan.f_contact_n, limits.force_n, limits.lateral_n, jump_n, *(rating.force_n if rating else ())
        torques_nm = limits.torque_nm, *(rating.torque_nm if rating else (limits.torque_nm,))
        most_n, most_nm = min(forces_n) / 2, min(torques_nm) / 2
        self._most_counts = [
            most / step for most, step in zip([most_n] * 3 + [most_nm] * 3, self._force.steps, strict=True)
        ]
        self._most_spring_n = min(GAP_AT_REST_N, limits.spring_gap_n, limits.spring_n) - most_n

    def go_on(self, beat: Beat) -> tuple[Motion, float]:
        """Turns off contact, as many as can be gone through together, and the full one after them."""
        try:
            now_s, late_s = beat.wait()
            while self._passes(now_s, late_s):
                now_s, late_s = beat.wait()
            self._recall()
            motion = self.turn(now_s, late_s)
        except BaseException:
            self._recall()
            self._write()
            raise
        # whoever carries out the run tells its record of a phase that begins
        if motion.since_s == now_s or self._record.judged or now_s - self._rows[0].time_s > _TOGETHER_S:
            self._write()
        return motion, now_s

    def log_escape(self, position_ticks: int, preset_ticks: int, notes: list[str]) -> ForceSample | None:
        """As `ControlCycle.log_escape`."""
        with suppress(EndRun):
            self._write()
        return super().log_escape(position_ticks, preset_ticks, notes)

    def _passes(self, now_s: float, late_s: float) -> bool:
        """Go through a turn without its guards and its log. False: it is for a full turn, to which the sensor gives the
        same sample again."""
        before, limits, witnesses = self.motion, self._limits, self._witnesses
        assert before is not None
        if before.phase not in _PHASES or late_s > 0 or self._near():
            self._calm = 0
            return False
        seen = self._force.newest
        record, time_s = self._force.take(far=True)
        changed = seen is not None and seen.counts != record.counts
        small = True not in map(le, self._most_counts, map(abs, record.counts))
        self._calm = self._calm + 1 if small and changed and record.status == 0 else 0
        if self._calm <= self._rig.filter_samples or now_s - time_s > limits.stale_s:
            return False
        if now_s - self._frame_s > limits.camera_s:
            return False
        wanted = advance(before, self._plan, 0.0, now_s, now_s - self._turned_s)
        if wanted.phase != before.phase or wanted.depth_mm > self._plan.travel_mm:
            return False
        command = self._rig.ticks_at(wanted.depth_mm), self._preset_ticks(wanted)
        actuator = self._devices.actuator
        at, currents_ma = actuator.measurements(), actuator.currents_ma()
        if not witnesses.surely_idles(currents_ma, limits.current_ma):
            return False
        if abs(witnesses.spring_of(at) or 0.0) > self._most_spring_n:
            return False
        if before.phase == "approach" and self._rig.depth_at(at.shaft) > limits.contact_mm:
            return False
        if now_s - self._asked_s >= limits.motors_every_s:
            with ending("lost device"):
                if not actuator.is_active():
                    return False
            self._asked_s = now_s
        if self._turns and now_s - self._turns[0].now_s > _TOGETHER_S:
            self._recall()
            self._write()
        if self._camera is not None and self._camera.due_s <= now_s:
            self._look(now_s)
        actuator.set_position_stiffness(*command)
        witnesses.send(*command, now_s)
        self.motion, self._turned_s, self._sent = wanted, now_s, command
        self._turns.append(_Turn(now_s, record, time_s, wanted, command, at, currents_ma))
        if witnesses.astray_ticks(at) > limits.following_ticks:
            self._recall()
            assert self._before is not None
            self._judge(self._before, wanted, now_s, late_s, AFTER_READING)
        return True

    def _look(self, now_s: float) -> None:
        # rows of the turns before a frame bear the number of the frame before
        if self._record.pressing and self._camera is not None and self._camera.due_s <= now_s:
            self._recall()
            self._write()
        super()._look(now_s)

    def _enter(self, wanted: Motion, force: Force) -> None:
        assert self.motion is not None
        if wanted.repetition != self.motion.repetition:
            self._write()
        super()._enter(wanted, force)

    def _log(self, now_s: float, late_s: float, force: Force, readings: Readings) -> None:
        assert self.motion is not None
        self._rows.append(self._row(now_s, late_s, force, readings, self.motion, self._sent or (None, None)))

    def _write(self) -> None:
        rows, self._rows = self._rows, []
        if rows:
            with ending("recording"):
                self._record.rows(rows)

    def _recall(self) -> None:
        """The rows of the turns that have been gone through, and what the loop remembers of them."""
        turns, self._turns = self._turns, []
        if not turns:
            return
        with ending("recording"):
            self._record.all_forces(self._devices.force.read_all)
            samples = [self._force.sample_of(turn.record, turn.time_s) for turn in turns]
            for turn, sample in zip(turns, samples, strict=True):
                self._note_peak(sample)
                raw_n = self._rig.pushing_n(sample)
                force = Force(raw_n, self._average.update(raw_n), sample)
                readings = *turn.at, *turn.currents_ma
                self._rows.append(self._row(turn.now_s, 0.0, force, readings, turn.motion, turn.command))
            last, before = turns[-1], turns[:-1]
            self._witnesses.skim(
                samples[:-1],
                [turn.currents_ma for turn in before],
                before[-1].at if before else None,
                last.motion.phase,
            )
            self._witnesses.feel(samples[-1], last.motion.phase)
            self._witnesses.read(last.at, last.currents_ma, force.raw_n, last.motion, begins=False)
            self._before = force
