"""Files that an editor or ill will wrote."""

from __future__ import annotations

from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.study_file.problems import shown
from emg2vsa.study_file.toml_file import placed, read_toml


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
