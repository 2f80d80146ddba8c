"""A disk that refuses: the session says so, damages nothing, and goes on when there is room."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.streams import Block, StreamInfo
from emg2vsa.durable import writer as writing
from emg2vsa.durable.sealed_file import SealedFile
from emg2vsa.durable.system import OperatingSystem
from emg2vsa.durable.writer import Writer
from emg2vsa.errors import DeviceError
from emg2vsa.session.journal import Noted, read_journal
from emg2vsa.session.plan import Plan, draw_presses
from emg2vsa.session.raw_files import SampleFile
from emg2vsa.session.record import SessionRecord, new_session, resume_session
from emg2vsa.session_settings import SessionSettings

LINE_END = b"\n"
SETTINGS = SessionSettings(emg=SimulatedEmgSettings(), force=SimulatedForceSettings())
EMG = StreamInfo("emg", ("EDC",), "V", 1000.0)


def running() -> threading.Event:
    event = threading.Event()
    event.set()
    return event


@dataclass
class SmallDisk(OperatingSystem):
    """A disk with so much room, which takes a part of what does not fit. An fsync ends when it goes on."""

    room: int = 10_000
    goes_on: threading.Event = field(default_factory=running)
    broken: bool = False
    sizes: dict[int, int] = field(default_factory=dict)

    def write(self, handle: int, offset: int, piece: bytes) -> None:
        used = sum(self.sizes.values()) - max(0, self.sizes.get(handle, 0) - offset)
        fits = max(0, min(len(piece), self.room - used))
        super().write(handle, offset, piece[:fits])
        self.sizes[handle] = max(self.sizes.get(handle, 0), offset + fits)
        if fits < len(piece):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def truncate(self, handle: int, size: int) -> None:
        super().truncate(handle, size)
        self.sizes[handle] = size

    def sync(self, handle: int) -> None:
        self.goes_on.wait(20)
        if self.broken:
            raise OSError(errno.EIO, os.strerror(errno.EIO))


def a_session(tmp_path: Path, system: OperatingSystem, background: bool = False) -> SessionRecord:
    presses = draw_presses("disk", "P01", ("S1",), SETTINGS)
    plan = Plan("disk", "P01", 1, "", presses)
    return new_session(tmp_path / "s", plan, lambda: 0.0, background=background, system=system)


@pytest.mark.parametrize("background", [False, True])
@pytest.mark.parametrize("fault", ["full", "broken"])
def test_a_disk_that_refuses_is_told_and_nothing_is_lost_when_it_takes_again(tmp_path, monkeypatch, background, fault):
    monkeypatch.setattr(writing, "_AGAIN_S", 0.02)
    system = SmallDisk()
    record = a_session(tmp_path, system, background)
    stream = record.open_stream("emg", EMG)
    samples = np.arange(3000.0).reshape(-1, 1)
    for i in range(10):
        stream.append(Block(samples[100 * i : 100 * i + 100], 100 * i, 0.0))
    record.append(Noted("before"))
    assert record.wait()
    system.room, system.broken = (10**6 if fault == "broken" else 6_000), fault == "broken"
    for i in range(10, 30):
        stream.append(Block(samples[100 * i : 100 * i + 100], 100 * i, 0.0))
        record.append(Noted(f"during {i}"))
    assert not record.wait(0.3)
    word = os.strerror(errno.EIO if fault == "broken" else errno.ENOSPC)
    assert record.trouble == f"The disk does not take the recording: {word}. Free some disk space."
    assert not record.is_safe
    lines, size = read_journal(tmp_path / "s" / "journal.jsonl")
    assert Noted("before") in [line.event for line in lines]
    assert size == (tmp_path / "s" / "journal.jsonl").stat().st_size
    system.room, system.broken = 10**9, False
    assert record.wait(5.0)
    assert record.trouble == ""
    record.append(Noted("after"))
    record.close()
    notes = [line.event.text for line in read_journal(tmp_path / "s" / "journal.jsonl")[0][1:]]
    assert notes == ["before", *(f"during {i}" for i in range(10, 30)), "after"]
    file = SampleFile(tmp_path / "s" / "sitting-1_emg.samples")
    np.testing.assert_array_equal(file.read(0, 3000), samples)
    assert file.passed_over == 0


@pytest.mark.parametrize("background", [False, True])
def test_a_disk_that_stays_full_is_told_at_the_end_and_the_session_resumes(tmp_path, monkeypatch, background):
    monkeypatch.setattr(writing, "_AGAIN_S", 0.02)
    record = a_session(tmp_path, SmallDisk(room=8_000), background)
    stream = record.open_stream("emg", EMG)
    for i in range(100):
        stream.append(Block(np.ones((100, 1)), 100 * i, 0.0))
        if i == 10:
            record.wait()
    record.append(Noted("lost"))
    with pytest.raises(DeviceError, match=r"room for what was recorded last.*bytes that were not written.*--resume"):
        record.close()
    again = resume_session(tmp_path / "s", lambda: 0.0, background=False)
    again.close()
    file = SampleFile(tmp_path / "s" / "sitting-1_emg.samples")
    assert 0 < file.stop < 10_000
    assert np.isfinite(file.read(0, file.stop)).all()


def test_samples_beyond_what_may_wait_are_given_up_and_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "LARGEST_WAITING_BYTES", 20_000)
    record = a_session(tmp_path, SmallDisk(room=8_000))
    stream = record.open_stream("emg", EMG)
    taken = [stream.append(Block(np.ones((100, 1)), 100 * i, 0.0)) for i in range(150)]
    assert taken[0]
    assert not taken[-1]
    with pytest.raises(DeviceError):
        record.close()


def test_no_caller_waits_for_a_slow_disk(tmp_path):
    threads = threading.active_count()
    disk = SmallDisk(room=10**9)
    record = a_session(tmp_path, disk, background=True)
    stream = record.open_stream("emg", EMG)
    assert record.wait()
    disk.goes_on.clear()
    for i in range(8):
        stream.append(Block(np.ones((10, 1)), 10 * i, 0.0))
        record.append(Noted(str(i)))
    assert not record.is_safe  # so no call has waited
    disk.goes_on.set()
    assert record.wait()
    assert record.is_safe
    record.close()
    assert SampleFile(tmp_path / "s" / "sitting-1_emg.samples").stop == 80
    assert threading.active_count() == threads


def test_a_line_never_reaches_the_disk_before_what_was_laid_before_it(tmp_path):
    order: list[str] = []

    class Watched(OperatingSystem):
        def sync(self, handle: int) -> None:
            order.append(os.readlink(f"/proc/self/fd/{handle}").rpartition("/")[2])

    if not Path("/proc/self/fd").exists():
        pytest.skip("names of open files are asked of /proc")
    disk = Writer(background=False, system=Watched())
    samples, lines = SealedFile(tmp_path / "samples", disk), SealedFile(tmp_path / "lines", disk)
    samples.append(b"a")
    lines.seal(b"1")
    lines.seal(b"2")
    samples.append(b"b")
    lines.seal(b"3")
    disk.close()
    assert order == ["samples", "lines", "lines", "samples", "lines"]


def test_without_a_thread_samples_are_in_the_file_at_once(tmp_path):
    disk = Writer(background=False)
    samples = SealedFile(tmp_path / "samples", disk)
    assert samples.append(b"1234")
    assert (tmp_path / "samples").read_bytes() == b"1234"
    disk.close()


KILLED = """
import sys, time
from pathlib import Path
import numpy as np
from emg2vsa.session.journal import Noted
from emg2vsa.session.plan import Plan, draw_presses
from emg2vsa.session.record import new_session
from emg2vsa.devices.streams import Block, StreamInfo
record = new_session(Path(sys.argv[1]), Plan("disk", "P01", 1, "", ()), time.monotonic)
stream = record.open_stream("emg", StreamInfo("emg", ("EDC",), "V", 1000.0))
for i in range(100_000):
    stream.append(Block(np.full((10, 1), i), 10 * i, 0.0))
    if i % 20 == 0:
        record.append(Noted(str(10 * i + 10)))
        record.wait()
        print(i, flush=True)
"""


def test_a_killed_process_leaves_every_line_and_the_samples_before_it(tmp_path):
    folder = tmp_path / "s"
    child = subprocess.Popen([sys.executable, "-c", KILLED, str(folder)], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    last = [int(child.stdout.readline()) for _ in range(15)][-1]
    child.kill()
    child.wait()
    child.stdout.close()
    again = resume_session(folder, lambda: 0.0, background=False)
    again.close()
    notes = [
        int(line.event.text) for line in read_journal(folder / "journal.jsonl")[0] if isinstance(line.event, Noted)
    ]
    assert notes[-1] >= 10 * last + 10
    file = SampleFile(folder / "sitting-1_emg.samples")
    samples = file.read(0, notes[-1])
    np.testing.assert_array_equal(samples[:, 0], np.repeat(np.arange(notes[-1] // 10), 10))


def test_lines_that_wait_together_share_the_time_of_their_samples(tmp_path):
    """One fsync for the samples of all, and one for each line: a line is on the disk before the next is written."""

    class Slow(OperatingSystem):
        def __init__(self) -> None:
            self.calls: list[str] = []

        def write(self, handle: int, offset: int, piece: bytes) -> None:
            self.calls.append(f"write {handle} {piece.count(LINE_END)}")
            super().write(handle, offset, piece)

        def sync(self, handle: int) -> None:
            self.calls.append(f"sync {handle}")
            goes_on.wait(20)

    goes_on = running()
    system = Slow()
    record = a_session(tmp_path, system, background=True)
    stream = record.open_stream("emg", EMG)
    assert record.wait()
    goes_on.clear()
    system.calls.clear()
    record.append(Noted("first"))
    end_s = time.monotonic() + 60
    while not any(call.startswith("sync") for call in system.calls) and time.monotonic() < end_s:
        time.sleep(0.001)
    system.calls.clear()  # it is being written
    for i in range(5):
        stream.append(Block(np.zeros((100, 1)), 100 * i, 0.0))
        record.append(Noted(f"{i}"))
    goes_on.set()
    assert record.wait()
    syncs = [call for call in system.calls if call.startswith("sync")]
    record.close()
    journal = max(syncs, key=syncs.count)
    assert syncs.count(journal) in (5, 6)  # the first line's may be among them
    assert len(syncs) - syncs.count(journal) <= 2
    of_journal = [call for call in system.calls if call.startswith(f"write {journal.split()[1]} ")]
    assert all(call.endswith(" 1") for call in of_journal)
