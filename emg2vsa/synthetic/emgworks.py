"""A recording as Delsys EMGworks exports it without its header lines: each channel behind its own time column.

The layout states no units: EMG is in volts, and force (an analog input of the same system) is in whatever unit the
study gives its force channel. Headings are the channel names of the study, so name them as EMGworks would
(``"Bagnoli sensor 1: EDC"``, ``"Load Cell: Fz"``) where that matters.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from emg2vsa.atomic import write_text_atomic
from emg2vsa.synthetic.delimited import number_rows
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import stored_channels


def write_emgworks(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Seven significant digits, as EMGworks writes: a round trip is exact to 5e-7 of each value."""
    channels = stored_channels(planned, recording, "V")
    time_s = np.arange(recording.force_n.size) / recording.fs_hz
    header = ",".join(f'X[s],"{channel.name}"' for channel in channels)
    columns = [column for channel in channels for column in (time_s, channel.samples)]
    path = folder / f"{planned.participant}_{planned.specimen}.csv"
    write_text_atomic(path, f"{header}\n{number_rows(columns, ['%.7g'] * len(columns))}")
    return path
