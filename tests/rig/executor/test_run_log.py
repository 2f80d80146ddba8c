"""The log on disk, whole or cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.rig.fault_case import read_log
from emg2vsa.devices.protocols import LogColumns, Measurements
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, LOG_COLUMNS
from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.run_log import Row, RunLog
from emg2vsa.rig.record.run_log import read_log as read_frame

AT = 100 * DEG_PER_TICK
ROWS = [
    Row(
        n / 200, 1, "load", n / 200, 0.25 * n, None, AT + n * DEG_PER_TICK, 600 * DEG_PER_TICK,
        Measurements((), n * DEG_PER_TICK), (-0.003,), n // 10 - 1,
    )
    for n in range(40)
]  # fmt: skip


def written(path: Path) -> bytes:
    log = RunLog(path, LOG_COLUMNS)
    for row in ROWS:
        log.append(row)
        assert read_log(path)[-1] == row  # without closing: nothing waits in the program
    log.close()
    return path.read_bytes()


def test_what_is_written_is_read(tmp_path: Path) -> None:
    written(tmp_path / "log.csv")
    assert read_log(tmp_path / "log.csv") == ROWS


def test_a_qbmove_is_logged_in_ticks_and_every_other_actuator_in_degrees(tmp_path: Path) -> None:
    row = Row(0.5, 1, "load", 0.4985, 2.5, 2.25, 22.5, 11.25, Measurements((33.75, 11.25), 22.4), (0.25, -0.125), 7)
    heads = {"ticks": (LOG_COLUMNS, "2048,1024,3072,1024,2039,250,-125"), "degrees": (
        LogColumns(), "22.500000,11.250000,33.750000,11.250000,22.400000,0.250000,-0.125000"
    )}  # fmt: skip
    for name, (columns, own) in heads.items():
        log = RunLog(tmp_path / name, columns)
        log.append(row)
        log.close()
        head, line = (tmp_path / name).read_text().splitlines()
        assert ",".join(columns.names) in head
        assert line == f"0.500000,1,load,0.498500,2.500000,2.250000,{own},7,,,,,,,,,"
        (back,) = read_log(tmp_path / name)
        assert back.at is not None
        assert (back.position_deg, back.preset, back.at.motors_deg, back.currents_a) == (
            row[6],
            row[7],
            *row[8][:1],
            row[9],
        )
        assert back.at.shaft_deg == pytest.approx(22.4, abs=0 if name == "degrees" else DEG_PER_TICK / 2)
        frame = read_frame(tmp_path / name, ["force_n"])
        assert (list(frame.columns), *frame.iloc[0]) == (["force_n", "shaft_deg"], 2.5, back.at.shaft_deg)


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
    assert read_log(tmp_path / "old.csv") == [Row(*row[:11]) for row in ROWS]


def test_a_row_of_the_old_length_is_none_of_a_new_log(tmp_path: Path) -> None:
    lines = written(tmp_path / "log.csv").decode().splitlines()
    lines[5] = ",".join(lines[5].split(",")[:14])
    (tmp_path / "bad.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(RecordingError, match="23 fields of a row"):
        read_log(tmp_path / "bad.csv")
