"""How ``emg2vsa/statistics/lilliefors_table.py`` is made: the law of Lilliefors' D by simulation down to p = 1e-8.

``python -m benchmarks.lilliefors_table`` prints the tables; half an hour of one core. The body of each law is plain
Monte Carlo, down to p = .01, of 3e8 values and at most 1e7 samples. The tail is multilevel splitting (Kahn and Harris
1951; Au and Beck 2001): the samples with the largest D are copied and moved by Metropolis steps that keep the normal
law above that D, then their largest tenth, and so on, down a factor ten each time. Small n have a row each; from n = 12
on the rows are smoothed by polynomials in 1 / sqrt(n), which also lead to the limit law.
"""

from __future__ import annotations

import math
import sys
import textwrap
import time

import numpy as np
from numba import njit

from emg2vsa.arrays import Floats
from emg2vsa.statistics.lilliefors import LARGE, LEVELS, reach

SIZES = [*range(4, 13), 14, 15, 17, 20, 25, 30, 40, 50, 70, 100, 300, 1000]
SAMPLES, MOST_VALUES, DEGREE = 10_000_000, 300_000_000, 5
KEPT, ACCEPTED = 0.1, 0.3


@njit(cache=True)
def seed(value: int) -> None:
    np.random.seed(value)  # noqa: NPY002 (numba has no other generator inside compiled code)


@njit(cache=True)
def lilliefors_d(x: Floats, ordered: Floats) -> float:
    n = x.size
    mean = 0.0
    for i in range(n):
        mean += x[i]
    mean /= n
    squares = 0.0
    for i in range(n):
        squares += (x[i] - mean) ** 2
    scale = 1 / math.sqrt(2 * squares / (n - 1))
    ordered[:] = x
    if n > 40:
        ordered.sort()
    else:
        for i in range(1, n):
            value, j = ordered[i], i - 1
            while j >= 0 and ordered[j] > value:
                ordered[j + 1] = ordered[j]
                j -= 1
            ordered[j + 1] = value
    d = 0.0
    for i in range(n):
        cdf = 0.5 * math.erfc((mean - ordered[i]) * scale)
        d = max(d, (i + 1) / n - cdf, cdf - i / n)
    return d


@njit(cache=True)
def simulate(n: int, samples: int, floor: float, room: int) -> tuple[Floats, Floats]:
    """D of normal samples of n, and those samples, at most ``room``, whose D is above ``floor``."""
    d, above, x, work, found = np.empty(samples), np.empty((room, n)), np.empty(n), np.empty(n), 0
    for s in range(samples):
        for i in range(n):
            x[i] = np.random.standard_normal()  # noqa: NPY002
        d[s] = lilliefors_d(x, work)
        if d[s] > floor and found < room:
            above[found] = x
            found += 1
    return d, above[:found]


@njit(cache=True)
def move(x: Floats, d: Floats, floor: float, step: float) -> float:
    """One Metropolis step of every particle that keeps the normal law restricted to D > floor; share accepted."""
    proposal, work, kept, accepted = np.empty(x.shape[1]), np.empty(x.shape[1]), math.sqrt(1 - step**2), 0
    for s in range(d.size):
        for i in range(x.shape[1]):
            proposal[i] = kept * x[s, i] + step * np.random.standard_normal()  # noqa: NPY002
        new = lilliefors_d(proposal, work)
        if new > floor:
            x[s], d[s] = proposal, new
            accepted += 1
    return accepted / d.size


def law(n: int, samples: int) -> Floats:
    """Quantiles D (levels,) of LEVELS for samples of n."""
    copies, steps = (5, 24) if n < LARGE else (3, 12)  # larger n are smoothed besides
    seed(n)
    floor = float(np.quantile(simulate(n, 100_000, 9.0, 1)[0], 0.99))
    body, start = simulate(n, samples, floor, samples // 50)
    quantiles, at_floor, step = np.quantile(body, 1 - LEVELS), float(np.mean(body > floor)), 0.5
    x, d = np.tile(start, (copies, 1)), np.tile(body[body > floor], copies)
    particles = d.size
    del body
    while at_floor > LEVELS[-1]:
        pooled = []
        for i in range(steps):
            share = move(x, d, floor, step)
            step = min(0.9, step * math.exp(share - ACCEPTED))
            if i >= steps // 2:
                pooled.append(d.copy())
        segment = np.concatenate(pooled)
        inside = at_floor * 0.99 > LEVELS
        quantiles[inside] = np.quantile(segment, np.maximum(1 - LEVELS[inside] / at_floor, 0.0))
        floor, at_floor = float(np.quantile(segment, 1 - KEPT)), at_floor * KEPT
        above = np.flatnonzero(d > floor)
        chosen = above[np.arange(particles) % above.size]
        x, d = x[chosen], d[chosen]
    return quantiles


def smooth(rows: Floats) -> Floats:
    """Polynomials in 1 / sqrt(n) (levels, degree + 1) through the rows of sizes from LARGE on, by their precision."""
    n = np.array(SIZES)
    weight = np.sqrt(np.where(n >= LARGE, np.minimum(SAMPLES, MOST_VALUES / n), 0.0))
    return np.asarray(np.polynomial.polynomial.polyfit(1 / np.sqrt(n), rows, DEGREE, w=weight).T)


def as_python(name: str, table: Floats) -> str:
    rows = ("[" + ", ".join(f"{value:.4f}" for value in row) + "]," for row in table)
    lines = (textwrap.fill(row, 116, initial_indent=" " * 4, subsequent_indent=" " * 5) for row in rows)
    return f"{name} = np.array([\n" + "\n".join(lines) + "\n])  # fmt: skip"


def main() -> None:
    rows = []
    for n in SIZES:
        begin = time.process_time()
        rows.append(reach(law(n, min(SAMPLES, MOST_VALUES // n)), n))
        print(f"n = {n}: {time.process_time() - begin:.0f} s", file=sys.stderr, flush=True)
    print(as_python("SMALL", np.array(rows)[np.array(SIZES) < LARGE]))
    print(as_python("LARGER", smooth(np.array(rows))))


if __name__ == "__main__":
    main()
