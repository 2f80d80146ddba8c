"""Which test files see a line, nearest first."""

from __future__ import annotations

from bisect import bisect_right
from pathlib import Path, PurePosixPath

import coverage

FILES = 10
"""Test files run against one mutant, at most."""

LineMap = dict[str, dict[int, frozenset[str]]]
"""For each source file (path in the tree), the test files that executed each of its lines."""


def files_for(tree: Path, module: str, line: int, lines: LineMap) -> list[str]:
    """Test files of ``tree`` for a mutant in ``line`` of ``module``: at most ``FILES``.

    Files that execute the line, then those that name the module, then the rest of its package's tests; among equals
    those whose name and folder resemble the module's. Child processes leave no trace in the map: hence the last two.
    """
    known = lines.get(module, {})
    executed = sorted(known)
    at = bisect_right(executed, line)
    see = known[executed[at - 1]] if at else frozenset()
    if not see:  # run by an import: whatever executes any of the module
        see = frozenset().union(*known.values()) if known else see
    path = PurePosixPath(module)
    named = ".".join(path.with_suffix("").parts).removesuffix(".__init__")
    words = [named, f"import {path.stem}\n"] + [f'"{path.stem}"'] * (
        "cli" in path.parts
    )  # a command is called by its name
    folder = _test_folder(tree, path)
    ranks = {}
    for file in sorted((tree / "tests").rglob("test_*.py")):
        name = file.relative_to(tree).as_posix()
        text = file.read_text(encoding="utf-8")
        names, near = any(word in text for word in words), name.startswith(folder)
        if name in see or names or near:
            resembles = path.stem.strip("_") in file.stem
            size = file.stat().st_size * (1 if name in see else -1)  # a guess is best made with much
            ranks[name] = (not (resembles and near), name not in see, not names, not near, size)
    return sorted(ranks, key=lambda name: ranks[name])[:FILES]


def _test_folder(tree: Path, module: PurePosixPath) -> str:
    """Folder of the tests of the module's package, or of the nearest package above it that has one."""
    parts = module.parts[1:-1] if module.parts[0] == "emg2vsa" else module.parts[:-1]
    while parts and not tree.joinpath("tests", *parts).is_dir():
        parts = parts[:-1]
    return "/".join(("tests", *parts, ""))


def read_line_map(folder: Path) -> LineMap:
    """The map in ``folder``. Raises FileNotFoundError if it holds no coverage file."""
    parts = sorted(folder.glob(".coverage.*"))
    if not parts:
        raise FileNotFoundError(
            f"{folder}: expected coverage files of a run with benchmarks.mutation.line_map, but found none. "
            "Make them as its first lines say."
        )
    lines: LineMap = {}
    for part in parts:
        data = coverage.CoverageData(basename=str(part))
        data.read()
        for file in data.measured_files():
            known = lines.setdefault(_in_tree(file), {})
            for line, contexts in data.contexts_by_lineno(file).items():
                known[line] = known.get(line, frozenset()) | {name for name in contexts if name}
    return lines


def _in_tree(file: str) -> str:
    parts = Path(file).parts
    package = max(i for i, part in enumerate(parts) if part in ("emg2vsa", "casr") and "." not in part)
    return "/".join(parts[package:])
