"""Published against recomputed: which numbers agree, exactly or within what other processors may change."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

from emg2vsa.report.numbers import Quantity, macro_names, numbers_tex

TOLERANCES = (
    ("runs.*", 1e-2),
    ("contrast.frame_sum.*", 1e-2),
    ("contrast.*", 1e-4),
    ("claims.*", 1e-2),
    ("stiffness.*", 1e-6),
    ("*", 1e-9),
)
"""Pattern of keys to the largest relative difference that another processor may make; the first that fits counts.

Measured over instruction sets of NumPy, OpenBLAS, OpenCV and libm: docs/decisions/0031-processors.md."""
OF_RUNS, OF_PEOPLE = 1e-2, 1e-9
"Tolerances of the cells of tables."

Value = str | int | float | bool | None
Quantities = Mapping[str, Value]


@dataclass(frozen=True)
class Difference:
    """One number that does not agree. where : its key, or file and place. tolerance : None where words differ."""

    where: str
    published: Value
    recomputed: Value
    relative: float | None = None
    tolerance: float | None = None

    def __str__(self) -> str:
        said = f"{self.where}: published {_shown(self.published)}, recomputed {_shown(self.recomputed)}"
        if self.relative is None or self.tolerance is None:
            return said
        return f"{said}, relative difference {self.relative:.2g}, tolerance {self.tolerance:g}"


class _Absent(str):
    """Says that there is no such number; no text that a report may hold is one."""


ABSENT = _Absent("nothing")


def _shown(value: Value) -> str:
    if isinstance(value, _Absent):
        return str(value)
    return "not defined" if value is None else json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True)
class Agreement:
    """exact, within : how many agree to the last digit, and within the tolerance. differ : those that do not."""

    exact: int
    within: int
    differ: tuple[Difference, ...]


def tolerance_of(key: str) -> float:
    """Largest relative difference of the number ``key`` between processors."""
    return next(relative for pattern, relative in TOLERANCES if fnmatchcase(key, pattern))


def relative_difference(one: Value, other: Value) -> float | None:
    """Difference of two numbers relative to the larger; None where either is none, or not defined."""
    if not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in (one, other)):
        return None
    a, b = float(one), float(other)  # type: ignore[arg-type]
    if a == b:
        return 0.0
    largest = max(abs(a), abs(b))
    return abs(a - b) / largest if math.isfinite(largest) else None


def compared(published: Quantities, recomputed: Quantities, keys: Iterable[str]) -> Agreement:
    """The numbers ``keys`` of two ``results.json``."""
    exact, within, differ = 0, 0, []
    for key in keys:
        ours, theirs = recomputed.get(key, ABSENT), published.get(key, ABSENT)
        if _same(theirs, ours):
            exact += 1
            continue
        relative, tolerance = relative_difference(theirs, ours), tolerance_of(key)
        if relative is not None and relative <= tolerance:
            within += 1
        else:
            differ.append(Difference(key, theirs, ours, relative, None if relative is None else tolerance))
    return Agreement(exact, within, tuple(differ))


def _same(one: Value, other: Value) -> bool:
    """Equal, and of one kind: true is not 1."""
    return one == other and isinstance(one, bool) == isinstance(other, bool) and (one is None) == (other is None)


_MACRO = re.compile(r"^\\newcommand\{\\(\w+)\}(.*) % (.+)$", re.M)


def restated_macros(published: Quantities, text: str) -> Iterator[Difference]:
    """Lines of ``numbers.tex`` that do not say what ``results.json`` says."""
    wanted = {key: line for _, line, key in _MACRO.findall(numbers_tex(_quantities(published)))}
    found = {key: (name, line) for name, line, key in _MACRO.findall(text)}
    names = macro_names(sorted(wanted))
    for key in sorted(wanted.keys() | found.keys()):
        name, line = found.get(key, ("", ABSENT))
        expected = wanted.get(key, ABSENT)
        if line != expected or name != names.get(key):
            yield Difference(f"numbers.tex: \\{name or names[key]}", line, expected)


def _quantities(published: Quantities) -> dict[str, Quantity]:
    """The numbers as the report had them, before JSON wrote them."""
    return {key: math.nan if v is None else float(v) if v in ("inf", "-inf") else v for key, v in published.items()}


def restated_list(published: Quantities, text: str) -> Iterator[Difference]:
    """Rows of ``results.csv`` that do not say what ``results.json`` says."""
    found = {row.get("key") or "": row.get("value") for row in csv.DictReader(io.StringIO(text))}
    for key in sorted(published.keys() | found.keys()):
        value = published.get(key, ABSENT)
        wanted = "" if value is None else value if isinstance(value, str) else json.dumps(value)
        if found.get(key, ABSENT) != wanted:
            yield Difference(f"results.csv: {key}", found.get(key, ABSENT), wanted)


_WORD = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[^\d]+?(?=[+-]?\.?\d|$)", re.S)


def compared_texts(name: str, published: str, recomputed: str, tolerance: float, *, exact: bool) -> Agreement:
    """Two files of the same lines: words are the same, numbers agree.

    exact : all that the files tell of is equal. Otherwise a rounded number, which is one in LaTeX or in a sentence,
    may differ by one in its last digit: numbers that agree may round either way.
    """
    equal, within, differ = 0, 0, []
    theirs, ours = _lines(published), _lines(recomputed)
    for place in range(max(len(theirs), len(ours))):
        one, other = (lines[place] if place < len(lines) else ABSENT for lines in (theirs, ours))
        odd = _odd_cell(_cells(name, one), _cells(name, other), tolerance, exact)
        if one == other:
            equal += 1
        elif odd is None:
            within += 1
        else:
            shown = [cell if isinstance(cell, _Absent) else _number(cell) for cell in odd]
            relative = relative_difference(*shown)
            allowed = None if relative is None else tolerance
            differ.append(Difference(f"{name}, line {place + 1}", shown[0], shown[1], relative, allowed))
    return Agreement(equal, within, tuple(differ))


def _lines(text: str) -> list[str]:
    """The lines; those of provenance, which hold digests, are empty."""
    return ["" if line.startswith(("# provenance:", "# sha256:")) else line for line in text.splitlines()]


def _cells(name: str, line: str) -> list[str]:
    if isinstance(line, _Absent) or not name.endswith(".csv") or line.startswith("#"):
        return [line]
    return next(csv.reader([line]), [])


def _odd_cell(published: list[str], recomputed: list[str], tolerance: float, exact: bool) -> tuple[str, str] | None:
    """The first two cells that do not agree."""
    if len(published) != len(recomputed):
        return ",".join(published), ",".join(recomputed)
    pairs = zip(published, recomputed, strict=True)
    return next((pair for pair in pairs if not _alike(*pair, tolerance, exact)), None)


def _alike(one: str, other: str, tolerance: float, exact: bool) -> bool:
    if isinstance(one, _Absent) or isinstance(other, _Absent):
        return False
    whole = relative_difference(_number(one), _number(other))
    if whole is not None:
        return whole <= tolerance
    words = _WORD.findall(one), _WORD.findall(other)
    pairs = zip(*words, strict=False)
    return len(words[0]) == len(words[1]) and all(_agree(a, b, tolerance, exact) for a, b in pairs)


def _agree(one: str, other: str, tolerance: float, exact: bool) -> bool:
    relative = 0.0 if one == other else relative_difference(_number(one), _number(other))
    if relative is None or relative <= tolerance:
        return relative is not None
    return not exact and abs(float(one) - float(other)) <= 1.0001 * max(map(_last_digit, (one, other)))


def _number(text: str) -> Value:
    try:
        return float(text)
    except ValueError:
        return text


def _last_digit(text: str) -> float:
    """The value of one in the last digit of a number as it is written."""
    digits, _, power = text.lower().partition("e")
    return float(10.0 ** (int(power or 0) - len(digits.partition(".")[2])))
