"""Lines of keys, against tomllib for which keys there are and against the text for where they stand."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.study_file.problems import KeyPath
from emg2vsa.study_file.toml_file import key_lines, line_of

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
