"""The order of a session's presses: drawn once, before the first press, and never again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class PlannedPress:
    """number : from 1, in the order of pressing. repetition : of this specimen, from 1. stay : from 1 over the whole
    session; presses on one specimen without another between them are one stay, and one recording."""

    number: int
    phase: Literal["training", "main"]
    specimen: str
    repetition: int
    stay: int
