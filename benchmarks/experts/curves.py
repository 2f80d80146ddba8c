"""Straight lines over log F with their errors, and exponentials, all rows of a table in one call."""

from __future__ import annotations

import numpy as np
from scipy import special

Found = dict[str, np.ndarray]


def log_fits(force: np.ndarray, v: np.ndarray) -> Found:
    """v = a + b log F of rows (r, n) in closed form: a, b, their SE, interval of 95 % of b, both R2 and n."""
    x = np.log(force)
    mean_x, mean_v = x.mean(axis=1), v.mean(axis=1)
    x -= mean_x[:, None]
    y = v - mean_v[:, None]
    xx, xy, yy = np.einsum("ij,ij->i", x, x), np.einsum("ij,ij->i", x, y), np.einsum("ij,ij->i", y, y)
    return _with_errors(x, y, mean_x, mean_v, xx, xy / xx, yy - xy * xy / xx, yy)


def log_fits_by_qr(force: np.ndarray, v: np.ndarray) -> Found:
    """The same by Householder's QR of every row's matrix."""
    x = np.log(force)
    r = np.linalg.qr(np.stack((np.ones_like(force), x, v), axis=2), mode="r")
    b = r[:, 1, 2] / r[:, 1, 1]
    left, yy = r[:, 2, 2] ** 2, r[:, 1, 2] ** 2 + r[:, 2, 2] ** 2
    mean_x, mean_v = r[:, 0, 1:].T / r[:, 0, 0]
    return _with_errors(x, v, mean_x, mean_v, r[:, 1, 1] ** 2, b, left, yy, close=False)


def log_fits_on_a_grid(grid: np.ndarray, v: np.ndarray) -> Found:
    """The same where all rows (r, n) share their forces (n,): one product."""
    x = np.log(grid)
    mean_x = x.mean()
    x -= mean_x
    xx, mean_v, xy = x @ x, v.mean(axis=1), v @ x
    y = v - mean_v[:, None]
    yy = np.einsum("ij,ij->i", y, y)
    return _with_errors(x, y, mean_x, mean_v, xx, xy / xx, yy - xy * xy / xx, yy)


def _with_errors(
    x: np.ndarray, y: np.ndarray, mean_x: np.ndarray, mean_y: np.ndarray, xx: np.ndarray, b: np.ndarray,
    left: np.ndarray, yy: np.ndarray, close: bool = True,
) -> Found:  # fmt: skip
    """Of x and y about their means. A point that is no number is refused; close : the residuals of a fit of less than a
    tenth of yy are summed one by one, as their difference loses digits."""
    if not np.isfinite(left).all():
        raise ValueError("every force must be above zero, and every point a number")
    near = np.flatnonzero(left < 0.1 * yy) if close else ()
    if len(near):
        rest = y[near] - b[near, None] * (x if x.ndim == 1 else x[near])
        left[near] = np.einsum("ij,ij->i", rest, rest)
    n = y.shape[1]
    se = np.sqrt(left / ((n - 2) * xx))
    reach = special.stdtrit(n - 2, 0.975) * se
    share = left / yy
    return {
        "a": mean_y - b * mean_x, "b": b, "SE(a)": se * np.sqrt(xx / n + mean_x * mean_x), "SE(b)": se,
        "low": b - reach, "high": b + reach, "R2": 1 - share, "adj R2": 1 - share * ((n - 1) / (n - 2)),
        "n": np.full(len(b), n),
    }  # fmt: skip


def exponential_fits(x: np.ndarray, y: np.ndarray) -> Found:
    """y (n,) = p exp(q x) of rows x (r, n): p eliminated, Halley's steps on q from the line of log y, weights y^2."""
    w = y * y
    mean = (x @ w) / w.sum()
    z = x - mean[:, None]
    log_y = np.log(y)
    q = (z @ (w * (log_y - w @ log_y / w.sum()))) / (z * z @ w)
    for _ in range(50):
        e = np.exp(q[:, None] * z)
        ze = z * e
        t0, t1, t2 = e @ y, ze @ y, (z * ze) @ y
        s0, s1, s2 = np.einsum("ij,ij->i", e, e), np.einsum("ij,ij->i", ze, e), np.einsum("ij,ij->i", ze, ze)
        t1, s1 = t1 / t0, s1 / s0
        step = (t1 - s1) / (t2 / t0 - t1 * t1 - 2 * (s2 / s0 - s1 * s1))
        q = q - step
        if np.all(np.abs(step) <= 1e-9 * np.abs(q)):  # the next step would be of the order of its square
            break
    return {"p": t0 / s0 * np.exp(-q * mean), "q": q}
