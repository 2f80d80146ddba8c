"""From frames of a press as they come to the stiffness of the specimen: areas by casr, kappa by a calibration."""

from __future__ import annotations

import csv
import io
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.library_front import height_in_tables, worlds_for
from casr.dome.library import Library, tables
from casr.errors import CasrError
from casr.flow.estimate import FlowSettings
from casr.frames.force import force_at_exposure
from casr.kappa.presses import FEWEST_FRAMES, KappaPress
from casr.scored import ScoreSettings
from casr.stream import StreamScorer
from emg2vsa.calibration.forms import HERTZ
from emg2vsa.calibration.online import OnlineCalibration, OnlineEstimator, OnlineState
from emg2vsa.calibration.online_pins import NEW
from emg2vsa.settings import RECIPES

KAPPA_FILE = "kappa.csv"
_RECENT_FRAMES = 8
"""Whose times tell the period of the camera."""
Rows = Sequence[tuple[float, float]]
"""Time, s, and force, N, of readings."""


@dataclass(frozen=True)
class KappaRow:
    """A line of kappa.csv: what is known after a frame. Cells of what is not known yet are empty."""

    time_s: float
    "Time of the frame, on the clock of the log."
    repetition: int
    frame: int
    "Frame of the press, from 0."
    force_n: float
    "Force at the exposure of the frame, above the level at rest."
    area: float | None
    "Contact area, in the unit of the calibration."
    kappa_n_per_mm: float
    low_n_per_mm: float
    high_n_per_mm: float
    "Total 95 % interval."
    half_width: float
    "Half width of the interval, as a share of kappa."
    presses: int
    "Presses that count in the interval."
    judged_at_n: float
    "Force up to which areas were used."
    cues: str
    "What kappa is told by."
    reachable: float
    "Half width that is expected at the end of this press."
    stop: str
    "Why the press may stop; empty while it goes on."
    latency_s: float
    "Time from the exposure to this line; empty where time is not real."
    note: str = ""

    def told(self) -> str:
        """For people: kappa with its interval, how many presses, and how the press ended."""
        if not np.isfinite(self.kappa_n_per_mm):
            return "not determined" + (f" ({self.note})" if self.note else "")
        high = f"{self.high_n_per_mm:.3g}" if np.isfinite(self.high_n_per_mm) else "rigid"
        share = f" (±{self.half_width:.0%})" if np.isfinite(self.half_width) else ""
        parts = [
            f"{self.kappa_n_per_mm:.3g} N/mm, 95 %: {self.low_n_per_mm:.3g} to {high}{share}",
            f"presses: {self.presses}",
        ]
        return "; ".join([*parts, *([f"stopped: {self.stop} at {self.judged_at_n:g} N"] if self.stop else [])])


KAPPA_HEADER = ",".join(each.name for each in fields(KappaRow))


def line_of(row: KappaRow) -> str:
    """A line of kappa.csv."""
    text = io.StringIO()
    values = (getattr(row, each.name) for each in fields(KappaRow))
    csv.writer(text, lineterminator="\n").writerow(_cell(value) for value in values)
    return text.getvalue()


def _cell(value: object) -> object:
    if isinstance(value, float):
        return f"{value:.6g}" if np.isfinite(value) else "inf" if value > 0 else ""
    return "" if value is None else value


def rows_of(text: str) -> list[KappaRow]:
    """Rows of whole lines of kappa.csv, without its header. ValueError for a line that is none of it."""
    return [_row_of(cells) for cells in csv.reader(io.StringIO(text))]


def _row_of(cells: list[str]) -> KappaRow:
    values = dict(zip((each.name for each in fields(KappaRow)), cells, strict=True))
    whole, texts = {"repetition", "frame", "presses"}, {"cues", "stop", "note"}
    parsed: dict[str, Any] = {
        name: text if name in texts else int(text) if name in whole else float(text or "nan")
        for name, text in values.items()
    }
    return KappaRow(**(parsed | {"area": parsed["area"] if np.isfinite(parsed["area"]) else None}))


def last_rows(path: Path) -> list[KappaRow]:
    """The last row of each press that tells kappa, or else the last one; empty without a kappa.csv that can be read."""
    try:
        text = path.read_text(encoding="utf-8")
        rows = rows_of(text[text.index("\n") + 1 : text.rindex("\n") + 1])
    except (OSError, ValueError):
        return []
    last: dict[int, KappaRow] = {}
    for row in rows:
        if np.isfinite(row.kappa_n_per_mm) or row.repetition not in last:
            last[row.repetition] = row
    return list(last.values())


@dataclass(frozen=True)
class KappaPlan:
    """What presses are judged by.

    name : of the calibration's file. camera : in mm2; None for a calibration in px2. stop_at : half width, as a share
    of kappa, at which a press stops; None never stops one. domes, specimen_height_mm : of ``casr.ScoreSettings``.
    """

    name: str
    calibration: OnlineCalibration
    camera: Camera | None
    stop_at: float | None
    domes: str | None = None
    specimen_height_mm: float | None = None

    def worlds(self) -> Library:
        """Those that areas are found by. casr.errors.CasrError : there are none for this sensor."""
        return worlds_for(self.camera, self.domes, self.specimen_height_mm)

    def tables(self) -> Library:
        """Those that stiffness is told by from the pins."""
        own_height_mm = self.specimen_height_mm if self.domes else None
        return tables(self.domes, height_in_tables(self.camera, self.domes, own_height_mm))


class LiveKappa:
    """Judges the presses of one run, frame by frame."""

    def __init__(self, plan: KappaPlan) -> None:
        calibration = plan.calibration
        self._plan = plan
        self._estimator = OnlineEstimator(calibration, plan.stop_at or 0.0, plan.tables())
        last_n = float(calibration.forces_n[-1])
        recipe = RECIPES[calibration.quantity]
        self._settings = ScoreSettings(
            quantity="front" if calibration.quantity == "front" else "skin",
            flow=FlowSettings(engine=recipe.engine),
            area_rule=recipe.area_rule,
            area_law=recipe.law,
            force_start_n=calibration.start_n,
            rate_window_n=(calibration.start_n, last_n),
            domes=plan.domes,
            specimen_height_mm=plan.specimen_height_mm,
        )
        self._press: _Press | None = None
        self._stop, self._presses = "", 0
        # what is made once is made before the first frame waits for it
        plan.worlds()
        self._prepare(1)
        if calibration.pins is None:
            force_n = np.linspace(calibration.start_n, last_n, 20)
            OnlineEstimator(calibration).follow(force_n, force_n**HERTZ)

    def frame(self, repetition: int, time_s: float, image: NDArray[np.uint8], readings: Rows) -> KappaRow:
        """The next frame (H, W), taken at ``time_s``, s, with the readings since the one before; what is known then,
        without its latency."""
        if self._press is None or self._press.repetition != repetition:
            self.press_over()
            self._press = _Press(repetition, StreamScorer(self._plan.camera, self._settings))
        press, state, note, area = self._press, self._press.state, "", None
        force_n = press.force_at(time_s, readings)
        if not press.trouble:
            try:
                seen = press.scorer.push(image, force_n)
                note, area, force_n = "; ".join(seen.notes), seen.area, seen.force_n
                # what a stopped press says is what it was stopped by
                press.goes_on = seen.phase == "loading" and not self._stop
                if press.goes_on and self._plan.calibration.pins is None:
                    state = self._estimator.follow(*press.scorer.curve())
            except CasrError as trouble:
                press.trouble = str(trouble)
        press.state = state
        if self._plan.stop_at is not None and state.stop and not self._stop:
            self._stop = state.stop
        return KappaRow(
            time_s, repetition, press.n_frames - 1, force_n, area,
            state.kappa, state.low, state.high, state.half_width, state.presses, state.judged_at_n,
            state.cues, state.reachable, self._stop, float("nan"),
            press.trouble or "; ".join(filter(None, (state.doubt, note))),
        )  # fmt: skip

    def _judge_pins(self, press: _Press) -> None:
        rest_px, pins_px, force_n = press.scorer.pins()
        if len(force_n) < FEWEST_FRAMES:
            return
        press.state = self._estimator.follow_pins(
            KappaPress(
                rest_px=rest_px, pins_px=pins_px, force_n=force_n, specimen=NEW, mounting=self._estimator.mounting,
            )
        )  # fmt: skip

    def _prepare(self, presses: int) -> None:
        if self._plan.calibration.pins is None:
            self._plan.calibration.expected_reach(self._plan.calibration.kappa, presses)

    def settle(self) -> None:
        """Work for the time in which no frame waits; what the pins say then stands in the row of the next frame."""
        if (press := self._press) is None or press.trouble:
            return
        press.scorer.settle()
        if press.goes_on and self._plan.calibration.pins is not None:
            try:
                self._judge_pins(press)
            except CasrError as trouble:
                press.trouble = str(trouble)

    def press_over(self) -> None:
        """No more frames of this press come."""
        if self._press is not None:
            self._estimator.finish_press()
            self._presses += 1
            self._prepare(self._presses + 1)
        self._press, self._stop = None, ""


@dataclass
class _Press:
    repetition: int
    scorer: StreamScorer
    state: OnlineState = field(default_factory=OnlineState)
    trouble: str = ""
    goes_on: bool = False
    n_frames: int = 0
    frame_s: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT_FRAMES))
    readings: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=2000))

    def force_at(self, time_s: float, readings: Rows) -> float:
        """Force as a recording has it, N."""
        self.frame_s.append(time_s)
        self.n_frames += 1
        self.readings.extend(readings)
        while len(self.readings) > 1 and self.readings[1][0] < self.frame_s[0]:
            self.readings.popleft()
        if not self.readings:
            return float("nan")
        read_s, force_n = np.array(self.readings).T
        return float(force_at_exposure(np.array(self.frame_s), read_s, force_n)[-1])
