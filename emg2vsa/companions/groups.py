"""Do groups differ, and which? The paper's one-way analysis of variance with its uncorrected LSD, what does not rest on
their assumptions, and the post-hoc tests that hold the error of the family.

Is each sample Gaussian? The paper's Kolmogorov-Smirnov in both its forms, and the two tests that can tell. Are groups
equal? Not having found a difference does not say so: what the data bound, and tests against a margin.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints, unmasked
from emg2vsa.shown import shown
from emg2vsa.statistics.anova import Anova, brown_forsythe, one_way, welch
from emg2vsa.statistics.bayes import BayesFactors, jzs_anova
from emg2vsa.statistics.effect_size import hedges_g, omega2, share_interval
from emg2vsa.statistics.equivalence import MarginUnit, tost_in_parts
from emg2vsa.statistics.kruskal import KruskalWallis, RankPairs, dunn, kruskal
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.mann_whitney import MannWhitney, mann_whitney
from emg2vsa.statistics.moments import group_moments
from emg2vsa.statistics.multiplicity import adjust
from emg2vsa.statistics.normality import ks_normal, shapiro_wilk
from emg2vsa.statistics.outcome import Outcome, Outcomes
from emg2vsa.statistics.post_hoc import PairDifferences, games_howell, lsd, tukey


@dataclass(frozen=True)
class NormalityTests:
    """Four tests of k samples, row by row."""

    standardised: Outcomes
    raw: Outcomes
    lilliefors: Outcomes
    shapiro: Outcomes

    def outcomes(self, i: int) -> tuple[Outcome, ...]:
        """All tests of sample ``i``."""
        return tuple(tests.outcome(i) for tests in (self.standardised, self.raw, self.lilliefors, self.shapiro))


def normality_of(values: ArrayLike, origin: float = 0.0) -> NormalityTests:
    """Test each row of ``values`` (k, n), relative to ``origin``; NaN marks a value that is not there."""
    values = np.asarray(unmasked(values), dtype=np.float64)
    return NormalityTests(
        standardised=ks_normal(values, standardise=True),
        raw=ks_normal(values + origin, standardise=False),
        lilliefors=lilliefors(values),
        shapiro=shapiro_wilk(values),
    )


@dataclass(frozen=True)
class GroupTests:
    """Tests of d one-way designs of k groups.

    omega2 : (d,) share of the population's variance that lies between groups; eta2_low, eta2_high : (d,) its interval,
    the same share's that the sample's eta squared overstates. sd : (d, k) of each group, NaN below two values.
    """

    anova: Anova
    omega2: Floats = field(metadata=shown("ω²"))
    eta2_low: Floats = field(metadata=shown("ω² low"))
    eta2_high: Floats = field(metadata=shown("ω² high"))
    welch: Outcomes
    brown_forsythe: Outcomes
    kruskal: KruskalWallis
    bayes: BayesFactors
    sd: Floats
    confidence: float

    def anova_outcome(self, i: int = 0) -> Outcome:
        """The analysis of variance of design ``i`` with the interval of its effect."""
        return replace(
            self.anova.outcome(i),
            estimate_name="omega2",
            estimate=float(self.omega2[i]),
            interval=(float(self.eta2_low[i]), float(self.eta2_high[i])),
            confidence=self.confidence,
        )

    def outcomes(self, i: int = 0) -> tuple[Outcome, ...]:
        """All tests of design ``i``."""
        others = (self.welch, self.brown_forsythe, self.kruskal, self.bayes)
        return (self.anova_outcome(i), *(tests.outcome(i) for tests in others))


def group_tests(values: ArrayLike, confidence: float = 0.95) -> GroupTests:
    """Test ``values`` (d, k groups, n a group), or one design (k, n); NaN: no value there. DataError as ``one_way``."""
    anova = one_way(values)
    n = np.sum(anova.count, axis=1)
    low, high = share_interval(anova.f, anova.df1, anova.df2, n, confidence)
    groups = group_moments(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(np.where(groups.counts > 1, groups.squares / (groups.counts - 1), np.nan))
    return GroupTests(
        anova=anova,
        omega2=omega2(anova.f, anova.df1, n),
        eta2_low=low,
        eta2_high=high,
        welch=welch(values),
        brown_forsythe=brown_forsythe(values),
        kruskal=kruskal(values),
        bayes=jzs_anova(values),
        sd=groups.to_data(sd),
        confidence=confidence,
    )


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
    g: Floats = field(metadata=shown("g"))
    g_low: Floats = field(metadata=shown("g low"))
    g_high: Floats = field(metadata=shown("g high"))

    @property
    def first(self) -> Ints:
        """(q,) number of the first group of each pair."""
        return self.lsd.first

    @property
    def second(self) -> Ints:
        """(q,) number of the second group of each pair."""
        return self.lsd.second

    @property
    def corrected(self) -> dict[str, Floats]:
        """p (d, q) of every pair by each test that is corrected for their number."""
        return {
            "holm": self.p_holm, "tukey": self.tukey.p, "games_howell": self.games_howell.p, "fdr": self.p_fdr,
            "dunn": self.dunn.p, "mann_whitney": self.p_rank_holm,
        }  # fmt: skip

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
    """Hedges' g from the t of the two groups alone: their own SDs, not that of all groups."""
    count, mean, sd = groups.anova.count, groups.anova.offset, groups.sd
    n1, n2 = count[:, first], count[:, second]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (n1 - 1) / (n1 + n2 - 2)
        pooled = np.hypot(np.sqrt(share) * sd[:, first], np.sqrt(1 - share) * sd[:, second])
        t = (mean[:, first] - mean[:, second]) / (pooled * np.sqrt(1 / n1 + 1 / n2))
    return hedges_g(np.where(np.isfinite(t), t, np.nan), np.maximum(n1, 2), np.maximum(n2, 2), confidence)


@dataclass(frozen=True)
class EqualityTests:
    """Over all pairs of groups of d designs, of which only what is said of all is kept: many groups have too many.

    bound : (d,) smallest margin within which every pair would be shown equal, in the unit of the data; bound_sd : in
    pooled SDs of the design. pairs : (d,) that have a p, untested : that have none. margin, unit : as stated, None
    without one; then worst_p : (d,) largest p of two one-sided tests, and shown : (d,) pairs with p below ``alpha``,
    are NaN and 0.
    """

    bound: Floats
    bound_sd: Floats
    pairs: Ints
    untested: Ints
    worst_p: Floats
    shown: Ints
    margin: float | None
    unit: MarginUnit
    alpha: float

    @property
    def p(self) -> Floats:
        """Largest p of every design, (d,). Where a pair has none: that of the others if it is ``alpha`` or more, which
        settles that not all are equal, else NaN."""
        return np.where((self.untested > 0) & ~(self.worst_p >= self.alpha), np.nan, self.worst_p)


def equality_tests(
    values: ArrayLike, anova: Anova, alpha: float, margin: float | None = None, unit: MarginUnit = "data"
) -> EqualityTests:
    """Two one-sided tests of all pairs of ``values`` (d, k, n) whose ``anova`` is known; each at ``alpha``."""
    d = anova.sd.size
    bound, worst_p = np.full(d, np.nan), np.full(d, np.nan)
    pairs, untested, shown = (np.zeros(d, dtype=np.int64) for _ in range(3))
    for part in tost_in_parts(values, margin or 1.0, unit, alpha):  # the intervals do not depend on the margin
        ends = np.fmax(np.abs(part.low), np.abs(part.high))
        bound = np.fmax(bound, np.fmax.reduce(ends, axis=1))
        worst_p = np.fmax(worst_p, np.fmax.reduce(part.p, axis=1))
        there = np.isfinite(part.p)
        pairs += np.count_nonzero(there, axis=1)
        untested += np.count_nonzero(~there, axis=1)
        shown += np.count_nonzero(part.p < alpha, axis=1)
    if not margin:
        worst_p, shown = np.full(d, np.nan), np.zeros(d, dtype=np.int64)
    bound = np.where(np.isfinite(bound), bound, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        return EqualityTests(bound, bound / anova.sd, pairs, untested, worst_p, shown, margin, unit, alpha)
