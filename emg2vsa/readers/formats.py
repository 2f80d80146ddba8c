"""The known formats: how a file of each is recognised by its name and first bytes, and the module that reads it.

The table is tried from top to bottom. Nothing here imports a reader, so a program may ask which one it would be.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.readers.text_file import unmarked_utf16

_HEAD_BYTES = 4096
"""Number of leading bytes the recognisers look at."""

_NUMBERS = re.compile(r"[\s,;]*([+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|nan|inf)([\s,;]|$)", re.IGNORECASE)
_X_PAIRS = re.compile(r'"?X\s*\[s\]"?\s*[,;\t][^,;\t]*([,;\t]\s*"?X\s*\[s\]|[,;\t]*$)')


@dataclass(frozen=True)
class Reader:
    """A format: its name, the module whose ``open_recording(path)`` reads it, and how a file of it is recognised.

    second : the reader that is tried where this one does not support a file, crashes or meets a limit.
    any_text : it takes whatever is text, so that readers of other packages are asked before it.
    library : the foreign decoder that the module calls, for which it runs in a child process; None: it calls none.
    """

    format: str
    module: str
    matches: Callable[[Path, bytes], bool]
    library: str | None = None
    second: Reader | None = None
    any_text: bool = False


def _first_line(head: bytes) -> str:
    """First line of a text head that is neither blank nor a ``#`` comment; "" where the head is not text."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = head[: len(head) // 2 * 2].decode("utf-16", errors="replace")
    elif (wide := unmarked_utf16(head)) is not None:
        text = head[: len(head) // 2 * 2].decode(wide, errors="replace")
    else:
        text = head.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    if "\0" in text:
        return ""
    return next((line for line in re.split(r"[\r\n]+", text) if line.strip() and not line.startswith("#")), "")


def _is_edf(path: Path, head: bytes) -> bool:
    return head.startswith(b"0       ") or (path.suffix.lower() == ".edf" and not _is_bdf(path, head))


def _is_bdf(path: Path, head: bytes) -> bool:
    return head.startswith(b"\xffBIOSEMI") or (path.suffix.lower() == ".bdf" and not head.startswith(b"0       "))


def _is_c3d(path: Path, head: bytes) -> bool:
    return path.suffix.lower() == ".c3d" or (head[1:2] == b"\x50" and b"\0" in head)


def _is_hpf(path: Path, head: bytes) -> bool:
    return head[:8] == b"\0\x10" + bytes(6) and head[16:20] == b"datx"


def _begins(*starts: bytes) -> Callable[[Path, bytes], bool]:
    return lambda path, head: head.removeprefix(b"\xef\xbb\xbf").startswith(starts)


def _is_hdf5(path: Path, head: bytes) -> bool:
    return head.startswith(b"\x89HDF\r\n\x1a\n") and path.suffix.lower() != ".mat"


def _is_vicon(path: Path, head: bytes) -> bool:
    return bool(re.match(rb'(\xef\xbb\xbf)?"?Devices"?[\s,;]*[\r\n]+"?\d', head))


def _is_net_ft(path: Path, head: bytes) -> bool:
    return b"RDT Sample Rate:" in head and b"Status (hex)" in head


def _is_matlab(path: Path, head: bytes) -> bool:
    return path.suffix.lower() == ".mat" or head.startswith(b"MATLAB ")


def _is_discover(path: Path, head: bytes) -> bool:
    return "Trigno Discover" in _first_line(head)


def _is_emgworks(path: Path, head: bytes) -> bool:
    line = _first_line(head)
    return bool(_X_PAIRS.match(line)) or (line.startswith("Label:") and "Sampling frequency:" in line)


def _is_text_matrix(path: Path, head: bytes) -> bool:
    return bool(_NUMBERS.match(_first_line(head)))


def _is_plain_csv(path: Path, head: bytes) -> bool:
    return bool(re.search(r"[A-Za-z]", _first_line(head)))


READERS: tuple[Reader, ...] = (
    Reader("HPF", "emg2vsa.readers.hpf", _is_hpf),
    Reader("DEMG", "emg2vsa.readers.demg", _begins(b"DEMG")),
    Reader("TDMS", "emg2vsa.readers.tdms", _begins(b"TDSm"), "npTDMS"),
    Reader("XDF", "emg2vsa.readers.xdf", _begins(b"XDF:"), "pyxdf"),
    Reader("OpenSignals HDF5", "emg2vsa.readers.opensignals_hdf5", _is_hdf5, "h5py"),
    Reader("OpenSignals text", "emg2vsa.readers.opensignals", _begins(b"# OpenSignals")),
    Reader("LabVIEW LVM", "emg2vsa.readers.lvm", _begins(b"LabVIEW Measurement")),
    Reader("Vicon ASCII", "emg2vsa.readers.vicon", _is_vicon),
    Reader("EVaRT ANC", "emg2vsa.readers.evart", _begins(b"File_Type:\tAnalog")),
    Reader("ATI Net F/T CSV", "emg2vsa.readers.net_ft", _is_net_ft),
    Reader("EDF", "emg2vsa.readers.edf_bdf", _is_edf, "edfio"),
    Reader("BDF", "emg2vsa.readers.edf_bdf", _is_bdf, "edfio"),
    Reader(
        "C3D",
        "emg2vsa.readers.c3d",
        _is_c3d,
        "ezc3d",
        second=Reader("C3D", "emg2vsa.readers.c3d_second", _is_c3d, "c3d"),
    ),
    Reader("MATLAB", "emg2vsa.readers.matlab", _is_matlab, "scipy or h5py"),
    Reader("Trigno Discover CSV", "emg2vsa.readers.discover", _is_discover),
    Reader("EMGworks CSV", "emg2vsa.readers.emgworks", _is_emgworks),
    Reader("text matrix", "emg2vsa.readers.text_matrix", _is_text_matrix, any_text=True),
    Reader("CSV", "emg2vsa.readers.plain_csv", _is_plain_csv, any_text=True),
)


def head_of(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(_HEAD_BYTES)


def reader_of(path: Path, head: bytes) -> Reader | None:
    return next((reader for reader in READERS if reader.matches(path, head)), None)
