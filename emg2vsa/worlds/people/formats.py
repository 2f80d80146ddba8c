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
from emg2vsa.readers.units import si_factor
from emg2vsa.worlds.people.plan import PlannedRecording
from emg2vsa.worlds.people.recording import SyntheticRecording

FloatArray = NDArray[np.float64]

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
    """EMG channels, then force. emg_unit : unit of EMG where the study does not name one.

    SettingError : the force channel has a unit that is none of force.
    """
    stored, force = [], planned.channels.force
    for muscle, channel in planned.channels.emg.items():
        unit = channel.unit or emg_unit
        _, volts = si_factor(unit) or ("V", 1.0)
        stored.append(StoredChannel(channel.name, recording.emg_v[muscle] / (volts / channel.gain), unit, muscle))
    unit = force.unit or ("N" if force.newtons_per_unit is None else "")
    quantity, newtons = si_factor(unit) or ("", 1.0)
    if force.newtons_per_unit is not None:
        newtons = force.newtons_per_unit
    elif quantity != "N":
        raise SettingError(
            f"force channel {force.name!r}, unit", wanted="N, mN, kN, lbf, kgf or gf, or newtons_per_unit",
            found=repr(unit), do="Declare newtons_per_unit.",
        )  # fmt: skip
    return [*stored, StoredChannel(force.name, recording.force_n / (force.sign * newtons), unit, None)]


def write_csv(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """A time column, then one column per channel, units in brackets in the header.

    Nine significant digits: a round trip is exact to 5e-9 of each value.
    """
    channels = stored_channels(planned, recording, "V")
    header = io.StringIO()
    names = [f"{channel.name} [{channel.unit}]" if channel.unit else channel.name for channel in channels]
    csv.writer(header, lineterminator="\n").writerow(["time [s]", *names])
    columns = [recording.time_s, *(channel.samples for channel in channels)]
    return _write_table(_path(folder, planned, "csv"), header.getvalue(), columns, "%.9g")


def write_emgworks(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Write the file as Delsys EMGworks exports it without its header lines: each channel behind its own time column.

    The layout states no units: EMG is in volts, and force (an analog input of the same system) is in whatever unit the
    study gives its force channel. Headings are the channel names of the study, so name them as EMGworks would
    (``"Bagnoli sensor 1: EDC"``, ``"Load Cell: Fz"``) where that matters. Seven significant digits, as EMGworks writes:
    a round trip is exact to 5e-7 of each value.
    """
    channels = stored_channels(planned, recording, "V")
    header = ",".join(f'X[s],"{channel.name}"' for channel in channels)
    columns = [column for channel in channels for column in (recording.time_s, channel.samples)]
    return _write_table(_path(folder, planned, "csv"), f"{header}\n", columns, "%.7g")


def _path(folder: Path, planned: PlannedRecording, suffix: str) -> Path:
    return folder / f"{planned.participant}_{planned.specimen}.{suffix}"


def _write_table(path: Path, header: str, columns: Sequence[FloatArray], number: str) -> Path:
    """``columns`` are equally long, ``number`` is the printf format of each value."""
    table = np.column_stack(columns)
    line = ",".join([number] * table.shape[1]) + "\n"
    write_text_atomic(path, header + line * table.shape[0] % tuple(table.ravel().tolist()))
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
    path = _path(folder, planned, "c3d")
    path.parent.mkdir(parents=True, exist_ok=True)
    # ezc3d writes to a path only
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.stem}.") as temporary:
        file.write(str(Path(temporary) / path.name))
        os.replace(Path(temporary) / path.name, path)
    return path


def _rates_hz(fs_hz: float) -> tuple[float, float]:
    """Frames and samples a second in single precision, the former rounded down, for ezc3d truncates their ratio."""
    analog_hz, frame_hz = np.float32(fs_hz), np.float32(fs_hz / SAMPLES_PER_FRAME)
    while float(analog_hz) / float(frame_hz) < SAMPLES_PER_FRAME:
        frame_hz = np.nextafter(frame_hz, np.float32(0))
    return float(frame_hz), float(analog_hz)
