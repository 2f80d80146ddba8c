"""Counts of the emulated force sensor, of loads that change and loads that stay."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.worlds.far_ends.netft_box import LEAST_COUNT, MOST_COUNT, NO_LOAD, NoisyCounts

NOISE, PER_UNIT = (0.005, 0.0001), (1_000_000, 2_000_000)
PRESSED, FAR_OUT = [0.3, -0.1, 2.5, 0.01, 0.0, -0.02], [0.0, 0.0, 5000.0, 0.0, -3000.0, 0.0]
BIAS = [0.1, 0.0, -0.2, 0.0, 0.001, 0.0]


def one_by_one(loads: list[tuple[list[float], list[float]]], seed: int) -> list[tuple[int, ...]]:
    """Each record by itself, from one long draw."""
    noise = np.repeat(NOISE, 3) * np.random.default_rng(seed).standard_normal((len(loads), 6))
    per_unit = [PER_UNIT[0]] * 3 + [PER_UNIT[1]] * 3
    return [
        tuple(
            max(LEAST_COUNT, min(MOST_COUNT, round((on - off + extra) * counts)))
            for on, off, extra, counts in zip(load, bias, row, per_unit, strict=True)
        )
        for (load, bias), row in zip(loads, noise.tolist(), strict=True)
    ]


@pytest.mark.parametrize("stays", [1, 2, 7, 300])
def test_counts_are_those_of_each_record_by_itself(stays: int) -> None:
    rng, kinds = np.random.default_rng(stays), [(list(NO_LOAD), list(NO_LOAD)), (PRESSED, BIAS), (FAR_OUT, BIAS)]
    loads = [kinds[int(rng.integers(3))] for _ in range(900 // stays + 1) for _ in range(stays)]
    counts = NoisyCounts(NOISE, PER_UNIT, seed=5)
    found = [counts.of(load, bias) for load, bias in loads]
    assert found == one_by_one(loads, seed=5)
    assert {MOST_COUNT, LEAST_COUNT} <= {count for record in found for count in record}


@pytest.mark.parametrize("skipped", [0, 1, 4, 255, 256, 257, 700])
def test_records_that_nobody_looks_at_take_their_noise_with_them(skipped: int) -> None:
    loads = [(PRESSED, BIAS)] * (skipped + 303)
    counts, all_of_them = NoisyCounts(NOISE, PER_UNIT, seed=3), one_by_one(loads, seed=3)
    found = [counts.of(*load) for load in loads[:3]]
    counts.skip(skipped)
    found += [counts.of(*load) for load in loads[skipped + 3 :]]
    assert found == all_of_them[:3] + all_of_them[skipped + 3 :]
