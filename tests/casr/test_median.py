"""The quick median is NumPy's, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from casr.median import median


@pytest.mark.parametrize("shape", [(1,), (2,), (7,), (36,), (5, 2), (6, 3)])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_it_is_that_of_numpy(shape: tuple[int, ...], kind: type) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        values = np.round(rng.normal(size=shape) * 10.0 ** rng.integers(-3, 3), 2).astype(kind)
        for axis in range(len(shape)):
            np.testing.assert_array_equal(median(values, axis=axis), np.median(values, axis=axis))
