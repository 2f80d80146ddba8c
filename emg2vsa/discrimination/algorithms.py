"""Old and new vision algorithm side by side, on the same presses: initial area and CASR (paper, VI.A)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import RunTable, mean_of
from emg2vsa.discrimination.separation import pressed_everywhere, repetition_cv, smallest_gap
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.stats.bootstrap import Bootstrap, bca


@dataclass(frozen=True)
class AlgorithmComparison:
    """Of A algorithms in D designs; (A, D) unless said, over the ``specimens`` pressed in every design.

    names : (A,), the one that is tested first, then the old one. area : (A, D, S) mean A_c0. area_ratio : to that of
    the first, mean of presses. area_error, area_error_sd : A_c0 over its truth less 1, mean and SD of presses; NaN
    where nobody knows the truth. area_cv, casr_cv : SD of repeated presses over their mean. gap : ``smallest_gap``
    between specimens, its A D designs algorithm by algorithm.
    """

    names: tuple[str, ...]
    specimens: tuple[str, ...]
    area: Floats
    area_ratio: Floats
    area_error: Floats
    area_error_sd: Floats
    area_cv: Floats
    casr_cv: Floats
    gap: Bootstrap

    def gap_of(self, algorithm: int, design: int) -> tuple[float, float, float]:
        """The smallest gap with its interval."""
        i = algorithm * self.area_ratio.shape[1] + design
        return float(self.gap.estimate[i]), float(self.gap.low[i]), float(self.gap.high[i])


def compare_algorithms(table: RunTable, settings: DiscriminationSettings) -> AlgorithmComparison:
    """All algorithms that the runs were scored with."""
    names = tuple(dict.fromkeys((settings.algorithm, settings.old_algorithm, *table.casr)))
    names = tuple(name for name in names if name in table.casr)
    used = pressed_everywhere(table.casr[names[0]])
    area = np.stack([table.a_c0[name][:, used] for name in names])
    casr = np.stack([table.casr[name][:, used] for name in names])
    a, d, s, r = area.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (area / area[0]).reshape(a, d, s * r)
        error = (area / table.true_a_c0[:, used] - 1).reshape(a, d, s * r)
    mean_error = mean_of(error)
    return AlgorithmComparison(
        names=names,
        specimens=tuple(table.specimens[i] for i in used),
        area=mean_of(area),
        area_ratio=mean_of(ratio),
        area_error=mean_error,
        area_error_sd=np.sqrt(mean_of((error - mean_error[..., None]) ** 2)),
        area_cv=repetition_cv(area),
        casr_cv=repetition_cv(casr),
        gap=bca(
            casr.reshape(a * d, s, r), smallest_gap, settings.resamples, settings.seed, 1 - settings.alpha,
            "smallest gap in SDs",
        ),
    )  # fmt: skip
