from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.truth import recover


@pytest.fixture
def biased(results):
    """Every b 2 % above its truth; one interval in four misses it."""
    true_b = np.array([results.people.truth[key][1] for key in keys_of(results.people.fits)])
    miss = np.arange(true_b.size) % 4 == 0
    low = np.where(miss, 1.01, 0.9) * true_b
    return replace(results.people.fits, b_v=1.02 * true_b, b_lo_v=low, b_hi_v=1.2 * true_b)


def keys_of(fits):
    return list(zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), strict=True))


def test_bias_and_coverage_are_found(results, biased):
    found = recover(biased, results.people.truth, "ok+warned")
    used = biased.verdict != "rejected"
    covered = np.mean(np.arange(used.size)[used] % 4 != 0)
    assert found.n == 71
    assert found.mean_b_error == pytest.approx(0.02)
    assert found.sd_b_error == pytest.approx(0.0, abs=1e-12)
    assert found.coverage == pytest.approx(covered)
    assert found.coverage_mcse == pytest.approx(np.sqrt(covered * (1 - covered) / 71))


def test_monte_carlo_error_is_the_standard_error_of_the_mean(results):
    found = recover(results.people.fits, results.people.truth, "ok+warned")
    assert found.mean_b_error_mcse == pytest.approx(found.sd_b_error / np.sqrt(found.n))
    assert abs(found.mean_b_error) < 4 * found.mean_b_error_mcse


def test_only_known_and_usable_trials_enter(results):
    known = {key: value for key, value in results.people.truth.items() if key[1] == "S3"}
    assert recover(results.people.fits, known, "ok+warned").n == 17
    assert recover(results.people.fits, known, "ok").n == 16
    assert recover(results.people.fits, known, "ok", "S1").n == 0
    assert np.isnan(recover(results.people.fits, known, "ok", "S1").mean_b_error)
