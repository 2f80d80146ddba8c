"""A number, or a word, of the report under a flat name; the name tells its unit, and whether it is a p."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from emg2vsa.arrays import Floats

Quantity = str | int | float | bool
Items = Iterator[tuple[str, Quantity]]


def least(values: Floats) -> float:
    """Smallest finite value, or NaN."""
    return float(np.min(values, initial=np.inf, where=np.isfinite(values))) if np.isfinite(values).any() else np.nan


def most(values: Floats) -> float:
    """Largest finite value, or NaN."""
    return -least(-values)


_UNITS = {
    "nm_per_rad": "N·m/rad", "n_per_mm": "N/mm", "mm2_per_n": "mm²/N", "px2_per_n": "px²/N", "deg_per_s": "°/s",
    "mm_per_s": "mm/s", "mm2": "mm²", "px2": "px²", "mm": "mm", "deg": "°", "percent": "%", "hz": "Hz", "ms": "ms",
    "s": "s", "n": "N", "v": "V",
}  # fmt: skip
_STATISTICS = frozenset({"mean", "sd", "median", "min", "max", "low", "high"})
_P = re.compile(r"(?:.*_)?p(?:_gg|_hf)?")


def unit_of(key: str) -> str:
    """Unit of the quantity ``key``, "" where it has none: ``fit.S1.b_v.mean`` is in V, ``fit.S1.n`` is a count."""
    words = key.split(".")
    name = words[-2] if words[-1] in _STATISTICS and len(words) > 1 else words[-1]
    if name in _STATISTICS:
        return ""
    for ending, unit in _UNITS.items():
        if name.endswith(f"_per_{ending}"):
            return ""
        # a letter alone is a name: n is a count, f a statistic
        if name.endswith(f"_{ending}") or (name == ending and len(ending) > 1):
            return unit
    return ""


def is_p(key: str) -> bool:
    """Whether the quantity is a p: its name ends so, or is the test that corrected a ``worst_p``."""
    words = key.split(".")
    return bool(_P.fullmatch(words[-1])) or words[-2:-1] == ["worst_p"]
