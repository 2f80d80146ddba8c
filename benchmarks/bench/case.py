"""What is measured: areas, their cases, and the ways of a case."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Any, Literal, TypeVar

Work = Literal["equal", "as used"]
OURS = ("emg2vsa", "casr")
Value = TypeVar("Value")


class Size(Enum):
    """smoke : seconds for all areas, for tests. full : what is published."""

    SMOKE = "smoke"
    FULL = "full"

    def pick(self, smoke: Value, full: Value) -> Value:
        """The first at smoke size, else the second."""
        return smoke if self is Size.SMOKE else full


@dataclass(frozen=True)
class Way:
    """One library's way to the output of a case.

    Parameters
    ----------
    library : as people name it; ``emg2vsa`` or ``casr`` for ours.
    name : the function or the recipe. Together with the library unlike that of any other way of the case.
    run : does the work once and returns its output; inputs are made before, not in it.
    work : ``equal`` where input and output are those of the first way; ``as used`` where the library is called as its
        documentation shows, whatever more or less it does. ``note`` says what differs.
    error : overrides ``Case.error`` where the output has another form; None takes that of the case.
    """

    library: str
    name: str
    run: Callable[[], Any]
    work: Work
    note: str = ""
    error: Callable[[Any], float] | None = None

    @property
    def ours(self) -> bool:
        return self.library in OURS


@dataclass(frozen=True)
class Case:
    """One task and all ways to do it. The first way is ours: ratios are times slower than it.

    Parameters
    ----------
    name : unlike that of any other case of the area.
    size, size_unit : how much is done, e.g. 700, ``"trials"``.
    error : error of an output against something that none of the ways made; None where only time is measured.
    error_unit : ``"relative"`` gives digits too (-log10).
    truth : what the error is against, e.g. ``"mpmath, 40 digits"``.
    family : cases of one family differ in size alone, and make one growth curve.
    bytes_moved, flops : that any way has to read and write, and to compute; 0 where nobody counted.
    """

    name: str
    size: float
    size_unit: str
    ways: tuple[Way, ...]
    error: Callable[[Any], float] | None
    error_unit: str
    truth: str
    family: str = ""
    bytes_moved: float = 0.0
    flops: float = 0.0

    def __post_init__(self) -> None:
        names = [(way.library, way.name) for way in self.ways]
        assert self.ways
        assert self.ways[0].ours, f"{self.name}: the first way must be ours"
        assert len(set(names)) == len(names), f"{self.name}: two ways have one name"

    def error_of(self, way: Way, output: Any) -> float | None:
        """Error of an output of the way, None where nothing is to be compared."""
        error = way.error or self.error
        return None if error is None else float(error(output))


Part = Callable[[Size], Iterable[Case]]


def part_of(module: str, function: str) -> Part:
    """A part of an area whose module is imported when it is asked for."""

    def part(size: Size) -> Iterable[Case]:
        found: Iterable[Case] = getattr(importlib.import_module(module), function)(size)
        return found

    part.__name__ = function
    return part


@dataclass(frozen=True)
class Area:
    """A question, and the cases that answer it.

    Parameters
    ----------
    name : that of its file.
    question : what the table answers, one sentence.
    parts : functions that make cases of a size. Each imports what it measures, so that a part whose functions an older
        revision lacks leaves the others whole (``--compare``).
    peers : import name -> name on PyPI of every library that takes part where it is installed.
    meaning : what the results mean, one paragraph; numbers stand in the table alone.
    """

    name: str
    question: str
    parts: tuple[Part, ...]
    peers: dict[str, str]
    meaning: str

    @property
    def absent(self) -> tuple[str, ...]:
        """Names of the peers that are not installed."""
        return tuple(name for module, name in self.peers.items() if not installed(module))


class NotHere(Exception):
    """A part needs data that are not on this machine; the message says which, and how to name them."""


def installed(module: str) -> bool:
    """Whether a library can be imported; its import is not run."""
    return importlib.util.find_spec(module.partition(".")[0]) is not None


def peer(module: str) -> Any:
    """The module of another library, None where it is not installed."""
    return importlib.import_module(module) if installed(module) else None
