"""Files that are not read say what they are."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import open_recording


def _zip(name: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as file:
        file.writestr(name, "x")
    return packed.getvalue()


NORAXON = (
    'type;begin_time;frequency;count\r\n"record";"0,00000";2000.4;42520\r\n\r\ntime;BICEPS (uV)\r\n0,00000;1,5\r\n'
)
CASES = {
    "picture.png": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(40), r"a picture \(PNG\)"),
    "press.c3d": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(40), r"a picture \(PNG\)"),
    "photo.jpg": (b"\xff\xd8\xff\xe0\0\x10JFIF\0", r"a picture \(JPEG\)"),
    "paper.pdf": (b"%PDF-1.7\n1 0 obj\n", "a PDF document"),
    "a.xlsx": (_zip("xl/workbook.xml"), r"an Excel sheet \(.xlsx\).*Save the sheet as CSV"),
    "a.delsys": (_zip("exported.db"), r"a Trigno Discover recording.*Export > CSV"),
    "a.zip": (_zip("press.csv"), r"a packed file \(ZIP\).*Unpack it"),
    "cut.zip": (_zip("press.csv")[:40], r"a packed file \(ZIP\)"),
    "a.csv.gz": (b"\x1f\x8b\x08\0" + bytes(20), "a packed file"),
    "a.smr": (b"\x09\0(C) CED 87" + bytes(60), r"a Spike2 recording \(.smr\).*In Spike2: File > Export As"),
    "a.slk": (b"ID;PWXL;N;E\r\nP;PGeneral\r\nC;Y1;X1;K0\r\nE\r\n", r"a SYLK sheet.*In Noraxon MR: Export"),
    "noraxon.csv": (NORAXON.encode(), r"a Noraxon CSV.*in Noraxon MR: Export"),
    "page.htm": (b"<!DOCTYPE html><html>", "a web page"),
    "a.xls": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(50), "an old Excel"),
    "a.npy": (b"\x93NUMPY\x01\0", "a NumPy array"),
    "a.smrx": (b"S64" + bytes(60), r"a Spike2 recording \(.smrx\).*In Spike2: File > Export As"),
    "a.cfs": (b'CEDFILE"' + bytes(60), r"a CED Signal recording \(.cfs\).*In Signal: File > Export As"),
    "a.adicht": (b"CFWB\1\0\0\0" + bytes(60), "a LabChart recording.*In LabChart: File > Export > MATLAB"),
    "a.abf": (b"ABF2\0\0\6\2" + bytes(60), r"an Axon recording \(.abf\).*Export the recording as CSV"),
    "old.abf": (b"ABF \xc3\xf5\xe8\x3f" + bytes(60), r"an Axon recording \(.abf\)"),
    "a.gif": (b"GIF89a" + bytes(60), r"a picture \(GIF\)"),
    "a.tif": (b"II*\0\x08\0\0\0" + bytes(60), r"a picture \(TIFF\)"),
    "big-endian.tif": (b"MM\0*\0\0\0\x08" + bytes(60), r"a picture \(TIFF\)"),
    "a.bmp": (b"BM\x36\x04\0\0\0\0\0\0" + bytes(60), r"a picture \(BMP\)"),
    "a.mp4": (b"\0\0\0\x20ftypisom" + bytes(60), r"a film \(MP4 or MOV\)"),
    "a.avi": (b"RIFF\xff\1\0\0AVI LIST" + bytes(60), r"a film \(AVI\)"),
    "a.wav": (b"RIFF\xff\1\0\0WAVEfmt " + bytes(60), r"a sound file \(WAV\).*Export the recording as CSV"),
    "a.bz2": (b"BZh91AY&SY" + bytes(60), "a packed file.*Unpack it"),
    "a.xz": (b"\xfd7zXZ\0\0\4" + bytes(60), "a packed file"),
    "a.7z": (b"7z\xbc\xaf\x27\x1c" + bytes(60), "a packed file"),
    "a.rar": (b"Rar!\x1a\7\1\0" + bytes(60), "a packed file"),
    "a.db": (b"SQLite format 3\0" + bytes(60), r"a database \(SQLite\)"),
    "a.out": (b"\x7fELF\2\1\1\0" + bytes(60), "a program"),
    "a.exe": (b"MZ\x90\0\3\0\0\0" + bytes(60), "a program"),
    "a.vhdr": (b"BrainVision Data Exchange Header File Version 1.0\r\n", "a BrainVision header.*to EDF"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_refused_file_says_what_it_is_and_what_to_do(tmp_path: Path, name: str) -> None:
    content, said = CASES[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordingError, match=f"expected a recording in a format that is read, but found {said}"):
        open_recording(tmp_path / name)


@pytest.mark.parametrize("header", ["ID;Pressure", "BM;x", "MZ;time", "S64;time", "II;x", "CFWB;x"])
def test_a_table_whose_first_name_looks_like_a_signature_is_a_table(tmp_path: Path, header: str) -> None:
    rows = "\n".join(f"{i / 100};{i}.5;{i}" for i in range(20))
    (tmp_path / "a.csv").write_text(f"time (s);{header}\n{rows}\n")
    (tmp_path / "b.csv").write_text(
        f"{header};time (s)\n" + "\n".join(f"{i}.5;{i};{i / 100}" for i in range(20)) + "\n"
    )
    for name in ("a.csv", "b.csv"):
        assert open_recording(tmp_path / name)[0] == "CSV"
