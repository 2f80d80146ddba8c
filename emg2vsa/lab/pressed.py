"""A run that was carried out: where it is recorded, its log, and how it ended, for people."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.devices.clock import LoopTiming
from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.press_counts import weighed
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.rig.rig_settings import RigSettings, axis_of

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Pressed:
    """A run on the rig, real or emulated.

    folder : plan.json, log.csv, presses.csv, ended.json, and a folder of frames for each press.
    ended : how and why the run ended, how many presses are done, where probe and motors were left.
    """

    folder: Path
    ended: Ended

    @property
    def completed(self) -> bool:
        """All presses are done and whole, and the probe is away."""
        return self.ended.how == "completed"

    @property
    def left_safe(self) -> bool:
        """The probe is away from the specimen, and the motors are known to be off."""
        return self.ended.retracted and self.ended.deactivated

    @property
    def log(self) -> pd.DataFrame:
        """One row a turn of the control loop (5 ms): columns of log.csv, ``shaft_deg``, and ``depth_mm`` of the probe
        from home, mm.

        ``repetition`` counts presses from 1; ``phase`` is home, approach, contact, load, retract, pause or done;
        ``force_n`` is along the push axis, N. RecordingError where log.csv or plan.json cannot be read.
        """
        try:
            log = read_log(self.folder / "log.csv")
            axis = axis_of(json.loads((self.folder / PLAN_FILE).read_text(encoding="utf-8"))["rig"])
            return log.assign(depth_mm=log["shaft_deg"].map(axis.depth_at))
        except (OSError, ValueError, KeyError) as error:
            do = "Choose the folder of a run that the rig has recorded."
            raise RecordingError(self.folder, wanted="log.csv and plan.json", found=str(error), do=do) from error

    def document(self) -> dict[str, Any]:
        """For JSON."""
        return {"folder": str(self.folder), "ended": asdict(self.ended)}


def told(ended: Ended, repetitions: int, folder: Path, rig: RigSettings) -> str:
    """How, cause and why, presses done, where motors and files were left, and the timing of the control loop."""
    lines = [summary(ended, repetitions)]
    probe = "probe retracted" if ended.retracted else "probe NOT retracted"
    lines.append(f"left: {probe}, motors {'off' if ended.deactivated else 'NOT confirmed off'}")
    lines += [f"note: {note}" for note in ended.notes]
    for number, kappa in weighed(folder).items():
        lines.append(f"press {number} by its depth: {kappa}")
    if ended.peak_force_n:
        lines.append(f"largest force: {ended.peak_force_n:.2f} N")
    lines.append(f"recorded: {folder / 'log.csv'} (rows: {ended.rows})")
    if ended.timing:
        lines += _table(ended.timing, rig)
    return "\n".join(lines)


def summary(ended: Ended, repetitions: int) -> str:
    """The same in one line."""
    presses = f"{ended.repetitions_done} of {repetitions} presses, {ended.time_s:.1f} s"
    if ended.how == "completed":
        return f"completed: {presses}"
    where = f"{ended.phase} of press {ended.repetition}" if ended.repetition else ended.phase
    why = "" if ended.how == "stopped" else f" ({ended.why})"
    return f"{ended.how}: {ended.cause} in {where}{why}; {presses}"


def _table(timing: LoopTiming, rig: RigSettings) -> list[str]:
    errors_ms = [1e3 * value for value in (timing.median_s, timing.p99_s, timing.p999_s, timing.largest_s)]
    return [
        f"{'control loop':<22}{'turns':>8}{'median':>9}{'99 %':>9}{'99.9 %':>9}{'largest':>9}{'overruns':>10}",
        f"{f'off {1e3 * rig.period_s:g} ms by, ms':<22}{timing.turns:>8}"
        + "".join(f"{value:>9.3f}" for value in errors_ms)
        + f"{timing.overruns:>10}",
    ]
