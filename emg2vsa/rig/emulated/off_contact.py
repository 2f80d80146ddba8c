"""A run in virtual time that makes short work of the turns in which nothing is near the probe: 90 % of them.

Near the specimen, and in contact, the drivers speak byte for byte, and every guard looks at every turn. Elsewhere they
ask the emulated devices themselves, and guards that cannot speak are not asked. Devices, log and frames are the same
either way; ``[emulated] exact = true`` does without.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from emg2vsa.errors import DeviceError
from emg2vsa.rig.devices import ForceSample
from emg2vsa.rig.emulated.qbmove_firmware import QbmoveFirmware
from emg2vsa.rig.emulated.rdt_box import RdtBox
from emg2vsa.rig.executor.control_cycle import UNREAD, ControlCycle, ending
from emg2vsa.rig.executor.guards import AFTER_READING, GUARDS
from emg2vsa.rig.executor.motion import Motion, advance
from emg2vsa.rig.force.net_ft import NetFt
from emg2vsa.rig.qbmove.driver import Qbmove
from emg2vsa.rig.qbmove.packets import Command

Near = Callable[[], bool]
"""Whether the probe is in contact, or so near that it may be within a turn of the loop."""
_PHASES = ("approach", "retract", "pause")
_MAY_SPEAK = AFTER_READING | {name: GUARDS[name] for name in ("frozen force", "stale sensor", "lost camera")}


class OffContactQbmove(Qbmove):
    """What a run sends and asks in every turn goes straight to the ``firmware``; all else over the line."""

    def __init__(self, *given: Any, firmware: QbmoveFirmware, near: Near, **named: Any) -> None:
        super().__init__(*given, **named)
        self._firmware, self._near = firmware, near

    def _tell_ticks(self, command: Command, first: int, second: int) -> None:
        if self._near():
            super()._tell_ticks(command, first, second)
        else:
            self._firmware.tell(command, first, second)

    def _ask_words(self, command: Command, count: int) -> tuple[int, ...]:
        return super()._ask_words(command, count) if self._near() else self._firmware.ask(command)


class OffContactNetFt(NetFt):
    """Records come straight from the ``box``, which feels nothing."""

    def __init__(self, *given: Any, box: RdtBox, near: Near, **named: Any) -> None:
        self._box, self._near = box, near
        self._far = False
        "Whether nothing was near at the last look."
        super().__init__(*given, **named)

    def _arrived(self) -> bool:
        newest = self._newest
        if newest is None or self._near():
            self._far = False
            return super()._arrived()
        now_s = self._looked_s = self._clock.now_s()
        newest_s = newest[1]
        far, self._far = self._far, True
        for record, sent_s in self._box.records_until(now_s, free=far):
            age_s = now_s - sent_s
            newest_s = max(now_s - age_s, newest_s)  # as of a datagram, whose age is told
            self._take(record, newest_s)
        return True


class OffContactCycle(ControlCycle):
    """The control loop of such a run.

    A turn is short where the phase goes on, the forces of this turn and of those that the filter remembers are far
    below contact and below every limit, and the motors need not be asked whether they are on. The guards that judge
    force and lateness cannot speak then; the others are asked.

    near : whether the probe is near the specimen.
    """

    def __init__(self, *given: Any, near: Near) -> None:
        super().__init__(*given)
        self._near, self._calm = near, 0

    def start(self) -> None:
        """As `ControlCycle.start`."""
        super().start()
        plan, limits, rating = self._plan, self._limits, self._devices.force.rating
        jump_n = limits.force_rate_n_per_s * self._rig.period_s / 2
        # of each axis; all three together are less than twice as much
        forces_n = plan.f_contact_n, limits.force_n, limits.lateral_n, jump_n, *(rating.force_n if rating else ())
        torques_nm = limits.torque_nm, *(rating.torque_nm if rating else ())
        self._small_n, self._small_nm = min(forces_n) / 2, min(torques_nm) / 2

    def turn(self, now_s: float, late_s: float) -> Motion:
        """As `ControlCycle.turn`."""
        before = self.motion
        assert before is not None
        if before.phase not in _PHASES or late_s > 0 or self._near():
            self._calm = 0
            return super().turn(now_s, late_s)
        sample = self._small_sample()
        if sample and now_s - self._asked_s < self._limits.motors_every_s:
            wanted = advance(before, self._plan, 0.0, now_s, now_s - self._turned_s)
            if wanted.phase == before.phase and wanted.depth_mm <= self._plan.travel_mm:
                self._short(wanted, sample, now_s, late_s)
                return wanted
        return super().turn(now_s, late_s)

    def _small_sample(self) -> ForceSample | None:
        """The newest sample, where it and those that the filter remembers are small. A full turn gets it again."""
        try:
            sample = self._devices.force.read()
        except DeviceError:
            return None
        x, y, z = sample.force_n.tolist()
        small_n, small_nm = self._small_n, self._small_nm
        small = -small_n < x < small_n and -small_n < y < small_n and -small_n < z < small_n
        x, y, z = sample.torque_nm.tolist()
        small = small and -small_nm < x < small_nm and -small_nm < y < small_nm and -small_nm < z < small_nm
        self._calm = self._calm + 1 if small and not sample.status.faults else 0
        return sample if self._calm > self._rig.filter_samples else None

    def _short(self, wanted: Motion, sample: ForceSample, now_s: float, late_s: float) -> None:
        force = self._felt(sample)
        readings = UNREAD
        try:
            self._look(now_s)
            self.motion = wanted
            self._send(wanted)
            self._turned_s, self._before = now_s, force
            with ending("lost device"):
                at, currents_ma = self._devices.actuator.measurements(), self._devices.actuator.currents_ma()
            readings = (*at, *currents_ma)
            self._witnesses.read(at, currents_ma, force.raw_n, wanted, begins=False)
            self._judge(force, wanted, now_s, late_s, _MAY_SPEAK)
        finally:
            self._log(now_s, late_s, force, readings)
