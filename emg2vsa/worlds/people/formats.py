"""A recording as a file stores it: as plain CSV, as a table of Delsys EMGworks, or as C3D.

Name, gain, unit and sign of each channel are those that the study tells the reader to undo.
"""

from __future__ import annotations

import csv
import io
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import ezc3d
import numpy as np
from numpy.typing import NDArray

from casr.atomic import write_text_atomic
from emg2vsa.errors import SettingError
from emg2vsa.settings import EmgChannelSettings, ForceChannelSettings
from emg2vsa.worlds.people.plan import PlannedRecording
from emg2vsa.worlds.people.recording import SyntheticRecording

FloatArray = NDArray[np.float64]

VOLTS = {"V": 1.0, "mV": 1e-3, "uV": 1e-6}
NEWTONS = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605, "kgf": 9.80665, "gf": 9.80665e-3}
SAMPLES_PER_FRAME = 10
"Analog samples of a C3D frame: the format counts frames in 16 bits, and a minute at 1 kHz holds 60 000 samples."


@dataclass(frozen=True)
class StoredChannel:
    """One channel of a file. samples : (n,) in ``unit``, "" where there is none. muscle : None for force."""

    name: str
    samples: FloatArray
    unit: str
    muscle: str | None


def stored_channels(planned: PlannedRecording, recording: SyntheticRecording, emg_unit: str) -> list[StoredChannel]:
    """EMG channels, then force. emg_unit : unit of EMG where the study does not name one."""
    channels = planned.channels
    emg = [_stored_emg(muscle, recording.emg_v[muscle], setting, emg_unit) for muscle, setting in channels.emg.items()]
    return [*emg, _stored_force(recording.force_n, channels.force)]


def _stored_emg(muscle: str, emg_v: FloatArray, setting: EmgChannelSettings, default_unit: str) -> StoredChannel:
    unit = setting.unit or default_unit
    scale = VOLTS[unit] / setting.gain
    return StoredChannel(setting.name, emg_v / scale, unit, muscle)


def _stored_force(force_n: FloatArray, setting: ForceChannelSettings) -> StoredChannel:
    if setting.newtons_per_unit is not None:
        unit, newtons = setting.unit or "", setting.newtons_per_unit
    else:
        unit = setting.unit or "N"
        if unit not in NEWTONS:
            raise SettingError(
                f"force channel {setting.name!r}, unit",
                wanted="N, mN, kN, lbf, kgf or gf, or newtons_per_unit",
                found=repr(unit),
                do="Declare newtons_per_unit.",
            )
        newtons = NEWTONS[unit]
    scale = setting.sign * newtons
    return StoredChannel(setting.name, force_n / scale, unit, None)


def write_csv(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """A time column, then one column per channel, units in brackets in the header.

    Nine significant digits: a round trip is exact to 5e-9 of each value.
    """
    channels = stored_channels(planned, recording, "V")
    time_s = np.arange(recording.force_n.size) / recording.fs_hz
    header = io.StringIO()
    csv.writer(header, lineterminator="\n").writerow(["time [s]", *map(_heading, channels)])
    rows = _rows([time_s, *(channel.samples for channel in channels)], ["%.9g"] * (len(channels) + 1))
    path = folder / f"{planned.participant}_{planned.specimen}.csv"
    write_text_atomic(path, header.getvalue() + rows)
    return path


def _rows(columns: Sequence[FloatArray], formats: Sequence[str]) -> str:
    """CSV rows of equally long columns, each with its printf format, lines ended by a line feed."""
    table = np.column_stack(columns)
    line = ",".join(formats) + "\n"
    text: str = line * table.shape[0] % tuple(table.ravel().tolist())
    return text


def _heading(channel: StoredChannel) -> str:
    return f"{channel.name} [{channel.unit}]" if channel.unit else channel.name


def write_emgworks(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """As Delsys EMGworks exports it without its header lines: each channel behind its own time column.

    The layout states no units: EMG is in volts, and force (an analog input of the same system) is in whatever unit the
    study gives its force channel. Headings are the channel names of the study, so name them as EMGworks would
    (``"Bagnoli sensor 1: EDC"``, ``"Load Cell: Fz"``) where that matters. Seven significant digits, as EMGworks writes:
    a round trip is exact to 5e-7 of each value.
    """
    channels = stored_channels(planned, recording, "V")
    time_s = np.arange(recording.force_n.size) / recording.fs_hz
    header = ",".join(f'X[s],"{channel.name}"' for channel in channels)
    columns = [column for channel in channels for column in (time_s, channel.samples)]
    path = folder / f"{planned.participant}_{planned.specimen}.csv"
    write_text_atomic(path, f"{header}\n{_rows(columns, ['%.7g'] * len(columns))}")
    return path


def write_c3d(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Analog channels in 32-bit floats, no points.

    A round trip is exact to 6e-8 of each value. An incomplete last frame of rest is left out.
    """
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
