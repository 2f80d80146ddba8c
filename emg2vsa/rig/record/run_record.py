"""The folder of a run: plan.json, log.csv, ended.json, and press-001, press-002 ... where there is a camera.

A press holds frames and forces from the approach to the end of loading, which is all that CASR needs; the log goes on.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, replace
from datetime import datetime, timedelta
from pathlib import Path

from emg2vsa.errors import DeviceError
from emg2vsa.rig.devices import Frame
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.append_file import AppendFile
from emg2vsa.rig.record.ended import Ended, ended_bytes
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.press_recorder import PressRecorder
from emg2vsa.rig.record.run_log import Row, RunLog
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.schedules.document import document_of

_KILLED = Ended("killed", "", "the program was killed; log.csv tells how far it came", "", 0, 0.0, "")


class RunRecord:
    """Writes it. DeviceError, here and in every method: a run is there already, or the disk is full.

    ``started`` : date and time at 0 s of the log's clock. ``frame_shape`` : (height, width) px; None without a camera.
    ``delay_s`` : of the camera; frames are on their way for so long.
    """

    def __init__(
        self, folder: Path, started: datetime, frame_shape: tuple[int, int] | None, *, delay_s: float = 0.0
    ) -> None:
        self._folder, self._started, self._frame_shape, self._delay_s = folder, started, frame_shape, delay_s
        # says from the start that the run was killed: so a killed run says so itself, and a full disk hides no cause
        self._ended = AppendFile(folder / "ended.json")
        self._ended.append(ended_bytes(replace(_KILLED, at=started.isoformat())))
        self.log = RunLog(folder / "log.csv")
        self._press: PressRecorder | None = None
        self._begun_s, self._turned_s = 0.0, math.inf
        self.presses_done = 0

    def plan(self, plan: RunPlan, rig: RigSettings) -> None:
        """Write plan.json."""
        schedule = None if plan.schedule is None else document_of(plan.schedule)
        document = {"plan": asdict(replace(plan, schedule=None)) | {"schedule": schedule}, "rig": asdict(rig)}
        file = AppendFile(self._folder / PLAN_FILE)
        file.append((json.dumps(document, indent=2) + "\n").encode())
        file.close()

    def begin_press(self, repetition: int, time_s: float) -> None:
        """Frames taken from ``time_s`` on, and forces, are kept as one press to the end of loading."""
        self._close_press()
        self._begun_s, self._turned_s = time_s, math.inf
        if self._frame_shape is not None:
            self._press = PressRecorder(self._folder / f"press-{repetition:03d}", self._frame_shape)

    def frame(self, frame: Frame) -> None:
        """Keep a frame that was taken during a loading; nobody looks at others."""
        if self._press is None or frame.time_s < self._begun_s:
            return
        if frame.time_s > self._turned_s:
            self._close_press()
        else:
            self._press.frame(frame.image, frame.time_s)

    @property
    def frame_index(self) -> int:
        """Last frame kept of the loading that is being recorded; -1 for none."""
        return -1 if self._press is None else self._press.n_frames - 1

    def row(self, row: Row) -> None:
        """Log a row; its raw force belongs to the press as well."""
        self.log.append(row)
        if self._press is not None and row.force_n is not None and row.force_time_s is not None:
            self._press.force(row.force_time_s, row.force_n)

    def end_loading(self, time_s: float) -> None:
        """The press turned back then: its files are given back, once all frames of its loading have come. What follows
        says nothing of how the contact spreads, and is in the log."""
        self._turned_s = time_s
        if self._delay_s == 0:  # none is on its way
            self._close_press()

    def end_press(self) -> None:
        """The press is over."""
        self.presses_done += 1

    def end(self, ended: Ended) -> Ended:
        """Write ended.json and close everything; ``ended`` with what only the record knows."""
        at = (self._started + timedelta(seconds=ended.time_s)).isoformat()
        ended = replace(ended, at=at, rows=self.log.rows, repetitions_done=self.presses_done)
        try:
            self._ended.patch(0, ended_bytes(ended))
        except DeviceError as error:
            ended = replace(ended, notes=(*ended.notes, str(error)))
        self._close_press()
        self.log.close()
        self._ended.close()
        return ended

    def _close_press(self) -> None:
        if self._press is not None:
            self._press.close()
            self._press = None
