"""A specimen pressed by a testing machine, as text: lines on the test, a header row, perhaps a row of units, the table.

``Compression (mm)``, ``Load [N]``, ``force_n``, or the units in the row beneath; what has no unit is asked for.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.readers.text_file import WHITESPACE, Dialect, Line, open_text
from emg2vsa.readers.tidy_table import TidyTable, table_below
from emg2vsa.readers.units import canonical, si_factor

_SEARCHED = 200
"""Lines within which the header row is looked for."""
_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "in": 25.4, "inch": 25.4}
_NAMES = {
    "depth": r"(compressive |crosshead )?(indentation|compression|displacement|extension|depth|travel|stroke|position)",
    "force": r"(compressive |standard )?(force|load)|fz",
}
_UNIT = re.compile(r"(.*?)(?:\s*[\[(]([^\[\]()]*)[\])]|_([a-zµμ]+))?", re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?\d*[.,]?\d+(e[+-]?\d+)?", re.IGNORECASE)
_STATED = re.compile(r'"?([^:;,\t="]+)"?[:;,\t=]"?([^"]*)"?')
_SAMPLE = re.compile(r"(specimen|sample)( (name|id|label))?", re.IGNORECASE)
_REPEAT = re.compile(r"(.+?)(?:[ _-]([A-Z]{1,2}|\w))?[ _-]sample[ _-]?(\w+)")
_TOOL = re.compile(r"plate|platen|probe|punch|indenter", re.IGNORECASE)
"""Whose diameter is not the specimen's."""
_SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0}


@dataclass(frozen=True, eq=False)
class PressTable:
    """table : as written. depth_mm, force_n : (n,), NaN where blank. time_s : likewise, where a column with a unit has
    it. specimen, casting, trial : as the lines on the test name the sample (``X_A_sample_3``), else None. diameter_mm,
    height_mm : of a cylinder, where they are stated with their unit."""

    table: TidyTable
    depth_mm: Floats
    force_n: Floats
    time_s: Floats | None
    specimen: str | None
    casting: str | None
    trial: str | None
    diameter_mm: float | None
    height_mm: float | None


def read_press_table(path: Path, depth: str = "", force: str = "") -> PressTable:
    """Read the file. depth, force : names of the columns with their units where the file says neither clearly.

    DataError : no header row, several columns to choose from, or a column without a unit.
    """
    asked = {"depth": depth, "force": force}
    named = {kind: _split(label)[0] if label else "" for kind, label in asked.items()}
    text = open_text(path)
    above: list[str] = []
    head = list(islice((line for line in text.lines() if line.text.strip()), _SEARCHED))
    for i, header in enumerate(head):
        if columns := _columns_of(header, head[i + 1 : i + 3], named):
            break
        above.append(header.text)
    else:
        shown = " ".join(above[0].split()) if above else "an empty file"
        wanted = " and ".join(named[kind] or kind for kind in _NAMES)
        wanted += "" if any(named.values()) else ", such as indentation_mm and force_n"
        raise DataError(
            path, wanted=f"a header row that names {wanted}",
            found=f"none in {len(above)} lines; the first is {shown[:60]!r}",
            do='Name the columns in the file, or say --depth "Travel (mm)" --force "Load (N)" with the names it has.',
        )  # fmt: skip
    lines = text.filled_lines(text.data.count(b"\n") + text.data.count(b"\r") + 1, header.start, header.number)
    places, separator = columns
    beneath = Dialect(separator, ".").split(lines[1].text) if len(lines) > 1 else []
    units = not any(map(_NUMBER.fullmatch, beneath)) and any(_split(f"x {cell}")[1] or _known(cell) for cell in beneath)
    table = table_below(path, text, [lines[0], *lines[2:]] if units else lines)
    found = {}
    for kind, names in places.items():
        name = _one(path, header, kind, names)
        cell = beneath[table.names.index(name)] if units and table.names.index(name) < len(beneath) else ""
        unit = _split(asked[kind])[1] or _split(name)[1] or cell.strip("()[] ")
        found[kind] = _numbers(table, name) * _factor(path, header, kind, name, unit)
    matches = (_STATED.fullmatch(line.rstrip(";,\t ")) for line in above)
    stated: dict[str, str] = {match[1]: match[2] for match in matches if match}
    sample = next((value.strip() for key, value in stated.items() if _SAMPLE.fullmatch(key.strip())), "")
    sample = sample or next((line.strip(';,\t "') for line in above if _REPEAT.fullmatch(line.strip(';,\t "'))), "")
    of_several = _REPEAT.fullmatch(sample)
    specimen, casting, trial = of_several.groups() if of_several else (sample or None, None, None)
    return PressTable(
        table, found["depth"], found["force"], _time(table, beneath if units else []), specimen, casting, trial,
        _length(stated, "diameter"), _length(stated, "height"),
    )  # fmt: skip


def _columns_of(
    line: Line, beneath: Sequence[Line], named: Mapping[str, str]
) -> tuple[dict[str, list[str]], str] | None:
    """Names in this line for depth and for force, and what separates them; None where one of both is not there.

    Prose may hold both words: as many cells, numbers among them, follow a header within two lines.
    """
    for separator in (";", "\t", ",", WHITESPACE):
        cells, *rows = (Dialect(separator, ".").split(each.text) for each in (line, *beneath))
        found = {kind: [cell for cell in cells if _means(cell, kind, named[kind])] for kind in _NAMES}
        filled = any(len(row) >= len(cells) - 1 and any(map(_NUMBER.fullmatch, row)) for row in rows)
        if all(found.values()) and (filled or not beneath):
            return found, separator
    return None


def _means(cell: str, kind: str, named: str) -> bool:
    """Whether the column is the one asked for, or has a name that says depth or force."""
    name = _split(cell)[0]
    return named in (name, cell) if named else re.fullmatch(_NAMES[kind], name, re.IGNORECASE) is not None


def _split(label: str) -> tuple[str, str]:
    """``"Load [N]"`` and ``"Load_N"`` -> ("Load", "N"); without a unit ("Load", "")."""
    match = _UNIT.fullmatch(label.strip())
    if match is None:
        return label.strip(), ""
    in_brackets, behind = canonical(match[2] or ""), canonical(match[3] or "")
    if behind and not _known(behind):
        return label.strip(), ""
    return match[1].strip(), in_brackets or behind


def _known(unit: str) -> float | None:
    """Newtons or millimetres in a unit of force or length; ``n``, ``mn`` and ``kn`` are written in names."""
    text = canonical(unit).strip("()[] ")
    newtons = si_factor({"n": "N", "mn": "mN", "kn": "kN"}.get(text, text))
    return newtons[1] if newtons and newtons[0] == "N" else _MM.get(text)


def _one(path: Path, header: Line, kind: str, names: Sequence[str]) -> str:
    plain = {"depth": "indentation_mm", "force": "force_n"}[kind]
    if len(names) == 1 or plain in names:
        return names[0] if len(names) == 1 else plain
    raise DataError(
        f"{path}, line {header.number}", wanted=f"one column of {kind}", found=" and ".join(map(repr, names)),
        do=f'Say which: --{kind} "{names[0]}".',
    )  # fmt: skip


def _factor(path: Path, header: Line, kind: str, name: str, unit: str) -> float:
    factor, example = _known(unit), {"depth": "mm", "force": "N"}[kind]
    if factor is not None and (kind == "depth") == (canonical(unit) in _MM):
        return factor
    plain = {"depth": "indentation_mm", "force": "force_n"}[kind]
    if canonical(unit) in ("kg", "g"):
        do = "Convert it to newtons: 9.80665 N a kilogram."
        where = f"{path}, line {header.number}, column {name!r}"
        raise DataError(where, wanted="a unit of force, such as N", found=f"a mass, {unit!r}", do=do)
    raise DataError(
        f"{path}, line {header.number}, column {name!r}", wanted=f"a unit of {kind}, such as {example}",
        found=repr(unit) if unit else "none",
        do=f'Say --{kind} "{_split(name)[0]} ({example})" if it is that, or name the column {plain}.',
    )  # fmt: skip


def _numbers(table: TidyTable, name: str) -> Floats:
    return np.array([np.nan if value is None else float(value) for value in table.numbers(name)])


def _time(table: TidyTable, beneath: Sequence[str]) -> Floats | None:
    """Seconds; None where no column is named so, or none of these has a unit of time."""
    for place, label in enumerate(table.names):
        match = _UNIT.fullmatch(label.strip())
        cell = beneath[place].strip("()[] ") if place < len(beneath) else ""
        unit = (match[2] or match[3] or cell) if match else cell
        if match and re.fullmatch(r"(\w+ )?time", match[1].strip(), re.IGNORECASE) and unit in _SECONDS:
            return _numbers(table, label) * _SECONDS[unit]
    return None


def _length(stated: Mapping[str, str], word: str) -> float | None:
    """Length in ``Cylinder Height: 30mm`` or ``Height (mm): 30``, millimetres; None where number or unit is missing."""
    for key, value in stated.items():
        name, unit = _split(key)
        match = re.fullmatch(r"(\d+[.,]?\d*)\s*([a-zµμ]*)", value.strip(), re.IGNORECASE)
        own = word in name.lower() and not _TOOL.search(name)
        if own and match and (factor := _MM.get(canonical(match[2] or unit))):
            return float(match[1].replace(",", ".")) * factor or None
    return None
