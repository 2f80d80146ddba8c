"""How people read a field of a result: head, factor and digits, declared where the field is.

A dataclass says ``f: Floats = field(metadata=shown("F", digits=4))``; ``report.table.columns(found, "f")`` shows it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, NamedTuple

_KEY = "shown"


class Shown(NamedTuple):
    """head : of a table's column, with the unit that people read. factor : from the stored unit to that. digits :
    significant ones."""

    head: str
    factor: float = 1.0
    digits: int = 3


def shown(head: str, factor: float = 1.0, digits: int = 3) -> dict[str, Shown]:
    """Metadata of a dataclass field."""
    return {_KEY: Shown(head, factor, digits)}


def words_of(owner: object) -> Mapping[str, Shown]:
    """Name of each field of the dataclass ``owner``, or of its instance, that declares how it is read."""
    of: Any = owner
    return {each.name: each.metadata[_KEY] for each in fields(of) if _KEY in each.metadata}
