"""The curve of a person's presses on a specimen without any law: a monotone spline through their force bins."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from emg2vsa.companions.force_laws import rows_of_cells
from emg2vsa.curves.logarithmic import level_weights
from emg2vsa.curves.monotone_spline import MonotoneSpline, fit_monotone, mean_spline
from emg2vsa.fits import Fits

Splines = Mapping[tuple[str, str], MonotoneSpline]
"""By participant and specimen."""


def cell_splines(fits: Fits, use: str, range_n: tuple[float, float]) -> dict[tuple[str, str], MonotoneSpline]:
    """Splines of every cell through all bins of the trials that ``use`` admits, weighted as in their fits of the
    logarithm.

    range_n : of the spline, N. Without force bins there are none.
    """
    found = {}
    for cell, own in rows_of_cells(fits, use).items():
        force_n, v = fits.bin_force_n[own], fits.bin_v[own]
        if np.count_nonzero(np.isfinite(v)) < 2:
            continue
        level = fits.a_v[own, None] + fits.b_v[own, None] * np.log(force_n)
        found[cell] = fit_monotone(force_n.ravel(), v.ravel(), level_weights(level).ravel(), range_n)
    return found


def of_specimen(splines: Splines, participants: NDArray[np.str_], specimen: str) -> MonotoneSpline | None:
    """Mean curve of these people (n,), each the same; None where one of them has none."""
    own = [splines.get((who, specimen)) for who in dict.fromkeys(participants.tolist())]
    known = [each for each in own if each is not None]
    return mean_spline(known) if own and len(known) == len(own) else None
