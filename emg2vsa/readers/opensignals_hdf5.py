"""OpenSignals (biosignalsplux): HDF5 exports. One group per device, each with its own rate, resolution and length.

``raw/channel_<k>`` and ``digital/digital_<k>`` are its channels; ``raw/nSeq`` says which samples were lost. The
decimated copies under ``support`` are made for plotting and are no channels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import CountedRows, OnDemand, Track, counted, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.opensignals import COUNTER, rate_hz, started, unit_of

_WRITTEN_BY = "OpenSignals, or MATLAB 7.3"
_RAW = "channel_"


def open_recording(path: Path) -> OnDemand:
    """Read attributes and counters. Raises RecordingError for an HDF5 file that OpenSignals did not write."""
    try:
        return _opened(path, h5py.File(path, "r"))
    except (RecordingError, MemoryError, ImportError):
        raise
    except Exception as error:  # h5py raises whatever its parsing stumbles over
        raise RecordingError(
            path, wanted="an HDF5 file", found=f"a damaged one ({said_by(error)})", do="Export or copy the file again."
        ) from error


def _opened(path: Path, file: h5py.File) -> OnDemand:
    devices = {name: group for name, group in file.items() if isinstance(group, h5py.Group) and "raw" in group}
    if not devices:
        raise RecordingError(
            path, wanted=f"an HDF5 file of {_WRITTEN_BY}", found="groups " + ", ".join(map(repr, list(file)[:8])),
            do="Export the recording as CSV with a time column.",
        )  # fmt: skip
    tracks: list[Track] = []
    places: list[tuple[h5py.Dataset, CountedRows]] = []
    aliases: dict[str, int] = {}
    for address, device in devices.items():
        stated = dict(device.attrs)
        fs_hz = rate_hz(path, address, stated)
        rows = _rows(address, device, fs_hz)
        prefix = f"{address}: " if len(devices) > 1 else ""
        for own, channel in _channels(device):
            label = str(channel.attrs.get("label", own))
            own_rows = rows if rows.n_rows == channel.shape[0] else CountedRows(None, channel.shape[0])
            unit, notes = unit_of(stated) if own.startswith(_RAW) else (None, ())
            aliases[prefix + own] = len(tracks)
            tracks.append(Track(prefix + label, unit, fs_hz, own_rows.n_samples, notes=(*own_rows.notes, *notes)))
            places.append((channel, own_rows))
    refuse_nothing(path, tracks)

    def decode(indices: Sequence[int]) -> list[NDArray[Any]]:
        return [places[i][1].placed(np.asarray(places[i][0]).reshape(-1)) for i in indices]

    contents = Contents(
        unique_names([track.name for track in tracks]),
        aliases,
        started=started(_text(next(iter(devices.values())).attrs)),
    )
    return OnDemand(path, contents, tuple(tracks), decode)


def _text(attributes: Mapping[str, Any]) -> dict[str, str]:
    return {key: str(attributes[key]) for key in ("date", "time") if key in attributes}


def _channels(device: h5py.Group) -> list[tuple[str, h5py.Dataset]]:
    """(own name, samples) of the analogue channels in order of their number, then of the digital ones."""
    found = []
    for folder, start in (("raw", _RAW), ("digital", "digital_")):
        group = device.get(folder)
        names = [name for name in group if name.startswith(start)] if isinstance(group, h5py.Group) else []
        for name in sorted(names, key=lambda name: (len(name), name)):
            channel = group[name]
            if isinstance(channel, h5py.Dataset) and channel.ndim in (1, 2) and channel.size == channel.shape[0]:
                found.append((name, channel))
    return found


def _rows(address: str, device: h5py.Group, fs_hz: float) -> CountedRows:
    counter = device["raw"].get(COUNTER)
    if not isinstance(counter, h5py.Dataset):
        return CountedRows(None, 0)
    return counted(np.asarray(counter).reshape(-1).astype(np.float64), f"{address}: {COUNTER}", fs_hz)
