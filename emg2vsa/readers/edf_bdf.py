"""EDF, EDF+, BDF and BDF+, with the side files of BIDS-EMG where they exist.

The samples are taken straight from the mapped file, one strided view for a signal, so that a signal nobody asks for
costs nothing. Specification: Kemp et al. 1992 and Kemp & Olivan 2003 (edfplus.info); BDF stores 24-bit integers.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.bids_sidecars import SideChannel, SideFiles, side_files
from emg2vsa.readers.edf_header import EdfHeader, Signal, parse_header
from emg2vsa.readers.opened import Contents, StoredChannel, unique_names
from emg2vsa.readers.units import canonical, si_factor
from emg2vsa.recordings import ChannelInfo

_ONSET = re.compile(rb"([+-]\d+(\.\d*)?)")


@dataclass(frozen=True)
class EdfRecording:
    """An EDF or BDF file whose header agrees with its size."""

    path: Path
    contents: Contents
    header: EdfHeader
    signals: tuple[Signal, ...]
    side: SideFiles
    raw: NDArray[np.uint8]
    n_records: int
    start_s: float

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(
            ChannelInfo(name, self._unit(signal)[0], self._fs_hz(signal), self.n_records * signal.samples)
            for name, signal in zip(self.contents.names, self.signals, strict=True)
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        return [self._load(self.contents.names[i], self.signals[i]) for i in indices]

    def _load(self, name: str, signal: Signal) -> StoredChannel:
        gain, offset = signal.calibration(f"{self.path}, channel {name!r}")
        samples = np.add(self._digital(signal), offset, dtype=np.float64).reshape(-1)
        samples *= gain
        unit, notes = self._unit(signal)
        side = self.side.channels.get(signal.label, SideChannel())
        return StoredChannel(
            name, samples, unit, self._fs_hz(signal), self.start_s, (*notes, *side.warnings(name, self._fs_hz(signal)))
        )

    def _digital(self, signal: Signal) -> NDArray[np.int32] | NDArray[np.int16]:
        shape, start = (self.n_records, signal.samples), self.header.n_bytes + signal.offset
        strides = (self.header.record_bytes, self.header.sample_bytes)
        if self.header.sample_bytes == 2:
            return np.ndarray(shape, "<i2", self.raw, start, strides)
        # four bytes from one before each 24-bit sample: the shift drops that byte and extends the sign
        return np.ndarray(shape, "<i4", self.raw, start - 1, strides) >> 8

    def _fs_hz(self, signal: Signal) -> float:
        return signal.samples / self.header.record_s

    def _unit(self, signal: Signal) -> tuple[str | None, tuple[str, ...]]:
        """The header's unit scales the samples; the side file's counts where the header states no known one."""
        header = canonical(signal.unit) or None
        side = self.side.channels.get(signal.label, SideChannel()).unit
        if header is None or side is None or header == side:
            return header or side, ()
        stated = f"{signal.label}: the file's header states {header}, channels.tsv {side}"
        ours, theirs = si_factor(header), si_factor(side)
        if ours and theirs and ours[0] != theirs[0]:
            return None, (f"{stated}, which are different quantities",)
        if ours or not theirs:
            return header, (f"{stated}; the header counts",)
        return side, (f"{stated}; the latter counts",)


def open_recording(path: Path) -> EdfRecording:
    """Validate header, size and continuity. Raises RecordingError with the field at fault."""
    header = parse_header(path)
    data_bytes = path.stat().st_size - header.n_bytes
    n_records = data_bytes // header.record_bytes
    if n_records == 0:
        raise RecordingError(
            path, wanted="data records", found="none", do="Copy the file again; it ends after its header."
        )
    raw = np.memmap(path, np.uint8, "r")
    side = side_files(path)
    signals = tuple(signal for signal in header.signals if not signal.is_annotation)
    if not signals:
        raise RecordingError(
            path, wanted="signals", found="annotations only", do="Choose the file that holds the signals."
        )
    start_s = _start_s(path, header, raw, n_records)
    fastest_hz = max(signal.samples for signal in signals) / header.record_s
    notes = (*_length_notes(header, n_records), *side.notes(fastest_hz))
    contents = Contents(unique_names([s.label for s in signals]), {}, notes, header.started)
    return EdfRecording(path, contents, header, signals, side, raw, n_records, start_s)


def _length_notes(header: EdfHeader, n_records: int) -> tuple[str, ...]:
    if header.n_records in (-1, n_records):  # -1: the recorder never wrote the number
        return ()
    said = f"The header promises {header.n_records} data records, the file holds {n_records}"
    return (f"{said}: it is incomplete." if n_records < header.n_records else f"{said}; all were used.",)


def _start_s(path: Path, header: EdfHeader, raw: NDArray[np.uint8], n_records: int) -> float:
    """Onset of the first data record (EDF+ time-keeping annotation); a discontinuous file is refused."""
    keeper = next((signal for signal in header.signals if signal.is_annotation), None)
    if keeper is None:
        return 0.0
    length = keeper.samples * header.sample_bytes
    first = header.n_bytes + keeper.offset
    n_looked_at = n_records if header.discontinuous else 1
    onsets = [
        _ONSET.match(raw[s : s + length].tobytes())
        for s in range(first, first + n_looked_at * header.record_bytes, header.record_bytes)
    ]
    found = [float(onset[1]) for onset in onsets if onset]
    for record in range(1, len(found)):
        if abs(found[record] - found[record - 1] - header.record_s) > 1e-6:
            raise RecordingError(
                f"{path}, data record {record + 1}", wanted="a continuous recording",
                found=f"a jump from {found[record - 1]:.6g} to {found[record]:.6g} s",
                do="Export the continuous stretches as files of their own.",
            )  # fmt: skip
    return found[0] if found else 0.0
