"""The known formats: how a file of each is recognised by its name and first bytes, and the module that reads it.

The table is tried from top to bottom. Nothing here imports a reader, so a program may ask which one it would be.

A second table names files that are not read by their first bytes, and says how to export one that is read.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.readers.text_file import unmarked_utf16

_AS_CSV = "Export the recording as CSV with a time column, C3D, EDF/BDF or .mat from the program that wrote it."
_CHOOSE = "Choose the file of the recording."
_SPIKE2 = "In Spike2: File > Export As > Spreadsheet text, all channels at one rate, with a time column."
_NORAXON = "In Noraxon MR: Export > C3D, EDF or ASCII with a time column in seconds and one decimal sign."
_DELSYS = "In Trigno Discover: Export > CSV; it is read with its rates."
_UNPACK = "Unpack it and choose the recording in it."
_SHEET = "Save the sheet as CSV with a time column."

_BEGINNINGS: tuple[tuple[int, Sequence[bytes], str, str], ...] = (
    (0, (b"S64",), "a Spike2 recording (.smrx)", _SPIKE2),
    (0, (b"CEDFILE",), "a CED Signal recording (.cfs)", _SPIKE2.replace("Spike2", "Signal")),
    (0, (b"CFWB",), "a LabChart recording", "In LabChart: File > Export > MATLAB."),
    (0, (b"\x89PNG",), "a picture (PNG)", _CHOOSE),
    (0, (b"\xff\xd8\xff",), "a picture (JPEG)", _CHOOSE),
    (0, (b"GIF8",), "a picture (GIF)", _CHOOSE),
    (0, (b"II*\0", b"MM\0*"), "a picture (TIFF)", _CHOOSE),
    (0, (b"BM",), "a picture (BMP)", _CHOOSE),
    (0, (b"%PDF-",), "a PDF document", _CHOOSE),
    (4, (b"ftyp",), "a film (MP4 or MOV)", _CHOOSE),
    (8, (b"AVI ",), "a film (AVI)", _CHOOSE),
    (8, (b"WAVE",), "a sound file (WAV)", _AS_CSV),
    (0, (b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"7z\xbc\xaf", b"Rar!"), "a packed file", _UNPACK),
    (0, (b"\xd0\xcf\x11\xe0",), "an old Excel, Word or project file", _SHEET),
    (0, (b"SQLite format 3",), "a database (SQLite)", _AS_CSV),
    (0, (b"\x93NUMPY",), "a NumPy array (.npy)", "Save it as .mat or as CSV with a time column."),
    (0, (b"\x7fELF", b"MZ"), "a program", _CHOOSE),
    (0, (b"BrainVision", b"Brain Vision"), "a BrainVision header", "Convert the recording to EDF."),
)
_TEXTS: tuple[tuple[re.Pattern[bytes], str, str], ...] = (
    (re.compile(rb"ID;P[^\r\n]*[\r\n]+[BCEFOP];"), "a SYLK sheet (.slk), as Noraxon exports", _NORAXON),
    (re.compile(rb"\s*(<!doctype html|<html)", re.IGNORECASE), "a web page", _CHOOSE),
    (re.compile(rb"\s*<\?xml|\s*<FTSensor", re.IGNORECASE), "an XML file", _CHOOSE),
    (re.compile(rb'\s*\{(?!.*"continuous")', re.DOTALL), "a JSON file", _CHOOSE),
    (re.compile(rb"PathFileType", re.IGNORECASE), "a marker file of a motion system (.trc)", _CHOOSE),
)
_ZIPPED: tuple[tuple[str, str, str], ...] = (
    ("xl/workbook.xml", "an Excel sheet (.xlsx)", _SHEET),
    ("word/document.xml", "a Word document (.docx)", _CHOOSE),
    ("exported.db", "a Trigno Discover recording (.delsys)", _DELSYS),
)


def refused(path: Path, head: bytes) -> tuple[str, str] | None:
    """(what the file is, what to do), or None where it is not known to be anything that is not read.

    head : its first bytes.
    """
    binary = b"\0" in head
    for at, beginnings, what, do in _BEGINNINGS:
        for beginning in beginnings:
            # a short word may begin a table too
            if head[at : at + len(beginning)] == beginning and (
                binary or len(beginning) > 4 or not beginning.isascii()
            ):
                return what, do
    if head.startswith(b"PK\x03\x04"):
        return _zipped(path)
    return next(((what, do) for pattern, what, do in _TEXTS if pattern.match(head.removeprefix(b"\xef\xbb\xbf"))), None)


def _zipped(path: Path) -> tuple[str, str]:
    try:
        with zipfile.ZipFile(path) as packed:
            names = set(packed.namelist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        names = set()
    if path.suffix.lower() == ".delsys":
        return "a Trigno Discover recording (.delsys)", _DELSYS
    return next(((what, do) for inside, what, do in _ZIPPED if inside in names), ("a packed file (ZIP)", _UNPACK))


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
    do : what to do where that is not installed, beside installing it.
    """

    format: str
    module: str
    matches: Callable[[Path, bytes], bool]
    library: str | None = None
    second: Reader | None = None
    any_text: bool = False
    do: str = ""


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


def _is_spike2(path: Path, head: bytes) -> bool:
    return head[2:12] == b"(C) CED 87"


def _is_intan(path: Path, head: bytes) -> bool:
    return head.startswith((b"\x02\x27\x91\xc6", b"\xac\x27\x91\xd6"))


def _is_open_ephys(path: Path, head: bytes) -> bool:
    return path.name == "structure.oebin"


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
    Reader("Spike2", "emg2vsa.readers.neo_formats", _is_spike2, "neo", do=_SPIKE2),
    Reader("Axon ABF", "emg2vsa.readers.neo_formats", _begins(b"ABF ", b"ABF2"), "neo", do=_AS_CSV),
    Reader("Intan", "emg2vsa.readers.neo_formats", _is_intan, "neo", do=_AS_CSV),
    Reader("Open Ephys", "emg2vsa.readers.neo_formats", _is_open_ephys, "neo", do=_AS_CSV),
    Reader("Plexon", "emg2vsa.readers.neo_formats", _begins(b"PLEX"), "neo", do=_AS_CSV),
    Reader("OpenSignals HDF5", "emg2vsa.readers.opensignals_hdf5", _is_hdf5, "h5py"),
    Reader("OpenSignals text", "emg2vsa.readers.opensignals", _begins(b"# OpenSignals")),
    Reader("LabVIEW LVM", "emg2vsa.readers.lvm", _begins(b"LabVIEW Measurement")),
    Reader("Vicon ASCII", "emg2vsa.readers.vicon", _is_vicon),
    Reader("LabChart text", "emg2vsa.readers.labchart", _begins(b"Interval=\t")),
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
