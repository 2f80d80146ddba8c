"""Recursive filters as products of matrices: a block of samples at a time, joined by the filter's state.

Within a block the output is a matrix times the samples; of all samples before it (and, in two passes, after it) only a
few numbers matter, the state. A product of matrices is several times faster than a recursion from sample to sample.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.signals.products import times

SIZE = 64
"Samples in a block: of the powers of two the fastest, for filters of one to four sections."
NOTHING = 1e-15
"Share of a state of which, when no more is left, nothing is carried on."


@dataclass(frozen=True)
class Blocks:
    """A filter of q poles on rows that hold ``SIZE`` samples, the state before them, and, of both passes, that after.

    output : (row, SIZE) from a row to its filtered samples. into : (SIZE, q) from samples to the state that they leave
    behind them; mirrored, of both passes : that which they leave before them. carry : (q, q) each; takes a state, as a
    row, over 1, 2, 4, ... blocks, until nothing is left of it.
    """

    output: Floats
    into: Floats
    mirrored: Floats | None
    carry: tuple[Floats, ...]


@lru_cache(maxsize=64)
def blocks_of(sos: bytes, both_passes: bool) -> Blocks:
    """The filter whose sections (sections, 6) are ``sos``, forward and backward or forward only.

    Both passes are one symmetric filter: the samples before count through its impulse response, those after through the
    mirror image of it. With P, the sum of (A^k)' C' C A^k over all k, its readout of a state is B' P A + D C.
    """
    a, b, c, d = _state_space(np.frombuffer(sos).reshape(-1, 6))
    powers = [np.eye(b.size)]
    for _ in range(SIZE):
        powers.append(powers[-1] @ a)
    carry = tuple(power.T.copy() for power in _doubled(powers[SIZE]))
    into = np.array([power @ b for power in powers[SIZE - 1 :: -1]])
    lag = np.subtract.outer(np.arange(SIZE), np.arange(SIZE))
    if not both_passes:
        readout = np.array([c @ power for power in powers[:SIZE]])
        response = np.concatenate(([d], readout[:-1] @ b))
        own = np.where(lag >= 0, response[np.abs(lag)], 0.0)
        return Blocks(np.concatenate((own.T, readout.T)), into, None, carry)
    seen = np.outer(c, c)
    for power in _doubled(a):
        seen = seen + power.T @ seen @ power
    readout = np.array([(b @ seen @ a + d * c) @ power for power in powers[:SIZE]])
    response = np.concatenate(([b @ seen @ b + d * d], readout[:-1] @ b))
    output = np.concatenate((response[np.abs(lag)], readout.T, readout[::-1].T))
    return Blocks(output, into, into[::-1].copy(), carry)


def fill_states(rows: Floats, filters: Blocks) -> None:
    """Fill in the states of rows (m, blocks, row), whose samples are there. Before and after all are zeros."""
    states = SIZE + filters.into.shape[1]
    samples, before, after = rows[..., :SIZE], rows[..., SIZE:states], rows[..., states:]
    forward = times(samples, filters.into)
    for reach, power in _within(filters, rows.shape[1]):
        forward[:, reach:] += times(forward[:, :-reach], power)
    before[:, 0], before[:, 1:] = 0.0, forward[:, :-1]
    if filters.mirrored is not None:
        backward = times(samples, filters.mirrored)
        for reach, power in _within(filters, rows.shape[1]):
            backward[:, :-reach] += times(backward[:, reach:], power)
        after[:, -1], after[:, :-1] = 0.0, backward[:, 1:]


def _within(filters: Blocks, n_blocks: int) -> Iterator[tuple[int, Floats]]:
    """The powers that carry a state over less than so many blocks, and over how many each does."""
    for i, power in enumerate(filters.carry):
        if 2**i >= n_blocks:
            return
        yield 2**i, power


def _doubled(power: Floats) -> Iterator[Floats]:
    """A, A^2, A^4, ... until nothing is left."""
    while np.max(np.abs(power)) > NOTHING:
        yield power
        power = power @ power


def _state_space(sos: Floats) -> tuple[Floats, Floats, Floats, float]:
    """A (q, q), B (q,), C (q,), D of the sections (sections, 6) one after the other: s' = A s + B x, y = C s + D x.

    A section's block of A turns and shrinks its pair of states, on a scale g of the distances of its poles from each
    other and from 1: the usual form, coefficients in the first row, would lose digits where poles lie near 1.
    """
    a, b, c, d = np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0
    for b0, b1, b2, _, a1, a2 in sos:
        mean = -a1 / 2
        # mean^2 - a2, without its cancellation where the poles are near 1 or -1
        spread = (1 - abs(mean)) ** 2 - (1 - abs(a1) + a2)
        radius = np.sqrt(a2) if spread < 0 else abs(mean) + np.sqrt(spread)
        g = max(np.sqrt(abs(spread)), 1 - radius)
        turn = np.array([[mean, g], [spread / g, mean]])
        entry, n1 = np.array([0.0, g]), b1 - b0 * a1
        read = np.array([(b2 - b0 * a2 + n1 * mean) / g**2, n1 / g])
        a = np.block([[a, np.zeros((b.size, 2))], [np.outer(entry, c), turn]])
        b, c, d = np.concatenate((b, d * entry)), np.concatenate((b0 * c, read)), b0 * d
    return a, b, c, float(d)
