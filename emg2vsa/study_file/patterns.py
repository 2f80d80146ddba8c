"""Recordings found by a pattern: ``{participant}`` and ``{specimen}`` by name, ``{repetition}`` by number.

A ``*`` stands for any text within one folder or file name. Whatever matches more than once is refused, never guessed.
"""

from __future__ import annotations

import glob
import os
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from emg2vsa.study_file.toml_file import beside

PLACEHOLDERS = ("participant", "specimen", "repetition")
REPETITION = "{repetition}"
PLACEHOLDER = re.compile(r"(\{(?:participant|specimen|repetition)\}|\*)")
_SHOWN = 4

Cell = tuple[str, str]
"""Participant and specimen."""


class Found(NamedTuple):
    """One file of a cell, as the study file would write it. fault : why it may be the wrong one; "" where it is not."""

    file: str
    fault: str = ""


def filled(pattern: str, cell: Cell) -> str:
    return pattern.replace("{participant}", cell[0]).replace("{specimen}", cell[1])


def is_searched(pattern: str) -> bool:
    """Whether files must be looked for, as the pattern leaves something open."""
    return "*" in pattern or REPETITION in pattern


def files_by_cell(folder: str | os.PathLike[str], pattern: str, cells: Iterable[Cell]) -> dict[Cell, dict[int, Found]]:
    """The files of every cell by repetition, in the order of these; 0 is that of a pattern without ``{repetition}``.

    A pattern that leaves nothing open names its files, whether they exist or not. A cell without any match has the
    pattern itself, which no file has as its name.
    """
    cells = list(cells)
    if not is_searched(pattern):
        return {cell: {0: Found(filled(pattern, cell))} for cell in cells}
    present = sorted(_present(folder, pattern))
    claimed = {cell: _claimed(filled(pattern, cell), present) for cell in cells}
    claimants: dict[str, list[Cell]] = {}
    for cell, files in claimed.items():
        for _, name in files:
            claimants.setdefault(name, []).append(cell)
    return {cell: _one_each(cell, claimed[cell], claimants) or {0: Found(filled(pattern, cell))} for cell in cells}


def _present(folder: str | os.PathLike[str], pattern: str) -> list[str]:
    """Files in the folder that may match for any cell, as the pattern would write them."""
    parts = PLACEHOLDER.split(pattern)
    search = "".join("*" if index % 2 else glob.escape(text) for index, text in enumerate(parts))
    base = str(beside(folder, ""))  # type: ignore[arg-type]
    found = glob.glob(search) if os.path.isabs(pattern) else glob.glob(search, root_dir=base)
    return [name.replace(os.sep, "/") for name in found if os.path.isfile(os.path.join(base, name))]


def _claimed(pattern: str, present: list[str]) -> list[tuple[int, str]]:
    """(repetition, file) of what a cell's pattern matches. present : sorted, so that few are looked at."""
    parts = PLACEHOLDER.split(pattern)
    texts = {"*": "[^/]*", REPETITION: "([0-9]+)"}
    first = True
    expression = ""
    for index, text in enumerate(parts):
        if index % 2 == 0:
            expression += re.escape(text)
        elif text == REPETITION and not first:
            expression += r"\1"  # the same number again, in a folder's name and in the file's
        else:
            expression += texts.get(text, "")
            first = first and text != REPETITION
    start, size = parts[0], len(parts[0])
    names = present[bisect_left(present, start) : bisect_right(present, start, key=lambda name: name[:size])]
    matches = ((re.fullmatch(expression, name), name) for name in names)
    return [(int(match[1]) if match.re.groups else 0, name) for match, name in matches if match]


def _one_each(cell: Cell, claimed: list[tuple[int, str]], claimants: Mapping[str, list[Cell]]) -> dict[int, Found]:
    """The file of each repetition of a cell. claimants : file to all cells whose patterns match it."""
    found: dict[int, Found] = {}
    for repetition in sorted({number for number, _ in claimed}):
        names = [name for number, name in claimed if number == repetition]
        others = ["/".join(other) for other in claimants[names[0]] if other != cell]
        fault = ""
        if len(names) > 1:
            shown = [os.path.basename(name) for name in names[:_SHOWN]]
            fault = f"{len(names)} files, {', '.join(shown)}{', ...' if len(names) > _SHOWN else ''}"
        elif others:
            fault = f"{os.path.basename(names[0])}, which matches for {' and '.join(others)} too"
        found[repetition] = Found(names[0], fault)
    return found
