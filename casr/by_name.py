"""Modules and plugins that are chosen by name while a program runs, told to whoever asks which a piece of work used.

An import statement stands in the code, and can be read there. What a setting, a file or a stored result chooses is
imported here, each time, so that nobody has to guess what it was: a cache must not stand between the choice and this.
Nobody asks by default.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType

_open: list[set[str]] = []


def module_named(name: str) -> ModuleType:
    """The module of that name. It is told even where it cannot be imported: the outcome hangs on that too."""
    used([name])
    return import_module(name)


def used(names: Iterable[str]) -> None:
    """Tell everybody who asks. names : of modules that another process imports, or of what ``casr.plugins`` finds."""
    for told in _open:
        told.update(names)


@contextmanager
def noting() -> Iterator[set[str]]:
    """What is told inside."""
    told: set[str] = set()
    _open.append(told)
    try:
        yield told
    finally:
        _open[:] = [each for each in _open if each is not told]
