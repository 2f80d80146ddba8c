"""Tidy tables as people write them: separators, decimal signs, blanks, and what is no number."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import pytest

from emg2vsa.errors import DataError, InputError, RecordingError
from emg2vsa.readers.tidy_table import read_tidy_table

ROWS = [("P1", "S1", "1000000000000.4"), ("P1", "S2", "-1.5e-6"), ("P2", "S1", ""), ("P2", "S2", "NaN")]


def write(tmp_path: Path, text: str, encoding: str = "utf-8") -> Path:
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(("separator", "sign"), [(",", "."), (";", ","), ("\t", "."), ("\t", ","), (";", ".")])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_digit_survives(tmp_path: Path, separator: str, sign: str, encoding: str) -> None:
    lines = [separator.join((p, s, b.replace(".", sign))) for p, s, b in ROWS]
    path = write(tmp_path, "\r\n".join([separator.join(("participant", "specimen", "b")), *lines]), encoding)
    table = read_tidy_table(path)
    assert table.names == ("participant", "specimen", "b")
    assert table.texts("specimen") == ["S1", "S2", "S1", "S2"]
    assert table.numbers("b") == [Decimal("1000000000000.4"), Decimal("-1.5e-6"), None, None]
    assert table.numeric() == ("b",)


def test_comments_blank_lines_quotes_and_short_rows(tmp_path: Path) -> None:
    table = read_tidy_table(write(tmp_path, '# made by hand\na,"b, unit",c\n\n1,"2",x\n3\n'))
    assert table.names == ("a", "b, unit", "c")
    assert table.numbers("b, unit") == [Decimal(2), None]
    assert table.lines == (4, 5)


def test_what_is_no_number_is_named_with_its_line(tmp_path: Path) -> None:
    table = read_tidy_table(write(tmp_path, "specimen,b,c\nS1,1.5,1\n\nS1,about 2,2\n"))
    with pytest.raises(DataError, match=r"line 4, column 'b'.*found 'about 2'.*Columns of numbers: 'c'"):
        table.numbers("b")


@pytest.mark.parametrize("text", ["1e999", "1e-999", "inf", "1_000", "0x1F", "1e999999999", "٣"])
def test_numbers_out_of_reach_are_refused(tmp_path: Path, text: str) -> None:
    table = read_tidy_table(write(tmp_path, f"specimen,b\nS1,{text}\nS2,1\n"))
    with pytest.raises(DataError, match="line 2"):
        table.numbers("b")


def test_zero_is_a_number_however_it_is_written(tmp_path: Path) -> None:
    table = read_tidy_table(write(tmp_path, "specimen,b\nS1,0.000e-999\nS2,-0\n"))
    assert table.numbers("b") == [Decimal(0), Decimal(0)]


def test_near_names_are_offered(tmp_path: Path) -> None:
    table = read_tidy_table(write(tmp_path, "Participant,Specimen,b_v\nP1,S1,1\n"))
    with pytest.raises(DataError, match="Did you mean 'Specimen'"):
        table.texts("specimens")
    with pytest.raises(DataError, match="columns 'Participant', 'Specimen', 'b_v'"):
        table.texts("zzz")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "0 filled lines"),
        ("a,b\n", "1 filled lines"),
        ("1,2\n3,4\n", "header row of different names"),
        ("a,a\n1,2\n", "'a' twice"),
        ("a,b\n1,2,3\n", "line 2: expected 2 cells"),
        ('a,b\n1,"2\n3,4\n', "quotation mark"),
        ("PK\0\0", "binary content"),
    ],
)
def test_no_table_is_one_clear_error(tmp_path: Path, text: str, match: str) -> None:
    with pytest.raises(InputError, match=match) as raised:
        read_tidy_table(write(tmp_path, text))
    assert isinstance(raised.value, (DataError, RecordingError))
