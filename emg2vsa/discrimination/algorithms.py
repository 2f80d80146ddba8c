"""Old and new vision algorithm side by side, on the same presses: initial area and CASR (paper, VI.A)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import RunTable, mean_of
from emg2vsa.discrimination.separation import Gaps, closest_pair, gaps_of, pressed_everywhere, repetition_cv
from emg2vsa.settings import DiscriminationSettings


@dataclass(frozen=True)
class AlgorithmComparison:
    """Of A algorithms in D designs; (A, D) unless said, over the ``specimens`` pressed in every design.

    names : (A,), the one that is tested first, then the old one. area : (A, D, S) mean A_c0. area_ratio : to that of
    the first, mean of presses. area_error, area_error_sd : A_c0 over its truth less 1, mean and SD of presses; NaN
    where nobody knows the truth. area_cv, casr_cv : SD of repeated presses over their mean. gaps : of the ``pair`` of
    specimens that lies closest, A D of them, algorithm by algorithm.
    """

    names: tuple[str, ...]
    specimens: tuple[str, ...]
    area: Floats
    area_ratio: Floats
    area_error: Floats
    area_error_sd: Floats
    area_cv: Floats
    casr_cv: Floats
    pair: tuple[str, str]
    gaps: Gaps

    def gap(self, algorithm: int, design: int) -> tuple[float, float, float]:
        """The gap with its interval."""
        i = algorithm * self.area_ratio.shape[1] + design
        return float(self.gaps.gap[i]), float(self.gaps.low[i]), float(self.gaps.high[i])


def compare_algorithms(table: RunTable, settings: DiscriminationSettings) -> AlgorithmComparison:
    """All algorithms that the runs were scored with."""
    names = tuple(dict.fromkeys((table.algorithm, settings.old_algorithm, *table.casr)))
    names = tuple(name for name in names if name in table.casr)
    used = pressed_everywhere(table.casr[names[0]])
    area = np.stack([table.a_c0[name][:, used] for name in names])
    casr = np.stack([table.casr[name][:, used] for name in names])
    a, d, s, r = area.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (area / area[0]).reshape(a, d, s * r)
        error = (area / table.true_a_c0[:, used] - 1).reshape(a, d, s * r)
    mean_error = mean_of(error)
    specimens = tuple(table.specimens[i] for i in used)
    pair = closest_pair(casr[0])
    return AlgorithmComparison(
        names=names,
        specimens=specimens,
        area=mean_of(area),
        area_ratio=mean_of(ratio),
        area_error=mean_error,
        area_error_sd=np.sqrt(mean_of((error - mean_error[..., None]) ** 2)),
        area_cv=repetition_cv(area),
        casr_cv=repetition_cv(casr),
        pair=(specimens[pair], specimens[pair + 1]),
        gaps=gaps_of(casr[:, :, pair : pair + 2].reshape(a * d, 2, r), 1 - settings.alpha),
    )
