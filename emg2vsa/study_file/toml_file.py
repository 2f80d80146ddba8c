"""A TOML file as text and tables; what is wrong with either, said with its line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from emg2vsa.errors import StudyError
from emg2vsa.study_file.lines import key_lines, line_of
from emg2vsa.study_file.problems import Problem


def read_toml(path: Path, what: str) -> tuple[str, dict[str, Any]]:
    """Text and tables of ``path``. StudyError when there is no ``what`` ("a study file") to read, or it is no TOML."""
    try:
        # line ends as TOML counts them, whatever the editor wrote
        text = path.read_bytes().decode("utf-8").replace("\r\n", "\n")
    except OSError as error:
        raise StudyError((f"{path}: wanted {what}; found none to read ({error.strerror}).",)) from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise StudyError(
            (f"{path}:{line}: wanted UTF-8 text; found byte 0x{error.object[error.start]:02x}.",)
        ) from None
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, _, at = str(error).rpartition(" (at ")
        digits = re.findall(r"\d+", at) or [str(text.count("\n") + 1)]
        raise StudyError((f"{path}:{':'.join(digits)}: wanted valid TOML; found: {what}.",)) from None


def placed(path: Path, text: str, problems: Iterable[Problem]) -> StudyError:
    """The error that lists all problems of a file, in the order of its lines."""
    lines = key_lines(text)
    by_line = sorted(((line_of(p.path, lines), str(p)) for p in problems), key=lambda item: item[0])
    return StudyError(tuple(f"{path}:{line}: {problem}" for line, problem in by_line))
