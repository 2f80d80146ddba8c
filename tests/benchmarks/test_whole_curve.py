"""The benchmark of whole curves: its worlds are what it says, and spm1d finds the same ranges of force."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import whole_curve as bench


@pytest.mark.parametrize("world", bench.WORLDS)
def test_no_world_has_a_difference(world: str) -> None:
    y = np.concatenate([bench.null_study(world, 14, seed) for seed in range(150)])
    error = y.std(axis=0) / np.sqrt(len(y))
    assert np.all(np.abs(y.mean(axis=0)) < 5.5 * error)


def test_signs_of_five_people_cannot_reach_five_percent() -> None:
    y = bench.null_study("memory", 5, 0)
    y[:, 0] += 100
    assert bench.signs_p(y, 0) == pytest.approx(1 / 16)
    y = bench.null_study("memory", 14, 0)
    y[:, 0] += 100
    assert bench.signs_p(y, 0) < 0.01


@pytest.mark.parametrize("specimens", [2, 3], ids=["paired t", "repeated-measures F"])
def test_spm1d_finds_the_same_ranges(specimens: int) -> None:
    pytest.importorskip("spm1d", reason="spm1d is not installed: it is GPL, and no dependency")
    for seed in range(5):
        y = bench.smooth_study(14, specimens, 3.0, seed)
        (ours, ranges), (theirs, by_spm1d) = bench.by_us(y, seed, 9_999), bench.by_spm1d(y)
        assert ours == pytest.approx(theirs, rel=0.15)
        assert len(ranges) == len(by_spm1d)
        assert np.abs(np.array(ranges) - np.array(by_spm1d)).max() <= 1
