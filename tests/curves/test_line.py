"""Straight lines against NIST's certified values."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from emg2vsa.curves.line import fit_line


def digits(value: float, certified: float) -> float:
    return 15.0 if value == certified else -np.log10(abs(value - certified) / abs(certified))


def test_norris(shared_data: Callable[[str], Path]) -> None:
    lines = shared_data("nist/nist_linear/Norris.dat").read_text().splitlines()
    y, x = np.array([line.split() for line in lines[60:96]], dtype=float).T
    line = fit_line(x[None], y[None])
    assert digits(line.intercept[0], -0.262323073774029) >= 11.5
    assert digits(line.slope[0], 1.00211681802045) >= 14
    assert digits(line.intercept_se[0], 0.232818234301152) >= 12.5
    assert digits(line.slope_se[0], 0.429796848199937e-3) >= 12.5
    assert digits(line.r2[0], 0.999993745883712) >= 14


def test_exact_line_of_long_rows() -> None:
    x = np.arange(20_000.0)[None]
    line = fit_line(x, 3 + 0.5 * x)
    assert line.slope[0] == 0.5
    assert line.intercept[0] == 3
    assert line.r2[0] == 1
    assert line.slope_se[0] == 0
