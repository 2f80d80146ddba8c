"""Which groups differ? The paper's uncorrected LSD, and the post-hoc tests that hold the error of the family."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.groups import GroupTests
from emg2vsa.statistics.effect_size import hedges_g
from emg2vsa.statistics.kruskal import RankPairs, dunn
from emg2vsa.statistics.mann_whitney import MannWhitney, mann_whitney
from emg2vsa.statistics.multiplicity import adjust
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import PairDifferences, lsd, tukey
from emg2vsa.statistics.welch import games_howell


@dataclass(frozen=True)
class PairTests:
    """Tests of all q pairs of d designs; arrays (d, q) unless said.

    p_holm, p_fdr : of the unprotected LSD, Holm and Benjamini-Hochberg over the q pairs of a design. p_rank_holm : of
    the exact Mann-Whitney. g, g_low, g_high : Hedges' from the two groups' pooled t.
    """

    lsd: PairDifferences
    p_holm: Floats
    p_fdr: Floats
    tukey: PairDifferences
    games_howell: PairDifferences
    dunn: RankPairs
    mann_whitney: MannWhitney
    p_rank_holm: Floats
    g: Floats
    g_low: Floats
    g_high: Floats

    @property
    def first(self) -> Ints:
        return self.lsd.first

    @property
    def second(self) -> Ints:
        return self.lsd.second

    def outcomes(self, i: int, pair: int) -> tuple[Outcome, ...]:
        """All tests of one pair of design ``i``."""
        uncorrected, ranks = self.lsd.outcome(i, pair), self.mann_whitney.outcome(i, pair)
        note = f"p corrected over the {self.first.size} pairs, the interval is not"
        corrected = (note, *self.lsd.undefined(i, pair))
        return (
            uncorrected,
            replace(
                uncorrected, method="pairwise t, pooled SD, Holm", p=float(self.p_holm[i, pair]),
                notes=corrected, effect_name="Hedges g",
                effect_size=float(self.g[i, pair]),
            ),
            replace(
                uncorrected, method="pairwise t, pooled SD, false discovery rate (Benjamini-Hochberg)",
                p=float(self.p_fdr[i, pair]), notes=corrected,
            ),
            self.tukey.outcome(i, pair),
            self.games_howell.outcome(i, pair),
            self.dunn.outcome(i, pair),
            replace(
                ranks, method=f"{ranks.method}, Holm", p=float(self.p_rank_holm[i, pair]),
                notes=(*ranks.notes, note),
            ),
        )  # fmt: skip


def pair_tests(
    values: ArrayLike, groups: GroupTests, confidence: float = 0.95, *, protected: bool = False
) -> PairTests:
    """All pairs of ``values`` (d, k, n) whose ``groups`` were tested before. protected : of the LSD, see there."""
    uncorrected = lsd(groups.anova, confidence)
    ranks = mann_whitney(values, confidence)
    g, low, high = _hedges(groups, uncorrected.first, uncorrected.second, confidence)
    return PairTests(
        lsd=lsd(groups.anova, confidence, protected=True) if protected else uncorrected,
        p_holm=adjust(uncorrected.p, "holm"),
        p_fdr=adjust(uncorrected.p, "fdr_bh"),
        tukey=tukey(groups.anova, confidence),
        games_howell=games_howell(values, confidence),
        dunn=dunn(groups.kruskal),
        mann_whitney=ranks,
        p_rank_holm=adjust(ranks.p, "holm"),
        g=g,
        g_low=low,
        g_high=high,
    )


def _hedges(groups: GroupTests, first: Ints, second: Ints, confidence: float) -> tuple[Floats, Floats, Floats]:
    """From the t of the two groups alone: their own SDs, not that of all groups."""
    count, mean, sd = groups.anova.count, groups.anova.offset, groups.sd
    n1, n2 = count[:, first], count[:, second]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (n1 - 1) / (n1 + n2 - 2)
        pooled = np.hypot(np.sqrt(share) * sd[:, first], np.sqrt(1 - share) * sd[:, second])
        t = (mean[:, first] - mean[:, second]) / (pooled * np.sqrt(1 / n1 + 1 / n2))
    return hedges_g(np.where(np.isfinite(t), t, np.nan), np.maximum(n1, 2), np.maximum(n2, 2), confidence)
