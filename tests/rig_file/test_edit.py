"""One value changed in the text of a TOML file, and nothing else."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from emg2vsa.errors import SettingError
from emg2vsa.rig_file.edit import edited, write_values

TEXT = """\
# the rig
[rig]
push_sign = 1 # -1 where smaller angles push
push_axis = [
  0, 0, 1, # down
] # of the sensor
label = "a # b" # text

[rig.guards]
force_n = 10

[[specimens]]
name = "S1"

[[specimens]]
name = "S2"   # soft
"""


def test_the_value_changes_and_the_comment_stays() -> None:
    changed = edited(TEXT, ("rig", "push_sign"), -1, Path("rig.toml"))
    assert changed == TEXT.replace("push_sign = 1 #", "push_sign = -1 #")


def test_an_array_over_lines_becomes_one_line() -> None:
    changed = edited(TEXT, ("rig", "push_axis"), (1.0, 0.0, 0.0), Path("rig.toml"))
    assert "push_axis = [1.0, 0.0, 0.0] # of the sensor\nlabel" in changed


def test_a_mark_of_comment_within_a_text_is_none() -> None:
    changed = edited(TEXT, ("rig", "label"), "c", Path("rig.toml"))
    assert 'label = "c" # text\n' in changed


def test_a_key_that_is_not_there_comes_under_its_table() -> None:
    changed = edited(TEXT, ("rig", "guards", "late_s"), 0.1, Path("rig.toml"))
    assert "[rig.guards]\nlate_s = 0.1\nforce_n = 10\n" in changed
    changed = edited(TEXT, ("camera", "source"), 2, Path("rig.toml"))
    assert tomllib.loads(changed)["camera"] == {"source": 2}


def test_a_table_of_an_array_is_counted() -> None:
    changed = edited(TEXT, ("specimens", 1, "stiffness_n_per_mm"), 3.35, Path("study.toml"))
    assert tomllib.loads(changed)["specimens"] == [{"name": "S1"}, {"name": "S2", "stiffness_n_per_mm": 3.35}]
    assert 'name = "S2"   # soft\n' in changed


def test_a_key_in_quotation_marks_is_found() -> None:
    changed = edited("[rig]\n'push_sign' = 1\nx = 2\n", ("rig", "push_sign"), -1, Path("rig.toml"))
    assert tomllib.loads(changed)["rig"] == {"push_sign": -1, "x": 2}


def test_an_inline_table_is_refused() -> None:
    form = "rig = { push_sign = 1, home_deg = 3 }\n"
    with pytest.raises(
        SettingError,
        match=r"rig.push_sign: expected a key on a line of its own, but found another "
        r"form",
    ):
        edited(form, ("rig", "push_sign"), -1, Path("rig.toml"))


def test_the_file_is_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(TEXT)
    write_values(path, {("rig", "push_sign"): -1, ("rig", "home_deg"): -3.25})
    assert tomllib.loads(path.read_text())["rig"]["home_deg"] == -3.25
    assert path.read_text().count("#") == TEXT.count("#")
