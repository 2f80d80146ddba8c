"""The contact area spread rate of one press (paper, eq. 2), as printed or as a slope."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, SettingError
from casr.spread.loading_points import frames_with_force, outside_dips, pooled
from casr.spread.slope import force_slope, normal_quantile

RATE_RULES = ("slope", "paper")


@dataclass(frozen=True)
class SpreadRate:
    """Spread rate of the contact area over force.

    Parameters
    ----------
    value : in ``unit``.
    low, high : interval of the slope for the error of the single areas; None where there is none. The error of the
        initial area scales value and interval alike and is not in it.
    unit : ``mm2/N`` or ``px2/N``; for rule ``paper`` a sum of such quotients, which grows with the number of frames.
    rule : one of ``RATE_RULES``.
    n_frames : frames used.
    notes : what was left out, pooled or merged.
    """

    value: float
    low: float | None
    high: float | None
    unit: str
    rule: str
    n_frames: int
    notes: tuple[str, ...]


def spread_rate(
    area: ArrayLike,
    force_n: ArrayLike,
    *,
    rule: str = "slope",
    area_unit: str = "mm2",
    min_step_n: float = 0.02,
    confidence: float = 0.95,
) -> SpreadRate:
    """Contact area spread rate of a loading phase.

    Parameters
    ----------
    area : (T,) contact areas, the first one A_c0.
    force_n : (T,) force per frame, N; frames with NaN are left out.
    rule : ``slope``: slope of the line through A(F) over the force axis; dips of the force are left out
        (``outside_dips``), and where it does not rise, neighbouring frames are pooled (``pooled``).
        ``paper``: eq. (2) as printed, the sum over frames of dA/dF with F_0 = 0.
    area_unit : ``mm2`` or ``px2``, for the unit of the result.
    min_step_n : ``paper`` divides only by steps of force this large, N; smaller ones are merged with the next, so no
        change of area is lost.
    confidence : of the interval of ``slope``.

    Raises
    ------
    FramesError : lengths that do not fit, infinite values, or a force that never changes enough.
    SettingError : an unknown rule or a setting out of range.
    """
    if rule not in RATE_RULES:
        raise SettingError("rule", wanted=" or ".join(RATE_RULES), found=repr(rule), do="Choose one of these.")
    if not (0 < confidence < 1 and 0 < min_step_n < np.inf):
        raise SettingError(
            "confidence, min_step_n",
            wanted="a confidence between 0 and 1 and a step above 0 N",
            found=f"{confidence!r}, {min_step_n!r}",
            do="Correct the setting.",
        )
    if rule == "paper":
        return _summed_quotients(area, force_n, area_unit, min_step_n)
    return _slope(area, force_n, area_unit, confidence)


def _slope(area: ArrayLike, force_n: ArrayLike, area_unit: str, confidence: float) -> SpreadRate:
    known_area, known_force, notes = frames_with_force(area, force_n)
    loading_area, loading_force, dips = outside_dips(known_area, known_force)
    rising_area, rising_force, more = pooled(loading_area, loading_force)
    if rising_force.size < 2 or not rising_force[-1] - rising_force[0] > 1e-9 * np.abs(rising_force).max():
        raise _flat(known_force)
    value, error = force_slope(rising_area, rising_force)
    if error is None:
        low = high = None
        more += (f"No interval: {rising_force.size} points are too few to judge their error.",)
    else:
        half = normal_quantile(confidence) * error
        low, high = value - half, value + half
    return SpreadRate(value, low, high, f"{area_unit}/N", "slope", loading_force.size, notes + dips + more)


def _summed_quotients(area: ArrayLike, force_n: ArrayLike, area_unit: str, min_step_n: float) -> SpreadRate:
    force: NDArray[np.float64] = np.array(force_n, dtype=np.float64).reshape(-1)
    force[:1] = 0.0
    a, f, notes = frames_with_force(area, force)
    ends = _steps(f, min_step_n)
    if len(ends) < 2:
        raise _flat(f)
    value = float(np.sum(np.diff(a[ends]) / np.diff(f[ends])))
    merged = f.size - len(ends)
    if merged:
        notes += (f"{merged} of {f.size - 1} steps of force below {min_step_n:g} N merged with their neighbours.",)
    notes += (f"A sum of {len(ends) - 1} quotients: it grows with the number of frames.",)
    return SpreadRate(value, None, None, f"{area_unit}/N summed over frames", "paper", f.size, notes)


def _steps(force_n: NDArray[np.float64], min_step_n: float) -> list[int]:
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


def _flat(force_n: NDArray[np.float64]) -> FramesError:
    found = f"{force_n.size} frames with a force"
    if force_n.size:
        found += f" from {force_n.min():.3g} to {force_n.max():.3g} N"
    return FramesError(
        "force of the loading phase",
        wanted="at least two frames with rising force",
        found=found,
        do="Score frames in which the force rises; check the force log.",
    )
