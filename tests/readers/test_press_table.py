"""Presses as testing machines write them: preamble, header, units row, signs of numbers, and what is asked for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import DataError, RecordingError
from emg2vsa.readers.press_table import PressTable, read_press_table


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., PressTable]:
    def write_and_read(text: str | bytes, **asked: str) -> PressTable:
        path = tmp_path / "press.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_press_table(path, **asked)

    return write_and_read


PREAMBLE = """\
EF10_25T_A_sample_3
Compression test;
Cylinder Diameter: 50mm;
Cylinder Height: 3 cm;
Speed (mm/min): 10;
"""
TABLE = "Time (s),Compression (mm),Load (N),Engineering Stress (kPa)\n0.0,0.0,0.002,-0.0\n0.1,0.5,1.25,-0.6\n"


def test_a_preamble_tells_sample_and_size(read: Callable[..., PressTable]) -> None:
    found = read(PREAMBLE + TABLE)
    np.testing.assert_array_equal([found.depth_mm, found.force_n], [[0, 0.5], [0.002, 1.25]])
    assert (found.specimen, found.casting, found.trial, found.diameter_mm, found.height_mm) == (
        "EF10_25T", "A", "3", 50, 30,
    )  # fmt: skip
    named = read("Specimen name,S4\nHeight (mm),12.5\nOperator,me\n" + TABLE)
    assert (named.specimen, named.trial, named.diameter_mm, named.height_mm) == ("S4", None, None, 12.5)
    bare = read("Height,12.5\n" + TABLE)  # without a unit it is not known
    assert (bare.specimen, bare.height_mm) == (None, None)


@pytest.mark.parametrize(
    ("text", "depth_mm", "force_n"),
    [
        ('"Time","Extension","Load"\n"(s)","(mm)","(kN)"\n"0","0","0"\n"1","0.5","0.002"\n', 0.5, 2.0),
        ("Time\tDisplacement\tForce\nsec\tum\tmN\n0\t0\t0\n1\t500\t2000\n", 0.5, 2.0),
        ("time;Compressive extension [mm];Compressive load [N]\n0;0,0;0,0\n1;0,5;2,0\n", 0.5, 2.0),
        ("indentation_mm force_n\n0 0\n0.5 2.0\n", 0.5, 2.0),
        ("travel_in,load_lbf\n0,0\n0.01,1\n", 0.254, 4.4482216152605),
        ("depth_cm,force_kn\n0,0\n0.05,0.002\n", 0.5, 2.0),
        ("A compression and load test\n\nDepth (mm),Force (N)\n0,0\n0.5,2\n", 0.5, 2.0),
        ("indentation_mm,position (mm),force_n\n0,9,0\n0.5,9.5,2\n", 0.5, 2.0),
    ],
    ids=[
        "units row in brackets",
        "units row",
        "decimal comma",
        "blanks",
        "inch and lbf",
        "glued",
        "prose",
        "own names",
    ],
)
def test_units_are_read_where_they_stand(
    read: Callable[..., PressTable], text: str, depth_mm: float, force_n: float
) -> None:
    found = read(text)
    assert (found.depth_mm[-1], found.force_n[-1]) == pytest.approx((depth_mm, force_n), rel=1e-12)
    assert found.depth_mm.size == 2


def test_columns_and_units_are_taken_as_asked_for(read: Callable[..., PressTable]) -> None:
    text = "Weg;Kraft;Kraft 2\n0;0;0\n0,5;2;9\n"
    found = read(text, depth="Weg (mm)", force="Kraft (N)")
    assert (found.depth_mm[-1], found.force_n[-1]) == (0.5, 2)
    found = read("Depth (mm),Load,Force (N)\n0,0,0\n0.5,2000,9\n", force="Load [mN]")
    assert found.force_n[-1] == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "time,emg\n0,1\n1,2\n",
            "expected a header row that names depth and force, such as indentation_mm and force_n",
        ),
        ("1,2\n3,4\n", "found none in 2 lines; the first is '1,2'"),
        ("", "the first is 'an empty file'"),
        ("depth,force\n0,0\n1,2\n", "line 1, column 'depth': expected a unit of depth, such as mm, but found none"),
        ("depth (mm),force\n0,0\n1,2\n", "column 'force': expected a unit of force, such as N, but found none"),
        ("depth (mm),force (kg)\n0,0\n1,2\n", "found a mass, 'kg'. Convert it to newtons: 9.80665 N"),
        ("depth (N),force (N)\n0,0\n1,2\n", "expected a unit of depth, such as mm, but found 'N'"),
        ("Extension (mm),Position (mm),Load (N)\n0,0,0\n1,1,2\n", 'Say which: --depth "Extension (mm)".'),
        ("Depth (mm),Load (N)\n0,0\n1,two\n", "line 3, column 'Load (N)': expected a number"),
        ("Depth (mm),Load (N)\n0,0\n1,2\nMaximum,9 N\n", "line 4, column 'Depth (mm)': expected a number"),
    ],
    ids=["others", "numbers", "empty", "no unit", "no unit of force", "kg", "wrong unit", "two", "text", "footer"],
)
def test_what_cannot_be_told_is_asked_for(read: Callable[..., PressTable], text: str, said: str) -> None:
    with pytest.raises(DataError) as error:
        read(text)
    assert said in str(error.value)


def test_binary_content_is_refused(read: Callable[..., PressTable]) -> None:
    with pytest.raises(RecordingError, match="binary content"):
        read(b"PK\x03\x04\x00\x00\x00")


def test_real_files_of_a_testing_machine(shared_data: Callable[[str], Path]) -> None:
    paths = sorted(shared_data("phantoms").glob("*/*.csv"))
    assert len(paths) == 50
    for path in paths:
        found = read_press_table(path)
        assert (f"{found.specimen}_{found.casting}{found.trial}", found.diameter_mm, found.height_mm) == (
            path.stem,
            50,
            30,
        )
        whole = np.genfromtxt(path, delimiter=",", skip_header=8)
        np.testing.assert_array_equal([found.depth_mm, found.force_n], whole[:, 1:3].T)
