"""A run in virtual time that makes short work of the turns in which nothing is near the probe: 90 % of them.

While a press is measured, from near the specimen to the end of loading, the drivers speak byte for byte. Elsewhere they
ask the emulated devices themselves. Every guard looks at every turn near the specimen and in contact. Off contact,
guards that cannot speak are not asked. Devices, log and frames are the same either way; ``[emulated] exact = true``
does without.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from emg2vsa.rig.clock import Beat, Clock
from emg2vsa.rig.devices import Devices, ForceSample, Measurements
from emg2vsa.rig.emulated.camera import EmulatedCamera
from emg2vsa.rig.emulated.qbmove_firmware import QbmoveFirmware
from emg2vsa.rig.emulated.rdt_box import RdtBox
from emg2vsa.rig.executor.control_cycle import ControlCycle, Force, ending
from emg2vsa.rig.executor.guards import AFTER_READING, GAP_AT_REST_N
from emg2vsa.rig.executor.motion import Motion, advance
from emg2vsa.rig.force.net_ft import NetFt
from emg2vsa.rig.force.rdt import Record
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.qbmove.driver import Qbmove
from emg2vsa.rig.qbmove.packets import Command
from emg2vsa.rig.record.run_record import RunRecord
from emg2vsa.rig.rig_settings import RigSettings

Near = Callable[[], bool]
"""Whether the probe is in contact, or so near that it may be within a turn of the loop."""
_PHASES = ("approach", "retract", "pause")
_UNMEASURED = ("retract", "pause")
"Nothing that is felt in these is scored."
_TOGETHER_S = 0.5
"Turns of no more than this are written together: the driver of the sensor keeps the records of a second."


class Nearness:
    """What the drivers of such a run go by. near : as given. measuring : whether a press is being measured."""

    def __init__(self, near: Near) -> None:
        self.near, self.measuring = near, True

    def speaks(self) -> bool:
        """Whether the drivers speak byte for byte."""
        return self.measuring and self.near()


class OffContactQbmove(Qbmove):
    """What a run sends and asks in every turn goes straight to the ``firmware``; all else over the line."""

    def __init__(self, *given: Any, firmware: QbmoveFirmware, nearness: Nearness, **named: Any) -> None:
        super().__init__(*given, **named)
        self._firmware, self._nearness = firmware, nearness

    def _tell_ticks(self, command: Command, first: int, second: int) -> None:
        if self._nearness.speaks():
            super()._tell_ticks(command, first, second)
        else:
            self._firmware.tell(command, first, second)

    def _ask_words(self, command: Command, count: int) -> tuple[int, ...]:
        return super()._ask_words(command, count) if self._nearness.speaks() else self._firmware.ask(command)


class OffContactNetFt(NetFt):
    """Records come straight from the ``box`` while the drivers need not speak."""

    def __init__(self, *given: Any, box: RdtBox, nearness: Nearness, **named: Any) -> None:
        self._box, self._nearness = box, nearness
        self._far = False
        "Whether nothing was near at the last look."
        super().__init__(*given, **named)

    def _arrived(self) -> bool:
        if self._newest is None or self._nearness.speaks():
            self._far = False
            return super()._arrived()
        self.take(far=not self._nearness.near())
        return True

    @property
    def newest(self) -> Record | None:
        """The newest record that has been taken."""
        return self._newest[0] if self._newest else None

    def take(self, *, far: bool) -> tuple[Record, float]:
        """The newest record and its time. far : nothing is near the probe."""
        assert self._newest is not None
        now_s = self._looked_s = self._clock.now_s()
        newest, newest_s = self._newest
        free, self._far = far and self._far, far
        # as a stream without gaps: faults are put only into exact benches
        records = self._box.records_until(now_s, free=free)
        for record, sent_s in records:
            age_s = now_s - sent_s
            newest_s = max(now_s - age_s, newest_s)  # as of a datagram, whose age is told
            if record.counts != newest.counts:
                self._changed_s = newest_s
            newest = record
            self._unread.append((record, newest_s))
        self._records += len(records)
        self._newest = newest, newest_s
        return self._newest

    def sample_of(self, record: Record, time_s: float) -> ForceSample:
        """As `read` gives it."""
        return self._sample(record, time_s)

    @property
    def steps(self) -> list[float]:
        """Of the six counts, N and N m."""
        return self._scale.tolist()


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

    devices : of a bench, not exact. nearness : which they go by.
    """

    def __init__(
        self, plan: RunPlan, rig: RigSettings, devices: Devices, record: RunRecord, clock: Clock, *, nearness: Nearness
    ) -> None:
        super().__init__(plan, rig, devices, record, clock)
        assert isinstance(devices.force, OffContactNetFt)
        assert devices.camera is None or isinstance(devices.camera, EmulatedCamera)
        self._force, self._camera, self._nearness = devices.force, devices.camera, nearness
        self._calm = 0
        "Turns before this one, without a gap, in which the force was small."
        self._turns: list[_Turn] = []
        "Gone through, and not written yet."

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
        finally:
            self._write()
        return self.turn(now_s, late_s), now_s

    def turn(self, now_s: float, late_s: float) -> Motion:
        """As `ControlCycle.turn`."""
        assert self.motion is not None
        self._nearness.measuring = self.motion.phase not in _UNMEASURED
        return super().turn(now_s, late_s)

    def _passes(self, now_s: float, late_s: float) -> bool:
        """Go through a turn without its guards and its log. False: it is for a full turn, to which the sensor gives the
        same sample again."""
        before, limits, witnesses = self.motion, self._limits, self._witnesses
        assert before is not None
        if before.phase not in _PHASES or late_s > 0 or self._nearness.near():
            self._calm = 0
            return False
        seen = self._force.newest
        record, time_s = self._force.take(far=True)
        changed = seen is not None and seen.counts != record.counts
        small = all(-most < count < most for most, count in zip(self._most_counts, record.counts, strict=True))
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
        comes = self._camera is not None and self._camera.due_s <= now_s
        # rows of the turns before a frame bear the number of the frame before
        if (comes and self._record.pressing) or (self._turns and now_s - self._turns[0].now_s > _TOGETHER_S):
            self._write()
        if comes:
            self._look(now_s)
        actuator.set_position_stiffness(*command)
        witnesses.send(*command, now_s)
        self.motion, self._turned_s, self._sent = wanted, now_s, command
        self._turns.append(_Turn(now_s, record, time_s, wanted, command, at, currents_ma))
        if witnesses.astray_ticks(at) > limits.following_ticks:
            self._write()
            assert self._before is not None
            self._judge(self._before, wanted, now_s, late_s, AFTER_READING)
        return True

    def _write(self) -> None:
        """The rows of the turns that have been gone through, and what the loop remembers of them."""
        turns, self._turns = self._turns, []
        if not turns:
            return
        with ending("recording"):
            self._record.all_forces(self._devices.force.read_all)
            samples, rows = [self._force.sample_of(turn.record, turn.time_s) for turn in turns], []
            for turn, sample in zip(turns, samples, strict=True):
                self._note_peak(sample)
                raw_n = self._rig.pushing_n(sample)
                force = Force(raw_n, self._average.update(raw_n), sample)
                rows.append(self._row(turn.now_s, 0.0, force, (*turn.at, *turn.currents_ma), turn.motion, turn.command))
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
            self._record.rows(rows)
