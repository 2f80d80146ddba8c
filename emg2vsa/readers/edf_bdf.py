"""EDF, EDF+, BDF and BDF+ through edfio, with the side files of BIDS-EMG where they exist.

edfio believes the header. Checked here is what it would pass over: a first line or a header size that is wrong, a
calibration that cannot be read (it then hands out the stored integers), and a discontinuous file (it joins the pieces).
Samples are read when a channel is asked for, some data records at a time and not through edfio, which would hold the
whole file in memory, and decode every sample of a BDF. Formats: edfplus.info.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import edfio
import numpy as np
from edfio import Bdf, BdfSignal, Edf, EdfSignal
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.bids_sidecars import SideChannel, SideFiles, side_files
from emg2vsa.readers.opened import Contents, StoredChannel, unique_names
from emg2vsa.readers.units import canonical, si_factor
from emg2vsa.recordings import ChannelInfo

_EDF, _BDF = b"0       ", b"\xffBIOSEMI"
_ENCODING = "latin-1"  # the specification says ASCII, but recorders write the micro sign
Digital = NDArray[np.int16] | NDArray[np.int32]
_AT_ONCE = 2**21
"Stored samples that are in memory at a time."


@dataclass(frozen=True)
class EdfRecording:
    """signals : those of the file without its annotations. records : where their samples are."""

    path: Path
    contents: Contents
    signals: tuple[EdfSignal | BdfSignal, ...]
    n_records: int
    side: SideFiles
    start_s: float
    records: _Records

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(
            ChannelInfo(
                name, self._unit(signal)[0], signal.sampling_frequency, self.n_records * signal.samples_per_data_record
            )
            for name, signal in zip(self.contents.names, self.signals, strict=True)
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        return [self._load(i) for i in indices]

    def _load(self, i: int) -> StoredChannel:
        name, signal = self.contents.names[i], self.signals[i]
        _refuse_uncalibrated(f"{self.path}, channel {name!r}", signal)
        fs_hz = signal.sampling_frequency
        unit, notes = self._unit(signal)
        notes = (*notes, *self._side(signal).warnings(name, fs_hz))
        n = self.n_records * signal.samples_per_data_record
        samples = _calibrated(self.records.of(i, self.n_records), n, signal)
        return StoredChannel(name, samples, unit, fs_hz, self.start_s, notes)

    def _side(self, signal: EdfSignal | BdfSignal) -> SideChannel:
        return self.side.channels.get(signal.label.strip(), SideChannel())

    def _unit(self, signal: EdfSignal | BdfSignal) -> tuple[str | None, tuple[str, ...]]:
        """The header's unit scales the samples; the side file's counts where the header states no known one."""
        header = canonical(signal.physical_dimension) or None
        side = self._side(signal).unit
        if header is None or side is None or header == side:
            return header or side, ()
        stated = f"{signal.label.strip()}: the file's header states {header}, channels.tsv {side}"
        ours, theirs = si_factor(header), si_factor(side)
        if ours and theirs and ours[0] != theirs[0]:
            return None, (f"{stated}, which are different quantities",)
        if ours or not theirs:
            return header, (f"{stated}; the header counts",)
        return side, (f"{stated}; the latter counts",)


def open_recording(path: Path) -> EdfRecording:
    """Raises RecordingError for a damaged header, a file without signals or samples, and a discontinuous one."""
    is_bdf = _checked_head(path)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        file, records, n_records = _read(path, is_bdf)
        _refuse_gaps(path, file)
        start_s, started, unknown_start = _start(file)
    signals = file.signals
    side = side_files(path)
    warned = [str(warning.message).removesuffix(" Updating header.") for warning in said]
    notes = (*warned, *unknown_start, *side.notes(max(signal.sampling_frequency for signal in signals)))
    contents = Contents(unique_names([signal.label for signal in signals]), {}, notes, started)
    return EdfRecording(path, contents, signals, n_records, side, start_s, records)


@dataclass(frozen=True)
class _Records:
    """Data records after the header ``head``, of ``size`` samples of ``width`` bytes; columns : where those of each
    signal, without annotations, begin and end in them. file : kept open, so that a file put in its place is not read
    for it."""

    file: BinaryIO
    head: bytes
    size: int
    width: int
    columns: tuple[tuple[int, int], ...]

    @staticmethod
    def of_file(path: Path, is_bdf: bool) -> _Records:
        """ValueError where the header states no numbers."""
        file = path.open("rb")
        head = file.read(256)
        n = int(head[252:256])
        head += file.read(256 * n)
        labels = [head[256 + 16 * i : 272 + 16 * i].rstrip() for i in range(n)]
        counts = head[256 + 216 * n :].decode(_ENCODING)
        ends = np.cumsum([0, *(int(counts[8 * i : 8 * i + 8].strip()) for i in range(n))]).tolist()
        notes = b"BDF Annotations" if is_bdf else b"EDF Annotations"
        columns = [(ends[i], ends[i + 1]) for i in range(n) if labels[i] != notes]
        return _Records(file, head, ends[-1], 3 if is_bdf else 2, tuple(columns))

    def of(self, i: int, n_records: int) -> Iterator[Digital]:
        """Stored samples of one signal, those of some records at a time. RecordingError where the file has become
        shorter since it was opened."""
        first, last = self.columns[i]
        self.file.seek(len(self.head))
        at_once, step = max(1, _AT_ONCE // self.size), self.size * self.width
        before = self.width % 2  # of three bytes and the one before them, three make the number
        for left in range(n_records, 0, -at_once):
            wanted = min(at_once, left)
            block = bytearray(before + wanted * step)
            found = self.file.readinto(memoryview(block)[before:])  # type: ignore[attr-defined]
            if found < wanted * step:
                raise RecordingError(
                    self.file.name, wanted=f"{n_records} data records, as when it was opened",
                    found=f"{n_records - left + found // step}",
                    do="Wait until the program that writes it has finished, then read it again.",
                )  # fmt: skip
            shape, steps = (wanted, last - first), (step, self.width)
            stored = np.ndarray(shape, "<i4" if before else "<i2", block, first * self.width, steps)
            yield (stored >> 8 if before else stored).ravel()


def _calibrated(pieces: Iterator[Digital], n: int, signal: EdfSignal | BdfSignal) -> NDArray[np.float64]:
    """The n samples in the signal's unit, rounded as edfio does."""
    (low, high), (digital_low, digital_high) = signal.physical_range, signal.digital_range
    gain = (high - low) / (digital_high - digital_low)
    offset = high / gain - digital_high
    samples = np.empty(n)
    begin = 0
    for piece in pieces:
        own = samples[begin : begin + piece.size]
        np.add(piece, offset, out=own)
        own *= gain
        begin += piece.size
    return samples


def _checked_head(path: Path) -> bool:
    """Whether the file is BDF; RecordingError where its first 256 bytes are neither EDF nor BDF, or it ends there."""
    with path.open("rb") as file:
        head = file.read(256)
    if len(head) < 256 or not head.startswith((_EDF, _BDF)):
        raise RecordingError(
            path, wanted="an EDF or BDF header of 256 bytes", found=f"{len(head)} bytes that begin with {head[:8]!r}",
            do="Export or copy the file again.",
        )  # fmt: skip
    try:
        n_bytes, n_signals = int(head[184:192]), int(head[252:256])
    except ValueError as error:
        raise _damaged(path, error) from error
    if n_signals < 1 or n_bytes != 256 * (n_signals + 1):
        raise RecordingError(
            path, wanted="a header of 256 bytes, and 256 more for each signal",
            found=f"{n_bytes} bytes stated for {n_signals} signals", do="Export or copy the file again.",
        )  # fmt: skip
    if path.stat().st_size <= n_bytes:
        raise _no_records(path)
    return head.startswith(_BDF)


def _read(path: Path, is_bdf: bool) -> tuple[Edf | Bdf, _Records, int]:
    """The header with the annotations as edfio reads them, and the data records with their number."""
    try:
        records = _Records.of_file(path, is_bdf)
        file, n_records = _described(path, records, edfio.read_bdf if is_bdf else edfio.read_edf)
    except MemoryError:
        raise
    except Exception as error:  # edfio raises whatever its parsing stumbles over, even NameError
        raise _damaged(path, error) from error
    if not file.signals:
        raise RecordingError(
            path, wanted="signals", found="annotations only", do="Choose the file that holds the signals."
        )
    fewest = min(signal.samples_per_data_record for signal in file.signals)
    if not (file.data_record_duration > 0 and fewest > 0):
        raise RecordingError(
            path, wanted="data records of a positive duration, with samples of every signal",
            found=f"{file.data_record_duration:g} s, and {fewest} samples of a signal", do="Export the file again.",
        )  # fmt: skip
    if n_records == 0:
        raise _no_records(path)
    return file, records, n_records


def _described(path: Path, records: _Records, read: Callable[..., Edf | Bdf]) -> tuple[Edf | Bdf, int]:
    """edfio, which decodes all that it is given, gets the first data record, which states the start; every one where
    the header says that there may be gaps."""
    head, step, kind = records.head, records.size * records.width, read.__name__[-3:].upper()
    if head[192:].startswith((b"EDF+D", b"BDF+D")):
        file = read(path, header_encoding=_ENCODING)
        return file, file.num_data_records
    stated = int(head[236:244].decode(_ENCODING).strip())
    n_records, rest = divmod(path.stat().st_size - len(head), step)
    if rest:
        warnings.warn(f"Incomplete data record at the end of the {kind} file. Data was truncated.", stacklevel=2)
    if n_records != stated:
        told = f"{kind} header indicates {stated} data records, but file contains {n_records} records."
        warnings.warn(told, stacklevel=2)
    given = min(n_records, 1)
    part = head[:236] + b"%-8d" % given + head[244:] + records.file.read(given * step)
    return read(io.BytesIO(part), header_encoding=_ENCODING), n_records


def _damaged(path: Path, error: Exception) -> RecordingError:
    found = "one that cannot be read" + (f" ({error})" if isinstance(error, ValueError) else "")
    return RecordingError(path, wanted="an EDF or BDF header", found=found, do="Export or copy the file again.")


def _no_records(path: Path) -> RecordingError:
    return RecordingError(
        path, wanted="data records", found="none", do="Copy the file again; it ends after its header."
    )


def _refuse_gaps(path: Path, file: Edf | Bdf) -> None:
    if not file.reserved.startswith(("EDF+D", "BDF+D")):
        return
    try:
        if file.is_continuous:
            return
        found = f"{file.reserved[:5]}, with gaps between its data records"
    except ValueError:
        found = f"{file.reserved[:5]}, with data records of unknown onset"
    raise RecordingError(
        path, wanted="a continuous recording", found=found, do="Export the continuous stretches as files of their own."
    )


def _start(file: Edf | Bdf) -> tuple[float, str, tuple[str, ...]]:
    """(time of the first sample, the full second that is time 0, notes). EDF+ states the fraction as an annotation."""
    try:
        time = file.starttime
    except (ValueError, IndexError):
        return 0.0, "", ("The start of the recording cannot be read; time 0 is its first sample.",)
    try:
        date = f"{file.startdate} "
    except ValueError:  # anonymised
        date = ""
    return time.microsecond * 1e-6, f"{date}{time.replace(microsecond=0)}", ()


def _refuse_uncalibrated(where: str, signal: EdfSignal | BdfSignal) -> None:
    try:
        (low, high), (digital_low, digital_high) = signal.physical_range, signal.digital_range
        found = f"physical {low:g} to {high:g}, digital {digital_low} to {digital_high}"
        readable = low != high and digital_low != digital_high
    except ValueError as error:
        found, readable = f"a field that is no number ({error})", False
    if not readable:
        raise RecordingError(
            where, wanted="a calibration with two different ends", found=found,
            do="Export the channel again with its true range.",
        )  # fmt: skip
