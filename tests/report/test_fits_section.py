"""Numbers of the fits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.report.sections.fits import FITS


@pytest.mark.parametrize("n", [0, 1, 2])
def test_a_specimen_has_a_mean_from_one_fit_on_and_a_spread_from_two(results, n):
    fits = results.recorded.fits
    verdict = fits.verdict.copy()
    (of_s1,) = np.nonzero(results.used & (fits.specimen == "S1"))
    verdict[of_s1[n:]] = "rejected"
    few = replace(results, people=replace(results.recorded, fits=replace(fits, verdict=verdict)))
    found, b_v = dict(FITS.quantities(few)), fits.b_v[of_s1[:n]]
    assert found["fit.S1.n"] == n
    expected = np.mean(b_v) if n else np.nan, np.ptp(b_v) / np.sqrt(2) if n == 2 else np.nan
    b = f"fit.S1.b{results.activity_suffix}"
    assert (found[f"{b}.mean"], found[f"{b}.sd"]) == pytest.approx(expected, nan_ok=True)
