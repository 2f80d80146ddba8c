"""Small sequences of frames that differ, and the ways to write them."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def frames() -> np.ndarray:
    """(12, 24, 32) uint8 frames; frame k has the brightest stripe at row 2 k."""
    stack = np.random.default_rng(5).integers(0, 100, (12, 24, 32), dtype=np.uint8)
    for index, frame in enumerate(stack):
        frame[2 * index] = 200 + index
    return stack
