"""Designs of groups that differ in size and scatter, for tests that allow for both."""

from __future__ import annotations

import numpy as np


def unequal(seed: int, k: int = 4, n: int = 9) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((k, n)) * np.geomspace(1, 4, k)[:, None] + 0.8 * np.arange(k)[:, None]
    values[np.arange(n) >= rng.integers(3, n + 1, (k, 1))] = np.nan
    return values


def groups_of(design: np.ndarray) -> list[np.ndarray]:
    return [group[np.isfinite(group)] for group in design]


DESIGNS = np.array([unequal(seed) for seed in range(12)])
