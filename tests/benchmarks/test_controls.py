"""A small sample of the table of the control worlds: nothing is found where nothing is, and what is there is found."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from benchmarks.controls import exact_power, false_claims, p1_slopes, p4_rates, power

WORLD_MD = {0.02: (0.597, 0.080), 0.05: (0.666, 0.096), 0.10: (0.783, 0.125)}
"ln(S5/S1) and ln(S2/S1) with human-like stiffness in P1, computed apart from this program."


def contrast(slopes: np.ndarray) -> np.ndarray:
    """(2, C) of softest and second stiffest over the stiffest."""
    return np.asarray(np.log(slopes[[3, 1]] / slopes[0]))


@pytest.mark.parametrize("exponent", WORLD_MD)
def test_the_artificial_effect_is_as_computed_elsewhere(exponent: float) -> None:
    found = contrast(p1_slopes(exponent))
    assert found[:, 0] == pytest.approx([0.553, 0.0696], abs=6e-4)
    assert found[:, 1] == pytest.approx(WORLD_MD[exponent], abs=1.2e-3)
    # constants that are the same for all specimens show nothing
    assert found[:, 5:] == pytest.approx(np.repeat(found[:, :1], 3, axis=1), abs=1e-12)


def test_nothing_is_claimed_without_an_effect() -> None:
    """60 experiments: one wrong claim in twenty is allowed."""
    logs = np.repeat(np.log([2.0, 2.14, 2.4, 3.5])[:, None], 5, axis=1)
    scatter = np.array([0.04, 0.03, 0.03, 0.03, 0.03]), np.full(5, 0.025)
    assert false_claims(logs, scatter, 60, 3) <= stats.binom.ppf(0.999, 60, 0.05)


def test_the_artificial_effect_is_found_with_three_presses() -> None:
    logs = np.log(p1_slopes(0.05)[:, :5])
    assert exact_power(logs, 0, 3, 0.03) > 0.8
    assert exact_power(logs, 1, 40, 0.03) > 0.8
    assert power(logs, 0, 1, 3, 0.03, 0.0, 40, 1) > stats.binom.ppf(0.001, 40, 0.8) / 40


def test_the_right_stiffness_is_the_least_noisy() -> None:
    """d' of S1 and S2 as computed apart from this program: 7.1, 3.2, 1.8, 1.1 and 0.9."""
    rates = p4_rates(80, np.random.default_rng(0))
    apart = {c: (r[1].mean() - r[0].mean()) / np.sqrt(r[:2].var(axis=1).mean()) for c, r in rates.items()}
    assert list(apart) == sorted(apart, key=lambda condition: -apart[condition])
    assert list(apart.values()) == pytest.approx([7.1, 3.2, 1.8, 1.1, 0.9], rel=0.25)
