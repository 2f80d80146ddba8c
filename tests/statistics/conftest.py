"""Studies whose mixed model is known from lme4, and its likelihood from the covariance matrix of all values."""

from __future__ import annotations

import csv
from pathlib import Path

import mpmath
import numpy as np

from emg2vsa.statistics.clusters import Clusters, clusters_of

LMER = Path(__file__).parent / "lmer"
STUDIES = ("interior.csv", "no_participants.csv", "no_interaction.csv")


def clusters(name: str) -> Clusters:
    with (LMER / name).open() as file:
        rows = list(csv.DictReader(file))
    participant, specimen, b = (np.array([row[key] for row in rows]) for key in ("participant", "specimen", "b"))
    return clusters_of(participant, specimen, b.astype(float), np.ones(b.size, dtype=bool))


def study(seed: int, person: float, interaction: float, shape: tuple[int, int, int] = (14, 5, 10)) -> np.ndarray:
    rng, (p, s, _) = np.random.default_rng(seed), shape
    y = rng.standard_normal(shape) + np.arange(s)[:, None] * 0.1
    return np.asarray(y + person * rng.standard_normal((p, 1, 1)) + interaction * rng.standard_normal((p, s, 1)))


def dense_minus_2_reml(of: Clusters, variance: list[mpmath.mpf]) -> mpmath.mpf:
    """From the covariance matrix of all values, in 30 digits."""
    places = np.argwhere(np.isfinite(of.values))
    y = mpmath.matrix([mpmath.mpf(float(of.values[tuple(at)])) for at in places])
    n, s = len(places), of.specimens.size
    v = mpmath.matrix(n, n)
    for i, a in enumerate(places):
        for j, b in enumerate(places):
            if a[0] == b[0]:
                v[i, j] = variance[0] + (a[1] == b[1]) * variance[1] + (i == j) * variance[2]
    x = mpmath.matrix(n, s)
    for i, a in enumerate(places):
        x[i, int(a[1])] = 1
    inverse = mpmath.inverse(v)
    information = x.T * inverse * x
    residual = y - x * mpmath.lu_solve(information, x.T * inverse * y)
    logs = mpmath.log(mpmath.det(v)) + mpmath.log(mpmath.det(information))
    return logs + (residual.T * inverse * residual)[0] + (n - s) * mpmath.log(2 * mpmath.pi)
