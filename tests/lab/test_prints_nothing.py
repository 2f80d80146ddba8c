"""The functions of the laboratory know no terminal: who calls them says what becomes of each line."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import emg2vsa.lab

MODULES = sorted(Path(emg2vsa.lab.__file__).parent.glob("**/*.py"))


def told_to_a_terminal(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Name(id="print" | "input") | ast.Attribute(attr="stdout" | "stderr" | "stdin"):
                yield f"line {node.lineno}"
            case ast.Import(names=names) if any(name.name in ("argparse", "sys") for name in names):
                yield f"line {node.lineno}"
            case ast.ImportFrom(module="argparse" | "sys" | "casr.command_line" | "casr.terminal"):
                yield f"line {node.lineno}"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_a_module_of_the_laboratory_prints_nothing(path: Path) -> None:
    assert list(told_to_a_terminal(ast.parse(path.read_text(encoding="utf-8")))) == []


@pytest.mark.parametrize("code", ["print(1)", "say = print", "import argparse", "from sys import stderr", "sys.stdout"])
def test_the_check_finds_what_it_looks_for(code: str) -> None:
    assert list(told_to_a_terminal(ast.parse(code))) == ["line 1"]
