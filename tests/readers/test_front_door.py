"""Recognition, lazy imports, and files nobody should have given us.

What files of ill will, and the doings of the caller, must not do to the reading of a recording.

Files that are not read say what they are.
"""

from __future__ import annotations

import concurrent.futures.process
import io
import os
import re
import struct
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import edfio
import numpy as np
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

from casr.decoder_process import end_child
from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.pipeline.fingerprint import MISSING, Fingerprints
from emg2vsa.pipeline.tasks import Workers
from emg2vsa.readers.formats import READERS, head_of, reader_of
from emg2vsa.readers.front_door import inspect, open_recording, read
from emg2vsa.readers.opened import unique_names

HEAVY = ("pandas", "ezc3d", "edfio", "scipy", "h5py")


def test_importing_the_package_loads_no_format_library() -> None:
    modules = "emg2vsa.readers.front_door, emg2vsa.readers.roles, sys"
    code = f"import {modules}; print([m for m in {HEAVY!r} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_reading_bdf_loads_no_format_library_in_this_process(tmp_path: Path) -> None:
    path = tmp_path / "a.bdf"
    edfio.Bdf([edfio.BdfSignal(np.arange(100.0), 100, label="EDC", physical_dimension="uV")]).write(path)
    code = (
        "from emg2vsa.readers.front_door import read; import sys; read(sys.argv[1], ['EDC']); "
        f"print([m for m in {HEAVY!r} if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("relative", "name"),
    [
        ("emg/bids/emg_IndependentMod/sub-01/emg/sub-01_task-grasping_emg.edf", "EDF"),
        ("emg/c3d/btk_1123x01EMG.c3d", "C3D"),
        ("emg/emg_force/openhdemg_otb_testfile_VL64_force.mat", "MATLAB"),
        ("emg/delsys_csv/discover150.csv", "Trigno Discover CSV"),
        ("emg/delsys_csv/discover170.csv", "Trigno Discover CSV"),
        ("emg/delsys_csv/emgworks.csv", "EMGworks CSV"),
        ("emg/delsys_csv/emgio_emgworks_verbose_truncated.csv", "EMGworks CSV"),
        ("emg/emg_force/novainstrumentation_emg.txt", "text matrix"),
    ],
)
def test_real_files_are_recognised(shared_data, relative: str, name: str) -> None:
    path = shared_data(relative)
    known, opened = open_recording(path)
    assert known == name
    reader = next(reader for reader in READERS if reader.format == name)
    assert reader_of(path, head_of(path)) is reader
    if reader.library is None:
        assert type(opened).__module__ in (reader.module, "emg2vsa.readers.timed_columns")


def test_a_file_of_no_known_format_is_refused_with_the_known_ones(tmp_path: Path) -> None:
    path = tmp_path / "x.bin"
    path.write_bytes(bytes(range(128, 256)) * 40 + bytes(64))
    with pytest.raises(RecordingError, match="unknown format") as caught:
        inspect(path)
    page = re.search(r"docs/\S+\.md", caught.value.wanted)
    assert page is not None
    text = (Path(__file__).parents[2] / page[0]).read_text(encoding="utf-8")
    assert [reader.format for reader in READERS if reader.format.split()[0] not in text] == []


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".edf", ".bdf", ".c3d", ".mat"])
def test_empty_and_garbage_files_end_in_one_error(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"x{suffix}"
    for content in (
        b"",
        b"\n\n",
        b"\x00" * 600,
        os.urandom(3000),
        b"\x02\x50" + bytes(range(256)) * 8,
        b"0       ",
        b"MATLAB ",
    ):
        path.write_bytes(content)
        with pytest.raises(RecordingError) as caught:
            inspect(path)
        assert str(path) in caught.value.where


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="No such file"):
        inspect(tmp_path / "absent.csv")
    with pytest.raises(RecordingError, match="directory"):
        inspect(tmp_path)


def test_content_goes_before_the_name(tmp_path: Path) -> None:
    contents = {
        "a.csv": b"0       " + b" " * 300,
        "b.txt": b"time (s),EDC (mV)\n0,1\n",
        "d.dat": b"\0" * 9,
    }
    found = [reader_of(tmp_path / name, content) for name, content in contents.items()]
    assert [reader and reader.format for reader in found] == ["EDF", "CSV", None]


@pytest.mark.parametrize(("asked", "meant"), [("ECD", "EDC"), ("fz", "Fz"), ("EMG1", "Sensor 1: EMG 1")])
def test_unknown_channel_suggests_the_nearest(tmp_path: Path, asked: str, meant: str) -> None:
    path = tmp_path / "x.csv"
    path.write_text("time (s),EDC (mV),Fz (N),Sensor 1: EMG 1\n0,1,1,1\n0.001,2,2,2\n")
    with pytest.raises(RecordingError, match=f"Did you mean '{meant}'"):
        read(path, [asked])


def test_many_channels_are_not_all_listed(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("time (s)," + ",".join(f"c{i}" for i in range(23)) + "\n" + 2 * ("0," * 23 + "1\n"))
    with pytest.raises(RecordingError, match=r"'c19' and 3 more\. Choose one of these names\."):
        read(path, ["force"])


@given(st.lists(st.sampled_from(["EMG", "EMG #2", "", " EMG ", "channel 1"]), max_size=12))
def test_names_become_unique_and_the_first_keeps_its_own(names: list[str]) -> None:
    made = unique_names(names)
    assert len(set(made)) == len(made) == len(names)
    assert all(new.startswith(old.strip()) for new, old in zip(made, names, strict=True))


@pytest.fixture(autouse=True)
def _own_child() -> Iterator[None]:
    """Tests that harm the child share it with none."""
    end_child()
    yield
    end_child()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes on Windows")
@pytest.mark.parametrize("name", ["press.mat", "press.csv"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(RecordingError, match="found a pipe or a device"):
        open_recording(tmp_path / name)


def _cells_within_cells(depth: int) -> bytes:
    """A MATLAB file of a number in a cell in a cell, ``depth`` of them."""
    numbers = struct.pack("<4d", 1, 2, 3, 4)
    inner = struct.pack("<IIIIIIiiIIII", 6, 8, 6, 0, 5, 8, 1, 4, 1, 0, 9, len(numbers)) + numbers
    inner = struct.pack("<II", 14, len(inner)) + inner
    for n in range(depth):
        name = struct.pack("<HH4s", 1, 1, b"a") if n == depth - 1 else struct.pack("<II", 1, 0)
        inner = struct.pack("<IIIIIIii", 6, 8, 1, 0, 5, 8, 1, 1) + name + inner
        inner = struct.pack("<II", 14, len(inner)) + inner
    return b"MATLAB 5.0 MAT-file".ljust(116) + b"\0" * 8 + b"\x00\x01IM" + inner


def test_whatever_a_reader_stumbles_over_is_said_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "deep.mat"
    path.write_bytes(_cells_within_cells(50))
    assert [channel.n_samples for channel in open_recording(path)[1].describe()] == [4]
    path.write_bytes(_cells_within_cells(900))
    with pytest.raises(RecordingError, match=r"deep.mat: expected MATLAB data .* its reader failed \(RecursionError: "):
        open_recording(path)


def test_a_library_that_quotes_the_file_is_cut_short() -> None:
    said = said_by(ValueError("bad name '" + "\0\x1b\n\u0085x" * 5000 + "'"))
    assert said.startswith("ValueError: bad name ' x x")
    assert said.isprintable()
    assert len(said) == 160


def test_a_relative_path_follows_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder, length in (("one", 10), ("two", 20)):
        (tmp_path / folder).mkdir()
        scipy.io.savemat(tmp_path / folder / "press.mat", {"EDC": np.arange(length, dtype=float)})
        monkeypatch.chdir(tmp_path / folder)
        assert open_recording(Path("press.mat"))[1].describe()[0].n_samples == length


def test_channels_of_hdf5_have_one_order_in_every_process(tmp_path: Path) -> None:
    """A child that replaces another is asked by the numbers of the first: force must not come out as EMG."""
    pytest.importorskip("pymatreader")
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "press.mat"
    names = [f"channel{i}" for i in range(10)]
    with h5py.File(path, "w", userblock_size=512) as file:
        for group in (file, file.create_group("struct")):
            for name in names:
                group.create_dataset(name, data=np.arange(5.0)[:, None]).attrs["MATLAB_class"] = np.bytes_("double")
    data = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + data[128:])
    found = [channel.name for channel in open_recording(path)[1].describe()]
    assert found == [*names, *(f"struct.{name}" for name in names)]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes on Windows")
def test_a_pipe_among_the_inputs_of_a_study_has_no_content(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "press.mat")
    prints = Fingerprints(tmp_path / "memory.json")
    assert prints.file(tmp_path / "press.mat") == MISSING


def test_ctrl_c_waits_for_no_worker() -> None:
    """Else a study with a file that hangs its decoder goes on for the time limit of every file that a worker took."""
    tasks: list[Any] = [partial(abs, -1), partial(time.sleep, 40), partial(time.sleep, 40)]

    def stop(ended: object) -> None:
        raise KeyboardInterrupt

    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt), Workers(2) as workers:
        workers.run(tasks, stop)
    for thread in list(concurrent.futures.process._threads_wakeups):  # the program waits for them at its end
        thread.join(30)
        assert not thread.is_alive()
    assert time.monotonic() - started < 30


def _zip(name: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as file:
        file.writestr(name, "x")
    return packed.getvalue()


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
    "a.slk": (b"ID;PWXL;N;E\r\nP;PGeneral\r\nC;Y1;X1;K0\r\nE\r\n", r"a SYLK sheet.*In Noraxon MR: Export"),
    "page.htm": (b"<!DOCTYPE html><html>", "a web page"),
    "a.xls": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(50), "an old Excel"),
    "a.npy": (b"\x93NUMPY\x01\0", "a NumPy array"),
    "a.smrx": (b"S64" + bytes(60), r"a Spike2 recording \(.smrx\).*In Spike2: File > Export As"),
    "a.cfs": (b'CEDFILE"' + bytes(60), r"a CED Signal recording \(.cfs\).*In Signal: File > Export As"),
    "a.adicht": (b"CFWB\1\0\0\0" + bytes(60), "a LabChart recording.*In LabChart: File > Export > MATLAB"),
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
