"""What is said of faulty keys: all at once, each with its line, what was wanted and what was found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.study_file import load_study

Problems = Callable[[str], list[str]]


def test_six_planted_errors_are_all_reported_on_their_lines(small: str, problems: Problems) -> None:
    faulty = (
        small.replace("stiffness_n_per_mm = 3.35", "stiffness_n_per_mm = -3.35")
        .replace('name = "Fz"', 'named = "Fz"')
        .replace('ids = ["P01", "P02"]', 'ids = ["P01", "P01"]')
        .replace("S3 = 15e-6", 'S3 = "15e-6"')
        .replace("[channels.emg.FDS]", "[filter]\n[channels.emg.FDS]")
    ) + '[fit]\npoints = "bin"\n'
    assert problems(faulty) == [
        "5: participants.ids[1]: wanted every name once; found 'P01' again.",
        "13: specimens[1].stiffness_n_per_mm: wanted a number > 0; found -3.35.",
        "22: filter: wanted a known key; found 'filter'. Did you mean 'filters'?",
        "26: channels.force.name: wanted a key 'name'; found nothing.",
        "27: channels.force.named: wanted a known key; found 'named'. Did you mean 'name'?",
        '31: simulation.b_v.S3: wanted a number; found "15e-6". Write it without quotes.',
        "33: fit.points: wanted 'bins' or 'samples'; found \"bin\". Did you mean 'bins'?",
    ]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("band_order = 2.5", "filters.band_order: wanted a whole number; found 2.5."),
        ("band_order = true", "filters.band_order: wanted a whole number; found true."),
        ("band_order = 9", "filters.band_order: wanted a number <= 8; found 9."),
        ("band_hz = 10", "filters.band_hz: wanted an array [...]; found 10."),
        ("band_hz = [10]", "filters.band_hz[1]: wanted one more entry; found nothing."),
        ("band_hz = [10, 20, 30]", "filters.band_hz: wanted at most 2 entries; found [10, 20, 30]."),
        ('band_hz = [10, "450"]', 'filters.band_hz[1]: wanted a number; found "450". Write it without quotes.'),
        ("rms_window_s = inf", "filters.rms_window_s: wanted a finite number; found Infinity."),
        ("rms_window_s = nan", "filters.rms_window_s: wanted a finite number; found NaN."),
        ("rms_window_s = 1979-05-27", 'filters.rms_window_s: wanted a number; found "1979-05-27".'),
        ("force_filter = 1", "filters.force_filter: wanted true or false; found 1."),
        ('output_fs_hz = "nativ"', "filters.output_fs_hz: wanted a number or 'native'; found \"nativ\"."),
        ("output_fs_hz = 0", "filters.output_fs_hz: wanted a number > 0 or 'native'; found 0."),
        ("band_hz = {}", "filters.band_hz: wanted an array [...]; found a table."),
        ("points = 1", "filters.points: wanted a known key; found 'points'. Did you mean 'mains'? [fit] has"),
        ('mains = "notch"', "filters.mains: wanted 'remove' or 'keep'; found \"notch\"."),
        ("rest_level = 0.5", "filters.rest_level: wanted 'subtract' or 'keep'; found 0.5."),
        ("align = true", "filters.align: wanted 'stated' or 'lag'; found true."),
    ],
)
def test_one_faulty_key(small: str, problems: Problems, line: str, said: str) -> None:
    (problem,) = problems(f"{small}[filters]\n{line}\n")
    assert problem.removeprefix("32: ").startswith(said)


def test_true_is_no_number_in_a_choice_of_numbers(small: str, problems: Problems) -> None:
    (problem,) = problems(small.replace('name = "Fz"', 'name = "Fz"\nsign = true'))
    assert problem == "27: channels.force.sign: wanted 1 or -1; found true."


def test_a_key_of_another_table_says_which(small: str, problems: Problems) -> None:
    (problem,) = problems(small + "[filters]\nbin_n = 0.3\n")
    assert problem.endswith("[fit] has a key of that name.")


def test_tables_that_are_missing_or_no_tables(problems: Problems) -> None:
    said = problems("study = 1\nfilters = 2\nspecimens = { name = 'S1' }\n")
    assert "1: study: wanted a table; found 1." in said
    assert "2: filters: wanted a table; found 2." in said
    assert "3: specimens: wanted tables under [[specimens]]; found a table." in said
    assert "1: recordings: wanted a table [recordings]; found nothing." in said


def test_a_table_with_a_faulty_key_is_compared_with_others_once_it_is_mended(small: str, problems: Problems) -> None:
    two = "[filters]\nband_order = 0\nband_hz = [450, 10]\n[fit]\nbin_n = 3\n[window]\nforce_n = [0.5, 1, 2]\n"
    assert [line.split(": ")[1] for line in problems(small + two)] == ["filters.band_order", "window.force_n"]
    mended = two.replace("= 0", "= 2").replace("[0.5, 1, 2]", "[0.5, 2]")
    assert [line.split(": ")[1] for line in problems(small + mended)] == ["filters.band_hz", "fit.bin_n"]


def test_a_faulty_key_is_not_reported_twice(small: str, problems: Problems) -> None:
    said = problems(small + '[profile]\nnew_specimen = "N"\nnew_stiffness_n_per_mm = "5"\n')
    assert len(said) == 1


@pytest.mark.parametrize(
    ("text", "line_and_column"),
    [("a = [1,\n2", "2"), ("a = 1\na = 2\n", "2:"), ("a = 1\nb == 2\n", "2:4"), ("a = 1\n[b\n", "2:3")],
)
def test_toml_syntax(problems: Problems, text: str, line_and_column: str) -> None:
    (problem,) = problems(text)
    assert problem.startswith(line_and_column)
    assert ": wanted valid TOML; found: " in problem


def test_windows_line_ends_and_bytes_that_are_not_utf8(tmp_path: Path, small: str) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes(small.replace('name = "Fz"', "").replace("\n", "\r\n").encode())
    with pytest.raises(StudyError, match=r"study\.toml:25: channels\.force\.name"):
        load_study(path)
    path.write_bytes(b'[study]\ntitle = "\xe4"\n')
    with pytest.raises(StudyError, match=r"study\.toml:2: wanted UTF-8 text; found byte 0xe4"):
        load_study(path)


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="wanted a study file; found none to read"):
        load_study(tmp_path / "study.toml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("title = 1" + "0" * 5000, "wanted valid TOML; found: "),
        ("title = " + "[" * 5000 + "]" * 5000, "wanted valid TOML; found "),
    ],
)
def test_toml_that_python_does_not_read(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "study.toml"
    path.write_text(f"[study]\n{text}\n")
    with pytest.raises(StudyError) as caught:
        load_study(path)
    assert said in caught.value.problems[0]


def test_numbers_beyond_all_bounds(small: str, problems: Problems) -> None:
    huge = "0x" + "f" * 5000
    said = problems(f"{small}[filters]\nrms_window_s = {huge}\nband_order = {huge}\nband_hz = [1, {huge}]\n")
    assert [line.split(": ")[1] for line in said] == [
        "filters.rms_window_s",
        "filters.band_order",
        "filters.band_hz[1]",
    ]
    assert said[0].endswith("wanted a finite number; found a number of thousands of digits.")


def test_a_participants_table_with_a_name_that_no_file_can_have(small: str, problems: Problems) -> None:
    (problem,) = problems(small.replace('ids = ["P01", "P02"]', 'file = "a\\u0000b"'))
    assert problem.startswith("5: participants.file: wanted a readable table")


def test_listed_layout_without_files(small: str, problems: Problems) -> None:
    layout = small[small.index("layout = ") : small.index("[channels.emg.EDC]")]
    (problem,) = problems(small.replace(layout, 'layout = "files"\nfiles = []\n'))
    assert "recordings.files: wanted a key 'files' with layout = 'files'" in problem


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("max_seconds = 0", "; found 0."),
        ("max_seconds = 4000", "wanted a number <= 3600; found 4000."),
        ("max_memory_mb = 10", "; found 10."),
        ('max_memory_mb = "500"', '; found "500". Write it without quotes.'),
        ("seconds = 3", "wanted a known key; found 'seconds'. Did you mean 'max_seconds'?"),
    ],
)
def test_bad_limits_of_reading(small: str, problems: Problems, line: str, said: str) -> None:
    (problem,) = problems(f"{small}[reading]\n{line}\n")
    assert problem.endswith(said)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("mounting_sd_percent = -1", "wanted a number >= 0; found -1."),
        ("mounting_sd_percent = 80", "wanted a number < 50; found 80."),
        ('mounting_sd_percent = "2"', '; found "2". Write it without quotes.'),
        ("mounting_sd = 2", "wanted a known key; found 'mounting_sd'. Did you mean 'mounting_sd_percent'?"),
    ],
)
def test_a_bad_spread_of_mountings(small: str, problems: Problems, line: str, said: str) -> None:
    (problem,) = problems(f"{small}[calibration]\n{line}\n")
    assert problem.endswith(said)
