"""Decoders of binary recordings that crash, never end or flood the memory; and a seeded sample of flipped bytes.

The parsers of emg2vsa's own under changed bytes; the hour's run is ``python -m benchmarks.fuzz_readers``.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.corrupted_files import flipped, good_files
from benchmarks.fuzz_readers import FOUND, Tally, tried
from benchmarks.made_recordings import MADE
from casr.decoder_process import child_pid, end_child
from emg2vsa.errors import PassingError, RecordingError
from emg2vsa.pipeline.stage import Given
from emg2vsa.pipeline.tasks import Task
from emg2vsa.readers import front_door
from emg2vsa.readers.formats import Reader
from emg2vsa.readers.front_door import inspect, read
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings, ReadingSettings
from emg2vsa.study_file.problems import checked

READER = """
import ctypes, os, signal
import numpy as np
from emg2vsa.readers.opened import Contents, StoredChannel
from emg2vsa.recordings import ChannelInfo

def open_recording(path):
    return Opened(path)

class Opened:
    def __init__(self, path):
        self.path = path
        self.contents = Contents(("EDC", "Fz"), notes=("a note",))
        fault = path.read_text()
        if fault == "crash":
            ctypes.string_at(0)
        if fault == "hang":
            ctypes.PyDLL(None).sleep(100)
        if fault == "flood":
            np.ones(10**9)
        if fault in ("libodd", "_libodd"):
            raise {"libodd": ModuleNotFoundError, "_libodd": ImportError}[fault](f"no {fault}")
        if fault == "killed":
            os.kill(os.getpid(), signal.SIGKILL)

    def describe(self):
        return (ChannelInfo("EDC", "V", 100.0, 500), ChannelInfo("Fz", "N", 100.0, 500))

    def load(self, indices):
        if self.path.read_text() == "crash later":
            ctypes.string_at(0)
        if self.path.read_text() == "killed later":
            os.kill(os.getpid(), signal.SIGKILL)
        return [StoredChannel("", np.arange(500.0), ("V", "N")[i], 100.0, notes=("of a channel",)) for i in indices]
"""
ROLES = ChannelSettings(emg={"EDC": EmgChannelSettings(name="EDC")}, force=ForceChannelSettings(name="Fz"))


@pytest.fixture
def odd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A file of a format whose decoder does what the file says."""
    (tmp_path / "odd_reader.py").write_text(READER)
    monkeypatch.syspath_prepend(tmp_path)
    reader = Reader("ODD", "odd_reader", lambda path, head: True, "libodd")
    monkeypatch.setattr(front_door, "reader_of", lambda path, head: reader)
    end_child()
    yield tmp_path / "rec.odd"
    end_child()


def test_a_good_file_comes_with_its_notes(odd: Path) -> None:
    odd.write_text("good")
    recording = read(odd, ["Fz", "EDC"])
    assert (recording.format, recording.notes) == ("ODD", ("a note", "of a channel"))
    assert [(channel.name, channel.unit, channel.samples.sum()) for channel in recording.channels] == [
        ("Fz", "N", 124750.0), ("EDC", "V", 124750.0)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("fault", "found", "do"),
    [
        ("crash", "that its reader crashed (libodd, segmentation fault)", "Export the file again, as CSV if need be."),
        ("crash later", "that its reader crashed (libodd, segmentation fault)", "Export the file again"),
        ("hang", "that its reader took more than 1 s", "raise max_seconds in the study's table [reading]"),
        ("flood", "that its reader needed more than 200 MB", "raise max_memory_mb in the study's table [reading]"),
    ],
)
def test_a_fault_is_a_recording_error_and_the_next_file_is_read(odd: Path, fault: str, found: str, do: str) -> None:
    odd.write_text(fault)
    reading = ReadingSettings(max_seconds=1, max_memory_mb=200)
    with pytest.raises(RecordingError) as caught:
        read_roles(odd, None, ROLES, reading)
    assert caught.value.where == str(odd)
    assert caught.value.found == found
    assert do in caught.value.do
    assert "expected ODD data that libodd can read" in str(caught.value)
    odd.write_text("good")
    assert [info.name for info in inspect(odd, reading)[1]] == ["EDC", "Fz"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither these signals nor these limits")
@pytest.mark.parametrize(
    ("fault", "found"),
    [
        ("killed", "that its reader was killed from outside (libodd, killed)"),
        ("killed later", "that its reader was killed from outside (libodd, killed)"),
    ],
)
def test_what_the_system_does_to_a_reader_is_not_the_files_fault(odd: Path, fault: str, found: str) -> None:
    odd.write_text(fault)
    with pytest.raises(PassingError) as caught:
        read(odd, ["Fz", "EDC"])
    assert caught.value.found == found
    assert "run again" in caught.value.do
    assert "Export" not in str(caught.value)
    odd.write_text("good")
    assert read(odd, ["Fz"]).channels[0].samples.sum() == 124750.0


@pytest.mark.parametrize(
    ("fault", "final"),
    [*((each, False) for each in ("crash", "killed", "hang", "libodd", "_libodd")), ("flood", True)],
)
def test_a_step_whose_reader_crashed_is_tried_again_by_the_next_run(
    odd: Path, monkeypatch: pytest.MonkeyPatch, fault: str, final: bool
) -> None:
    odd.write_text(fault)
    reading = ReadingSettings(max_seconds=1, max_memory_mb=200)
    task = Task("trials/P01/S1", Given("P01/S1", {}, {}, {}), odd.parent / "out", odd.parent / "claim")
    monkeypatch.setattr(Task, "_make", lambda self: read(odd, ["Fz"], reading))
    ended = task()
    assert (ended.status, ended.final) == ("failed", final)


@pytest.mark.parametrize(
    ("fault", "found", "do"),
    [
        ("libodd", "that it is not installed (ModuleNotFoundError: no libodd)", "Install it: "),
        ("_libodd", "that it cannot be imported (ImportError: no _libodd)", "Install it again: "),
    ],
)
def test_a_library_that_cannot_be_imported_is_not_the_files_fault(odd: Path, fault: str, found: str, do: str) -> None:
    odd.write_text(fault)
    with pytest.raises(PassingError) as caught:
        inspect(odd)
    assert caught.value.found == found
    assert caught.value.do.startswith(do)


def test_a_reader_that_cannot_be_started_is_not_the_files_fault(odd: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    odd.write_text("good")

    def no_process(*arguments: object, **how: object) -> None:
        raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))

    monkeypatch.setattr(subprocess, "Popen", no_process)
    with pytest.raises(PassingError, match="its reader could not be started \\(Cannot allocate memory\\)"):
        inspect(odd)


def test_files_of_text_start_no_child(tmp_path: Path) -> None:
    (tmp_path / "rec.csv").write_text("time (s),EDC (V)\n0,1\n0.001,2\n0.002,3\n")
    end_child()
    assert read(tmp_path / "rec.csv", ["EDC"]).channels[0].fs_hz == 1000
    assert child_pid() is None


@pytest.mark.parametrize(
    "values", [{"max_seconds": 0.5}, {"max_seconds": 4000}, {"max_memory_mb": 100}, {"max_memory_mb": 2e6}, {"max": 3}]
)
def test_limits_that_make_no_sense(values: dict[str, float]) -> None:
    _, problems = checked(ReadingSettings, values, ("reading",))
    assert [problem.path for problem in problems] == [("reading", *values)]


def test_limits_of_the_command(tmp_path: Path) -> None:
    (tmp_path / "rec.csv").write_text("time (s),EDC (V)\n0,1\n0.001,2\n0.002,3\n")
    command = [sys.executable, "-m", "emg2vsa.cli", "fit", str(tmp_path / "rec.csv")]
    good = subprocess.run([*command, "--max-seconds", "20", "--max-memory", "900"], capture_output=True, text=True)
    assert (good.returncode, good.stderr) == (0, "")
    bad = subprocess.run([*command, "--max-seconds", "0", "--max-memory", "1"], capture_output=True, text=True)
    assert bad.returncode != 0
    assert "max_seconds" in bad.stderr
    assert "max_memory_mb" in bad.stderr
    assert "Traceback" not in bad.stderr


def test_flipped_bytes_are_read_or_refused(tmp_path: Path) -> None:
    tallies = [flipped(good, tries=20, seed=7) for good in good_files(tmp_path)]
    assert [tally.name.rpartition(".")[2] for tally in tallies] == [
        "edf",
        "bdf",
        "c3d",
        "mat",
        "mat",
        "csv",
        "tdms",
        "h5",
        "xdf",
    ]
    for tally in tallies:
        assert tally.tries == 20
        assert tally.outcomes["other exception"] == 0, tally.examples
        assert tally.peak_mb < 1000
        assert tally.slowest_s < 60


TRIES = 60


@pytest.mark.parametrize("name", MADE)
def test_nothing_but_a_refusal_comes_of_changed_bytes(tmp_path: Path, name: str) -> None:
    tally = tried(name, iter([*FOUND.get(name, ()), *range(TRIES)]), tmp_path, Tally(name))
    assert not tally.failed
    assert tally.outcomes["read"] > 0
    assert tally.outcomes["refused"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_nothing_but_a_refusal_comes_of_ten_seconds_of_changed_bytes(tmp_path: Path, name: str) -> None:
    tally = tried(name, range(10**6, 10**7), tmp_path, Tally(name), until=time.monotonic() + 10)
    assert not tally.failed
