"""Read noise of a camera: normal numbers looked up in a table, at a third of what drawing them costs.

Of each pixel 16 random bits choose one of as many equally likely normal numbers. Mean and standard deviation are those
of a normal distribution, the largest of the numbers is 4.3 standard deviations: of a frame of 90 000 pixels one or two
would be beyond. A camera's image is rounded to whole grey levels, a thousand times coarser than the table.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

_BITS = 16
_REACH, _POINTS = 6.0, 24_001


def read_noise(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """(H, W) independent draws of mean 0 and standard deviation 1, from the bits of ``rng``."""
    size = math.prod(shape)
    words = rng.integers(2**64, size=-(-size * _BITS // 64), dtype=np.uint64).astype("<u8", copy=False)
    return _table().take(words.view("<u2")[:size]).reshape(shape)


@cache
def _table() -> NDArray[np.float32]:
    """Quantiles in the middle of equal shares of the normal distribution, scaled to a standard deviation of 1."""
    z = np.linspace(-_REACH, _REACH, _POINTS)
    below = [math.erfc(-each / math.sqrt(2)) / 2 for each in z.tolist()]
    shares = (np.arange(2**_BITS) + 0.5) / 2**_BITS
    quantiles = np.interp(shares, below, z)
    table: NDArray[np.float32] = (quantiles / quantiles.std()).astype(np.float32)
    return table
