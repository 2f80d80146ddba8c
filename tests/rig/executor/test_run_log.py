"""The log on disk, whole or cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.rig.logs import read_log
from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.run_log import Row, RunLog

ROWS = [
    Row(n / 200, 1, "load", n / 200, 0.25 * n, None, 100 + n, 600, None, None, n, -3, None, n // 10 - 1)
    for n in range(40)
]


def written(path: Path) -> bytes:
    log = RunLog(path)
    for row in ROWS:
        log.append(row)
        assert read_log(path)[-1] == row  # without closing: nothing waits in the program
    log.close()
    return path.read_bytes()


def test_what_is_written_is_read(tmp_path: Path) -> None:
    written(tmp_path / "log.csv")
    assert read_log(tmp_path / "log.csv") == ROWS


def test_cut_off_anywhere_whole_rows_are_read(tmp_path: Path) -> None:
    content, cut = written(tmp_path / "log.csv"), tmp_path / "cut.csv"
    for size in range(content.index(b"\n") + 1, len(content)):
        cut.write_bytes(content[:size])
        assert read_log(cut) == ROWS[: content[:size].count(b"\n") - 1]


@pytest.mark.parametrize(("old", "new"), [(b"load", b"load,1"), (b"100", b"1x0"), (b"time_s", b"time")])
def test_anything_else_is_refused(tmp_path: Path, old: bytes, new: bytes) -> None:
    (tmp_path / "bad.csv").write_bytes(written(tmp_path / "log.csv").replace(old, new, 1))
    with pytest.raises(RecordingError, match=r"bad\.csv"):
        read_log(tmp_path / "bad.csv")


def test_logs_of_version_0_1_0_are_read(tmp_path: Path) -> None:
    old = [",".join(line.split(",")[:14]) for line in written(tmp_path / "log.csv").decode().splitlines()]
    (tmp_path / "old.csv").write_text("\n".join(old) + "\n")
    assert read_log(tmp_path / "old.csv") == [Row(*row[:14]) for row in ROWS]


def test_a_row_of_the_old_length_is_none_of_a_new_log(tmp_path: Path) -> None:
    lines = written(tmp_path / "log.csv").decode().splitlines()
    lines[5] = ",".join(lines[5].split(",")[:14])
    (tmp_path / "bad.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(RecordingError, match="23 fields of a row"):
        read_log(tmp_path / "bad.csv")
