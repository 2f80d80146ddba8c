"""Frames of pins at places a test chooses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from casr.camera import Camera
from emg2vsa.worlds.tactile import TACTIP_127, Appearance, Skin, draw_surface, drawn, exposed

Points = NDArray[np.float64]
Draw = Callable[..., NDArray[np.uint8]]


@pytest.fixture
def hexagon_px() -> Points:
    """127 pins of pitch 20 px, half a pixel off a perfect lattice."""
    scatter = np.random.default_rng(5).uniform(-0.5, 0.5, (127, 2))
    return TACTIP_127.pins_px((149.5, 149.5)) + scatter


@pytest.fixture
def draw() -> Draw:
    """Frame of TacTip pins at (127, 2) or, with ``skin``, other places; noise 2 grey levels that never repeats."""
    noise = np.random.default_rng(11)

    def frame(pins_px: Points, *, skin: Skin = TACTIP_127, noise_grey: float = 2.0) -> NDArray[np.uint8]:
        seeds = np.random.default_rng(1), np.random.default_rng(2)
        surface = draw_surface(Appearance(), skin, Camera(), *seeds)
        return exposed(drawn(pins_px, surface, skin), noise_grey, noise)

    return frame
