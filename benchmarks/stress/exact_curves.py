"""Lines and curves by their normal equations in 50 digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.stress.case import exactly


def exact_line(x: Sequence[Any], y: Sequence[Any], w: Sequence[Any] | None = None) -> dict[str, Any]:
    """a + b x by weighted least squares, standard errors, R2; x, y, w in 50 digits."""
    weights = [mpf(1)] * len(x) if w is None else [each / max(w) for each in w]
    total = mp.fsum(weights)
    centre_x, centre_y = mp.fdot(weights, x) / total, mp.fdot(weights, y) / total
    dx, dy = [value - centre_x for value in x], [value - centre_y for value in y]
    sxx = mp.fsum(k * d * d for k, d in zip(weights, dx, strict=True))
    syy = mp.fsum(k * d * d for k, d in zip(weights, dy, strict=True))
    b = mp.fsum(k * p * q for k, p, q in zip(weights, dx, dy, strict=True)) / sxx
    sse = mp.fsum(k * (q - b * p) ** 2 for k, p, q in zip(weights, dx, dy, strict=True))
    s = mp.sqrt(sse / (len(x) - 2))
    return {
        "a": centre_y - b * centre_x,
        "b": b,
        "SE(a)": s * mp.sqrt(1 / total + centre_x**2 / sxx),
        "SE(b)": s / mp.sqrt(sxx),
        "R2": 1 - sse / syy,
    }


def exact_huber(x: Sequence[Any], y: Sequence[Any], tuning: Any, tolerance: float = 1e-20) -> dict[str, Any]:
    """Line of Huber's psi by reweighting, scale from the median absolute residual over that of the normal law."""
    normal = mp.sqrt(2) * mp.erfinv(mpf(1) / 2)
    fit, weights = exact_line(x, y), [mpf(1)] * len(x)
    for _ in range(400):
        residual = [abs(q - fit["a"] - fit["b"] * p) for p, q in zip(x, y, strict=True)]
        scale = _median(residual) / normal
        renewed = [min(mpf(1), tuning * scale / r) if r else mpf(1) for r in residual]
        change = max(abs(p - q) for p, q in zip(renewed, weights, strict=True))
        weights, fit = renewed, exact_line(x, y, renewed)
        if change < tolerance:
            break
    return {"a": fit["a"], "b": fit["b"]}


def exact_exponential(x: Sequence[Any], y: Sequence[Any]) -> dict[str, Any]:
    """Level and q of y = level exp(q (x - mean x)): Gauss-Newton on q, half the step where the squares would grow."""
    centre = mp.fsum(x) / len(x)
    z = [value - centre for value in x]
    q = exact_line(z, [mp.log(abs(value)) for value in y])["b"]

    def at(q: Any) -> tuple[Any, Any, Any]:
        """Level, sum of squares and step of q."""
        u = [mp.exp(q * each) for each in z]
        uu = mp.fdot(u, u)
        level = mp.fdot(u, y) / uu
        middle = mp.fsum(each * each * where for each, where in zip(u, z, strict=True)) / uu
        r = [value - level * each for value, each in zip(y, u, strict=True)]
        by_q = [level * (where - middle) * each for where, each in zip(z, u, strict=True)]
        return level, mp.fdot(r, r), mp.fdot(by_q, r) / mp.fdot(by_q, by_q)

    level, squares, step = at(q)
    for _ in range(500):
        there = at(q + step)
        if there[1] > squares:
            step /= 2
        else:
            q, (level, squares, step) = q + step, there
        if abs(step) < mpf("1e-40") * abs(q):
            break
    return {"q": q, "level": level, "centre": centre}


def exact_root(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Root between two numbers at which the function differs in sign, by bisection, then by Newton's secant."""
    return mp.findroot(function, (mpf(low), mpf(high)), solver="anderson", tol=mpf("1e-80"), maxsteps=400)


def mpfs(values: np.ndarray) -> list[Any]:
    return [exactly(value) for value in values.ravel()]


def _median(values: Sequence[Any]) -> Any:
    ordered = sorted(values)
    n = len(ordered)
    return (ordered[(n - 1) // 2] + ordered[n // 2]) / 2
