"""Read noise out of a table: normal, independent, and the same from the same seed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.worlds.tactile.read_noise import read_noise

SHAPE = (301, 299)
N = math.prod(SHAPE)


def noise(seed: int, bits: type[np.random.BitGenerator] = np.random.PCG64) -> np.ndarray:
    return read_noise(SHAPE, np.random.Generator(bits(seed)))


@pytest.mark.parametrize("bits", [np.random.PCG64, np.random.MT19937])
def test_it_is_normal(bits: type[np.random.BitGenerator]) -> None:
    """Moments within four of their standard errors, and as many beyond each of several limits as there should be.

    The bits come from a generator of 64 bits at a time, and from one of 32.
    """
    drawn = noise(1, bits).astype(np.float64).ravel()
    assert abs(drawn.mean()) < 4 / math.sqrt(N)
    assert abs(drawn.std() - 1) < 4 / math.sqrt(2 * N)
    assert abs((drawn**3).mean()) < 4 * math.sqrt(15 / N)
    assert abs((drawn**4).mean() - 3) < 4 * math.sqrt(96 / N)
    for limit in (-3.0, -1.5, -0.2, 0.4, 1.0, 2.5):
        expected = math.erfc(-limit / math.sqrt(2)) / 2
        assert abs(np.mean(drawn < limit) - expected) < 4 * math.sqrt(expected * (1 - expected) / N)
    assert 3.9 < np.abs(drawn).max() < 4.4


def test_pixels_and_frames_are_independent() -> None:
    first, second = noise(1), noise(2)
    pairs = [(first, second), (first[:, 1:], first[:, :-1]), (first[1:], first[:-1]), (first[:, 4:], first[:, :-4])]
    for one, other in pairs:
        assert abs(np.mean(one * other)) < 4 / math.sqrt(one.size)
        assert abs(np.mean(one**2 * other**2) - 1) < 4 * math.sqrt(8 / one.size)


def test_the_same_seed_gives_the_same_noise() -> None:
    assert noise(7).dtype == np.float32
    assert np.array_equal(noise(7), noise(7))
    assert not np.array_equal(noise(7), noise(8))
