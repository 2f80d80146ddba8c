"""n of Algorithm 1 against a second implementation, written from the paper's text."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.algorithm_1 import first_contact, mask_centroids, selected_pins
from casr.contact_area import initial_area
from casr.pins import PinTracker
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press

QUICK = TimelineSettings(loading_s=1.0)
PRESSES = list(product(("S1", "S3", "S5"), (0.0, 45.0), range(5)))

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]


@pytest.fixture(scope="module")
def pairs() -> list[Pair]:
    """The static frame and the first in contact of 30 presses."""
    return [
        first_contact(
            simulate_press(
                PressSettings(
                    stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle, repetition=repetition, timeline=QUICK
                )
            ).sequence()
        )
        for specimen, angle, repetition in PRESSES
    ]


def test_n_is_that_of_a_second_implementation(pairs: list[Pair]) -> None:
    rng = np.random.default_rng(3)
    found, again, apart = [], [], []
    for rest, contact in pairs:
        tracker = PinTracker()
        pins, moved = tracker.start(rest), tracker.step(contact)
        found.append(initial_area(pins, moved, rule="paper").selected.size)
        seen = moved[np.isfinite(moved).all(axis=1)]
        again.append(selected_pins(rng.permutation(pins.centroids_px), rng.permutation(seen)))
        apart.append(selected_pins(mask_centroids(rest), mask_centroids(contact)) - found[-1])
    assert found == again
    assert min(found) < 10 < 20 < max(found)
    # a mask of its own moves centroids by a tenth of a pixel, and whole pixels turn that into a pin more or less; into
    # several in a press whose pins move alike, by just the threshold
    assert np.median(apart) == 0
    assert np.count_nonzero(np.abs(apart) <= 1) >= 27


def test_pins_that_move_by_more_than_half_a_pitch_find_no_other_partner() -> None:
    rest = np.array([[10.0, 10.0], [30.0, 10.0], [50.0, 10.0]])
    moved = rest + np.array([[0.0, 2.0], [0.0, 3.0], [12.0, 0.0]])
    assert selected_pins(rest, moved[::-1]) == 2
