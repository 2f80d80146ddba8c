"""Whole studies whose truth is known; the truth travels beside them, one row per press and one per recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from emg2vsa.bids.tables import Column, Json, described, write_json, write_tsv
from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.bids import check_labels, write_around, write_bids
from emg2vsa.worlds.people.formats import write_c3d, write_csv, write_emgworks
from emg2vsa.worlds.people.plan import PlannedRecording, plan_study
from emg2vsa.worlds.people.recording import SyntheticRecording

Format = Literal["bids", "csv", "emgworks", "c3d"]
Progress = Callable[[int, int, str], None]

WRITERS: dict[str, Callable[[Path, PlannedRecording, SyntheticRecording], Path]] = {
    "bids": write_bids,
    "csv": write_csv,
    "emgworks": write_emgworks,
    "c3d": write_c3d,
}
PRESS_COLUMNS = {
    "participant": "Participant of the study.",
    "specimen": "Specimen that was pressed.",
    "repetition": "Press within the recording, 1-based, in time order.",
    "a_v": "True intercept of v = a + b ln(F / 1 N), volts.",
    "b_v": "True slope, volts per natural-log newton.",
    "onset_s": "Last rise of the true force through the window's lower force before it reaches the upper, seconds.",
    "stop_s": "First reach of the window's upper force, seconds.",
    "peak_force_n": "Largest true force of the press, newtons.",
    "largest_fall_n": "Deepest fall of the true force below its running maximum between onset and stop, newtons.",
}
RECORDING_COLUMNS = {
    "participant": "Participant of the study.",
    "order": "Place of the specimen in the participant's random order, 1-based.",
    "specimen": "Specimen that was pressed.",
    "acq_time": "Nominal start of the recording.",
    "duration_s": "Length of the recording, seconds.",
    "force_offset_n": "Bias of the force sensor over the recording, newtons (compression positive).",
}

Row = tuple[object, ...]


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


def press_rows(planned: PlannedRecording, recording: SyntheticRecording) -> list[Row]:
    """One row per press, cells in the order of ``PRESS_COLUMNS``."""
    truth, presses = recording.truth, recording.truth.presses
    columns = (truth.a_v, truth.b_v, presses.onset_s, presses.stop_s, presses.peak_force_n, presses.largest_fall_n)
    numbers = zip(*(column.tolist() for column in columns), strict=True)
    return [
        (planned.participant, planned.specimen, repetition, *cells) for repetition, cells in enumerate(numbers, start=1)
    ]


def recording_row(planned: PlannedRecording, recording: SyntheticRecording) -> Row:
    """Cells in the order of ``RECORDING_COLUMNS``."""
    return (
        planned.participant,
        planned.position,
        planned.specimen,
        planned.acquired.isoformat(),
        recording.duration_s,
        recording.truth.force_offset_n,
    )


def write_truth(folder: Path, settings: SimulationSettings, presses: Sequence[Row], recordings: Sequence[Row]) -> Path:
    """``truth.tsv`` and ``order.tsv`` (in order of acquisition), each with a JSON file that explains its columns.

    Returns the first of them.
    """
    participants = list(dict.fromkeys(row[0] for row in recordings))
    in_time = sorted(recordings, key=lambda row: (participants.index(row[0]), row[1]))
    _write_table(folder / "truth", PRESS_COLUMNS, presses, {"Simulation": asdict(settings)})
    _write_table(folder / "order", RECORDING_COLUMNS, in_time, {})
    return folder / "truth.tsv"


def _write_table(stem: Path, columns: Mapping[str, str], rows: Sequence[Row], more: Json) -> None:
    write_tsv(stem.with_suffix(".tsv"), columns, rows)
    write_json(stem.with_suffix(".json"), described({name: Column(said) for name, said in columns.items()}) | more)
