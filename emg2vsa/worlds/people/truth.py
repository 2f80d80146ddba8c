"""The truth that travels beside a synthetic study: one row per press, one per recording, and what the columns mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from emg2vsa.bids.tables import Column, Json, described, write_json, write_tsv
from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.plan import PlannedRecording
from emg2vsa.worlds.people.recording import SyntheticRecording

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
