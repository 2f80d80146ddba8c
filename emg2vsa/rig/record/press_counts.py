"""What each press has lost on its way to the disk, and whether it is still good: presses.csv."""

from __future__ import annotations

import contextlib
import csv
import io
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Literal, NamedTuple

from emg2vsa.devices.clock import LATE_PERIODS
from emg2vsa.devices.protocols import ForceCounts, Frame
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings

PRESSES_FILE = "presses.csv"
Verdict = Literal["ok", "doubtful", "rejected"]
_VERDICTS: dict[str, Verdict] = {"ok": "ok", "doubtful": "doubtful", "rejected": "rejected"}
BUSY = "the computer was busy"


class PressKappa(NamedTuple):
    """Stiffness of the specimen by one press, N/mm, with its 95 % interval; infinite where it may be rigid."""

    kappa: float
    low: float
    high: float

    def __str__(self) -> str:
        high = "rigid" if self.high == math.inf else f"{self.high:.3g}"
        return f"{self.kappa:.3g} N/mm, 95 %: {self.low:.3g} to {high}"


@dataclass
class PressCounts:
    """One press. Counts are of its approach, contact and loading, which is what is scored; forces of all of it."""

    repetition: int
    verdict: Verdict = "ok"
    why: str = ""
    begun_s: float = 0.0
    turned_s: float = 0.0
    "End of loading, or of the run."
    turns: int = 0
    late_turns: int = 0
    missing_turns: int = 0
    latest_s: float = 0.0
    "Largest delay of a turn."
    force_records: int = 0
    force_lost: int = 0
    force_late: int = 0
    force_duplicated: int = 0
    force_refused: int = 0
    frames: int = 0
    frames_missing: int = 0
    peak_force_n: float = 0.0
    "Largest force along push_axis, of either sign, as measured."
    peak_lateral_n: float = 0.0
    "Largest force across it."
    stopped: str = ""
    "Force at which, and reason why, a press was stopped before the force of a whole one; empty for a whole press."
    kappa_n_per_mm: float = math.nan
    "Stiffness of the specimen by force over depth of this press, with its 95 % interval; empty where it tells none."
    kappa_low_n_per_mm: float = math.nan
    kappa_high_n_per_mm: float = math.nan
    "inf where the specimen may be rigid."


HEADER = ",".join(field.name for field in fields(PressCounts))


def line_of(counts: PressCounts) -> str:
    """A line of presses.csv."""
    text = io.StringIO()
    values = ("" if value != value else f"{value:.6f}" if isinstance(value, float) else value
              for value in asdict(counts).values())  # fmt: skip
    csv.writer(text, lineterminator="\n").writerow(values)
    return text.getvalue()


def verdicts(folder: Path) -> dict[int, tuple[Verdict, str]]:
    """Repetition to verdict and reason, of the run in ``folder``; empty where there is no presses.csv that says so.

    Runs of version 0.1.0 have none. Half a last line is passed over; of two lines for a press the last holds.
    """
    found = {}
    for row in _rows(folder):
        number, verdict = row.get("repetition") or "", _VERDICTS.get(row.get("verdict") or "")
        if number.isdecimal() and verdict:
            found[int(number)] = verdict, row.get("why") or ""
    return found


def peak_forces_n(folder: Path) -> dict[int, float]:
    """Repetition to the largest force along the push axis, N, of the presses that are over; those of which the table
    says no number are left out, as are all without a table."""
    found = {}
    for row in _rows(folder):
        with contextlib.suppress(ValueError, TypeError, KeyError):
            found[int(row["repetition"])] = float(row["peak_force_n"])
    return found


def stopped_presses(folder: Path) -> dict[int, str]:
    """Repetition to force and reason of the presses that were stopped early, of the run in ``folder``."""
    said = {row.get("repetition") or "": row.get("stopped") or "" for row in _rows(folder)}
    return {int(number): why for number, why in said.items() if number.isdecimal() and why}


def weighed(folder: Path) -> dict[int, PressKappa]:
    """Repetition to the stiffness of the specimen by that press alone; of those that tell it."""
    found = {}
    for row in _rows(folder):
        with contextlib.suppress(ValueError, TypeError, KeyError):
            three = (float(row[f"kappa_{name}n_per_mm"]) for name in ("", "low_", "high_"))
            found[int(row["repetition"])] = PressKappa(*three)
    return found


def largest_forces(folder: Path) -> tuple[float, float]:
    """Largest force along and across the push axis of the presses that are over, N; 0 before the first."""
    try:
        peaks = [(float(row["peak_force_n"]), float(row["peak_lateral_n"])) for row in _rows(folder)]
    except (ValueError, TypeError, KeyError):
        return 0.0, 0.0
    return max((along for along, _ in peaks), default=0.0), max((across for _, across in peaks), default=0.0)


def _rows(folder: Path) -> list[dict[str, str]]:
    """Whole lines of presses.csv."""
    try:
        text = (folder / PRESSES_FILE).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return []
    return list(csv.DictReader(text[: text.rfind("\n") + 1].splitlines()))


class PressTally:
    """Counts one press as it happens. ``forces`` : of the sensor when it begins."""

    def __init__(self, repetition: int, begun_s: float, rig: RigSettings, forces: ForceCounts) -> None:
        self._now = PressCounts(repetition, begun_s=begun_s, turned_s=begun_s)
        self._rig, self._before, self._after = rig, forces, forces
        self._turned, self._last_s = False, math.nan
        self._doubts: list[tuple[Verdict, str]] = []

    @property
    def repetition(self) -> int:
        """Number of the press, from 1."""
        return self._now.repetition

    def row(self, row: Row) -> None:
        """A turn."""
        now, (force_n, across_n) = self._now, forces_of(row)
        now.peak_force_n, now.peak_lateral_n = max(now.peak_force_n, force_n), max(now.peak_lateral_n, across_n)
        # while the probe is taken away nobody keeps the beat of the loop
        if self._turned or row.phase == "escape":
            return
        period_s, late_s = self._rig.period_s, row.late_s or 0.0
        if now.turns:
            now.missing_turns += max(0, round((row.time_s - self._last_s) / period_s) - 1)
        now.turns += 1
        self._last_s = now.turned_s = row.time_s
        now.late_turns += late_s >= LATE_PERIODS * period_s
        now.latest_s = max(now.latest_s, late_s)

    def frame(self, frame: Frame) -> None:
        """A frame that was kept; what is missing before the first is not of this press."""
        self._now.frames_missing += frame.dropped if self._now.frames else 0
        self._now.frames += 1

    def turn_back(self, time_s: float, forces: ForceCounts) -> None:
        """The end of loading, or of the run, at ``time_s``, s. ``forces`` : of the sensor now. Only the first call
        counts."""
        if not self._turned:
            self._turned, self._now.turned_s, self._after = True, time_s, forces

    def stop(self, why: str) -> None:
        """It was stopped: at which force, and why."""
        self._now.stopped = why

    def kappa(self, kappa: PressKappa) -> None:
        """Kappa of the specimen by this press."""
        now = self._now
        now.kappa_n_per_mm, now.kappa_low_n_per_mm, now.kappa_high_n_per_mm = kappa

    def doubt(self, why: str, verdict: Verdict = "rejected") -> None:
        """Somebody else has found the press ``verdict``."""
        if (verdict, why) not in self._doubts:
            self._doubts.append((verdict, why))

    def counts(self) -> PressCounts:
        """So far."""
        came = ForceCounts(*(after - before for after, before in zip(self._after, self._before, strict=True)))
        found = [*self._doubts, *self._judged(came)]
        verdict: Verdict = "doubtful" if found else "ok"
        if "rejected" in (each for each, _ in found):
            verdict = "rejected"
        forces = {f"force_{name}": count for name, count in came._asdict().items()}
        return replace(self._now, verdict=verdict, why="; ".join(why for _, why in found), **forces)

    def _judged(self, came: ForceCounts) -> Iterator[tuple[Verdict, str]]:
        now, losses = self._now, self._rig.losses
        lost = came.lost + came.late
        for of, count, whole, limits in (
            (f"turns were late, by up to {1e3 * now.latest_s:.0f} ms: {BUSY}", now.late_turns, now.turns,
             losses.late_turns_percent),
            (f"turns are missing: {BUSY}, or a device slow", now.missing_turns, now.turns + now.missing_turns,
             losses.missing_turns_percent),
            ("records of the force sensor were lost: look at its network and cable", lost, came.records + lost,
             losses.lost_force_percent),
            ("frames are missing: look at the camera and its cable", now.frames_missing,
             now.frames + now.frames_missing, losses.missing_frames_percent),
        ):  # fmt: skip
            percent = 100 * count / whole if whole else 0.0
            if percent > limits[0]:
                share = f"{percent:.0f}" if percent >= 10 else f"{percent:.2g}"
                yield "rejected" if percent > limits[1] else "doubtful", f"{share} % of its {of}"


def forces_of(row: Row) -> tuple[float, float]:
    """Force along and across the push axis, N; 0 where the row has none."""
    if row.force_n is None or not math.isfinite(row.force_n):
        return 0.0, 0.0
    if row.fx_n is None or row.fy_n is None or row.fz_n is None:
        return abs(row.force_n), 0.0
    across = row.fx_n**2 + row.fy_n**2 + row.fz_n**2 - row.force_n**2
    return abs(row.force_n), math.sqrt(max(0.0, across)) if math.isfinite(across) else 0.0
