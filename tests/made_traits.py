"""Traits of recordings that are made by hand."""

from __future__ import annotations

import numpy as np

from emg2vsa.signals.traits import POINTS, Traits


def unknown(muscles: tuple[str, ...], n_presses: int) -> Traits:
    """Nothing is known: no comparison says anything."""
    level, band = np.full(len(muscles), np.nan), np.full((len(muscles), 3), np.nan)
    nothing = np.empty(0)
    prints = np.full((n_presses, 2, POINTS), np.nan)
    return Traits(muscles, level, band, band[:, :0], level, nothing, nothing, np.nan, np.nan, np.nan, np.nan, prints)
