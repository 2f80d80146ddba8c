"""Values of a TOML file changed in its text, so that comments, order and blank lines stay as their writer left them."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from emg2vsa.errors import SettingError
from emg2vsa.study_file.problems import KeyPath, shown, written
from emg2vsa.study_file.toml_file import key_lines, read_toml

_COMMENT = re.compile(r"""(?:"(?:\\.|[^"\\])*"|'[^']*'|[^#"'])*?(\s*\#.*)?$""")
"""The comment behind a value; a # within a text is none."""


def write_values(path: Path, values: Mapping[KeyPath, object]) -> None:
    """Set the keys of ``values`` in the file, and nothing else. SettingError as `edited`; StudyError for no TOML."""
    text, _ = read_toml(path, "a TOML file")
    for key, value in values.items():
        text = edited(text, key, value, path)
    write_text_atomic(path, text)


def edited(text: str, key: KeyPath, value: object, path: Path) -> str:
    """``text`` with ``value``, a number, text, truth value or list of these, at ``key``.

    Arrays of tables are counted: ("specimens", 1, "name"). SettingError where the key is not on lines of its own, as
    in an inline table: the whole file must read as before but for this value.
    """
    wanted = _with_value(tomllib.loads(text), key, value)
    lines, numbers = text.split("\n"), key_lines(text)
    line = f"{key[-1]} = {shown(value)}"
    try:
        if key in numbers:
            start = numbers[key] - 1
            end = _end_of_value(lines, start)
            head = lines[start][: lines[start].index("=") + 1].rstrip("= \t")
            comment = _COMMENT.match(lines[end])
            lines[start : end + 1] = [f"{head} = {shown(value)}{(comment and comment.group(1)) or ''}"]
        elif key[:-1] in numbers:
            lines.insert(numbers[key[:-1]], line)
        else:
            name = ".".join(str(part) for part in key[:-1])
            lines[-1:] = [*([lines[-1]] if lines[-1] else []), "", f"[{name}]", line, ""]
        changed = "\n".join(lines)
        if tomllib.loads(changed) == wanted:
            return changed
    except ValueError:
        pass
    do = "Write it there by hand."
    raise SettingError(f"{path}, {written(key)}", wanted="a key on a line of its own", found="another form", do=do)


def _end_of_value(lines: list[str], start: int) -> int:
    """Last line of the value that begins on line ``start``. ValueError where none makes it whole."""
    for end in range(start, len(lines)):
        try:
            tomllib.loads("\n".join(lines[start : end + 1]))
        except ValueError:
            continue
        return end
    raise ValueError("no whole value")


def _with_value(tables: dict[str, Any], key: KeyPath, value: object) -> dict[str, Any]:
    changed: Any = copy.deepcopy(tables)
    at = changed
    for part in key[:-1]:
        at = at[part] if isinstance(part, int) else at.setdefault(part, {})
    at[key[-1]] = list(value) if isinstance(value, tuple) else value
    return dict(changed)
