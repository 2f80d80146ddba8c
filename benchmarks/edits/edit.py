"""Random edits of a copy of the program, what is stale by each, and what a stage of a study runs."""

from __future__ import annotations

import ast
import json
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import emg2vsa

PRODUCT = Path(emg2vsa.__file__).parent.parent
PACKAGES = ("emg2vsa", "casr")
_STALE = """
import json, sys
from pathlib import Path
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER
from emg2vsa.study_file import load_study
Code._refuse_old = lambda *_: None  # a module edited after it was loaded counts as an edit: no step runs here
for line in sys.stdin:
    file, text = json.loads(line)
    path, before = Path(file), Path(file).read_bytes()
    path.write_text(text)
    plan = survey(load_study(sys.argv[1]), ORDER, print, asked=ORDER)
    path.write_bytes(before)
    print(json.dumps(sorted({s.stage for s in plan.steps.values() if s.status == "stale"})), flush=True)
"""


def copy_of_product(folder: Path) -> Path:
    """The two packages, copied into ``folder``."""
    for package in PACKAGES:
        shutil.copytree(PRODUCT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def file_of(root: Path, module: str) -> Path:
    """The file of a module below ``root``."""
    base = root.joinpath(*module.split("."))
    return base.with_suffix(".py") if base.with_suffix(".py").is_file() else base / "__init__.py"


def stale_after(copy: Path, study: Path, edits: Sequence[tuple[str, str]]) -> list[set[str]]:
    """Stages of a finished study that are stale by each of the edits alone. edits : module, and its text."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(copy), *sys.path])}
    sent = "".join(json.dumps([str(file_of(copy, module)), text]) + "\n" for module, text in edits)
    program = [sys.executable, "-c", _STALE, str(study)]
    done = subprocess.run(program, input=sent, capture_output=True, text=True, env=environment, check=False, cwd=copy)
    assert done.returncode == 0, done.stderr
    return [set(json.loads(line)) for line in done.stdout.splitlines()]


def trace(study: Path, steps: dict[str, str], out: Path) -> None:
    """Run the step of each stage once more, and write what it did, as ``trace_step`` says. steps : stage to item."""
    out.mkdir(parents=True)
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": os.pathsep.join([str(PRODUCT), *sys.path])}
    script = [sys.executable, str(Path(__file__).with_name("trace_step.py")), str(study), str(out)]
    script += map("/".join, steps.items())
    done = subprocess.run(script, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr


def edited(path: Path, draw: random.Random) -> str | None:
    """The source with one number or one operator changed; None where it has none."""
    text = path.read_text()
    lines = text.splitlines(keepends=True)
    places = []
    for node in ast.walk(ast.parse(text)):
        line = lines[node.lineno - 1] if isinstance(node, ast.expr) else ""
        if not line.isascii():  # columns of the parser count bytes
            continue
        if isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.lineno == node.end_lineno:
            places.append((node.lineno - 1, node.col_offset, node.end_col_offset or 0, f"{node.value + 1!r}"))  # type: ignore[operator]
        if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
            sign, other = ("+", "-") if isinstance(node.op, ast.Add) else ("-", "+")
            at = line.find(sign, node.left.end_col_offset) if node.left.end_lineno == node.lineno else -1
            places += [(node.lineno - 1, at, at + 1, other)] if at >= 0 else []
    if not places:
        return None
    line_number, first, last, new = draw.choice(sorted(places))
    lines[line_number] = lines[line_number][:first] + new + lines[line_number][last:]
    return "".join(lines)


def in_prose(path: Path, draw: random.Random) -> str:
    """The source with a comment or a blank line more, or a word more in its docstring."""
    text = path.read_text()
    lines = text.splitlines(keepends=True)
    starts = [node.lineno - 1 for node in ast.walk(ast.parse(text)) if isinstance(node, ast.stmt)] or [0]
    at = draw.choice(starts)
    kind = draw.choice(("comment", "blank line", "docstring"))
    if kind == "docstring" and text.startswith('"""'):
        return f'"""Truly: {text[3:]}'
    indent = lines[at][: len(lines[at]) - len(lines[at].lstrip())] if lines else ""
    return "".join([*lines[:at], "\n" if kind == "blank line" else f"{indent}# as ever\n", *lines[at:]])
