"""What options take: kinds of values with the name they have in the help, and how their text is read."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from casr.command_line import whole_number
from casr.plugins import plugins

ENGINES = ("pin-affine", "horn-schunck", "dis")
AREA_RULES = ("edge", "hexagon", "circle", "paper")
FORCE_RULES = ("exposure", "mean")
QUANTITIES = ("front", "skin")
AREA_LAWS = ("ode", "paper")
RATE_RULES = ("power", "slope", "paper")
"Written out once more, because the modules that own them load NumPy; a test compares them."


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


class Kind(NamedTuple):
    """Values of one kind. metavar : their name in the help. read : from text; ArgumentTypeError where it is none."""

    metavar: str
    read: Callable[[str], Any]


FILE, DIR, PICTURE = (Kind(name, Path) for name in ("FILE", "DIR", "PICTURE"))
FOLDER, NAME, NAMES = Kind("FOLDER", str), Kind("NAME", str), Kind("NAMES", names)
HTML, CSV = Kind("FILE.html", _file(".html")), Kind("FILE.csv", _file(".csv"))
NEWTON, PIXELS, MM, GREY = (Kind(unit, positive) for unit in ("N", "PX", "MM", "GREY"))
SECONDS, HZ, PX2 = (Kind(unit, positive) for unit in ("SECONDS", "HZ", "PX2"))
AT_LEAST_1, COUNT, INTEGER = Kind("N", whole_number), Kind("N", count), Kind("N", int)
LAG, RMS, DEGREES = Kind("SECONDS", number), Kind("RMS", not_negative), Kind("DEGREES", numbers)
FRAMES, CIRCLE, GRID = Kind("I,J", frame_pair), Kind("X,Y,R", str), Kind("COLUMNSxROWS", grid)
