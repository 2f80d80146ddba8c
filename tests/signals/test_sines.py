"""Amplitude and phase of sines in pieces equal the sum that defines them."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.signals.sines import BLOCK, sine_phasors

FS_HZ = 1000.0


def plainly(samples: np.ndarray, begin: int, end: int, hz: np.ndarray) -> np.ndarray:
    """Phasors (h,) by a sum over every sample of the piece."""
    size = end - begin
    window = np.array([np.sin(np.pi * (i + 0.5) / size) ** 2 for i in range(size)])
    turning = np.exp(-2j * np.pi / FS_HZ * np.outer(np.arange(size), hz))
    return 2 / window.sum() * (window * samples[begin:end]) @ turning


@pytest.mark.parametrize(
    "pieces", [[(0, 500)], [(7, 8)], [(0, BLOCK), (1, BLOCK), (5, 6 + BLOCK)], [(3, 2003), (9, 99)]]
)
def test_equal_to_the_sum_over_samples(pieces):
    channels = np.random.default_rng(0).standard_normal((2, 2010))
    hz = np.array([0.0, 49.93, 250.5, 499.9])
    got = sine_phasors(tuple(channels), pieces, hz, FS_HZ)
    assert got.shape == (2, len(pieces), hz.size)
    for m, row in enumerate(channels):
        for i, piece in enumerate(pieces):
            np.testing.assert_allclose(got[m, i], plainly(row, *piece, hz), rtol=0, atol=1e-13)


def test_a_sine_shows_its_amplitude_and_its_phase_at_the_first_sample():
    at = np.arange(5000) / FS_HZ
    wave = 3.0 * np.cos(2 * np.pi * 50.2 * at + 0.7)
    ((found,),) = sine_phasors((wave,), [(1000, 3000)], np.array([50.2]), FS_HZ)
    assert abs(found[0]) == pytest.approx(3.0, rel=1e-4)
    assert np.angle(found[0] * np.exp(-2j * np.pi * 50.2)) == pytest.approx(0.7, abs=1e-4)


def test_no_pieces_and_no_sines():
    wave = np.ones(100)
    assert sine_phasors((wave,), [], np.array([50.0]), FS_HZ).shape == (1, 0, 1)
    assert sine_phasors((wave,), [(0, 50)], np.empty(0), FS_HZ).shape == (1, 1, 0)
