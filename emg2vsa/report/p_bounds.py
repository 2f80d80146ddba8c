"""p that a design can reach at all: what is printed below cannot come from the test that is named."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Ints
from emg2vsa.stats.dunn import smallest_worst_p


def dunn_bounds(count: Ints) -> tuple[float, float] | None:
    """Smallest p of the worst pair, uncorrected and with Bonferroni, for groups of ``count`` (k,) untied values.

    None where the sizes differ: the bound is that of groups in a row without overlap, which only equal sizes make best.
    """
    sizes = np.unique(count)
    if sizes.size != 1 or sizes[0] < 1 or count.size < 2:
        return None
    groups, each = count.size, int(sizes[0])
    return smallest_worst_p(groups, each, "none"), smallest_worst_p(groups, each, "bonferroni")
