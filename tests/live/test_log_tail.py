"""The tail of a log that grows under the reader's hands."""

from __future__ import annotations

import pytest

from benchmarks.rig.fault_case import read_log
from emg2vsa.devices.qbmove.ticks import LOG_COLUMNS
from emg2vsa.errors import RecordingError
from emg2vsa.live.tails import LogTail
from emg2vsa.rig.record.run_log import RunLog


@pytest.fixture
def path(tmp_path):
    return tmp_path / "log.csv"


@pytest.fixture
def log(path):
    opened = RunLog(path, LOG_COLUMNS)
    yield opened
    opened.close()


def test_each_row_comes_once_as_it_was_written(log, path, row):
    tail = LogTail(path)
    seen = []
    for turn in range(5):
        seen += tail.new_rows()
        log.append(row(turn / 200, force_n=None if turn == 2 else turn / 3))
    seen += tail.new_rows()
    assert seen == read_log(path)
    assert tail.new_rows() == []


def test_a_line_cut_anywhere_waits_for_its_other_half(log, path, row, tmp_path):
    log.append(row(0.005))
    log.append(row(0.010, phase="retract"))
    whole = path.read_bytes()
    growing = tmp_path / "growing.csv"
    for cut in range(len(whole) - 130, len(whole)):  # two rows, and the end of the header
        growing.write_bytes(whole[:cut])
        tail = LogTail(growing)
        early = tail.new_rows()
        growing.write_bytes(whole)
        assert early == read_log(path)[: max(0, whole[:cut].count(b"\n") - 1)]
        assert early + tail.new_rows() == read_log(path), cut


def test_what_was_read_is_not_read_again(log, path, row):
    tail = LogTail(path)
    log.append(row(0.005))
    tail.new_rows()
    with path.open("r+b") as file:
        file.write(b"?" * log.path.stat().st_size)
    log.append(row(0.010))
    assert [found.time_s for found in tail.new_rows()] == [0.010]


def test_a_long_log_begins_near_its_end_with_a_whole_row(log, path, row):
    for turn in range(1000):
        log.append(row(turn / 200))
    tail = LogTail(path, newest_bytes=2000)
    rows = tail.new_rows()
    assert rows == read_log(path)[-len(rows) :]
    assert 10 <= len(rows) <= 2000 // 40
    log.append(row(9.0))
    assert tail.new_rows() == [row(9.0)]


def test_no_log_yet_is_no_row_and_no_age(path):
    tail = LogTail(path)
    assert tail.new_rows() == []
    assert tail.modified_s() is None


@pytest.mark.parametrize("content", [b"time,force\n1,2\n", b"\x00\xff" * 200])
def test_another_file_is_refused(path, content):
    path.write_bytes(content)
    with pytest.raises(RecordingError, match="expected the log of a run"):
        LogTail(path).new_rows()


def test_after_a_damaged_row_it_goes_on(log, path, row):
    tail = LogTail(path)
    log.append(row(0.005))
    with path.open("r+b") as file:
        file.seek(-3, 2)
        file.write(b",,")
    with pytest.raises(RecordingError, match="fields of a row"):
        tail.new_rows()
    log.append(row(0.010))
    assert tail.new_rows() == [row(0.010)]


def test_a_log_of_an_older_version_has_the_fields_it_had(log, path, row, tmp_path):
    for turn in range(3):
        log.append(row(turn / 200))
    older = tmp_path / "older.csv"
    older.write_text("".join(",".join(line.split(",")[:14]) + "\n" for line in path.read_text().splitlines()))
    found = LogTail(older).new_rows()
    assert found == read_log(older)
    assert [each[:11] for each in found] == [each[:11] for each in read_log(path)]
