"""The curves in 40-digit arithmetic."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpmath import mp, mpf


def exact_line(x: list[mpf], y: list[mpf]) -> dict[str, mpf]:
    """a + b x, SE(b), R2 and adjusted R2."""
    n = len(x)
    mean_x, mean_y = mp.fsum(x) / n, mp.fsum(y) / n
    dx, dy = [xi - mean_x for xi in x], [yi - mean_y for yi in y]
    sxx, syy = mp.fsum(d * d for d in dx), mp.fsum(d * d for d in dy)
    b = mp.fdot(dx, dy) / sxx
    sse = mp.fsum((q - b * p) ** 2 for p, q in zip(dx, dy, strict=True))
    left = sse / syy
    return {
        "a": mean_y - b * mean_x,
        "b": b,
        "SE(b)": mp.sqrt(sse / (n - 2) / sxx),
        "R2": 1 - left,
        "adj R2": 1 - left * (n - 1) / (n - 2),
    }


def exact_log_fit(force: np.ndarray, v: np.ndarray) -> dict[str, mpf]:
    return exact_line([mp.log(mpf(float(f))) for f in force], [mpf(float(value)) for value in v])


def exact_exponential(x: Any, y: Any) -> dict[str, mpf]:
    """p exp(q x) by Gauss-Newton from the log-linear fit."""
    x, y = [mpf(float(value)) for value in x], [mpf(float(value)) for value in y]
    start = exact_line(x, [mp.log(value) for value in y])
    p, q = mp.exp(start["a"]), start["b"]
    for _ in range(500):
        u = [mp.exp(q * xi) for xi in x]
        r = [yi - p * ui for yi, ui in zip(y, u, strict=True)]
        by_q = [p * xi * ui for xi, ui in zip(x, u, strict=True)]
        uu, uq, qq = mp.fdot(u, u), mp.fdot(u, by_q), mp.fdot(by_q, by_q)
        determinant = uu * qq - uq * uq
        step_p = (qq * mp.fdot(u, r) - uq * mp.fdot(by_q, r)) / determinant
        step_q = (uu * mp.fdot(by_q, r) - uq * mp.fdot(u, r)) / determinant
        p, q = p + step_p, q + step_q
        if abs(step_q) < mpf("1e-25") * abs(q):
            break
    return {"p": p, "q": q}
