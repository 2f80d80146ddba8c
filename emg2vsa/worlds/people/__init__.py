"""Whole studies, and single recordings, whose truth is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from emg2vsa.errors import SettingError
from emg2vsa.study import Study
from emg2vsa.worlds.people.bids import check_labels, write_around, write_bids
from emg2vsa.worlds.people.formats import write_c3d, write_csv, write_emgworks
from emg2vsa.worlds.people.plan import PlannedRecording, plan_study
from emg2vsa.worlds.people.recording import SyntheticRecording
from emg2vsa.worlds.people.truth import press_rows, recording_row, write_truth

__all__ = ["SimulatedStudy", "simulate_study"]


Format = Literal["bids", "csv", "emgworks", "c3d"]
Progress = Callable[[int, int, str], None]

WRITERS: dict[str, Callable[[Path, PlannedRecording, SyntheticRecording], Path]] = {
    "bids": write_bids,
    "csv": write_csv,
    "emgworks": write_emgworks,
    "c3d": write_c3d,
}


@dataclass(frozen=True)
class SimulatedStudy:
    """What was written. recordings : one per participant and specimen, in that order; truth : table of presses."""

    folder: Path
    format: str
    recordings: tuple[Path, ...]
    truth: Path


def simulate_study(
    study: Study, folder: Path, *, format: Format = "bids", progress: Progress | None = None
) -> SimulatedStudy:
    """Simulate every recording of the study and write it under ``folder``, each file whole or not at all.

    The same settings give the same bytes; each recording depends on the seed, its own settings and the places of its
    participant and specimen in the study, and on nothing else. progress is called as (done, total, recording).

    Raises SettingError: no simulation settings, or settings that do not fit the study or the format.
    """
    if format not in WRITERS:
        raise SettingError("format", wanted=" or ".join(WRITERS), found=repr(format), do="Choose one of these.")
    settings, plan = plan_study(study)
    if format == "bids":
        check_labels(plan)
    files, presses, rows = [], [], []
    for done, planned in enumerate(plan):
        if progress is not None:
            progress(done, len(plan), f"{planned.participant}/{planned.specimen}")
        recording = planned.make(settings)
        files.append(WRITERS[format](folder, planned, recording))
        presses += press_rows(planned, recording)
        rows.append(recording_row(planned, recording))
    truth_folder = folder
    if format == "bids":
        truth_folder = write_around(folder, study, settings, plan)
    truth = write_truth(truth_folder, settings, presses, rows)
    if progress is not None:
        progress(len(plan), len(plan), "truth")
    return SimulatedStudy(folder, format, tuple(files), truth)
