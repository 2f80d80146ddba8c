"""C3D: the analogue channels, and the force plates as channels "plate 1 Fx", "plate 1 Fy", "plate 1 Fz" in N.

The plates' forces come from ezc3d's force-platform module, which applies calibration matrix and sign of the plate type
(www.c3d.org). The clock counts from frame 1 of the measurement.
"""

from __future__ import annotations

import math
import struct
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ezc3d
import numpy as np
from ezc3d import ezc3d as binding
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError, UnsupportedError
from emg2vsa.readers.opened import Contents, StoredChannel, unique_names
from emg2vsa.recordings import ChannelInfo

_AXES = ("Fx", "Fy", "Fz")
_UNKNOWN_FRAME = 65535
"""Written where the frame number does not fit the header word."""
_PARAMETERS_END = 512 * 512
"""Parameters end before this byte: the block they begin at and the number of their blocks are bytes."""
_LONGEST_DESCRIPTION = 127


@dataclass(frozen=True)
class C3dRecording:
    """analogs : (channels, n) in the units of ANALOG:UNITS. Their names come first, those of the plates follow.

    file : the ezc3d object the plates are computed from.
    """

    path: Path
    contents: Contents
    analogs: NDArray[np.float64]
    units: tuple[str | None, ...]
    fs_hz: float
    start_s: float
    file: Any

    def describe(self) -> tuple[ChannelInfo, ...]:
        n = self.analogs.shape[1]
        return tuple(
            ChannelInfo(name, unit, self.fs_hz, n) for name, unit in zip(self.contents.names, self.units, strict=True)
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        """Samples of these channels. RecordingError : force plates of a type that cannot be read."""
        n_analogs = self.analogs.shape[0]
        plates = self._plate_forces_n() if any(i >= n_analogs for i in indices) else []
        channels = []
        for i in indices:
            plate, axis = divmod(i - n_analogs, 3)
            samples = np.ascontiguousarray(
                self.analogs[i] if i < n_analogs else plates[plate][:, axis], dtype=np.float64
            )
            channels.append(StoredChannel(self.contents.names[i], samples, self.units[i], self.fs_hz, self.start_s))
        return channels

    def _plate_forces_n(self) -> list[NDArray[np.float64]]:
        """(n, 3) per plate. The binding is asked directly: the Python layer converts moments and centres too."""
        try:
            plates = binding.ForcePlatforms(self.file.c3d_swig).forcePlatforms()
            return [np.array([force.to_array()[:, 0] for force in plate.forces()]) for plate in plates]
        except (RuntimeError, ValueError, IndexError) as error:
            raise RecordingError(
                f"{self.path}, force plates", wanted="plates of a type that ezc3d knows", found=str(error),
                do="Use the analogue channel of the vertical force instead.",
            ) from error  # fmt: skip


def open_recording(path: Path) -> C3dRecording:
    """Raises RecordingError where ezc3d refuses the file, or where it holds no analogue samples or no rate."""
    file = _read(path)
    parameters = file["parameters"]
    analogs = np.asarray(file["data"]["analogs"])[0]
    fs_hz = float(_values(parameters, "ANALOG", "RATE", 1, 0.0)[0])
    if analogs.size == 0 or fs_hz <= 0:
        raise RecordingError(
            path, wanted="analogue channels with a rate", found=f"{analogs.shape[0]} channels, {fs_hz:g} Hz",
            do="Export the analogue data into the C3D file.",
        )  # fmt: skip
    n = analogs.shape[0]
    names = [str(label) for label in _values(parameters, "ANALOG", "LABELS", n, "")]
    units = [str(unit).strip() or None for unit in _values(parameters, "ANALOG", "UNITS", n, "")]
    n_plates = int(_values(parameters, "FORCE_PLATFORM", "USED", 1, 0)[0])
    names += [f"plate {plate + 1} {axis}" for plate in range(n_plates) for axis in _AXES]
    units += ["N"] * (3 * n_plates)
    points = file["header"]["points"]
    start_s = points["first_frame"] / points["frame_rate"] if points["frame_rate"] > 0 else 0.0
    contents = Contents(unique_names(names), notes=_incomplete(path, analogs.shape[1]))
    return C3dRecording(path, contents, analogs, tuple(units), fs_hz, float(start_s), file)


def _incomplete(path: Path, n: int) -> tuple[str, ...]:
    """ezc3d stops without a word where the file does; words 4, 5 and 10 of the header say where it should."""
    with path.open("rb") as file:
        first, last, per_frame = struct.unpack("<6xHH8xH", file.read(20))
    promised = (last - first + 1) * per_frame
    if last == _UNKNOWN_FRAME or n >= promised:
        return ()
    return (f"The header promises {promised} samples a channel, the file holds {n}: it is incomplete.",)


def _read(path: Path) -> Any:
    with path.open("rb") as file:
        if file.read(2)[1:] != b"\x50":
            raise RecordingError(path, wanted="a C3D file", found="other content", do="Export or copy the file again.")
    try:
        with _readable(path) as file_for_ezc3d:
            return ezc3d.c3d(str(file_for_ezc3d))
    except (OSError, RuntimeError, ValueError, IndexError) as error:
        reason = str(error).partition(". If you want to ignore")[0]
        raise UnsupportedError(
            path, wanted="a C3D file", found=f"a file that ezc3d refuses ({reason})",
            do="Open it in the program that wrote it and export it again.",
        ) from error  # fmt: skip


@contextmanager
def _readable(path: Path) -> Iterator[Path]:
    """``path``, or a copy of it where ezc3d would not end.

    ezc3d takes the length of a description beyond 127 characters for a negative number and goes on to read 4 GB. Such
    descriptions are valid, and Kinarm (BKIN) writes them; the copy holds their first 127 characters.
    """
    with path.open("rb") as file:
        head = file.read(_PARAMETERS_END)
    shortened = _with_short_descriptions(path, head)
    if shortened is None:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_bytes(shortened + path.read_bytes()[len(shortened) :])
        yield copy


def _with_short_descriptions(path: Path, head: bytes) -> bytes | None:
    """The beginning of the file up to the end of its parameters; None where no description is too long."""
    at = 512 * (head[0] - 1) + 4
    parts, changed = [head[:at]], False
    try:
        while name_length := abs(_signed(head[at])):
            offset_at = at + 2 + name_length
            (offset,) = struct.unpack_from("<H", head, offset_at)
            description_at = offset_at + 2
            if _signed(head[at + 1]) > 0:  # a parameter; a group has no values
                item_bytes, n_dimensions = abs(_signed(head[description_at])), head[description_at + 1]
                dimensions = head[description_at + 2 : description_at + 2 + n_dimensions]
                description_at += 2 + n_dimensions + item_bytes * math.prod(dimensions)
            excess = max(0, head[description_at] - _LONGEST_DESCRIPTION)
            following = offset_at + offset
            if excess and description_at + 1 + head[description_at] != following:
                raise RecordingError(
                    path, wanted="parameters whose lengths fit together", found=f"damage near byte {description_at}",
                    do="Copy the file again, or open it in the program that wrote it and export it again.",
                )  # fmt: skip
            changed = changed or excess > 0
            kept = head[offset_at + 2 : description_at] + bytes([head[description_at] - excess])
            kept += head[description_at + 1 : following - excess]
            parts.append(head[at:offset_at] + struct.pack("<H", offset - excess) + kept)
            at = following
    except (IndexError, struct.error):  # ezc3d says what is wrong with it
        return None
    return b"".join(parts).ljust(at, b"\0") if changed else None


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def _values(parameters: Any, group: str, name: str, n: int, default: Any) -> list[Any]:
    """``n`` values of a parameter, beyond 255 from its continuations (LABELS2, ...), missing ones as ``default``."""
    values: list[Any] = []
    part = 1
    while group in parameters and (key := name if part == 1 else f"{name}{part}") in parameters[group]:
        values += list(parameters[group][key]["value"])
        part += 1
    return (values + [default] * n)[:n]
