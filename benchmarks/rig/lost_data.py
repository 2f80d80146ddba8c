"""What a run that went wrong has not on disk of all that came before."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from benchmarks.rig.logs import read_log
from casr.frame_files import open_frames, read_force_log
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings

LOADING = ("approach", "contact", "load")


class Lost(NamedTuple):
    """Counts; 0 when all is there."""

    rows: int
    "Turns before the fault without a row in log.csv, and the last row when it is not whole."
    forces: int
    "Readings of the loading before the fault that force.csv lacks."
    frames: int
    "Frames that the log knows and the press has not."


def lost_data(folder: Path, until_s: float) -> Lost:
    """Of the run in ``folder`` up to ``until_s`` of its clock. RecordingError, FramesError: what is there is spoilt."""
    log = folder / "log.csv"
    rows = [row for row in read_log(log) if row.time_s < until_s]
    loading = [row for row in rows if row.phase in LOADING and row.force_n is not None]
    n_frames = 1 + max((row.frame_index for row in loading), default=-1)
    forces = frames = 0
    # fewer than two frames are no press
    if n_frames > 1:
        press = next(folder.glob("press-*"))
        times = read_force_log(press / "force.csv").time_s
        forces = len({row.force_time_s for row in loading} - set([] if times is None else times.tolist()))
        frames = max(0, n_frames - len(open_frames(press / "frames.tif")))
    return Lost(_turns(rows, until_s) + (not log.read_bytes().endswith(b"\n")), forces, frames)


def _turns(rows: list[Row], until_s: float) -> int:
    """Missing between rows, and between the last of them and the fault."""
    if not rows:
        return 0
    period_s = RigSettings().period_s
    times_s = [*(row.time_s for row in rows), until_s]
    return sum(max(0, round((after - before) / period_s) - 1) for before, after in pairwise(times_s))
