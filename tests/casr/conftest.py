"""A scored press that many tests look at."""

from __future__ import annotations

import pytest

from casr.frames import FrameSequence
from casr.scoring import Score, score
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press


@pytest.fixture(scope="session")
def soft() -> tuple[FrameSequence, Score]:
    """A quick press of a soft specimen, and its score; never changed."""
    made = simulate_press(PressSettings(stiffness_n_per_mm=1.11, timeline=TimelineSettings(loading_s=0.5)))
    sequence = made.sequence()
    return sequence, score(sequence)
