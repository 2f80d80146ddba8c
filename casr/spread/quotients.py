"""Eq. (2) of the paper as printed: the sum over frames of dA/dF."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def sum_of_quotients(area: Vector, force_n: Vector, min_step_n: float) -> tuple[float | None, tuple[str, ...]]:
    """The sum, with steps of force below ``min_step_n`` merged with the next; None when no step is left."""
    ends = _steps(force_n, min_step_n)
    if len(ends) < 2:
        return None, ()
    merged = force_n.size - len(ends)
    notes: tuple[str, ...] = ()
    if merged:
        notes = (f"{merged} of {force_n.size - 1} steps of force below {min_step_n:g} N merged with their neighbours.",)
    notes += (f"A sum of {len(ends) - 1} quotients: it grows with the number of frames.",)
    return float(np.sum(np.diff(area[ends]) / np.diff(force_n[ends]))), notes


def _steps(force_n: Vector, min_step_n: float) -> list[int]:
    """Frames at which steps end, each at least ``min_step_n`` away from the one before; the last frame is one."""
    ends = [0]
    for frame, force in enumerate(force_n.tolist()):
        if abs(force - force_n[ends[-1]]) >= min_step_n:
            ends.append(frame)
    last = force_n.size - 1
    while len(ends) > 1 and ends[-1] != last:
        ends.pop()
        if abs(force_n[last] - force_n[ends[-1]]) >= min_step_n:
            ends.append(last)
    return ends
