"""What each press has lost on its way to the disk, and whether it is still good: presses.csv."""

from __future__ import annotations

import contextlib
import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Literal

from emg2vsa.devices.clock import LATE_PERIODS
from emg2vsa.devices.protocols import ForceCounts, Frame
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import LossSettings, RigSettings

PRESSES_FILE = "presses.csv"
Verdict = Literal["ok", "doubtful", "rejected"]
_VERDICTS: dict[str, Verdict] = {"ok": "ok", "doubtful": "doubtful", "rejected": "rejected"}
BUSY = "the computer was busy"


@dataclass(frozen=True)
class PressCounts:
    """One press. Counts are of its approach, contact and loading, which is what is scored; forces of all of it."""

    repetition: int
    verdict: Verdict
    why: str
    begun_s: float
    turned_s: float
    "End of loading, or of the run."
    turns: int
    late_turns: int
    missing_turns: int
    latest_s: float
    "Largest delay of a turn."
    force_records: int
    force_lost: int
    force_late: int
    force_duplicated: int
    force_refused: int
    frames: int
    frames_missing: int
    peak_force_n: float
    "Largest force along push_axis, of either sign, as measured."
    peak_lateral_n: float
    "Largest force across it."
    stopped: str = ""
    "At which force and why a press was stopped before the force of a whole one; empty for a whole press."


HEADER = ",".join(field.name for field in fields(PressCounts))


def line_of(counts: PressCounts) -> str:
    """A line of presses.csv."""
    text = io.StringIO()
    values = (f"{value:.6f}" if isinstance(value, float) else value for value in asdict(counts).values())
    csv.writer(text, lineterminator="\n").writerow(values)
    return text.getvalue()


def verdicts(folder: Path) -> dict[int, tuple[Verdict, str]]:
    """Repetition to verdict and reason, of the run in ``folder``; empty where there is no presses.csv that says so.

    Runs of version 0.1.0 have none. Half a last line is passed over; of two lines for a press the last holds.
    """
    return dict(_verdicts(_rows(folder)))


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


def _rows(folder: Path) -> list[dict[str, str]]:
    """Whole lines of presses.csv."""
    try:
        text = (folder / PRESSES_FILE).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return []
    return list(csv.DictReader(text[: text.rfind("\n") + 1].splitlines()))


def largest_forces(folder: Path) -> tuple[float, float]:
    """Largest force along and across the push axis of the presses that are over, N; 0 before the first."""
    try:
        rows = list(csv.DictReader((folder / PRESSES_FILE).read_text(encoding="utf-8").splitlines()))
        peaks = [(float(row["peak_force_n"]), float(row["peak_lateral_n"])) for row in rows]
    except (OSError, ValueError, TypeError, KeyError):
        return 0.0, 0.0
    return max((along for along, _ in peaks), default=0.0), max((across for _, across in peaks), default=0.0)


def _verdicts(rows: Iterable[Mapping[str, str]]) -> Iterator[tuple[int, tuple[Verdict, str]]]:
    for row in rows:
        number, verdict = row.get("repetition") or "", _VERDICTS.get(row.get("verdict") or "")
        if number.isdecimal() and verdict:
            yield int(number), (verdict, row.get("why") or "")


class PressTally:
    """Counts one press as it happens. ``forces`` : of the sensor when it begins."""

    def __init__(self, repetition: int, begun_s: float, rig: RigSettings, forces: ForceCounts) -> None:
        self._repetition, self._rig, self._before, self._after = repetition, rig, forces, forces
        self._begun_s, self._turned_s, self._turned = begun_s, begun_s, False
        self._last_s: float | None = None
        self._turns = self._late = self._missing = self._frames = self._frames_missing = 0
        self._latest_s = self._peak_n = self._lateral_n = 0.0
        self._doubts: list[tuple[Verdict, str]] = []
        self.stopped = ""
        "As in `PressCounts`."

    @property
    def repetition(self) -> int:
        """Number of the press, from 1."""
        return self._repetition

    def row(self, row: Row) -> None:
        """A turn."""
        force_n, across_n = forces_of(row)
        self._peak_n, self._lateral_n = max(self._peak_n, force_n), max(self._lateral_n, across_n)
        # while the probe is taken away nobody keeps the beat of the loop
        if self._turned or row.phase == "escape":
            return
        self._turns += 1
        period_s = self._rig.period_s
        if self._last_s is not None:
            self._missing += max(0, round((row.time_s - self._last_s) / period_s) - 1)
        self._last_s = self._turned_s = row.time_s
        self._late += (row.late_s or 0.0) >= LATE_PERIODS * period_s
        self._latest_s = max(self._latest_s, row.late_s or 0.0)

    def frame(self, frame: Frame) -> None:
        """A frame that was kept; what is missing before the first is not of this press."""
        self._frames_missing += frame.dropped if self._frames else 0
        self._frames += 1

    def turn_back(self, time_s: float, forces: ForceCounts) -> None:
        """The end of loading, or of the run. ``forces`` : of the sensor now. Only the first call counts."""
        if not self._turned:
            self._turned, self._turned_s, self._after = True, time_s, forces

    def doubt(self, why: str, verdict: Verdict = "rejected") -> None:
        """Somebody else has found the press ``verdict``."""
        if (verdict, why) not in self._doubts:
            self._doubts.append((verdict, why))

    def counts(self) -> PressCounts:
        """So far."""
        came = ForceCounts(*(after - before for after, before in zip(self._after, self._before, strict=True)))
        found = [*self._doubts, *self._judged(came)]
        rejected = [why for verdict, why in found if verdict == "rejected"]
        verdict: Verdict = "rejected" if rejected else "doubtful" if found else "ok"
        return PressCounts(
            self._repetition, verdict, "; ".join(why for _, why in found), self._begun_s, self._turned_s,
            self._turns, self._late, self._missing, self._latest_s,
            came.records, came.lost, came.late, came.duplicated, came.refused,
            self._frames, self._frames_missing, self._peak_n, self._lateral_n, self.stopped,
        )  # fmt: skip

    def _judged(self, came: ForceCounts) -> Iterator[tuple[Verdict, str]]:
        losses: LossSettings = self._rig.losses
        lost = came.lost + came.late
        for of, count, whole, limits in (
            (f"turns were late, by up to {1e3 * self._latest_s:.0f} ms: {BUSY}", self._late, self._turns,
             losses.late_turns_percent),
            (f"turns are missing: {BUSY}, or a device slow", self._missing, self._turns + self._missing,
             losses.missing_turns_percent),
            ("records of the force sensor were lost: look at its network and cable", lost, came.records + lost,
             losses.lost_force_percent),
            ("frames are missing: look at the camera and its cable", self._frames_missing,
             self._frames + self._frames_missing, losses.missing_frames_percent),
        ):  # fmt: skip
            percent = 100 * count / whole if whole else 0.0
            if percent > limits[0]:
                yield "rejected" if percent > limits[1] else "doubtful", f"{percent:.2g} % of its {of}"


def forces_of(row: Row) -> tuple[float, float]:
    """Force along and across the push axis, N; 0 where the row has none."""
    if row.force_n is None or not math.isfinite(row.force_n):
        return 0.0, 0.0
    if row.fx_n is None or row.fy_n is None or row.fz_n is None:
        return abs(row.force_n), 0.0
    across = row.fx_n**2 + row.fy_n**2 + row.fz_n**2 - row.force_n**2
    return abs(row.force_n), math.sqrt(max(0.0, across)) if math.isfinite(across) else 0.0
