"""What options take: how the text of a value is read, by the word that stands for it in the help."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from casr.plugins import plugins

ENGINES = ("pin-affine", "horn-schunck", "dis")
"Written out once more, because the module that owns them loads NumPy; a test compares them."


class Engines:
    """Names of engines for argparse; those of other installed packages are looked up when ours do not do."""

    def __contains__(self, name: object) -> bool:
        return name in ENGINES or name in tuple(self)

    def __iter__(self) -> Iterator[str]:
        yield from ENGINES
        yield from (plugin.name for plugin in plugins("casr.flow_engines") if plugin.name not in ENGINES)


def _refused(wanted: str, text: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"expected {wanted}, but found {text!r}")


def numbers(text: str, count: int | None = None) -> tuple[float, ...]:
    """Finite numbers between commas."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if not found or (count is not None and len(found) != count) or any(x - x != 0 for x in found):
        wanted = f"{count} numbers" if count else "numbers"
        raise _refused(f"{wanted} with commas between them", text)
    return found


def number(text: str) -> float:
    """A finite number."""
    return numbers(text, 1)[0]


def positive(text: str) -> float:
    """A number above 0."""
    if (value := number(text)) <= 0:
        raise _refused("a number above 0", text)
    return value


def not_negative(text: str) -> float:
    """A number from 0."""
    if (value := number(text)) < 0:
        raise _refused("a number from 0", text)
    return value


def count(text: str) -> int:
    """A whole number from 0."""
    if not text.isdecimal():
        raise _refused("a whole number from 0", text)
    return int(text)


def frame_pair(text: str) -> tuple[int, int]:
    """``"0,12"``: two different frame indices."""
    first, second = numbers(text, 2)
    if first == second or min(first, second) < 0 or not (first.is_integer() and second.is_integer()):
        raise _refused("two different frame numbers from 0, such as 0,12", text)
    return int(first), int(second)


def grid(text: str) -> tuple[int, int]:
    """``"9x7"``."""
    columns, _, rows = text.lower().partition("x")
    if not (columns.isdecimal() and rows.isdecimal()):
        raise _refused("columns and rows such as 9x7", text)
    return int(columns), int(rows)


def names(text: str) -> tuple[str, ...]:
    """Names with commas between them, each once."""
    return tuple(dict.fromkeys(part.strip() for part in text.split(",")))


def _file(suffix: str) -> Callable[[str], Path]:
    def read(text: str) -> Path:
        if not text.lower().endswith(suffix):
            raise _refused(f"a file name that ends in {suffix}", text)
        return Path(text)

    return read


TYPES: Mapping[str, Any] = {
    **dict.fromkeys(("N", "PX", "PX2", "MM", "GREY", "SECONDS", "HZ"), positive),
    "RMS": not_negative, "DEGREES": numbers, "NAMES": names, "I,J": frame_pair, "COLUMNSxROWS": grid,
    "FILE.html": _file(".html"), "FILE.csv": _file(".csv"), "FOLDER": str,
    **dict.fromkeys(("PICTURE", "PICTURES", "PRESS"), Path),
}  # fmt: skip
"What makes a value from its text, by the word that stands for it in the help."
