"""A recording as C3D: analog channels in 32-bit floats, no points."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import ezc3d
import numpy as np

from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import stored_channels

SAMPLES_PER_FRAME = 10
"Analog samples of one frame: the format counts frames in 16 bits, and a minute at 1 kHz holds 60 000 samples."


def write_c3d(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Single precision: a round trip is exact to 6e-8 of each value. An incomplete last frame of rest is left out."""
    channels = stored_channels(planned, recording, "V")
    frames = recording.force_n.size // SAMPLES_PER_FRAME
    file = ezc3d.c3d()
    parameters = file["parameters"]
    frame_hz, analog_hz = _rates_hz(recording.fs_hz)
    parameters["POINT"]["RATE"]["value"] = [frame_hz]
    parameters["ANALOG"]["RATE"]["value"] = [analog_hz]
    parameters["ANALOG"]["LABELS"]["value"] = [channel.name for channel in channels]
    parameters["ANALOG"]["UNITS"]["value"] = [channel.unit for channel in channels]
    samples = np.stack([channel.samples[: frames * SAMPLES_PER_FRAME] for channel in channels])
    file["data"]["points"] = np.zeros((4, 0, frames))
    file["data"]["analogs"] = samples[np.newaxis]
    path = folder / f"{planned.participant}_{planned.specimen}.c3d"
    _write_atomic(file, path)
    return path


def _rates_hz(fs_hz: float) -> tuple[float, float]:
    """Frames and samples a second in single precision, the former rounded down, for ezc3d truncates their ratio."""
    analog_hz, frame_hz = np.float32(fs_hz), np.float32(fs_hz / SAMPLES_PER_FRAME)
    while float(analog_hz) / float(frame_hz) < SAMPLES_PER_FRAME:
        frame_hz = np.nextafter(frame_hz, np.float32(0))
    return float(frame_hz), float(analog_hz)


def _write_atomic(file: ezc3d.c3d, path: Path) -> None:
    # ezc3d writes to a path only
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.stem}.") as folder:
        temporary = Path(folder) / path.name
        file.write(str(temporary))
        os.replace(temporary, path)
