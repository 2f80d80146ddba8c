"""Recordings of neurophysiology programs through neo, an optional package.

Spike2 (.smr), Axon (.abf), Intan (.rhd, .rhs), Open Ephys (structure.oebin) and Plexon (.plx). A pause or a sweep
begins a segment, and each segment is a channel of its own ("EMG, segment 2"), as in an XDF file.

Of Plexon's channels neo 0.14 tells no unit, though it scales them to millivolts; it takes the resolution of spikes for
theirs, begins them at 0, leaves out their last block and counts samples through pauses. The first four are mended here,
a pause is refused.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import neo.rawio
import numpy as np
from numpy.typing import NDArray

from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.units import canonical

_PLEXON_VERSION_AT, _PLEXON_BITS_AT = 4, 202
"""Bytes of a Plexon header where its version stands, and the bits of a sample of spikes, then of other channels."""
_PLEXON_STATES_BITS = 103
"""The first version that states them."""


@dataclass(frozen=True)
class _Place:
    """Where neo has one channel. scale : what the numbers that neo scales are to be multiplied by."""

    id: str
    block: int
    segment: int
    stream: int
    index: int
    scale: float


@dataclass(frozen=True)
class _Mended:
    """What neo does not tell of the channels of a file, starts by the channel's id."""

    unit: str | None = None
    scale: float = 1.0
    start_s: Mapping[str, float] | None = None


def open_recording(path: Path) -> OnDemand:
    """Read the header. Raises RecordingError for a damaged file, one without signals, and Plexon files with pauses."""
    logging.getLogger("neo").setLevel(logging.CRITICAL)
    try:
        decoder = _decoder(path)
        decoder.parse_header()
        mended = _plexon(path, decoder) if isinstance(decoder, neo.rawio.PlexonRawIO) else _Mended()
        found = _tracks(decoder, mended)
        refuse_nothing(path, [track for track, _ in found])
    except (RecordingError, MemoryError, ImportError):
        raise
    except Exception as error:  # neo raises whatever its parsing stumbles over
        raise RecordingError(
            path, wanted="a file that neo can read", found=f"a damaged or unknown one ({said_by(error)})",
            do="Export or copy the file again; as CSV with a time column if need be.",
        ) from error  # fmt: skip

    def decode(indices: Sequence[int]) -> list[NDArray[Any]]:
        return [_samples(decoder, found[i][1]) for i in indices]

    begun = decoder.raw_annotations["blocks"][0].get("rec_datetime")
    names = unique_names([track.name for track, _ in found])
    contents = Contents(names, started="" if begun is None else str(begun))
    return OnDemand(path, contents, tuple(track for track, _ in found), decode)


def _decoder(path: Path) -> Any:
    """The reader of neo for the file, by what the table of formats knows it by."""
    with path.open("rb") as file:
        head = file.read(16)
    if head.startswith((b"ABF ", b"ABF2")):
        return neo.rawio.AxonRawIO(str(path))
    if head.startswith(b"PLEX"):
        return neo.rawio.PlexonRawIO(str(path), progress_bar=False)
    if head[2:].startswith(b"(C) CED 87"):
        # grouped channels would share the start of the first
        return neo.rawio.Spike2RawIO(str(path), try_signal_grouping=False)
    if path.name == "structure.oebin":
        return neo.rawio.OpenEphysBinaryRawIO(str(path.parent))
    return neo.rawio.IntanRawIO(str(path))


def _tracks(decoder: Any, mended: _Mended) -> list[tuple[Track, _Place]]:
    """Every channel in every segment."""
    header = decoder.header
    channels = header["signal_channels"]
    segments = [(block, n) for block in range(header["nb_block"]) for n in range(header["nb_segment"][block])]
    uses = Counter(str(name) for name in channels["name"])
    found = []
    for stream, described in enumerate(header["signal_streams"]):
        for index, channel in enumerate(channels[channels["stream_id"] == described["id"]]):
            name = str(channel["name"])
            name = f"{described['name']}: {name}" if uses[name] > 1 and described["name"] else name
            told = f"{name}: {len(segments)} segments; each is a channel of its own."
            for number, (block, segment) in enumerate(segments, start=1):
                start_s = float(decoder.get_signal_t_start(block, segment, stream))
                track = Track(
                    f"{name}, segment {number}" if number > 1 else name,
                    canonical(str(channel["units"])) or mended.unit,
                    float(f"{float(channel['sampling_rate']):.9g}"),
                    int(decoder.get_signal_size(block, segment, stream)),
                    start_s if mended.start_s is None else mended.start_s[str(channel["id"])],
                    (told,) if len(segments) > 1 else (),
                )
                found.append((track, _Place(str(channel["id"]), block, segment, stream, index, mended.scale)))
    return found


def _samples(decoder: Any, place: _Place) -> NDArray[np.float64]:
    at = {"stream_index": place.stream, "channel_indexes": [place.index]}
    if isinstance(decoder, neo.rawio.PlexonRawIO):
        blocks = decoder._data_blocks[5][int(place.id)]
        parts = [decoder._memmap[block["pos"] : block["pos"] + block["size"]].view("<i2") for block in blocks]
        raw = np.concatenate(parts)[:, None]
    else:
        raw = decoder.get_analogsignal_chunk(place.block, place.segment, **at)
    scaled = decoder.rescale_signal_raw_to_float(raw, dtype="float64", **at)[:, 0]
    return np.asarray(scaled * place.scale)


def _plexon(path: Path, decoder: Any) -> _Mended:
    """Unit, scale and starts of a Plexon file. RecordingError: a pause, as neo joins what was recorded around it."""
    with path.open("rb") as file:
        head = file.read(_PLEXON_BITS_AT + 2)
    states_bits = int.from_bytes(head[_PLEXON_VERSION_AT : _PLEXON_VERSION_AT + 4], "little") >= _PLEXON_STATES_BITS
    of_spikes, of_channels = head[_PLEXON_BITS_AT:]
    clock_hz = float(decoder._global_ssampling_rate)
    starts_s = {}
    for channel in decoder.header["signal_channels"]:
        blocks = decoder._data_blocks[5][int(channel["id"])]
        starts_s[str(channel["id"])] = float(blocks["timestamp"][0]) / clock_hz
        lasts_s = blocks["size"][:-1] / 2 / float(channel["sampling_rate"])
        off_s = np.diff(blocks["timestamp"]) / clock_hz - lasts_s
        pauses = np.flatnonzero(np.abs(off_s) > 0.5 / float(channel["sampling_rate"]))
        if pauses.size:
            at_s = float(blocks["timestamp"][pauses[0]]) / clock_hz + float(lasts_s[pauses[0]])
            raise RecordingError(
                f"{path}, channel {str(channel['name'])!r}", wanted="a recording without pauses",
                found=f"{pauses.size} pauses, the first of {off_s[pauses[0]]:.6g} s after {at_s:.6g} s",
                do="Export each part as CSV with a time column, from Plexon's Offline Sorter or NeuroExplorer.",
            )  # fmt: skip
    return _Mended("mV", 2.0 ** (of_spikes - of_channels) if states_bits else 1.0, starts_s)
