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
            ranks[name] = (not (resembles and near), name not in see, not names, not near, file.stat().st_size)
    return sorted(ranks, key=lambda name: ranks[name])[:FILES]


def _test_folder(tree: Path, module: PurePosixPath) -> str:
    """Folder of the tests of the module's package, or of the nearest package above it that has one."""
    parts = module.parts[1:-1] if module.parts[0] == "emg2vsa" else module.parts[:-1]
    while parts and not tree.joinpath("tests", *parts).is_dir():
        parts = parts[:-1]
    return "/".join(("tests", *parts, ""))
