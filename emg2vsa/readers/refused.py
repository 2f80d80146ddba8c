"""Files that are not read, by their first bytes: what each one is, and how to come from it to one that is read."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Sequence
from pathlib import Path

_AS_CSV = "Export the recording as CSV with a time column, C3D, EDF/BDF or .mat from the program that wrote it."
_CHOOSE = "Choose the file of the recording."
_SPIKE2 = "In Spike2: File > Export As > Spreadsheet text, all channels at one rate, with a time column."
_NORAXON = "In Noraxon MR: Export > C3D, EDF or ASCII with a time column in seconds and one decimal sign."
_DELSYS = "In Trigno Discover: Export > CSV; it is read with its rates."
_UNPACK = "Unpack it and choose the recording in it."
_SHEET = "Save the sheet as CSV with a time column."

_BEGINNINGS: tuple[tuple[int, Sequence[bytes], str, str], ...] = (
    (2, (b"(C) CED 87",), "a Spike2 recording (.smr)", _SPIKE2),
    (0, (b"S64",), "a Spike2 recording (.smrx)", _SPIKE2),
    (0, (b"CEDFILE",), "a CED Signal recording (.cfs)", _SPIKE2.replace("Spike2", "Signal")),
    (0, (b"CFWB",), "a LabChart recording", "In LabChart: File > Export > MATLAB."),
    (0, (b"ABF ", b"ABF2"), "an Axon recording (.abf)", _AS_CSV),
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
    (
        re.compile(rb'"?type"?\s*;\s*"?begin_time"?\s*;\s*"?frequency', re.IGNORECASE),
        "a Noraxon CSV, whose table stands below a preamble",
        "Delete the lines above the row 'time; ...' and call it 'time (s)'; or " + _NORAXON[0].lower() + _NORAXON[1:],
    ),
    (re.compile(rb"\s*(<!doctype html|<html)", re.IGNORECASE), "a web page", _CHOOSE),
    (re.compile(rb"\s*<\?xml|\s*<FTSensor", re.IGNORECASE), "an XML file", _CHOOSE),
    (re.compile(rb"\s*\{"), "a JSON file", _CHOOSE),
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
