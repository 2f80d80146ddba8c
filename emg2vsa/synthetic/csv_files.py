"""A recording as plain CSV: a time column, then one column per channel, units in brackets in the header."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from emg2vsa.atomic import write_text_atomic
from emg2vsa.synthetic.delimited import number_rows, text_rows
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import stored_channels


def csv_path(folder: Path, planned: PlannedRecording) -> Path:
    return folder / f"{planned.participant}_{planned.specimen}.csv"


def write_csv(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Nine significant digits: a round trip is exact to 5e-10 of each value."""
    channels = stored_channels(planned, recording, "V")
    time_s = np.arange(recording.force_n.size) / recording.fs_hz
    header = text_rows([["time [s]", *(f"{channel.name} [{channel.unit}]" for channel in channels)]], ",")
    rows = number_rows([time_s, *(channel.samples for channel in channels)], ["%.9g"] * (len(channels) + 1))
    path = csv_path(folder, planned)
    write_text_atomic(path, header + rows)
    return path
