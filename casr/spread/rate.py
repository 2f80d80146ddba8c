"""The contact area spread rate of one press (paper, eq. 2): by a power law, as a slope, or as printed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, SettingError
from casr.spread.curves import PowerLaw, fit_power_laws, force_slope
from casr.spread.intervals import CONFIDENCE, normal_quantile, student_quantile

Vector = NDArray[np.float64]
Points = tuple[NDArray[np.float64], NDArray[np.float64], tuple[str, ...]]
"""Area (n,), force (n,) in N, and what was done to get there."""


DIP_N = 0.2
"""Depth of a fall of force, N, up to which it is noise: four standard deviations of a frame at 0.05 N."""


def frames_with_force(area: ArrayLike, force_n: ArrayLike) -> Points:
    """Areas and forces (n,), N, of the frames whose force is known, and notes; NaN marks an unknown force.

    FramesError : not of one size, or an area of a known force or a force is not finite.
    """
    area = np.asarray(area, dtype=np.float64).reshape(-1)
    force = np.asarray(force_n, dtype=np.float64).reshape(-1)
    known = ~np.isnan(force)
    if area.size != force.size or not np.isfinite(area[known]).all() or np.isinf(force).any():
        raise FramesError(
            "area and force",
            wanted="a finite area and a force, or NaN, for every frame",
            found=f"{area.size} areas, {force.size} forces, {int(np.isinf(force).sum())} infinite forces and "
            f"{int((~np.isfinite(area)).sum())} areas that are NaN or infinite",
            do="Give the same frames for both.",
        )
    lost = int(known.size - known.sum())
    notes = (f"{lost} of {known.size} frames carry no force and are left out.",) if lost else ()
    return area[known], force[known], notes


def outside_dips(area: NDArray[np.float64], force_n: NDArray[np.float64]) -> Points:
    """The frames that lie no more than ``DIP_N`` below an earlier force. area, force_n : (n,), the latter in N.

    When the force goes down and up again a contact keeps area that it had (hysteresis); from where the force was before
    it grows on as if nothing had been. Falls within ``DIP_N`` are taken for noise and left to ``pooled``: to keep
    rising frames only would choose those whose force reads too high.
    """
    kept = force_n >= np.maximum.accumulate(force_n) - DIP_N if force_n.size else np.ones(0, dtype=np.bool_)
    lost = int(force_n.size - kept.sum())
    notes = (f"{lost} of {force_n.size} frames in dips of the force deeper than {DIP_N:g} N are left out.",)
    return area[kept], force_n[kept], notes if lost else ()


def pooled(area: NDArray[np.float64], force_n: NDArray[np.float64]) -> Points:
    """Isotonic force: neighbouring frames whose force does not rise become one point, their mean force and mean area.

    area, force_n : (n,), the latter in N; returned are (m,) of both, and notes.
    The pools are those of the pool-adjacent-violators algorithm (Ayer et al. 1955), so the forces come out strictly
    rising and nearest to the measured ones in the least-squares sense.
    """
    pools: list[tuple[float, float, int]] = []
    for f, a in zip(force_n.tolist(), area.tolist(), strict=True):
        pool = (f, a, 1)
        while pools and pools[-1][0] / pools[-1][2] >= pool[0] / pool[2]:
            last = pools.pop()
            pool = (last[0] + pool[0], last[1] + pool[1], last[2] + pool[2])
        pools.append(pool)
    sums = np.array(pools, dtype=np.float64).reshape(-1, 3)
    merged = force_n.size - len(pools)
    notes = (f"Force does not rise in every frame: {merged} of {force_n.size} frames pooled.",) if merged else ()
    return sums[:, 1] / sums[:, 2], sums[:, 0] / sums[:, 2], notes


RATE_RULES = ("power", "slope", "paper")
WINDOW_N = (0.5, 7.0)
"Loading phase of the paper."
MIN_STEP_N = 0.02
"""``paper`` divides only by steps of force this large; smaller ones are merged with the next, so no change of area is
lost."""
FAR = 2.0  # times; frames that miss an end of the window by more are said to


@dataclass(frozen=True)
class SpreadRate:
    """Spread rate of the contact area over force.

    value : in ``unit``.
    scatter_low, scatter_high : 95 % interval for the scatter of the single areas only; None where there is none. All
        that scales value and interval alike is not in it: see ``total_interval``.
    unit : ``mm2/N`` or ``px2/N``; for rule ``paper`` a sum of such quotients, which grows with the number of frames.
    rule : one of ``RATE_RULES``. n_frames : frames used. notes : what was left out, pooled or merged.
    law, window_n : for rule ``power``: the areas it found, and the forces between which ``value`` is their mean rate.
    """

    value: float
    scatter_low: float | None
    scatter_high: float | None
    unit: str
    rule: str
    n_frames: int
    notes: tuple[str, ...]
    law: PowerLaw | None = None
    window_n: tuple[float, float] | None = None

    def __repr__(self) -> str:
        scatter = (
            "" if self.scatter_low is None else f" [{self.scatter_low:.4g}, {self.scatter_high:.4g}] by scatter alone"
        )
        return f"SpreadRate({self.value:.4g} {self.unit}{scatter}, rule {self.rule}, {self.n_frames} frames)"


def readable(unit: str) -> str:
    """``mm2/N`` as mm²/N."""
    return unit.replace("2", "²")


def spread_rate(
    area: ArrayLike,
    force_n: ArrayLike,
    *,
    rule: str = "power",
    area_unit: str = "mm2",
    window_n: tuple[float, float] = WINDOW_N,
) -> SpreadRate:
    """Contact area spread rate of a loading phase.

    area : (T,) contact areas, the first one A_c0. force_n : (T,) force per frame, N; frames with NaN are left out.
    rule : ``power``: mean rate from the lower to the higher force of ``window_n`` on the power law through the areas
        (``fit_power_laws``), wherever between or near them the first and the last frame fell. ``slope``: slope of the
        line through A(F) over the forces that were reached; where the force does not rise, neighbouring frames are
        pooled (``pooled``). Both leave out dips of the force (``outside_dips``). ``paper``: eq. (2) as printed, the sum
        over frames of dA/dF with F_0 = 0.
    area_unit : ``mm2`` or ``px2``, for the unit of the result. window_n : of ``power``, N.
    FramesError : lengths that do not fit, infinite values, a force that never changes enough, or for ``power`` areas
        below 0 or only some of them 0.
    SettingError : an unknown rule or a setting out of range.
    Equation (2) of the paper and the others compared: decision 8.
    """
    if rule not in RATE_RULES:
        raise SettingError("rule", wanted=" or ".join(RATE_RULES), found=repr(rule), do="Choose one of these.")
    if not 0 < window_n[0] < window_n[1] < np.inf:
        wanted = "two forces above 0 N, the lower first"
        raise SettingError("window_n", wanted=wanted, found=repr(window_n), do="Correct the setting.")
    if rule == "paper":
        return _paper(area, force_n, area_unit)
    known_area, known_force, lost = frames_with_force(area, force_n)
    loading_area, loading_force, dips = outside_dips(known_area, known_force)
    if rule == "power":
        return _power(loading_area, loading_force, f"{area_unit}/N", window_n, lost + dips)
    return _slope(loading_area, loading_force, f"{area_unit}/N", lost + dips)


def spread_rates(areas: Vector, force_n: Vector, *, rule: str, window_n: tuple[float, float]) -> Vector:
    """(P,) values of ``spread_rate`` of areas (P, T) over the same forces (T,), N; errors as there.

    Rule ``paper`` is equation (2) as printed.
    """
    if rule != "power":
        return np.array([spread_rate(area, force_n, rule=rule, window_n=window_n).value for area in areas])
    known = ~np.isnan(force_n)
    area, force, _ = outside_dips(areas.T[known], force_n[known])
    pressed = force > 0
    _check_rises(force[pressed])
    return fit_power_laws(area[pressed].T, force[pressed]).mean_rates(*window_n)


def _power(
    area: NDArray[np.float64],
    force_n: NDArray[np.float64],
    unit: str,
    window_n: tuple[float, float],
    notes: tuple[str, ...],
) -> SpreadRate:
    pressed = force_n > 0
    area, force_n = area[pressed], force_n[pressed]
    _check_rises(force_n)
    if not area.any():
        return SpreadRate(0.0, None, None, unit, "power", force_n.size, notes, PowerLaw(0.0, 0.0), window_n)
    if not (area > 0).all():
        raise FramesError(
            "area", wanted="areas above 0 in all frames, or 0 in all",
            found=f"{int((area <= 0).sum())} of {area.size} at {area.min():.3g} or so",
            do="Check the growth of these frames, or use rule 'slope'.",
        )  # fmt: skip
    fit = fit_power_laws(area, force_n)
    value, error = fit.law.mean_rate(*window_n), fit.standard_error(*window_n)
    if not (force_n[0] <= FAR * window_n[0] and force_n.max() >= window_n[1] / FAR):
        seen = f"{force_n[0]:.2g} to {force_n.max():.2g} N"
        notes += (f"Frames from {seen} tell of the rate from {window_n[0]:g} to {window_n[1]:g} N by the power law.",)
    half = None if error is None else student_quantile(CONFIDENCE, error[1]) * error[0]
    low, high, few = _interval(value, half, force_n.size)
    return SpreadRate(value, low, high, unit, "power", force_n.size, notes + few, fit.law, window_n)


def _slope(area: NDArray[np.float64], force_n: NDArray[np.float64], unit: str, notes: tuple[str, ...]) -> SpreadRate:
    rising_area, rising_force, merged = pooled(area, force_n)
    _check_rises(rising_force)
    value, error = force_slope(rising_area, rising_force)
    half = None if error is None else normal_quantile(CONFIDENCE) * error
    low, high, few = _interval(value, half, rising_force.size)
    return SpreadRate(value, low, high, unit, "slope", force_n.size, notes + merged + few)


def _interval(value: float, half: float | None, n_points: int) -> tuple[float | None, float | None, tuple[str, ...]]:
    if half is None:
        return None, None, (f"No interval: {n_points} points are too few to judge their error.",)
    return value - half, value + half, ()


def _paper(area: ArrayLike, force_n: ArrayLike, area_unit: str) -> SpreadRate:
    force: NDArray[np.float64] = np.array(force_n, dtype=np.float64).reshape(-1)
    force[:1] = 0.0
    known_area, known_force, lost = frames_with_force(area, force)
    value, notes = _sum_of_quotients(known_area, known_force)
    if value is None:
        raise _flat(known_force)
    return SpreadRate(value, None, None, f"{area_unit}/N summed over frames", "paper", known_force.size, lost + notes)


def _check_rises(force_n: NDArray[np.float64]) -> None:
    if force_n.size < 2 or not force_n[-1] - force_n[0] > 1e-9 * np.abs(force_n).max():
        raise _flat(force_n)


def _flat(force_n: NDArray[np.float64]) -> FramesError:
    found = f"{force_n.size} frames with a force"
    if force_n.size:
        found += f" from {force_n.min():.3g} to {force_n.max():.3g} N"
    return FramesError(
        "force of the loading phase", wanted="at least two frames with rising force", found=found,
        do="Score frames in which the force rises; check the force log.",
    )  # fmt: skip


def _sum_of_quotients(area: Vector, force_n: Vector) -> tuple[float | None, tuple[str, ...]]:
    """The sum, with steps of force below ``MIN_STEP_N`` merged with the next; None when no step is left."""
    ends = _steps(force_n)
    if len(ends) < 2:
        return None, ()
    merged = force_n.size - len(ends)
    notes: tuple[str, ...] = ()
    if merged:
        notes = (f"{merged} of {force_n.size - 1} steps of force below {MIN_STEP_N:g} N merged with their neighbours.",)
    notes += (f"A sum of {len(ends) - 1} quotients: it grows with the number of frames.",)
    return float(np.sum(np.diff(area[ends]) / np.diff(force_n[ends]))), notes


def _steps(force_n: Vector) -> list[int]:
    """Frames at which steps end, each at least ``MIN_STEP_N`` away from the one before; the last frame is one."""
    ends = [0]
    for frame, force in enumerate(force_n.tolist()):
        if abs(force - force_n[ends[-1]]) >= MIN_STEP_N:
            ends.append(frame)
    last = force_n.size - 1
    while len(ends) > 1 and ends[-1] != last:
        ends.pop()
        if abs(force_n[last] - force_n[ends[-1]]) >= MIN_STEP_N:
            ends.append(last)
    return ends
