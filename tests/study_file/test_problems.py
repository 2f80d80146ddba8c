"""What is said of faulty keys: all at once, each with its line, what was wanted and what was found.

Lines of keys, against tomllib for which keys there are and against the text for where they stand.

Files that an editor or ill will wrote.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.errors import StudyError
from emg2vsa.study_file import load_study
from emg2vsa.study_file.problems import KeyPath, shown
from emg2vsa.study_file.toml_file import key_lines, line_of, placed, read_toml

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
        "5: participants.ids[1]: expected every name once, but found 'P01' again.",
        "13: specimens[1].stiffness_n_per_mm: expected a number > 0, but found -3.35.",
        "22: filter: expected a known key, but found 'filter'. Did you mean 'filters'?",
        "26: channels.force.name: expected a key 'name', but found nothing.",
        "27: channels.force.named: expected a known key, but found 'named'. Did you mean 'name'?",
        '31: simulation.b_v.S3: expected a number, but found "15e-6". Write it without quotes.',
        "33: fit.points: expected 'bins' or 'samples', but found \"bin\". Did you mean 'bins'?",
    ]


@pytest.mark.parametrize("line", ["equivalence_margin = 0.05", "resamples = 2000", "seed = 0"])
def test_a_key_that_nothing_reads_any_more_says_so(small: str, problems: Problems, line: str) -> None:
    (said,) = problems(f"{small}[discrimination]\n{line}\n")
    assert f"discrimination.{line.split()[0]}: expected a known key" in said
    assert "Remove it: the rig's presses are compared over mountings now" in said


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("band_order = 2.5", "filters.band_order: expected a whole number, but found 2.5."),
        ("band_order = true", "filters.band_order: expected a whole number, but found true."),
        ("band_order = 9", "filters.band_order: expected a number <= 8, but found 9."),
        ("band_hz = 10", "filters.band_hz: expected an array [...], but found 10."),
        ("band_hz = [10]", "filters.band_hz[1]: expected one more entry, but found nothing."),
        ("band_hz = [10, 20, 30]", "filters.band_hz: expected at most 2 entries, but found [10, 20, 30]."),
        ('band_hz = [10, "450"]', 'filters.band_hz[1]: expected a number, but found "450". Write it without quotes.'),
        ("rms_window_s = inf", "filters.rms_window_s: expected a finite number, but found Infinity."),
        ("rms_window_s = nan", "filters.rms_window_s: expected a finite number, but found NaN."),
        ("rms_window_s = 1979-05-27", 'filters.rms_window_s: expected a number, but found "1979-05-27".'),
        ("force_filter = 1", "filters.force_filter: expected true or false, but found 1."),
        ('output_fs_hz = "nativ"', "filters.output_fs_hz: expected a number or 'native', but found \"nativ\"."),
        ("output_fs_hz = 0", "filters.output_fs_hz: expected a number > 0 or 'native', but found 0."),
        ("band_hz = {}", "filters.band_hz: expected an array [...], but found a table."),
        ("points = 1", "filters.points: expected a known key, but found 'points'. Did you mean 'mains'? [fit] has"),
        ('mains = "notch"', "filters.mains: expected 'remove' or 'keep', but found \"notch\"."),
        ("rest_level = 0.5", "filters.rest_level: expected 'subtract' or 'keep', but found 0.5."),
        ("align = true", "filters.align: expected 'stated' or 'lag', but found true."),
    ],
)
def test_one_faulty_key(small: str, problems: Problems, line: str, said: str) -> None:
    (problem,) = problems(f"{small}[filters]\n{line}\n")
    assert problem.removeprefix("32: ").startswith(said)


def test_a_curve_of_profiles_that_does_not_exist(small: str, problems: Problems) -> None:
    (said,) = problems(f'{small}[profile]\ncurve = "splines"\n')
    assert said.endswith("profile.curve: expected 'log' or 'spline', but found \"splines\". Did you mean 'spline'?")


def test_true_is_no_number_in_a_choice_of_numbers(small: str, problems: Problems) -> None:
    (problem,) = problems(small.replace('name = "Fz"', 'name = "Fz"\nsign = true'))
    assert problem == "27: channels.force.sign: expected 1 or -1, but found true."


def test_a_key_of_another_table_says_which(small: str, problems: Problems) -> None:
    (problem,) = problems(small + "[filters]\nbin_n = 0.3\n")
    assert problem.endswith("[fit] has a key of that name.")


def test_tables_that_are_missing_or_no_tables(problems: Problems) -> None:
    said = problems("study = 1\nfilters = 2\nspecimens = { name = 'S1' }\n")
    assert "1: study: expected a table, but found 1." in said
    assert "2: filters: expected a table, but found 2." in said
    assert "3: specimens: expected tables under [[specimens]], but found a table." in said
    assert "1: recordings: expected a table [recordings], but found nothing." in said


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
    assert ": expected valid TOML, but the parser says: " in problem


def test_windows_line_ends_and_bytes_that_are_not_utf8(tmp_path: Path, small: str) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes(small.replace('name = "Fz"', "").replace("\n", "\r\n").encode())
    with pytest.raises(StudyError, match=r"study\.toml:25: channels\.force\.name"):
        load_study(path)
    path.write_bytes(b'[study]\ntitle = "\xe4"\n')
    with pytest.raises(StudyError, match=r"study\.toml:2: expected UTF-8 text, but found byte 0xe4"):
        load_study(path)


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="expected a study file, but found no file that can be read"):
        load_study(tmp_path / "study.toml")
    with pytest.raises(StudyError, match=r"expected a study file, but found a folder\. Name the study file in it\."):
        load_study(tmp_path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("title = 1" + "0" * 5000, "expected valid TOML, but the parser says: "),
        ("title = " + "[" * 5000 + "]" * 5000, "expected valid TOML, but found "),
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
    assert said[0].endswith("expected a finite number, but found a number of thousands of digits.")


def test_a_participants_table_with_a_name_that_no_file_can_have(small: str, problems: Problems) -> None:
    (problem,) = problems(small.replace('ids = ["P01", "P02"]', 'file = "a\\u0000b"'))
    assert problem.startswith("5: participants.file: expected a readable table")


def test_listed_layout_without_files(small: str, problems: Problems) -> None:
    layout = small[small.index("layout = ") : small.index("[channels.emg.EDC]")]
    (problem,) = problems(small.replace(layout, 'layout = "files"\nfiles = []\n'))
    assert "recordings.files: expected a key 'files' with layout = 'files'" in problem


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("max_seconds = 0", ", but found 0."),
        ("max_seconds = 4000", "expected a number <= 3600, but found 4000."),
        ("max_memory_mb = 10", ", but found 10."),
        ('max_memory_mb = "500"', ', but found "500". Write it without quotes.'),
        ("seconds = 3", "expected a known key, but found 'seconds'. Did you mean 'max_seconds'?"),
    ],
)
def test_bad_limits_of_reading(small: str, problems: Problems, line: str, said: str) -> None:
    (problem,) = problems(f"{small}[reading]\n{line}\n")
    assert problem.endswith(said)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("mounting_sd_percent = -1", "expected a number >= 0, but found -1."),
        ("mounting_sd_percent = 80", "expected a number < 50, but found 80."),
        ('mounting_sd_percent = "2"', ', but found "2". Write it without quotes.'),
        ("mounting_sd = 2", "expected a known key, but found 'mounting_sd'. Did you mean 'mounting_sd_percent'?"),
    ],
)
def test_a_bad_spread_of_mountings(small: str, problems: Problems, line: str, said: str) -> None:
    (problem,) = problems(f"{small}[calibration]\n{line}\n")
    assert problem.endswith(said)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ('engine = "dense"', "runs.engine: expected 'pin-affine', 'horn-schunck' or 'dis', but found \"dense\"."),
        ('force_rule = "means"', "runs.force_rule: expected 'exposure' or 'mean', but found \"means\"."),
        ("area_rule = 2", "runs.area_rule: expected 'edge', 'hexagon', 'circle' or 'paper', but found 2."),
        ('area_rule = "as-printed"', "runs.area_rule: expected 'edge', 'hexagon', 'circle' or 'paper', but found"),
        ('law = "letter"', "runs.law: expected 'ode' or 'paper', but found \"letter\"."),
        ("rate = true", "runs.rate: expected 'power', 'slope' or 'paper', but found true."),
        ('region = "all"', "runs.region: expected 'contact' or 'image', but found \"all\"."),
        (
            'law = "paper"',
            "runs.law: expected no law, or 'ode', with algorithm = 'front', but found 'paper'. The front is followed "
            "by the pins; choose another algorithm, or leave the key out.",
        ),
        (
            'engine = "dis"',
            "runs.engine: expected no engine, or 'pin-affine', with algorithm = 'front', but found 'dis'",
        ),
        ('rate = "paper"', "runs.rate: expected no rate, or 'power', with algorithm = 'front', but found 'paper'."),
        (
            'region = "image"',
            "runs.region: expected no region, or 'contact', with algorithm = 'front', but found 'image'",
        ),
        (
            'algorithm = "hexagon"\narea_rule = "circle"',
            "runs.area_rule: expected no area_rule, or 'hexagon', with algorithm = 'hexagon', but found 'circle'. "
            "Choose algorithm = 'circle', or leave area_rule out.",
        ),
        (
            'algorithm = "edge"\nregion = "image"',
            "runs.engine: expected a dense engine with region = 'image', but found 'pin-affine'. Choose horn-schunck "
            "or dis, or leave region out.",
        ),
    ],
)
def test_steps_of_scoring_that_do_not_go_together(small: str, problems: Problems, lines: str, said: str) -> None:
    (problem,) = problems(f"{small}[runs]\n{lines}\n")
    assert problem.partition(": ")[2].startswith(said)


ROOT = Path(__file__).resolve().parents[2]

AWKWARD = '''\
# [not.a.table]
top = 1
[a]
x = """
[no]
key = 2
""" # ]
y.z = [1, # one
  "two]", { q = 1 },
  [3.5, 2020-01-01T00:00:00Z] ]
"quoted = key" = 'a = [b'
lit = \'\'\'
[neither]
\'\'\'
[[s]]
n = "\\"1"
[s.w]
k = 1e3
[[s]]
n = "2"
[[s.f]]
u = 1
[[s.f]]
u = { v = [1], "w.w" = 2 }
'''


def leaves(value: object, path: KeyPath = ()) -> set[KeyPath]:
    """Paths of everything in a TOML document but its root."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return {p for key, inner in items for p in ({(*path, key)} | leaves(inner, (*path, key)))}


@pytest.mark.parametrize("text", [AWKWARD, *(p.read_text() for p in sorted(ROOT.glob("studies/*/study.toml")))])
def test_every_key_that_tomllib_finds_has_a_line(text: str) -> None:
    assert set(key_lines(text)) == leaves(tomllib.loads(text))


def test_awkward_lines() -> None:
    lines = key_lines(AWKWARD)
    assert lines["top",] == 2
    assert lines["a", "x"] == 4
    assert lines["a", "y", "z"] == 8
    assert lines["a", "y", "z", 1] == 9
    assert lines["a", "y", "z", 3, 1] == 10
    assert lines["a", "quoted = key"] == 11
    assert lines["s", 0, "w", "k"] == 18
    assert lines["s", 1] == 19
    assert lines["s", 1, "f", 1, "u", "w.w"] == 24


def test_a_missing_key_is_placed_at_its_table() -> None:
    lines = key_lines(AWKWARD)
    assert line_of(("s", 1, "stiffness"), lines) == 19
    assert line_of(("nowhere", "at", "all"), lines) == 1


KEYS = st.text("abc=#[]'. ", min_size=1, max_size=4)
VALUES = st.recursive(
    st.sampled_from(["1", "2.5", "true", '"a#]b"', "'}='", '"""x\n[y]\n"""', "1979-05-27"]),
    lambda inner: st.lists(inner, max_size=3).map(lambda items: "[\n" + ", # c\n".join(items) + "]"),
    max_leaves=6,
)


@given(st.dictionaries(KEYS, VALUES, min_size=1, max_size=5))
def test_keys_of_any_value_are_found_where_they_stand(table: dict[str, str]) -> None:
    text, expected = "", {}
    for key, value in table.items():
        expected[key,] = text.count("\n") + 1
        text += f'"{key}" = {value}\n'
    lines = key_lines(text)
    assert {path: line for path, line in lines.items() if len(path) == 1} == expected
    assert set(lines) == leaves(tomllib.loads(text))


def test_a_byte_order_mark_as_windows_writes_it_is_no_fault(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes(b"\xef\xbb\xbf[study]\r\nname = 'x'\r\n")
    assert read_toml(path, "a study file") == ("[study]\nname = 'x'\n", {"study": {"name": "x"}})


def test_dotted_keys_without_end_are_shown_as_what_they_are(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(f"title = [{{{'.'.join('a' * 5000)} = 1}}]\n")
    assert shown(read_toml(path, "a study file")[1]["title"]) == "tables within tables by the hundred"


@pytest.mark.parametrize("opening", ["[", "{a="])
@pytest.mark.parametrize("step", [9, pytest.param(1, marks=pytest.mark.slow)])
def test_no_depth_of_brackets_ends_in_anything_but_an_error_with_a_place(
    tmp_path: Path, opening: str, step: int
) -> None:
    path = tmp_path / "study.toml"
    closing = "]" if opening == "[" else "}"
    seen = set()
    for depth in range(250, 520, step):  # there is a depth that tomllib still reads, and the search for lines did not
        path.write_text("[study]\ny = " + opening * depth + "1" + closing * depth)
        try:
            text, _ = read_toml(path, "a study file")
        except StudyError as error:
            seen.add(str(error))
        else:
            seen.add(str(placed(path, text, ())))
    assert seen == {"", f"{path}: expected valid TOML, but found brackets within brackets by the hundred."}
