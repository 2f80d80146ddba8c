"""Fits of a simulated study beside its truth: bias, spread, and whether the intervals hold what they promise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.fits import Fits, usable
from emg2vsa.truth import Truth


@dataclass(frozen=True)
class Recovery:
    """Over the usable trials whose truth is known; errors of b are relative to the true b of the trial.

    ``..._mcse`` are Monte-Carlo standard errors: what another seed would change.
    """

    n: int
    mean_b_error: float
    mean_b_error_mcse: float
    sd_b_error: float
    coverage: float
    coverage_mcse: float
    confidence: float


def recover(fits: Fits, truth: Truth, use: str, specimen: str | None = None) -> Recovery:
    """Recovery over all specimens, or over one."""
    keys = zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), strict=True)
    true_b = np.array([truth.get(key, (np.nan, np.nan))[1] for key in keys], dtype=np.float64)
    entering = usable(fits, use) & np.isfinite(true_b)
    if specimen is not None:
        entering &= fits.specimen == specimen
    n = int(np.count_nonzero(entering))
    if n == 0:
        nan = float("nan")
        return Recovery(0, nan, nan, nan, nan, nan, fits.confidence)
    true_b = true_b[entering]
    error = fits.b_v[entering] / true_b - 1
    coverage = float(np.mean((fits.b_lo_v[entering] <= true_b) & (true_b <= fits.b_hi_v[entering])))
    spread = float(np.std(error, ddof=1)) if n > 1 else float("nan")
    return Recovery(
        n=n,
        mean_b_error=float(np.mean(error)),
        mean_b_error_mcse=spread / n**0.5,
        sd_b_error=spread,
        coverage=coverage,
        coverage_mcse=(coverage * (1 - coverage) / n) ** 0.5,
        confidence=fits.confidence,
    )
