"""Counts of an emulated force sensor: a load, and noise that is drawn in blocks."""

from __future__ import annotations

from collections.abc import Sequence
from operator import add, mul, sub

import numpy as np

Counts = tuple[int, ...]
LEAST_COUNT, MOST_COUNT = -(2**31), 2**31 - 1
NO_LOAD = (0.0,) * 6
_BLOCK = 256
"Draws made at once; the counts come out the same for any number."


class NoisyCounts:
    """One record after the other. Of a load that stays, all counts of a block are made at once.

    Parameters
    ----------
    noise : standard deviation of force and torque. counts_per_unit : of force and torque. seed : of the draws.
    """

    def __init__(self, noise: tuple[float, float], counts_per_unit: tuple[int, int], seed: int) -> None:
        self._rng, self._size = np.random.default_rng(seed), np.repeat(noise, 3)
        # plain numbers too: six at a time are too few for arrays to pay
        self._per_unit = np.repeat(counts_per_unit, 3)
        self._each_per_unit: list[int] = self._per_unit.tolist()
        self._at = _BLOCK
        self._before: tuple[Sequence[float], Sequence[float]] = NO_LOAD, NO_LOAD
        "Load and bias of the record before."
        self._under: list[Counts] | None = None
        "Counts of the block under that load, once it has come twice."

    def of(self, load: Sequence[float], bias: Sequence[float]) -> Counts:
        """Six counts of the next record, under a load less a bias."""
        if self._at == _BLOCK:
            self._draw()
        row, self._at = self._at, self._at + 1
        if (load, bias) != self._before:
            self._before, self._under = (load, bias), None
            noisy = map(mul, map(add, map(sub, load, bias), self._rows[row]), self._each_per_unit)
            counts = tuple(map(round, noisy))
            if min(counts) >= LEAST_COUNT and max(counts) <= MOST_COUNT:
                return counts
            return tuple([max(LEAST_COUNT, min(MOST_COUNT, count)) for count in counts])  # far out of range
        if self._under is None:
            noisy_units = np.subtract(load, bias) + self._noise
            counts_of_block = np.rint(noisy_units * self._per_unit).clip(LEAST_COUNT, MOST_COUNT).astype(np.int64)
            self._under = list(map(tuple, counts_of_block.tolist()))
        return self._under[row]

    def skip(self, records: int) -> None:
        """So many records that nobody looks at: those after them come out as if these had been made."""
        self._at += records
        while self._at > _BLOCK:
            left = self._at - _BLOCK
            self._draw()
            self._at = left

    def _draw(self) -> None:
        self._noise = self._size * self._rng.standard_normal((_BLOCK, 6))
        self._rows, self._at, self._under = self._noise.tolist(), 0, None
