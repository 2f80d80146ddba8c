"""What speaks against a press whose stiffness over a range of force is told: why it is doubtful or unusable."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.curves.first_contact import LEAST, MAD, REST
from emg2vsa.curves.line import fit_line

DRIFTS = (0.02, 0.1)
"""Slope before contact over kappa, from which on a press is doubtful, and unusable."""
STARTS = (0.1, 1.0)
"""Force of the first point over F0 where there is no rest before it, from which on likewise."""
_LONG, _CREEPS = 1.4, 0.5
"""Depth over F0 / kappa, over which a force that rises at less than this share of kappa is no first contact."""
_CLOSES = 0.6
"""Share by which kappa at F0 may lie below its further course."""
_FALLS = 0.05
"""Share of the range of force by which a press may fall again."""
_KINKS = 0.01
"""SD of what the smoothest course leaves over the range of force, where it is no noise, that no material does."""
_BREAKS = 0.1
"""The same, from which on a press says nothing."""
_SPREAD = 0.5
"""Width of the interval of contact over the depth from contact to F1, from which on a press is doubtful."""
_TRAVELS_MM = (0.01, 200)
"""Depth from contact on; less or more is a mistake of units."""
_CLIPPED = 0.03
"""Share of points at the largest force, from which on it is the sensor's end."""

Doubt = tuple[bool, str]
"""Whether the press is unusable, and why."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """One press up to its deepest point, and its part between F0 and F1.

    x, y, smooth : (n,) depth, mm, force past the level at rest, and that smoothed, N. contact : depth of first touch
    with the ends of its interval, mm. rest : points before it, 0 where there is no rest. start_n, start_se : force of
    the first point. from_n, to_n : F0 and F1. places : points at F0 and F1. inside : (n,) points that are fitted.
    """

    x: Floats
    y: Floats
    smooth: Floats
    contact: tuple[float, float, float]
    level_n: float
    rest: int
    start_n: float
    start_se: float
    from_n: float
    to_n: float
    places: tuple[int, int]
    inside: NDArray[np.bool_]

    @property
    def first(self) -> float:
        return float(self.x[self.places[0]])

    @property
    def last(self) -> float:
        return float(self.x[self.places[1]])


def doubts_of_depth(part: Stretch, height_mm: float | None) -> Iterator[Doubt]:
    """height_mm : of the specimen, where it is known."""
    travel = part.last - part.contact[0]
    if not _TRAVELS_MM[0] < travel < _TRAVELS_MM[1]:
        yield False, f"it is pressed {travel:.3g} mm deep: is the unit of depth right?"
    if height_mm and travel >= height_mm:
        yield True, f"it is pressed {travel:.3g} mm deep, and the specimen is {height_mm:g} mm high"


def doubts_of_rest(part: Stretch, secant_n: float) -> Iterator[Doubt]:
    """Doubts about a press with a rest before contact. secant_n : kappa times the depth between F0 and F1, N."""
    before = fit_line(part.x[None, : part.rest], part.y[None, : part.rest])
    slope = max(0.0, abs(float(before.slope[0])) - 3 * float(before.slope_se[0]))
    drift = slope * (part.last - part.first) / secant_n
    if drift > DRIFTS[0]:
        yield drift > DRIFTS[1], f"the force drifts before contact, by {100 * drift:.0f} % of kappa"


def doubts_of_start(part: Stretch, slope_n: float) -> Iterator[Doubt]:
    """Doubts about a press without a rest. slope_n : tangent at F0 times the depth between F0 and F1, N."""
    if abs(part.start_n) - 2 * part.start_se > STARTS[0] * part.from_n:
        yield False, f"it begins at {part.start_n:.3g} N, with no rest before contact: its zero is not known"
    contact, span = part.contact[0], part.last - part.first
    before = (part.x >= contact) & (part.x <= (contact + part.first) / 2)
    if np.count_nonzero(before) < REST:
        return
    creep = fit_line(part.x[None, before], part.y[None, before]).slope[0] * span / slope_n
    long = (part.first - contact) / 2 > _LONG * part.from_n * span / slope_n
    if long and creep < _CREEPS:
        said = f"the force rises at {100 * creep:.0f} % of kappa for {(part.first - contact) / 2:.2g} mm"
        yield creep > DRIFTS[1], f"{said} before it is pressed: it drifts, or something soft is between"


def doubts_of_course(part: Stretch, closing: float, noise_n: float) -> Iterator[Doubt]:
    """closing : share by which kappa at F0 lies below its further course. noise_n : SD of what the curve leaves, N."""
    range_n, (start, end) = part.to_n - part.from_n, part.places
    if closing > _CLOSES:
        said = f"kappa at {part.from_n:g} N lies {100 * closing:.0f} % below its further course"
        yield False, f"{said}: it drifts, or something soft is between"
    fall = np.maximum.accumulate(part.smooth[start:end]) - part.smooth[start:end]
    if fall.max() > max(_FALLS * range_n, 3 * noise_n):
        yield True, f"the force falls by {fall.max():.2g} N at {part.x[start + int(np.argmax(fall))]:.3g} mm"
    scatter = float(np.median(np.abs(np.diff(part.y[part.inside], 2)))) / (MAD * np.sqrt(6))
    if noise_n > max(_KINKS * range_n, 4 * scatter):
        yield noise_n > _BREAKS * range_n, f"no smooth curve follows it: {noise_n:.2g} N are left"
    at_most = np.count_nonzero(part.y == part.y.max())
    if at_most >= max(LEAST, _CLIPPED * part.y.size):
        yield False, f"{at_most} points have the same largest force: does the load cell end there?"
    touch, low, high = part.contact
    if high - low > _SPREAD * (part.last - touch):
        yield False, f"contact lies anywhere from {low:.3g} to {high:.3g} mm"
