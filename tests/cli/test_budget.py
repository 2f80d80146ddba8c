"""The command line stays thin: verbs parse, call and print; what they do is in the packages below."""

from __future__ import annotations

import ast
from pathlib import Path

import casr
import emg2vsa

LONGEST = 46


def test_no_verb_is_long() -> None:
    files = [path for package in (casr, emg2vsa) for path in Path(str(package.__file__)).parent.glob("cli/**/*.py")]
    functions = [
        (path.name, node.name, (node.end_lineno or 0) - node.lineno + 1)
        for path in files
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    ]
    assert len(functions) > 100
    assert [each for each in functions if each[2] > LONGEST] == []
