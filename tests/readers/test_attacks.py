"""What files of ill will, and the doings of the caller, must not do to the reading of a recording."""

from __future__ import annotations

import concurrent.futures.process
import os
import struct
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from casr.decoder_process import end_child
from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.pipeline.fingerprint import MISSING, Fingerprints
from emg2vsa.pipeline.tasks import Workers
from emg2vsa.readers.front_door import open_recording


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
