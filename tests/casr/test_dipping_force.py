"""A press whose force goes back on the way: its frames give the spread rate of the same press without a dip."""

from __future__ import annotations

import numpy as np
import pytest

from casr.frames import FrameSequence
from casr.scoring import score
from emg2vsa.worlds.tactile import PressSettings, SimulatedFrames, simulate_press


@pytest.mark.parametrize("dip_n", [0.5, 2.0])
def test_a_press_with_dips_scores_as_without(dip_n: float) -> None:
    press = simulate_press(PressSettings())
    loading = press.truth.force_n[press.truth.loading_frames]
    time = np.linspace(0, 1, loading.size)
    dips = sum(np.exp(-(((time - middle) / 0.04) ** 2)) for middle in (0.4, 0.7))
    rest = np.zeros(4)

    def rate(force_n: np.ndarray) -> float:
        frames = SimulatedFrames(press.scene, np.concatenate([rest, force_n]))
        found = score(FrameSequence(frames, press.settings.camera, frames.force_n)).rate
        assert found is not None
        return found.value

    assert rate(loading - dip_n * dips) == pytest.approx(rate(loading), rel=0.005)
