"""Force logs as rigs and spreadsheets write them."""

from __future__ import annotations

import numpy as np
import pytest

from casr.errors import FramesError
from casr.frame_files import read_force_log

PLAIN = "time_s,force_n,frame_index\n0.000,0.1,-1\n0.005,0.2,0\n0.010,0.3,0\n0.015,-0.4,1\n"


def log_of(tmp_path, text, **asked):
    path = tmp_path / "force.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_force_log(path, **asked)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.replace("\n", "\r\n"),
        "\ufeff" + PLAIN,
        PLAIN.replace(",", "\t"),
        PLAIN.replace(",", ";"),
        PLAIN.replace(",", ";").replace(".", ","),
        PLAIN.replace("time_s,force_n", ' Time_s , "FORCE_N"'),
        "# rig 2\n\n" + PLAIN.replace("0.010", "# retracted, by hand\n0.010") + "\n\n",
        PLAIN.rstrip("\n"),
        "frame_index,note,force_n,time_s\n-1,a,0.1,0\n0,b,0.2,0.005\n0,,0.3,0.01\n1,,-0.4,0.015\n",
    ],
    ids=["plain", "crlf", "bom", "tabs", "semicolons", "decimal comma", "header", "comments", "no end", "order"],
)
def test_one_log_in_many_spellings(tmp_path, text):
    log = log_of(tmp_path, text)
    np.testing.assert_allclose(log.time_s, [0, 0.005, 0.01, 0.015])
    np.testing.assert_array_equal(log.force_n, [0.1, 0.2, 0.3, -0.4])
    np.testing.assert_array_equal(log.frame_index, [-1, 0, 0, 1])
    assert log.notes == ()


def test_one_row_for_each_frame_without_time(tmp_path):
    log = log_of(tmp_path, "frame_index,force_n\n0,0.1\n1,0.5\n")
    assert log.time_s is None
    np.testing.assert_array_equal(log.force_n, [0.1, 0.5])


def test_travel_is_optional_and_may_be_missing_in_a_row(tmp_path):
    assert log_of(tmp_path, PLAIN).travel_mm is None
    text = "force_n,travel_mm,frame_index\n0.1,3.5,0\n0.2,,1\n0.3,3.7,2\n"
    np.testing.assert_array_equal(log_of(tmp_path, text).travel_mm, [3.5, np.nan, 3.7])
    with pytest.raises(FramesError, match=r"line 3.*a number in travel_mm.*'deep'"):
        log_of(tmp_path, text.replace("0.2,", "0.2,deep"))


def test_times_of_frames_are_optional_and_may_begin_late(tmp_path):
    assert log_of(tmp_path, PLAIN).frame_time_s is None
    text = "time_s,force_n,frame_index,frame_time_s\n0,0.1,-1,\n0.01,0.2,0,0.004\n0.02,0.3,0,0.004\n"
    np.testing.assert_array_equal(log_of(tmp_path, text).frame_time_s, [np.nan, 0.004, 0.004])
    alone = log_of(tmp_path, "force_n,frame_index,frame_time_s\n0.1,0,0.004\n0.2,1,0.054\n")
    assert alone.notes == ("frame_time_s is not used without time_s",)
    empty = log_of(tmp_path, "time_s,force_n,frame_index,frame_time_s\n0,0.1,0,\n1,0.2,1,\n")
    assert empty.notes == ("frame_time_s is empty and not used",)
    holes = log_of(tmp_path, "time_s,force_n,frame_index,frame_time_s\n,0.1,0,0\n1,0.2,1,\n")
    assert holes.notes == (
        "1 of 2 rows of the force log have no time_s, and their force is not used",
        "1 of 2 frames have no frame_time_s",
    )
    with pytest.raises(FramesError, match=r"line 4: expected frame_time_s not below 0\.004"):
        log_of(tmp_path, text.replace("0,0.004\n0.02,0.3,0,0.004", "0,0.004\n0.02,0.3,1,0.003"))


def test_missing_forces_stay_and_rows_without_frame_go_with_notes(tmp_path):
    log = log_of(tmp_path, "time_s,force_n,frame_index\n0,,0\n1,nan,0\n2,3,\n3,4,1\n,,\n")
    np.testing.assert_array_equal(log.force_n, [np.nan, np.nan, 4])
    np.testing.assert_array_equal(log.time_s, [0, 1, 3])
    np.testing.assert_array_equal(log.frame_index, [0, 0, 1])
    assert log.notes == (
        "3 of 5 rows of the force log have no force",
        "2 of 5 rows of the force log have no frame index and are left out",
    )


def test_of_raw_and_filtered_force_the_one_asked_for(tmp_path):
    text = "force_n,force_filtered_n,frame_index\n1,2,0\n3,4,1\n"
    np.testing.assert_array_equal(log_of(tmp_path, text).force_n, [1, 3])
    np.testing.assert_array_equal(log_of(tmp_path, text, column="force_filtered_n").force_n, [2, 4])


@pytest.mark.parametrize(
    ("unit", "newtons"),
    [("mn", 1e-3), ("cN", 1e-2), ("kN", 1e3), ("gf", 9.80665e-3), ("kgf", 9.80665), ("lbf", 4.44822)],
)
def test_a_force_in_another_unit_is_converted_by_its_name(tmp_path, unit, newtons):
    log = log_of(tmp_path, PLAIN.replace("force_n", f"force_{unit}"))
    np.testing.assert_allclose(log.force_n, newtons * np.array([0.1, 0.2, 0.3, -0.4]), rtol=1e-5)
    assert f"force from column force_{unit.lower()}" in log.notes[0]
    named = log_of(tmp_path, PLAIN.replace("force_n", f"load_{unit}"), column=f"load_{unit}")
    np.testing.assert_array_equal(named.force_n, log.force_n)


def test_of_two_units_none_is_guessed(tmp_path):
    with pytest.raises(FramesError, match="a column force_n, but found columns force_mn, force_kgf, frame_index"):
        log_of(tmp_path, "force_mn,force_kgf,frame_index\n1,2,0\n3,4,1\n")
    both = log_of(tmp_path, "force_mn,force_n,frame_index\n1,2,0\n3,4,1\n")
    np.testing.assert_array_equal(both.force_n, [2, 4])
    assert both.notes == ()


def test_a_log_that_names_its_force_otherwise_gets_a_hint(tmp_path):
    with pytest.raises(
        FramesError, match=r"a column force_n, but found columns force_raw_n, frame_index. Is it force_raw_n"
    ):
        log_of(tmp_path, "force_raw_n,frame_index\n1,0\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PLAIN.replace("0.2", "x"), r"force.csv, line 3: expected a number in force_n, but found 'x'"),
        ("# c\n\n" + PLAIN.replace("0.2", "x"), r"force.csv, line 5: expected a number"),
        (PLAIN.replace("0.2", "inf"), r"line 3: expected a finite number in force_n, but found 'inf'"),
        (PLAIN.replace("0.010", "0.001"), r"line 4: expected time_s not below 0.005 .* found 0.001"),
        (PLAIN.replace(",1\n", ",-1\n"), r"line 5: expected frame_index not below 0 of the row before, but found -1"),
        (PLAIN.replace("0.3,0", "0.3,0.5"), r"line 4: expected a frame index: a whole number.* found 0.5"),
        (PLAIN.replace("0.1,-1", "0.1,-2"), r"line 2: expected a frame index.* found -2"),
        (PLAIN.replace("0.3,0", "0.3"), r"line 4: expected 3 cells as in the header, but found 2"),
        (PLAIN.replace("0.3,0", "0,3,0"), r"line 4: expected 3 cells as in the header, but found 4"),
        (PLAIN.replace("frame_index", "force_n"), r"a column force_n, but found 2 of that name"),
        (PLAIN.replace("frame_index", "frame"), r"a column frame_index, but found columns time_s, force_n, frame"),
        (
            "0.0,0.1,0\n0.1,0.2,1\n",
            r"a column force_n, but found columns 0.0, 0.1, 0. Name the columns in the first "
            r"line",
        ),
        ("", "expected a header line and rows, but found 0 lines"),
        ("force_n,frame_index\n", "expected a header line and rows, but found 1 lines"),
        ("force_n,frame_index\n,0\n2,\n", "rows with a force and a frame index, but found none"),
        (PLAIN.encode("utf-16"), "text in UTF-8"),
        (PLAIN.replace(".", ",").replace(",0,1", ";0,1"), "expected"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, message):
    with pytest.raises(FramesError, match=message):
        log_of(tmp_path, text)


def test_a_log_that_is_not_there(tmp_path):
    with pytest.raises(FramesError, match=r"gone.csv: .* No such file"):
        read_force_log(tmp_path / "gone.csv")
    with pytest.raises(FramesError, match=r"Is a directory"):
        read_force_log(tmp_path)


@pytest.mark.parametrize("word", ["doubtful", "rejected"])
def test_what_the_recorder_thought_of_the_press_is_a_note(tmp_path, word):
    log = log_of(tmp_path, f"# rig 2\n{PLAIN}# {word}: 5 % of its turns are missing\n")
    assert log.notes == (f"the recorder of the press says {word}: 5 % of its turns are missing",)
