"""Speed of a plate, and the force that relaxes while it holds still."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.curves.press_time import press_time


def held(speed: float, hold_s: float, relaxed: float, back: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """6 mm down, a hold in which the force falls by ``relaxed`` at once over 2 s, perhaps back up; ten records a s."""
    down_s = 6 / speed
    t = np.arange(0, down_s + hold_s + (down_s if back else 0), 0.1)
    x = np.minimum(speed * t, 6) - np.maximum(t - down_s - hold_s, 0) * speed
    fall = relaxed * np.clip((t - down_s) / 2, 0, 1)
    return x, 2 * np.maximum(x - 1, 0) * (1 - fall), t


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("sign", [1, -1])
def test_speed_and_relaxation_of_a_press_that_holds(back: bool, sign: int) -> None:
    x, force, t = held(0.5, 10, 0.2, back)
    found = press_time(sign * x, sign * force, t)
    assert found is not None
    assert found.speed_mm_per_s == pytest.approx(0.5, rel=1e-6)
    assert found.held_s == pytest.approx(10, abs=0.5)
    assert found.relaxed == pytest.approx(0.2, abs=0.02)


def test_a_press_that_turns_at_once_says_nothing_of_relaxation() -> None:
    found = press_time(*held(0.1, 0, 0, back=True))
    assert found is not None
    assert (found.held_s, np.isnan(found.relaxed)) == (0, True)


def test_a_clock_that_stands_or_runs_backwards_is_no_clock() -> None:
    x, force, t = held(0.5, 0, 0)
    assert press_time(x, force, t[::-1]) is None
    assert press_time(x, force, np.zeros_like(t)) is None
