"""The header of EDF and BDF files: fixed-width text fields, each checked as it is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.errors import RecordingError

_WIDTHS = {
    "label": 16, "transducer": 80, "unit": 8, "physical_min": 8, "physical_max": 8, "digital_min": 8, "digital_max": 8,
    "prefilter": 80, "samples": 8, "reserved": 32,
}  # fmt: skip


@dataclass(frozen=True)
class Signal:
    """One signal: ``samples`` in a data record, from byte ``offset`` of the record on."""

    label: str
    unit: str
    physical: tuple[float, float]
    digital: tuple[int, int]
    samples: int
    offset: int

    @property
    def is_annotation(self) -> bool:
        return self.label in ("EDF Annotations", "BDF Annotations")

    def calibration(self, where: str) -> tuple[float, float]:
        """(gain, offset) with physical = gain * (digital + offset)."""
        (low, high), (digital_low, digital_high) = self.physical, self.digital
        if low == high or digital_low == digital_high:
            raise RecordingError(
                where, wanted="a calibration with two different ends",
                found=f"physical {low:g} to {high:g}, digital {digital_low} to {digital_high}",
                do="Export the channel again with its true range.",
            )  # fmt: skip
        gain = (high - low) / (digital_high - digital_low)
        return gain, high / gain - digital_high


@dataclass(frozen=True)
class EdfHeader:
    """Sizes in bytes; ``n_records`` is -1 where the recorder never closed the file. record_s : seconds in a record."""

    n_bytes: int
    record_bytes: int
    sample_bytes: int
    n_records: int
    record_s: float
    started: str
    discontinuous: bool
    signals: tuple[Signal, ...]


def parse_header(path: Path) -> EdfHeader:
    """Read and check a header. Raises RecordingError naming the field that is wrong."""
    with path.open("rb") as file:
        fixed = file.read(256)
        if len(fixed) < 256 or not fixed.startswith((b"0       ", b"\xffBIOSEMI")):
            raise RecordingError(
                path, wanted="an EDF or BDF header of 256 bytes",
                found=f"{len(fixed)} bytes that begin with {fixed[:8]!r}", do="Export or copy the file again.",
            )  # fmt: skip
        n_signals = int(_number(path, "number of signals", fixed[252:256], 1, 9999))
        listed = file.read(256 * n_signals)
    if len(listed) < 256 * n_signals:
        raise RecordingError(
            path,
            wanted=f"a header of {n_signals} signals",
            found=f"{len(listed)} bytes of it",
            do="Copy the file again.",
        )
    sample_bytes = 3 if fixed[0] == 0xFF else 2
    signals = _signals(path, listed, n_signals, sample_bytes)
    reserved = fixed[192:236].decode("latin-1")
    n_bytes = int(_number(path, "header size", fixed[184:192], 256, 1e9))
    if n_bytes != 256 * (n_signals + 1):
        raise RecordingError(
            path, wanted=f"a header size of {256 * (n_signals + 1)} bytes for {n_signals} signals", found=str(n_bytes),
            do="Export the file again.",
        )  # fmt: skip
    date, time = fixed[168:176].decode("latin-1"), fixed[176:184].decode("latin-1")
    return EdfHeader(
        n_bytes,
        sum(signal.samples for signal in signals) * sample_bytes,
        sample_bytes,
        int(_number(path, "number of data records", fixed[236:244], -1, 1e9)),
        _number(path, "duration of a data record", fixed[244:252], 1e-6, 1e6),
        f"{date} {time}",
        reserved.startswith(("EDF+D", "BDF+D")),
        signals,
    )


def _signals(path: Path, listed: bytes, n_signals: int, sample_bytes: int) -> tuple[Signal, ...]:
    fields: dict[str, list[bytes]] = {}
    start = 0
    for name, width in _WIDTHS.items():
        fields[name] = [listed[start + width * i : start + width * (i + 1)] for i in range(n_signals)]
        start += width * n_signals
    signals: list[Signal] = []
    offset = 0
    for i in range(n_signals):
        signals.append(_signal(path, i + 1, {name: raw[i] for name, raw in fields.items()}, offset))
        offset += signals[-1].samples * sample_bytes
    return tuple(signals)


def _signal(path: Path, position: int, fields: Mapping[str, bytes], offset: int) -> Signal:
    label = fields["label"].decode("latin-1").strip()

    def number(name: str, low: float, high: float) -> float:
        return _number(path, f"{name.replace('_', ' ')} of signal {position} {label!r}", fields[name], low, high)

    return Signal(
        label,
        fields["unit"].decode("latin-1").strip(),
        (number("physical_min", -1e300, 1e300), number("physical_max", -1e300, 1e300)),
        (int(number("digital_min", -(2**23), 2**23)), int(number("digital_max", -(2**23), 2**23))),
        int(number("samples", 1, 1e9)),
        offset,
    )


def _number(path: Path, field: str, raw: bytes, low: float, high: float) -> float:
    text = raw.decode("latin-1").strip()
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not low <= value <= high:
        raise RecordingError(
            f"{path}, header field {field!r}", wanted=f"a number from {low:g} to {high:g}", found=repr(text),
            do="Export or copy the file again.",
        )  # fmt: skip
    return value
