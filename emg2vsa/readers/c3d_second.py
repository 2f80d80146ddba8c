"""C3D through the package c3d, for files that ezc3d refuses or never ends on: analogue channels only, no plates.

It reads the files of SGI/MIPS and DEC systems too. It decodes frame by frame, some 16 000 a second.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import c3d
import numpy as np

from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.units import canonical

_NOTE = "ezc3d does not read this file; the package c3d did. The forces of its plates are not computed."


def open_recording(path: Path) -> OnDemand:
    """Decode the analogue channels. Raises RecordingError where c3d fails, or finds none."""
    try:
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _opened(path, c3d.Reader(file))
    except (RecordingError, MemoryError, ImportError):
        raise
    except Exception as error:  # c3d raises whatever its parsing stumbles over
        raise RecordingError(
            path, wanted="a C3D file", found=f"a damaged one ({said_by(error)})", do="Export or copy the file again."
        ) from error


def _opened(path: Path, file: c3d.Reader) -> OnDemand:
    n_channels, fs_hz = file.analog_used, float(file.analog_rate)
    if n_channels < 1 or not 0 < fs_hz < 1e9:
        raise RecordingError(
            path, wanted="analogue channels with a rate", found=f"{n_channels} channels, {fs_hz:g} Hz",
            do="Export the analogue data into the C3D file.",
        )  # fmt: skip
    analogs = np.concatenate([frame[2] for frame in file.read_frames(copy=True)], axis=1)
    labels, units = (_texts(file, key, n_channels) for key in ("LABELS", "UNITS"))
    start_s = (file.first_frame - 1) / file.point_rate if file.point_rate > 0 else 0.0
    tracks = tuple(
        Track(label, canonical(unit) or None, fs_hz, analogs.shape[1], float(start_s))
        for label, unit in zip(labels, units, strict=True)
    )
    refuse_nothing(path, tracks)
    contents = Contents(unique_names([track.name for track in tracks]), notes=(_NOTE,))
    return OnDemand(path, contents, tracks, lambda indices: [analogs[i] for i in indices])


def _texts(file: c3d.Reader, key: str, n: int) -> list[str]:
    """``n`` texts of a parameter of ANALOG and its continuations (LABELS2, ...), missing ones as ""."""
    found: list[str] = []
    group, part = file.get("ANALOG"), 1
    while (parameter := group.get(key if part == 1 else f"{key}{part}")) is not None:
        found += [str(text).strip(" \0") for text in parameter.string_array]
        part += 1
    return (found + [""] * n)[:n]
