"""What the stiffness of the drive can do to the spread rates of specimens by mechanics alone: the numbers of a study.

Three ways are kept apart: creep of sensor and specimen, through how long a press lasts; equation (2) as printed, a sum
over frames, through how many there are; and errors of timing, through how fast the force grows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats

LOSSY_SENSOR, LOSSY_SPECIMENS = 0.30, 0.10
"Shares of a sensor that creeps as much as soft printed skin may, on specimens that creep alike."
PRESS_CV = 0.03
"CV of the spread rate from press to press (assumption; the emulated bench has 3 to 5 %)."
_FOUND, _MISSED = 1.959964, 0.841621
"Normal quantiles of 5 % on both sides and of a power of 80 %."


@dataclass(frozen=True, eq=False)
class StiffnessEffect:
    """Effect of stiffness on K specimens, the stiffest first, and C conditions, the rigid motor first.

    duration_s : (K, C) between the forces of the window, elastic bodies. rate : (M, K, C) true spread rate, mm2/N, in
    M materials. frame_sum : (K, C) equation (2) as printed, elastic bodies; frame_sum_swapped, rate_swapped : (K, C)
    the same and the rate with the schedules of the specimens in reverse order.
    timing_cv : (2, C) CV of the spread rate of the pair with errors of timing; timing_d : (C,) d' of the pair.
    specimen_share : (K,) of the compliance of specimen and sensor. area_power : (K,) ln of area per ln of force.
    """

    specimens: tuple[str, ...]
    conditions: tuple[str, ...]
    materials: tuple[str, ...]
    pair: tuple[str, str]
    duration_s: Floats
    rate: Floats
    frame_sum: Floats
    frame_sum_swapped: Floats
    rate_swapped: Floats
    timing_cv: Floats
    timing_d: Floats
    specimen_share: Floats
    area_power: Floats

    def creep_exponent(self, share: float, condition: int) -> float:
        """n of a creep t^n of the softest specimen alone that would raise its contrast to the stiffest by ``share``
        under a condition against the rigid motor: ln A grows by its power of force, times its share of the compliance,
        times n, with ln of the duration. Infinite where a press does not last longer."""
        longer = float(np.log(self.duration_s[-1, condition] / self.duration_s[-1, 0]))
        per_n = self.area_power[-1] * self.specimen_share[-1] * longer
        return float(np.log1p(share) / per_n) if per_n > 0 else np.inf

    def contrast(self, rates: Floats, specimen: int = -1) -> Floats:
        """(..., C) logarithm of the ratio of a specimen, the softest unless said, to the stiffest; of (..., K, C)."""
        return np.asarray(np.log(rates[..., specimen, :] / rates[..., 0, :]))


def replicates_needed(difference: Floats, sd: float) -> Floats:
    """In each of four cells, for a difference (n,) of two contrasts at 5 % and a power of 80 %; each score has that
    ``sd``.

    Logarithms: a contrast is that of a ratio of two scores. Infinite for no difference.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(4 * ((_FOUND + _MISSED) * sd / np.asarray(difference, dtype=np.float64)) ** 2)
