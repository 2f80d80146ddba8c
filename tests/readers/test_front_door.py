"""Recognition, lazy imports, and files nobody should have given us."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import edfio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.errors import RecordingError
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
