"""Colours, markers and dashes: one look per specimen everywhere, told apart without colour too. Units of activity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from casr.palette import BLUE, GREEN, GREY, GRID, INK, MUTED, PURPLE, RED, SKY, YELLOW

__all__ = ["BLUE", "GREEN", "GREY", "GRID", "INK", "MUTED", "NEW", "PURPLE", "RED", "SKY", "VERDICT_COLOURS", "YELLOW"]
__all__ += ["Look", "looks"]

VERDICT_COLOURS = {"ok": GREEN, "doubtful": YELLOW, "rejected": RED}


@dataclass(frozen=True)
class Look:
    """How one specimen is drawn; ``marker`` and ``dash`` are matplotlib's."""

    colour: str
    marker: str
    dash: str | tuple[int, tuple[float, ...]]


_MEASURED = (
    Look(BLUE, "o", "-"),
    Look(PURPLE, "D", (0, (6, 1))),
    Look(GREEN, "s", (0, (5, 1, 1, 1))),
    Look(SKY, "v", (0, (3, 1, 1, 1, 1, 1))),
    Look(YELLOW, "^", (0, (3, 1))),
    Look(GREY, "P", (0, (1, 1))),
)
NEW = Look(RED, "X", (0, (1, 1)))
"""A specimen nobody palpated: red and dotted, as in the paper's Fig. 11."""


def looks(specimens: Sequence[str], new: str | None = None) -> dict[str, Look]:
    """Specimen to look, by its place in the study: the five of the paper get the paper's colours (S1 blue, S3 green,
    S5 yellow, S_new red). From the seventh specimen on colours repeat, and from the thirteenth
    on markers and dashes too.
    """
    more = tuple(Look(look.colour, "<>ph*d"[i], _MEASURED[i - 2].dash) for i, look in enumerate(_MEASURED))
    every = _MEASURED + more
    found = {name: every[i % len(every)] for i, name in enumerate(specimens)}
    return found | ({new: NEW} if new is not None else {})


@dataclass(frozen=True)
class ActivityScale:
    """Volts are stored, microvolts are read: stored activity times ``factor`` is in ``unit`` ("": normalised)."""

    unit: str
    factor: float

    def label(self, quantity: str) -> str:
        """Axis label or table head: the quantity with its unit in brackets."""
        return f"{quantity} ({self.unit})" if self.unit else quantity


def activity_scale(activity_unit: str, values: ArrayLike) -> ActivityScale:
    """The unit that brings the largest of ``values`` to one or more; volts stay volts from 1 V on."""
    if activity_unit != "V":
        return ActivityScale("", 1.0)
    finite = np.abs(np.asarray(values, dtype=np.float64))
    largest = float(np.max(finite, initial=0.0, where=np.isfinite(finite)))
    if largest >= 1:
        return ActivityScale("V", 1.0)
    return ActivityScale("mV", 1e3) if largest >= 1e-3 else ActivityScale("µV", 1e6)
