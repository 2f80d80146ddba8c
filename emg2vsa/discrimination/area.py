"""The initial area: does it hang on the specimen, and on the angle (paper, VI.A and Fig. 8)?

Compared is the area at the force where loading begins. A_c0 itself, the area of the first frame after that, grows with
the force at which that frame happens to come.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, mean_of
from emg2vsa.companions.groups import (
    EqualityTests,
    GroupTests,
    NormalityTests,
    PairTests,
    equality_tests,
    group_tests,
    normality_of,
    pair_tests,
)
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.settings import DiscriminationSettings


@dataclass(frozen=True)
class AreaBySpecimen:
    """Known specimens compared within each of D designs: the paper's claim is that it is the same.

    normality : of the D S cells, design by design. equality : of areas over the design's mean, so that its margin is a
    share. softest_over_stiffest : (D,) ratio of their means.
    """

    normality: NormalityTests
    groups: GroupTests
    equality: EqualityTests
    softest_over_stiffest: Floats


@dataclass(frozen=True)
class AreaByAngle:
    """Angles compared: all specimens of a condition together ("" in ``specimens``), then each specimen alone.

    conditions, specimens : (q,) of each comparison. angles_deg : (A,), the groups. mean : (q, A) of the areas.
    """

    conditions: tuple[str, ...]
    specimens: tuple[str, ...]
    angles_deg: Floats
    mean: Floats
    groups: GroupTests
    pairs: PairTests

    def worst_p(self, i: int) -> float:
        """Largest p of the paper's pairwise comparison (mean ranks, Bonferroni); NaN where there is none."""
        return float(np.fmax.reduce(self.pairs.dunn.p[i], initial=np.nan))

    def falls(self, i: int) -> bool:
        """Whether the mean area falls with every larger angle."""
        mean = self.mean[i][np.isfinite(self.mean[i])]
        return bool(mean.size > 1 and np.all(np.diff(mean) < 0))


def area_by_specimen(table: RunTable, settings: DiscriminationSettings) -> AreaBySpecimen:
    """Kruskal-Wallis of the known specimens, with what absence of evidence needs beside it: margin, Bayes factor."""
    values = table.start_area[table.algorithm][:, table.known]
    groups = group_tests(values, 1 - settings.alpha)
    d, k, n = values.shape
    centre = mean_of(values.reshape(d, k * n))
    relative = values / centre[:, None, None]
    anova = group_tests(relative, 1 - settings.alpha).anova
    mean = groups.anova.mean
    return AreaBySpecimen(
        normality=normality_of(values.reshape(d * k, n)),
        groups=groups,
        equality=equality_tests(relative, anova, settings.alpha, settings.equivalence_margin),
        softest_over_stiffest=mean[:, -1] / mean[:, 0],
    )


def area_by_angle(table: RunTable, settings: DiscriminationSettings) -> AreaByAngle | None:
    """None where no condition was pressed at two angles."""
    angles = np.unique(table.angles_deg)
    several = [c for c in dict.fromkeys(table.conditions) if len(table.of_condition(c)) > 1]
    if not several:
        return None
    values = table.start_area[table.algorithm][:, table.known]
    _, k, n = values.shape
    comparisons = np.full((len(several), 1 + k, angles.size, k * n), np.nan)
    for i, condition in enumerate(several):
        for design in table.of_condition(condition):
            angle = int(np.searchsorted(angles, table.angles_deg[design]))
            comparisons[i, 0, angle] = values[design].ravel()
            comparisons[i, 1:, angle, :n] = values[design]
    stacked = comparisons.reshape(-1, angles.size, k * n)
    groups = group_tests(stacked, 1 - settings.alpha)
    return AreaByAngle(
        conditions=tuple(c for c in several for _ in range(1 + k)),
        specimens=("", *(table.specimens[i] for i in table.known)) * len(several),
        angles_deg=angles,
        mean=groups.anova.mean,
        groups=groups,
        pairs=pair_tests(stacked, groups, 1 - settings.alpha),
    )
