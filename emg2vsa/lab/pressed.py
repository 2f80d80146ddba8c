"""A run that was carried out: where it is recorded, how it ended, and its log."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.rig.rig_settings import axis_of

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
