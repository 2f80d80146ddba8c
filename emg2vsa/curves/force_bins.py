"""Means over force bins: the points of a fit whose errors are close to independent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.ragged import pad_rows, row_of_each
from emg2vsa.errors import SettingError


@dataclass(frozen=True)
class ForceBins:
    """force_n, v, samples : (k, B) force, activity and number of samples of every bin; NaN and 0 where empty.

    column : (k, longest) the bin of every sample of every trial, -1 outside the edges and beyond the trial's end.
    """

    force_n: Floats
    v: Floats
    samples: Ints
    column: Ints


def bin_edges(lowest_n: float, highest_n: float, bin_n: float) -> Floats:
    """Edges (B + 1,) from ``lowest_n`` in steps of ``bin_n``; a last, shorter bin is kept (0.5, 0.8, ... 6.8, 7)."""
    if not highest_n > lowest_n:
        raise SettingError(
            "window.force_n", wanted="a lower and a higher force", found=f"{lowest_n}, {highest_n} N", do="Swap them."
        )
    full = int(np.floor((highest_n - lowest_n) / bin_n * (1 + 1e-12)))
    edges = np.round(lowest_n + bin_n * np.arange(full + 1), 9)
    return edges if highest_n - edges[-1] < 1e-9 else np.append(edges, highest_n)


def bin_means(force_n: Floats, v: Floats, offsets: Ints, edges_n: Floats) -> ForceBins:
    """Bin the samples (N,) of k trials, cut by ``offsets`` (k + 1,); samples outside the edges are left out.

    The force of a bin is the geometric mean of its samples' forces, so that a law linear in ln F passes through the
    bin means exactly (the arithmetic mean would bias b by some tenths of a percent).
    """
    n_bins = edges_n.size - 1
    column = np.searchsorted(edges_n, force_n, side="right") - 1
    column[force_n == edges_n[-1]] = n_bins - 1
    inside = (column >= 0) & (column < n_bins) & np.isfinite(force_n) & np.isfinite(v)
    column[~inside] = -1
    cell = (row_of_each(offsets) * n_bins + column)[inside]
    shape = (offsets.size - 1, n_bins)
    samples = np.bincount(cell, minlength=shape[0] * n_bins)
    with np.errstate(invalid="ignore", divide="ignore"):
        log_force = np.bincount(cell, np.log(force_n[inside]), minlength=samples.size) / samples
        level = np.bincount(cell, v[inside], minlength=samples.size) / samples
    return ForceBins(
        np.exp(log_force).reshape(shape), level.reshape(shape), samples.reshape(shape), pad_rows(column, offsets, -1)
    )
