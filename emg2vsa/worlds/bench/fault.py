"""A fault of the emulated rig, by which each part of it lists its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

Strike = Callable[[Any, float], None]
"""Of the bench and a number."""


@dataclass(frozen=True)
class Fault:
    """What goes wrong, in words, and how.

    words : N stands for the number. strike : puts it on with a number, or off with ``neutral``.
    kind : count, it strikes so many times; switch, on or off; amount, so much until it is off.
    usual : the number when none is given. least, most : bounds of an amount.
    """

    words: str
    strike: Strike
    kind: Literal["count", "switch", "amount"] = "count"
    usual: float = 1
    neutral: float = 0
    least: float = -math.inf
    most: float = math.inf

    @property
    def lasts(self) -> bool:
        """Until it is put off."""
        return self.kind != "count"


def of_part(part: str, name: str, kind: Callable[[float], object] = bool) -> Strike:
    """Sets an attribute of a part of the bench, as ``box.faults``, to the number as ``kind`` makes it."""

    def strike(bench: Any, value: float) -> None:
        for step in part.split("."):
            bench = getattr(bench, step)
        setattr(bench, name, kind(value))

    return strike
