"""Values of a specimen that nobody measured, from those of its neighbours in stiffness (paper VI.B)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError

PAPER_RANGE_N_PER_MM = 10.0
"""The paper's weight is the stiffness as a fraction of this range (printed as N/m by mistake)."""


@dataclass(frozen=True)
class Interpolated:
    """values : as one specimen's; stiffer, softer : places of the two nearest; alpha : weight of the softer.

    ``alpha`` is NaN where all specimens had a part ("coefficients").
    """

    values: Floats
    stiffer: int
    softer: int
    alpha: float


def between(
    stiffness_n_per_mm: Floats, values: Floats, new_n_per_mm: float, method: str, *, extrapolate: bool, where: str
) -> Interpolated:
    """Values at the stiffness ``new_n_per_mm``, from ``values`` (n, ...) at ``stiffness_n_per_mm`` (n,).

    bracket, log-stiffness and paper blend the two nearest neighbours, (1 - alpha) stiffer + alpha softer, with

        bracket        alpha = (k1 - k) / (k1 - k3), k1 the stiffer and k3 the softer
        log-stiffness  the same in ln k
        paper          alpha = k / (10 N/mm), whatever the neighbours

    coefficients takes a monotone cubic (PCHIP) through all specimens. All but paper return a specimen's own values at
    its own stiffness. Outside the stiffness range: DataError, or with ``extrapolate`` the straight line through the
    nearest two. Of specimens with equal stiffness the first counts.
    """
    known, first = np.unique(stiffness_n_per_mm, return_index=True)
    inside = known.size > 1 and bool(known[0] <= new_n_per_mm <= known[-1])
    _refuse(known, new_n_per_mm, inside or extrapolate, where)
    upper = min(max(int(np.searchsorted(known, new_n_per_mm, side="right")), 1), known.size - 1)
    stiffer, softer = int(first[upper]), int(first[upper - 1])
    if method == "coefficients" and inside:
        from scipy.interpolate import PchipInterpolator  # noqa: PLC0415  (0.2 s that one option alone needs)

        return Interpolated(PchipInterpolator(known, values[first])(new_n_per_mm), stiffer, softer, math.nan)
    alpha = softer_weight(new_n_per_mm, float(known[upper]), float(known[upper - 1]), method, where)
    return Interpolated((1 - alpha) * values[stiffer] + alpha * values[softer], stiffer, softer, alpha)


def softer_weight(k: float, stiffer: float, softer: float, method: str, where: str) -> float:
    """alpha, the weight of the softer of two specimens (paper VI.B: kappa / 10 by method "paper"; decision 3); all
    stiffnesses in N/mm.

    DataError : by that method, a kappa above 10 N/mm.
    """
    if method == "log-stiffness":
        return (math.log(stiffer) - math.log(k)) / (math.log(stiffer) - math.log(softer))
    if method != "paper":
        return (stiffer - k) / (stiffer - softer)
    if k > PAPER_RANGE_N_PER_MM:
        raise DataError(
            where, wanted=f"at most {PAPER_RANGE_N_PER_MM:g} N/mm, the range of the paper's weight",
            found=f"{k:g} N/mm", do="Use interpolation = 'bracket'.",
        )  # fmt: skip
    return k / PAPER_RANGE_N_PER_MM


def _refuse(known: Floats, new_n_per_mm: float, allowed: bool, where: str) -> None:
    if known.size < 2:
        raise DataError(
            where, wanted="two specimens of known, different stiffness to interpolate between",
            found=f"{known.size}", do="Measure another specimen, or state its stiffness.",
        )  # fmt: skip
    if not allowed:
        raise DataError(
            where, wanted=f"a stiffness between {known[0]:g} and {known[-1]:g} N/mm, the specimens used",
            found=f"{new_n_per_mm:g} N/mm", do="Add specimens, or set extrapolate = true.",
        )  # fmt: skip
