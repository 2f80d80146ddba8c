"""CASR: does it tell the known specimens apart, and do softer ones have the larger (paper, VI)?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import GroupTests, group_tests
from emg2vsa.companions.normality import NormalityTests, normality_of
from emg2vsa.companions.pairs import PairTests, pair_tests
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.settings import DiscriminationSettings


@dataclass(frozen=True)
class SpreadBySpecimen:
    """Known specimens, stiffest first, compared within each of D designs.

    normality : of the D S cells. pairs : the paper's mean ranks with Bonferroni's correction are ``pairs.dunn``, the
    companions with Holm's are the exact Mann-Whitney tests. rises : (D,) whether every softer specimen has the larger
    mean.
    """

    specimens: tuple[str, ...]
    normality: NormalityTests
    groups: GroupTests
    pairs: PairTests
    rises: NDArray[np.bool_]

    @property
    def worst_p(self) -> Floats:
        """(D,) largest p of the paper's pairwise comparison; NaN where there is none."""
        return _largest(self.pairs.dunn.p)

    @property
    def worst_p_holm(self) -> Floats:
        """(D,) largest p of the exact Mann-Whitney tests, Holm."""
        return _largest(self.pairs.p_rank_holm)


def spread_by_specimen(table: RunTable, settings: DiscriminationSettings) -> SpreadBySpecimen:
    """Kruskal-Wallis and all pairs of the known specimens."""
    values = table.casr[table.algorithm][:, table.known]
    d, k, n = values.shape
    groups = group_tests(values, 1 - settings.alpha)
    return SpreadBySpecimen(
        specimens=tuple(table.specimens[i] for i in table.known),
        normality=normality_of(values.reshape(d * k, n)),
        groups=groups,
        pairs=pair_tests(values, groups, 1 - settings.alpha),
        rises=np.all(np.diff(groups.anova.mean, axis=1) > 0, axis=1),
    )


def _largest(p: Floats) -> Floats:
    return np.asarray(np.fmax.reduce(p, axis=1, initial=np.nan))
