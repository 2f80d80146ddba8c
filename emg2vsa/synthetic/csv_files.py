"""A recording as plain CSV: a time column, then one column per channel, units in brackets in the header."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from emg2vsa.atomic import write_text_atomic
from emg2vsa.synthetic.delimited import number_rows, text_rows
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import StoredChannel, stored_channels


def write_csv(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Nine significant digits: a round trip is exact to 5e-9 of each value."""
    channels = stored_channels(planned, recording, "V")
    time_s = np.arange(recording.force_n.size) / recording.fs_hz
    header = text_rows([["time [s]", *map(_heading, channels)]], ",")
    rows = number_rows([time_s, *(channel.samples for channel in channels)], ["%.9g"] * (len(channels) + 1))
    path = folder / f"{planned.participant}_{planned.specimen}.csv"
    write_text_atomic(path, header + rows)
    return path


def _heading(channel: StoredChannel) -> str:
    return f"{channel.name} [{channel.unit}]" if channel.unit else channel.name
