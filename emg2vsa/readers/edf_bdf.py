"""EDF, EDF+, BDF and BDF+ through edfio, with the side files of BIDS-EMG where they exist.

edfio believes the header. Checked here is what it would pass over: a first line or a header size that is wrong, a
calibration that cannot be read (it then hands out the stored integers), and a discontinuous file (it joins the pieces).
The samples of EDF are read when a channel is asked for; those of BDF all at once. Formats: edfplus.info.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import edfio
from edfio import Bdf, BdfSignal, Edf, EdfSignal

from emg2vsa.errors import RecordingError
from emg2vsa.readers.bids_sidecars import SideChannel, SideFiles, side_files
from emg2vsa.readers.opened import Contents, StoredChannel, unique_names
from emg2vsa.readers.units import canonical, si_factor
from emg2vsa.recordings import ChannelInfo

_EDF, _BDF = b"0       ", b"\xffBIOSEMI"
_ENCODING = "latin-1"  # the specification says ASCII, but recorders write the micro sign


@dataclass(frozen=True)
class EdfRecording:
    """signals : those of the file without its annotations."""

    path: Path
    contents: Contents
    signals: tuple[EdfSignal | BdfSignal, ...]
    n_records: int
    side: SideFiles
    start_s: float

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(
            ChannelInfo(
                name, self._unit(signal)[0], signal.sampling_frequency, self.n_records * signal.samples_per_data_record
            )
            for name, signal in zip(self.contents.names, self.signals, strict=True)
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        return [self._load(self.contents.names[i], self.signals[i]) for i in indices]

    def _load(self, name: str, signal: EdfSignal | BdfSignal) -> StoredChannel:
        _refuse_uncalibrated(f"{self.path}, channel {name!r}", signal)
        fs_hz = signal.sampling_frequency
        unit, notes = self._unit(signal)
        notes = (*notes, *self._side(signal).warnings(name, fs_hz))
        return StoredChannel(name, signal.data.copy(), unit, fs_hz, self.start_s, notes)

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
        file = _read(path, is_bdf)
        _refuse_gaps(path, file)
        start_s, started, unknown_start = _start(file)
    signals = file.signals
    side = side_files(path)
    warned = [str(warning.message).removesuffix(" Updating header.") for warning in said]
    notes = (*warned, *unknown_start, *side.notes(max(signal.sampling_frequency for signal in signals)))
    contents = Contents(unique_names([signal.label for signal in signals]), {}, notes, started)
    return EdfRecording(path, contents, signals, file.num_data_records, side, start_s)


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


def _read(path: Path, is_bdf: bool) -> Edf | Bdf:
    try:
        if is_bdf:
            file: Edf | Bdf = edfio.read_bdf(path, header_encoding=_ENCODING)
        else:
            file = edfio.read_edf(path, lazy_load_data=True, header_encoding=_ENCODING)
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
    if file.num_data_records == 0:
        raise _no_records(path)
    return file


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
