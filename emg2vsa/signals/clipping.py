"""What an amplifier that saturates takes from the level of EMG, by the two laws that EMG's amplitude lies between."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats

MOST = 0.6
"Level over the rail up to which the loss is known: of a square wave it is 1."
_SIZES = np.geomspace(0.02, 20, 400)


def _of_gauss(sd: Floats) -> Floats:
    """Mean rectified value of noise of this SD that saturates at 1."""
    return np.asarray(np.sqrt(2 / np.pi) * sd * -np.expm1(-0.5 / sd**2) + special.erfc(np.sqrt(0.5) / sd))


def _of_laplace(mean: Floats) -> Floats:
    """Likewise, by the mean rectified value before."""
    return -mean * np.expm1(-1 / mean)


class Rail(NamedTuple):
    """of_v : value above which a saturated channel has no sample. law : 0 where the samples that do not reach it are
    Gaussian, 1 where they have Laplace's law. sides : 1 or 2 that saturate. hard : samples pile up below it; where they
    do not, those below are smaller too, by nobody knows how much."""

    of_v: float
    law: float
    sides: int = 2
    hard: bool = True


def law_of(pieces: Sequence[Floats], size: int) -> float:
    """The ``law`` of a ``Rail``, 0 (Gauss) to 1 (Laplace), by root mean square over mean rectified value.

    pieces : samples (k,) each, cut into blocks of ``size``. 0.5 where none is so long.
    """
    blocks = np.concatenate([piece[: piece.size // size * size].reshape(-1, size) for piece in pieces])
    ratio = np.sqrt(np.mean(blocks**2, axis=1)) / np.maximum(np.mean(np.abs(blocks), axis=1), 1e-300)
    gauss, laplace = np.sqrt(np.pi / 2), np.sqrt(2)
    return float(np.clip((ratio.mean() - gauss) / (laplace - gauss), 0, 1)) if ratio.size else 0.5


def unclipped(levels_v: Floats, rail: Rail) -> tuple[Floats, Floats, Floats] | None:
    """Levels (n,) that a channel which saturates would show: by its own law, by Gauss's, and by Laplace's; None where
    too little is left of it to tell."""
    ratio = levels_v / rail.of_v
    if not rail.hard or np.max(ratio, initial=0.0) > MOST:
        return None
    gauss, laplace = (
        levels_v * (1 + rail.sides / 2 * (np.interp(ratio, read, true / read) - 1))
        for read, true in ((_of_gauss(_SIZES), np.sqrt(2 / np.pi) * _SIZES), (_of_laplace(_SIZES), _SIZES))
    )
    return gauss + rail.law * (laplace - gauss), gauss, laplace
