"""National Instruments TDMS through npTDMS, an optional package.

Rate, unit and start are properties of a channel: ``wf_increment``, ``unit_string`` or ``NI_UnitDescription``,
``wf_start_time`` and ``wf_start_offset``. A channel without wf_increment has no rate. SignalExpress adds groups
"Decimated Data_Level..." for plotting, which are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from numpy.typing import NDArray

from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.units import canonical

_DECIMATED = "Decimated Data_Level"


def open_recording(path: Path) -> OnDemand:
    """Read the properties. Raises RecordingError for a damaged file and one without channels of numbers."""
    try:
        file = TdmsFile.open(path.open("rb"))  # by its name, npTDMS would believe an index beside it, be it of another
        channels = [c for group in file.groups() if not group.name.startswith(_DECIMATED) for c in group.channels()]
        return _opened(path, file, channels)
    except (RecordingError, MemoryError, ImportError):
        raise
    except Exception as error:  # npTDMS raises whatever its parsing stumbles over
        raise RecordingError(
            path, wanted="a TDMS file", found=f"a damaged one ({said_by(error)})", do="Export or copy the file again."
        ) from error


def _opened(path: Path, file: TdmsFile, channels: Sequence[TdmsChannel]) -> OnDemand:
    numbers = [channel for channel in channels if channel.dtype.kind in "iuf"]
    notes = [
        f"{channel.name}: holds no numbers and is no channel here." for channel in channels if channel not in numbers
    ]
    if file.file_status.incomplete_final_segment:
        notes.append("The file is incomplete: its last segment is cut.")
    begun = [channel.properties.get("wf_start_time") for channel in numbers]
    known = [each for each in begun if isinstance(each, np.datetime64)]
    first = min(known, default=None)
    tracks = tuple(_track(channel, each, first) for channel, each in zip(numbers, begun, strict=True))
    refuse_nothing(path, tracks)
    several = len({channel.group_name for channel in numbers}) > 1
    common = [channel.name for channel in numbers]
    names = unique_names(
        [f"{c.group_name}: {c.name}" if several and common.count(c.name) > 1 else c.name for c in numbers]
    )
    aliases = {f"{channel.group_name}: {channel.name}": i for i, channel in enumerate(numbers)}

    def decode(indices: Sequence[int]) -> list[NDArray[Any]]:
        return [np.asarray(numbers[i][:]) for i in indices]

    contents = Contents(names, aliases, tuple(notes), "" if first is None else f"{first} UTC")
    return OnDemand(path, contents, tracks, decode)


def _track(channel: TdmsChannel, begun: Any, first: np.datetime64 | None) -> Track:
    said = channel.properties
    increment = _number(said.get("wf_increment"))
    unit = canonical(str(said.get("unit_string") or said.get("NI_UnitDescription") or "")) or None
    later_s = (
        (begun - first) / np.timedelta64(1, "s") if first is not None and isinstance(begun, np.datetime64) else 0.0
    )
    start_s = _number(said.get("wf_start_offset"), 0.0) + float(later_s)
    notes = () if increment > 0 else (f"{channel.name}: the file states no wf_increment, hence no rate.",)
    fs_hz = float(f"{1 / increment:.12g}") if increment > 0 else float("nan")
    return Track(channel.name, unit, fs_hz, len(channel), start_s if np.isfinite(start_s) else 0.0, notes)


def _number(value: Any, default: float = float("nan")) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return default
