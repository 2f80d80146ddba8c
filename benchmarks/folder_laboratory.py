"""A made folder of a laboratory, and what its people know of it that no file tells."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Known:
    """What the people of the laboratory know.

    stiffness_n_per_mm : of each object, by what the names of the files call it. emg : channel to muscle.
    force : channel. emg_unit, force_unit : of stored values; of the force it may be how many newtons one is.
    down : whether the force is negative while a finger presses. fs_hz : where no file tells it.
    """

    stiffness_n_per_mm: Mapping[str, float]
    emg: Mapping[str, str]
    force: str
    emg_unit: str = "V"
    force_unit: str = "N"
    down: bool = False
    fs_hz: float | None = None


@dataclass(frozen=True)
class Laboratory:
    """name : of the folder. what : of which laboratory. make : fills an empty folder.

    people : how many. presses : of each of them on each object. slope_v : true b of each object, V.
    """

    name: str
    what: str
    make: Callable[[Path], None]
    known: Known
    people: int
    presses: int
    slope_v: Mapping[str, float]
