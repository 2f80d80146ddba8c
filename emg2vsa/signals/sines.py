"""Amplitude and phase of sines in pieces of a record, each under a window of Hann's."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.signals.products import times

Phasors = NDArray[np.complex128]

BLOCK = 128
"Samples in a block of a piece."


def sine_phasors(channels: Sequence[Floats], pieces: Sequence[tuple[int, int]], hz: Floats, fs_hz: float) -> Phasors:
    """Amplitudes and phases (m, q, h) of sines (h,) in the pieces [begin, end) of channels (n,).

    The phase is that at the first sample of the piece. A sine over k blocks is the sine over one block, turned k times:
    so one small table of sines serves all blocks of all pieces, and another turns the blocks.
    """
    radians = 2 * np.pi / fs_hz * hz
    longest = max((end - begin for begin, end in pieces), default=0)
    n_blocks = -(-longest // BLOCK)
    within = np.exp(-1j * np.multiply.outer(np.arange(BLOCK), radians)).view(np.float64)
    turns = np.exp(-1j * BLOCK * np.multiply.outer(np.arange(n_blocks), radians))
    found = np.empty((len(channels), len(pieces), hz.size), dtype=np.complex128)
    padded = np.zeros((len(channels), n_blocks * BLOCK))
    for i, (begin, end) in enumerate(pieces):
        size = end - begin
        window = hann_of_sines(size)
        for row, samples in zip(padded, channels, strict=True):
            np.multiply(window, samples[begin:end], out=row[:size])
        padded[:, size:] = 0.0
        used = -(-size // BLOCK)
        of_block = times(padded[:, : used * BLOCK].reshape(-1, used, BLOCK), within).view(np.complex128)
        found[:, i] = np.einsum("mbh,bh->mh", of_block, turns[:used])
    return found


@lru_cache(maxsize=64)
def hann_of_sines(size: int) -> Floats:
    """Hann's window (size,), symmetric about the middle, by which a sum of samples gives the amplitude of a sine."""
    window = np.sin(np.pi * (np.arange(size) + 0.5) / size) ** 2
    window *= 2 / window.sum()
    window.flags.writeable = False
    return window
