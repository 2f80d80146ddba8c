"""The folder of a run: plan.json, log.csv, presses.csv, ended.json, and press-001 ... where there is a camera.

A press holds frames and forces from the approach to the end of loading, which is all that CASR needs; the log goes on.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from emg2vsa.devices.protocols import ForceCounts, ForceSample, Frame, LogColumns, PressJudge
from emg2vsa.devices.qbmove.ticks import LOG_COLUMNS, in_ticks
from emg2vsa.durable.append_file import AppendFile
from emg2vsa.durable.writer import AT_ONCE, Writer
from emg2vsa.errors import DeviceError
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended, ended_bytes
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.press_counts import HEADER, PRESSES_FILE, PressKappa, PressTally, Verdict, line_of
from emg2vsa.rig.record.press_recorder import PressRecorder
from emg2vsa.rig.record.run_log import ForceFile, Row, RunLog
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.schedules.document import document_of

ALL_FORCES_FILE = "force-full-rate.csv"
"""Every record of the sensor, where the rig file wants them."""
_KILLED = Ended("killed", "", "the program was killed; log.csv tells how far it came", "", 0, 0.0, "")
_CLOCK = "seconds on a clock that never goes back nor jumps; 0 s is zero_utc, whatever the computer's clock does later"


class RunRecord:
    """Writes it. DeviceError, here and in every method: a run is there already, or the disk is full.

    ``started`` : date and time at 0 s of the log's clock. ``frame_shape`` : (height, width) px; None without a camera.
    ``columns`` : of the actuator in the log.
    ``delay_s`` : of the camera; frames are on their way for so long. ``writer`` : who waits for the disk.
    ``force_counts`` : of the force sensor, at any moment. ``judge`` : is shown what is kept of a press, and may say
    that it has seen enough.
    """

    def __init__(
        self,
        folder: Path,
        started: datetime,
        frame_shape: tuple[int, int] | None,
        columns: LogColumns,
        *,
        delay_s: float = 0.0,
        writer: Writer = AT_ONCE,
        force_counts: Callable[[], ForceCounts] = ForceCounts,
        judge: PressJudge | None = None,
    ) -> None:
        self._folder, self._started, self._frame_shape, self._delay_s = folder, started, frame_shape, delay_s
        self._columns = columns
        self._judge = judge
        self._writer, self._force_counts, self._rig = writer, force_counts, RigSettings()
        # says from the start that the run was killed: so a killed run says so itself, and a full disk hides no cause
        self._ended = AppendFile(folder / "ended.json", writer)
        self._ended.append(ended_bytes(replace(_KILLED, at=started.isoformat())))
        self.log = RunLog(folder / "log.csv", columns, writer)
        self._presses = AppendFile(folder / PRESSES_FILE, writer)
        self._presses.append(f"{HEADER}\n".encode())
        self._forces: ForceFile | None = None
        self._press: PressRecorder | None = None
        self._tally: PressTally | None = None
        self._over: PressTally | None = None
        self._begun_s, self._turned_s = 0.0, math.inf
        self._notes: list[str] = []
        self._f_max_n = 0.0
        self.presses_done = 0
        self.rejected: list[str] = []
        "A line for each press that is over and does not count."

    def plan(self, plan: RunPlan, rig: RigSettings, devices: Mapping[str, Any] | None = None) -> None:
        """Write plan.json, and wait for it. ``devices`` : what they say of themselves, by name."""
        self._rig, self._f_max_n = rig, plan.f_max_n
        schedule = None if plan.schedule is None else document_of(plan.schedule)
        document = {
            "plan": asdict(replace(plan, schedule=None)) | {"schedule": schedule},
            "rig": rig_document(rig, self._columns),
            "clock": {"zero_utc": self._started.astimezone(UTC).isoformat(), "time_s": _CLOCK},
            "devices": dict(devices or {}),
        }
        file = AppendFile(self._folder / PLAN_FILE, self._writer)
        file.append((json.dumps(document, indent=2) + "\n").encode())
        file.close()
        if rig.record_full_rate_force:
            self._forces = ForceFile(self._folder / ALL_FORCES_FILE, self._writer)
        self._writer.finish()

    def begin_press(self, repetition: int, time_s: float) -> None:
        """Frames taken from ``time_s``, s, on, and forces, are kept as one press to the end of loading."""
        self._close_press()
        self._close_tally(time_s)
        self._begun_s, self._turned_s = time_s, math.inf
        self._tally = PressTally(repetition, time_s, self._rig, self._force_counts())
        if self._frame_shape is not None:
            self._press = PressRecorder(self._folder / f"press-{repetition:03d}", self._frame_shape, self._writer)

    def frame(self, frame: Frame) -> None:
        """Keep a frame that was taken during a loading; nobody looks at others."""
        if self._press is None or frame.time_s < self._begun_s:
            return
        if frame.time_s > self._turned_s:
            self._close_press()
        else:
            self._press.frame(frame.image, frame.time_s)
            if self._tally:
                self._tally.frame(frame)
                if self._judge is not None:
                    self._judge.frame(self._tally.repetition, frame)

    @property
    def frame_index(self) -> int:
        """Last frame kept of the loading that is being recorded; -1 for none."""
        return -1 if self._press is None else self._press.n_frames - 1

    def row(self, row: Row) -> None:
        """Log a row; its raw force belongs to the press as well."""
        self.log.append(row)
        if self._tally is not None:
            self._tally.row(row)
        if self._press is None or row.force_n is None or row.force_time_s is None:
            return
        self._press.force(row.force_time_s, row.force_n)
        if self._judge is not None:
            self._judge.force(row.force_time_s, row.force_n)

    def enough(self, force_n: float) -> bool:
        """Whether the judge has seen enough of the press that is being loaded; the press then counts as stopped at this
        force, N, and not as a whole one."""
        if self._judge is None or self._tally is None or not (why := self._judge.stop(self._tally.repetition)):
            return False
        self._tally.stop(f"at {force_n:.2f} N: {why}")
        return True

    def all_forces(self, samples: Sequence[ForceSample]) -> None:
        """Keep all that the sensor has measured, where the rig file wants that."""
        if self._forces is not None:
            self._forces.append(samples)

    def press_kappa(self, kappa: PressKappa | None) -> None:
        """Stiffness of the specimen by the press that is going on."""
        if self._tally is not None and kappa is not None:
            self._tally.kappa(kappa)

    def doubt_press(self, why: str, verdict: Verdict = "rejected") -> None:
        """The press that is going on is not to be trusted."""
        if self._tally is not None:
            self._tally.doubt(why, verdict)

    def end_loading(self, time_s: float) -> None:
        """The press turned back at ``time_s``, s: its files are given back, once all frames of its loading have come.
        What follows says nothing of how the contact spreads, and is in the log."""
        self._turned_s = time_s
        if self._tally is not None:
            self._tally.turn_back(time_s, self._force_counts())
        if self._delay_s == 0:  # none is on its way
            self._close_press()

    def end_press(self) -> None:
        """The press is over."""
        self.presses_done += 1
        self._close_press()
        self._close_tally(self._turned_s)
        counts = self._over.counts() if self._over else None
        # a lead foresees the force, and may foresee too much
        if counts and not counts.stopped and counts.peak_force_n < self._f_max_n:
            self._notes.append(
                f"press {counts.repetition} ended at {counts.peak_force_n:.2f} N, short of f_max_n, "
                f"{self._f_max_n:g} N: choose a smaller lead_s"
            )

    def end(self, ended: Ended) -> Ended:
        """Write ended.json and close everything; ``ended`` with what only the record knows."""
        at = (self._started + timedelta(seconds=ended.time_s)).isoformat()
        refused: list[str] = []
        if ended.how != "completed":
            self.doubt_press(f"the run ended in it: {ended.cause}", "doubtful")
        steps = [self._close_press, lambda: self._close_tally(ended.time_s), self._writer.finish]
        if self._tally is None and not ended.retracted:  # stuck after its last press
            steps.insert(0, self._reject_last)
        for last in steps:
            try:
                last()
            except DeviceError as error:
                refused.append(str(error))
        notes = tuple(dict.fromkeys((*ended.notes, *self._notes, *refused)))
        ended = replace(ended, at=at, rows=self.log.rows, repetitions_done=self.presses_done, notes=notes)
        try:
            self._ended.patch(0, ended_bytes(ended))
            self._writer.finish()
        except DeviceError as error:
            ended = replace(ended, notes=(*ended.notes, str(error)))
        for file in (self.log, self._presses, self._forces, self._ended):
            if file is not None:
                with suppress(DeviceError):
                    file.close()
        return ended

    def _close_press(self) -> None:
        if self._press is not None:
            press, self._press = self._press, None
            counts = self._tally.counts() if self._tally else None
            if counts and counts.verdict != "ok":
                press.remark(f"{counts.verdict}: {counts.why}")
            if counts and counts.stopped:
                press.remark(f"stopped: {counts.stopped}")
            press.close()
            if self._judge is not None:
                self._judge.press_over()

    def _close_tally(self, time_s: float) -> None:
        if self._tally is None:
            return
        tally, self._tally, self._over = self._tally, None, self._tally
        tally.turn_back(time_s, self._force_counts())
        self._write_tally(tally)

    def _reject_last(self) -> None:
        """Its probe is not away, or a force that shall be free is not: so its own force is not to be trusted. Of two
        lines for a press the last holds."""
        if self._over is not None:
            self._over.doubt("the probe was not retracted after it")
            self._write_tally(self._over)

    def _write_tally(self, tally: PressTally) -> None:
        counts = tally.counts()
        if counts.verdict != "ok":
            self._notes.append(f"press {counts.repetition} is {counts.verdict}: {counts.why}")
        if counts.verdict == "rejected":
            self.rejected.append(self._notes[-1])
        self._presses.append(line_of(counts).encode())


def rig_document(rig: RigSettings, columns: LogColumns) -> dict[str, Any]:
    """The rig as plan.json has it: of a qbmove in ticks, as its log."""
    return in_ticks(asdict(rig)) if columns == LOG_COLUMNS else asdict(rig)
