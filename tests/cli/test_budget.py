"""The command line stays thin: verbs parse, call and print; what they do is in the packages below."""

from __future__ import annotations

import ast
from pathlib import Path

import casr
import emg2vsa

LONGEST_FUNCTION, LONGEST_FILE, MOST_OF_EMG2VSA, MOST_IN_ALL = 46, 240, 2700, 4400
KIT = ("command_line.py", "completion.py", "terminal.py")
CASR, EMG2VSA = Path(casr.__file__).parent, Path(emg2vsa.__file__).parent
FILES = [path for package in (CASR, EMG2VSA) for path in (package / "cli").rglob("*.py")]


def lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def test_no_verb_and_no_file_is_long() -> None:
    assert {str(path): lines(path) for path in FILES if lines(path) > LONGEST_FILE} == {}
    functions = [
        (path.name, node.name, node.end_lineno - node.lineno + 1)
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.end_lineno is not None
    ]
    assert [each for each in functions if each[2] > LONGEST_FUNCTION] == []


def test_the_command_line_is_short() -> None:
    own, theirs = (sum(map(lines, (package / "cli").rglob("*.py"))) for package in (EMG2VSA, CASR))
    assert own <= MOST_OF_EMG2VSA
    assert own + theirs + sum(lines(CASR / name) for name in KIT) <= MOST_IN_ALL
