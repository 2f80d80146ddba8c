"""Writes that nobody waits for, and what becomes of them."""

from __future__ import annotations

import errno
import os
import statistics
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from emg2vsa.durable import writer as writing
from emg2vsa.durable.append_file import AppendFile
from emg2vsa.durable.writer import Writer
from emg2vsa.errors import DeviceError


@pytest.fixture
def disk() -> Iterator[Writer]:
    with closing(Writer(background=True)) as writer:
        yield writer


def test_pieces_come_in_their_order(disk: Writer, tmp_path: Path) -> None:
    file = AppendFile(tmp_path / "deep" / "log", disk)
    for number in range(1000):
        file.append(f"{number}\n".encode())
    file.patch(0, b"9")
    disk.finish()
    assert (tmp_path / "deep" / "log").read_text().split() == ["9", *map(str, range(1, 1000))]


def test_nobody_waits_for_a_disk_that_is_held_up(disk: Writer, tmp_path: Path, monkeypatch) -> None:
    file = AppendFile(tmp_path / "log", disk)
    disk.finish()
    held_up, pwrite = threading.Event(), os.pwrite
    monkeypatch.setattr(os, "pwrite", lambda *given: held_up.wait(10) and pwrite(*given))
    for number in range(100):
        file.append(b"%d\n" % number)
    assert (tmp_path / "log").read_bytes() == b""  # so no call has waited
    held_up.set()
    disk.finish()
    assert len((tmp_path / "log").read_text().split()) == 100


def test_a_disk_that_never_keeps_up_is_told(disk: Writer, monkeypatch) -> None:
    monkeypatch.setattr(writing, "LARGEST_QUEUE", 10)
    held_up = threading.Event()
    disk.do(held_up.wait, 10)
    while disk._asked.qsize():
        time.sleep(0.001)
    for _ in range(10):
        disk.do(lambda: None)
    with pytest.raises(DeviceError, match="expected one that keeps up with the control loop, but found"):
        disk.do(lambda: None)
    held_up.set()


def test_a_refusal_is_told_once_and_nothing_follows_what_was_refused(disk, tmp_path: Path, monkeypatch) -> None:
    full, other = AppendFile(tmp_path / "full", disk), AppendFile(tmp_path / "other", disk)
    full.append(b"whole\n")
    disk.finish()
    pwrite, place = os.pwrite, full._handle

    def refuse(file: int, piece: bytes, offset: int) -> int:
        if file == place:
            raise OSError(errno.EIO, "Input/output error")
        return pwrite(file, piece, offset)

    monkeypatch.setattr(os, "pwrite", refuse)
    full.append(b"lost\n")
    with pytest.raises(DeviceError, match="Input/output error"):
        disk.finish()
    monkeypatch.setattr(os, "pwrite", pwrite)
    other.append(b"written\n")
    disk.finish()
    assert (tmp_path / "full").read_bytes() == b"whole\n"
    assert (tmp_path / "other").read_bytes() == b"written\n"


def test_a_file_that_is_there_is_told_before_anything_moves(disk: Writer, tmp_path: Path) -> None:
    (tmp_path / "log").write_text("another run")
    AppendFile(tmp_path / "log", disk)
    with pytest.raises(DeviceError, match="expected a new file"):
        disk.finish()
    assert (tmp_path / "log").read_text() == "another run"


def test_what_was_asked_for_is_on_disk_within_a_turn_as_a_rule(disk: Writer, tmp_path: Path) -> None:
    file = AppendFile(tmp_path / "log", disk)
    disk.finish()
    waits_s = []
    for number in range(50):
        begun_s = time.monotonic()
        file.append(b"x" * 200)
        while (tmp_path / "log").stat().st_size < 200 * (number + 1) and time.monotonic() < begun_s + 20:
            time.sleep(0.001)
        waits_s.append(time.monotonic() - begun_s)
    assert statistics.median(waits_s) < 0.2  # on a busy computer; else a few milliseconds
