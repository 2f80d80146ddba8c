"""The static frame of a long rest: the choice of all forces, without looking at all of them at every frame."""

from __future__ import annotations

import numpy as np
import pytest

import casr.rest_frame
from casr.frames import loading_phase
from casr.rest_frame import RestFrame

START_N = 0.5


def test_a_long_rest_is_looked_at_ever_more_rarely(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = []

    def counted(force_n, **how):
        looks.append(len(force_n))
        return loading_phase(force_n, **how)

    monkeypatch.setattr(casr.rest_frame, "loading_phase", counted)
    rest, image = RestFrame(START_N), np.zeros((1, 1), np.uint8)
    for _ in range(20_000):
        rest.take(image, 0.0)
    assert len(looks) < 20_000 / 32 / 2
    assert looks[1] - looks[0] == 32


def test_the_frame_is_the_choice_of_all_forces_where_it_is_still_held() -> None:
    rng, rest = np.random.default_rng(1), RestFrame(START_N)
    force_n = 0.01 * rng.standard_normal(9000)
    for k, force in enumerate(force_n.tolist()):
        rest.take(np.array([[k % 256]], np.uint8), force)
    chosen = loading_phase(np.append(force_n, (START_N, 2 * START_N)), start_n=START_N).rest
    assert force_n.size - chosen < 64
    assert rest.image()[0, 0] == chosen % 256
