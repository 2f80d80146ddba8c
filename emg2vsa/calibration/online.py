"""Stiffness while a press goes on: an interval after every frame, and a stop as soon as it is narrow enough.

The score of half a press is not the score of a whole one, because A(F) is concave. So the calibration is made for every
force at which the new press may be judged: the presses of the known specimens are cut at that force too, and all slopes
are taken between the same two forces. Presses of the new specimen that are finished count along, cut alike.

A specimen pressed once shows no noise of its own; that of the known specimens is taken, pooled. The stopping rule looks
at the width of the interval alone. That is not quite innocent, for the width grows with the estimate and a press that
seems soft stops first: decision 16 has what is left of the coverage.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.repeats import repeat_interval
from emg2vsa.errors import DataError
from emg2vsa.settings import CalibrationSettings

Curve = tuple[ArrayLike, ArrayLike]
"""Force (T,) in N and contact area (T,) of the frames of a loading phase."""
_POINTS = 33  # of the force axis, through which the straight line goes


@dataclass(frozen=True)
class OnlineCalibration:
    """Calibrations for presses cut at forces_n (G,); all slopes begin at start_n. calibration : d = G."""

    start_n: float
    forces_n: Floats
    calibration: Calibration


@dataclass(frozen=True)
class OnlineState:
    """What is known after a frame; kappa, low, high in N/mm, NaN before the first force of the calibration.

    force_n : largest force of this press so far. judged_at_n : force up to which areas were used. presses : that count.
    half_width : of the interval, as a share of kappa. enough : whether it is as narrow as wanted.
    """

    force_n: float
    judged_at_n: float
    presses: int
    kappa: float
    low: float
    high: float
    half_width: float
    enough: bool


def calibrate_online(
    kappa: ArrayLike,
    curves: Sequence[Sequence[Curve]],
    settings: CalibrationSettings | None = None,
    *,
    area_unit: str = "mm2",
    start_n: float = 0.6,
    stop_n: float = 7.0,
    step_n: float = 0.2,
) -> OnlineCalibration:
    """A calibration for every ``step_n`` of force, the first two steps above ``start_n``, the last at ``stop_n``.

    kappa : (S,). curves : of each specimen its presses. start_n : where all slopes begin; a press must have been seen
    from below it to count. DataError where no press reaches ``stop_n``.
    """
    forces = np.arange(start_n + 2 * step_n, stop_n + step_n / 1000, step_n)
    presses = max((len(each) for each in curves), default=0)
    casr = np.full((forces.size, len(curves), presses), np.nan)
    for s, each in enumerate(curves):
        for r, (force_n, area) in enumerate(each):
            casr[:, s, r] = cut_rates(force_n, area, start_n, forces)
    if not np.any(np.isfinite(casr[-1:])):
        raise DataError(
            "on-line calibration",
            wanted=f"presses from {start_n:g} to {stop_n:g} N",
            found="none that covers these forces",
            do="Raise start_n or lower stop_n.",
        )
    known = np.broadcast_to(np.asarray(kappa, dtype=np.float64), casr.shape[:2])
    return OnlineCalibration(start_n, forces, calibrate(known, casr, settings, casr_unit=f"{area_unit}/N"))


class OnlineEstimator:
    """Judges a new specimen frame by frame.

    Parameters
    ----------
    calibration : of ``calibrate_online``.
    wanted : half width of the interval on kappa, as a share of kappa, at which ``OnlineState.enough`` says to stop.
    """

    def __init__(self, calibration: OnlineCalibration, wanted: float = 0.1) -> None:
        self._calibration, self._wanted = calibration, wanted
        self._finished: list[Floats] = []
        self._largest_n, self._reached = -np.inf, -1
        self._next_press()

    def push(self, force_n: float, area: float) -> OnlineState:
        """The next frame of the press: its force, N, and contact area."""
        self._curve.append((force_n, area))
        self._largest_n = max(self._largest_n, force_n)
        reached = int(np.searchsorted(self._calibration.forces_n, self._largest_n, side="right")) - 1
        if reached > self._reached:
            self._reached = reached
            self._state = self._judged(reached)
        return OnlineState(self._largest_n, *self._state)

    def finish_press(self) -> None:
        """The press is over; the next frame belongs to another one."""
        self._finished.append(self._rates())
        self._next_press()

    def _next_press(self) -> None:
        self._curve: list[tuple[float, float]] = []
        self._largest_n, self._reached = -np.inf, -1
        nothing = float("nan")
        self._state = (nothing, len(self._finished), nothing, nothing, nothing, nothing, False)

    def _rates(self) -> Floats:
        force, area = np.array(self._curve, dtype=np.float64).reshape(-1, 2).T
        return cut_rates(force, area, self._calibration.start_n, self._calibration.forces_n)

    def _judged(self, at: int) -> tuple[float, int, float, float, float, float, bool]:
        scores = np.stack([*self._finished, self._rates()], axis=1)
        found = repeat_interval(self._calibration.calibration, scores, own_noise=False)
        kappa, low, high = float(found.kappa[at]), float(found.low[at]), float(found.high[at])
        half_width = (high - low) / (2 * kappa)
        presses = int(np.count_nonzero(np.isfinite(scores[at])))
        return float(self._calibration.forces_n[at]), presses, kappa, low, high, half_width, half_width <= self._wanted


def cut_rates(force_n: ArrayLike, area: ArrayLike, start_n: float, stop_n: Floats) -> Floats:
    """Slope (G,) of the line through A(F) from ``start_n`` to each of ``stop_n`` (G,); NaN where the press ends before.

    Frames below an earlier force are left out: going down, a contact keeps more of its area than it had.
    """
    force, areas = rising(np.asarray(force_n, dtype=np.float64), np.asarray(area, dtype=np.float64))
    rates = np.full(stop_n.shape, np.nan)
    if force.size < 2 or force[0] > start_n:
        return rates
    unit = np.linspace(-0.5, 0.5, _POINTS)
    reached = stop_n <= force[-1]
    length = stop_n[reached] - start_n
    at = start_n + length[:, None] * (unit + 0.5)
    rates[reached] = np.interp(at, force, areas) @ unit / (unit @ unit) / length
    return rates


def rising(force_n: Floats, area: Floats) -> tuple[Floats, Floats]:
    """The frames whose force is larger than every force before."""
    known = np.isfinite(force_n) & np.isfinite(area)
    force, areas = force_n[known], area[known]
    before = np.maximum.accumulate(np.concatenate([[-np.inf], force]))[:-1]
    return force[force > before], areas[force > before]
