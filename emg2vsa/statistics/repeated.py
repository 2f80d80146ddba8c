"""Treatments on the same people: repeated-measures analysis of variance with the agreement that follows from it,
Friedman's test by ranks, and pairs of treatments by Student's paired t and by Wilcoxon's signed ranks, exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of, unmasked
from emg2vsa.statistics.effect_size import paired_g
from emg2vsa.statistics.kruskal import midranks
from emg2vsa.statistics.moments import shifted_doubles, without_rounding
from emg2vsa.statistics.outcome import Outcome, Outcomes
from emg2vsa.statistics.post_hoc import PairDifferences, pair_numbers, student_pairs

MOST_EXACT = 100
"""People up to whom all signs are counted; beyond, the law of the signed ranks is taken as normal."""


@dataclass(frozen=True)
class RepeatedAnova:
    """d designs of k treatments; (d,) unless said, NaN where undefined.

    f, df1, df2, p : sphericity assumed. epsilon_gg, epsilon_hf : of Greenhouse and Geisser (1959) and Huynh and Feldt
    (1976), from 1 / (k - 1) to 1; p_gg, p_hf : with both df times epsilon. mauchly_p : sphericity, NaN for k = 2 or
    n < k. eta2_generalised (Olejnik and Algina 2003). people_f : F of no difference between people. n : people
    without a gap; left_out : the others.
    """

    f: Floats
    df1: int
    df2: Ints
    p: Floats
    epsilon_gg: Floats
    epsilon_hf: Floats
    p_gg: Floats
    p_hf: Floats
    mauchly_p: Floats
    eta2_generalised: Floats
    people_f: Floats
    n: Ints
    left_out: Ints

    def outcome(self, i: int = 0, *, correction: str = "gg") -> Outcome:
        """Design ``i`` alone, df corrected by Greenhouse-Geisser ("gg"), Huynh-Feldt ("hf") or not ("none")."""
        names = {"gg": ", Greenhouse-Geisser", "hf": ", Huynh-Feldt", "none": ", sphericity assumed"}
        epsilon = {"gg": self.epsilon_gg, "hf": self.epsilon_hf, "none": np.ones(self.f.shape)}[correction][i]
        p = {"gg": self.p_gg, "hf": self.p_hf, "none": self.p}[correction][i]
        if np.isinf(self.f[i]):
            epsilon = 1.0  # no scatter to estimate it from
        return Outcome(
            method="repeated-measures ANOVA" + names[correction],
            n=int(self.n[i]),
            statistic_name="F",
            statistic=float(self.f[i]),
            df=(float(self.df1 * epsilon), float(self.df2[i] * epsilon)),
            p=float(p),
            effect_name="generalised eta2",
            effect_size=float(self.eta2_generalised[i]),
            notes=self._notes(i),
        )

    def consistency(self, i: int = 0, confidence: float = 0.95) -> Outcome:
        """ICC(3,1) of design ``i``: how far the same treatments tell people alike (Shrout and Fleiss 1979).

        n counts values. People whose treatments agree wholly have 1; values all equal, or one person, none.
        """
        n, k = int(self.n[i]), self.df1 + 1
        df1, df2, tail = n - 1.0, float(self.df2[i]), (1 - confidence) / 2
        f = float(self.people_f[i])
        ends = f / special.fdtri(df1, df2, 1 - tail), f * special.fdtri(df2, df1, 1 - tail)
        value, low, high = (1.0 if np.isinf(x) else float((x - 1) / (x + k - 1)) for x in (f, *ends))
        notes: tuple[str, ...] = (f"subjects with a gap, left out: {self.left_out[i]}",) if self.left_out[i] else ()
        if np.isnan(value):
            notes += ("undefined: needs two subjects, two ratings each, and ratings that differ",)
        elif value < 0:
            notes += ("negative: subjects differ less than the ratings of one subject do",)
        return Outcome(
            method="intraclass correlation ICC(3,1)",
            n=n * k,
            statistic_name="F",
            statistic=f,
            df=(df1, df2),
            p=float(special.fdtrc(df1, df2, f)),
            estimate_name="ICC(3,1)",
            estimate=value,
            interval=(low, high),
            confidence=confidence,
            notes=notes,
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        notes: tuple[str, ...] = (f"{self.left_out[i]} people with a gap left out",) if self.left_out[i] else ()
        if np.isnan(self.f[i]):
            return (*notes, "undefined: needs two people, two treatments and values that differ")
        if np.isinf(self.f[i]):
            return (*notes, "treatments differ by the same amounts in every person: F is infinite")
        return notes


def rm_anova(values: ArrayLike) -> RepeatedAnova:
    """Analysis of ``values`` (d, n people, k treatments), or one design (n, k); people with a NaN are left out.

    An error that rounding alone can make (see `without_rounding`) is 0: F is then infinite, or NaN.
    """
    doubles, _ = shifted_doubles(values)
    complete = np.all(np.isfinite(doubles), axis=2)
    n, k = np.count_nonzero(complete, axis=1), doubles.shape[2]
    y, largest = _scaled(doubles, complete)
    there = complete[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        treatment = np.sum(y, axis=1) / n[:, None]
        person = np.mean(y, axis=2)
        grand = np.mean(treatment, axis=1)
        ss_treatment = n * np.sum((treatment - grand[:, None]) ** 2, axis=1)
        ss_person = k * np.sum((person - grand[:, None]) ** 2, axis=1, where=complete)
        residual = np.where(there, y - treatment[:, None] - person[..., None] + grand[:, None, None], 0.0)
        ss_treatment, ss_person, ss_error = (
            without_rounding(squares, n * k, largest)
            for squares in (ss_treatment, ss_person, np.sum(residual**2, axis=(1, 2)))
        )
        residual = np.where(ss_error[:, None, None] > 0, residual, 0.0)
        df1, df2 = k - 1, (n - 1) * (k - 1)
        f = np.where(df2 > 0, ss_treatment / max(df1, 1) / (ss_error / df2), np.nan)
        gg, hf = _epsilons(residual, n, k)
        w_p = _mauchly(residual, n, k)
        generalised = ss_treatment / (ss_treatment + ss_person + ss_error)
        people_f = np.where(df2 > 0, ss_person / np.where(n > 1, n - 1, np.nan) / (ss_error / df2), np.nan)

    def p_at(epsilon: Floats | float) -> Floats:
        return np.where(np.isinf(f), 0.0, special.fdtrc(df1 * epsilon, df2 * epsilon, f))

    left_out = complete.shape[1] - n
    return RepeatedAnova(f, df1, df2, p_at(1.0), gg, hf, p_at(gg), p_at(hf), w_p, generalised, people_f, n, left_out)


def _scaled(doubles: Floats, complete: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Values relative to the first of their design, scaled to below 1; 0 for people left out. The largest before."""
    filled = np.where(complete[..., None], doubles, 0.0)
    unit = exponent_of(np.max(np.abs(filled), axis=2, initial=0.0))[:, 0] + 1
    filled = np.ldexp(filled, -unit[:, None, None])
    start = np.take_along_axis(filled[..., 0], np.argmax(complete, axis=1)[:, None], axis=1)
    return np.where(complete[..., None], filled - start[..., None], 0.0), np.max(np.abs(filled), axis=(1, 2), initial=0)


def _epsilons(residual: Floats, n: Ints, k: int) -> tuple[Floats, Floats]:
    """Epsilons from the doubly centred covariance of the treatments: trace^2 over (k - 1) times its sum of squares."""
    covariance = np.swapaxes(residual, 1, 2) @ residual
    trace = np.trace(covariance, axis1=1, axis2=2)
    gg = np.clip(trace**2 / ((k - 1) * np.sum(covariance**2, axis=(1, 2))), 1 / max(k - 1, 1), 1.0)
    hf = (n * (k - 1) * gg - 2) / ((k - 1) * (n - 1 - (k - 1) * gg))
    # with few people the denominator of Huynh and Feldt turns negative: their estimate is then 1
    hf = np.where((n - 1 - (k - 1) * gg) > 0, hf, 1.0)
    return gg, np.where(np.isnan(gg), np.nan, np.clip(hf, gg, 1.0))


def _mauchly(residual: Floats, n: Ints, k: int) -> Floats:
    """p (d,) of Mauchly's (1940) W with the second term of the expansion (Anderson 1958), as R's mauchly.test."""
    if k < 3:
        return np.full(n.shape, np.nan)
    contrasts = np.linalg.qr(np.eye(k) - 1 / k)[0][:, : k - 1]
    free = (n - 1).astype(np.float64)
    projected = residual @ contrasts
    covariance = np.swapaxes(projected, 1, 2) @ projected
    size = np.trace(covariance, axis1=1, axis2=2) / (k - 1)
    enough = (n >= k) & (size > 0)
    w = np.where(enough, np.linalg.det(covariance / np.where(size > 0, size, 1.0)[:, None, None]), np.nan)
    m = k - 1
    rho = 1 - (2 * m**2 + m + 2) / (6 * m * free)
    second = (m + 2) * (m - 1) * (m - 2) * (2 * m**3 + 6 * m**2 + 3 * m + 2) / (288 * (free * m * rho) ** 2)
    df = m * (m + 1) / 2 - 1
    statistic = -free * rho * np.log(w)
    first, later = special.chdtrc(df, statistic), special.chdtrc(df + 4, statistic)
    return np.clip(first + second * (later - first), 0.0, 1.0)


def friedman(values: ArrayLike) -> Outcomes:
    """Friedman (1937) on ``values`` (d, n people, k treatments), or one (n, k); a person with a NaN is left out."""
    doubles, _ = shifted_doubles(values)
    k = doubles.shape[2]
    complete = np.all(np.isfinite(doubles), axis=2)
    ranks = midranks(np.where(complete[..., None], doubles, np.nan))
    n = np.count_nonzero(complete, axis=1)
    there = complete[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean_rank = np.sum(ranks, axis=1, where=there) / n[:, None]
        spread = np.sum((ranks - (k + 1) / 2) ** 2, axis=(1, 2), where=there)
        between = n**2 * np.sum((mean_rank - (k + 1) / 2) ** 2, axis=1)
        chi2 = np.where((n > 1) & (k > 1), (k - 1) * between / spread, np.nan)
        w = chi2 / (n * (k - 1)) if k > 1 else np.full(n.shape, np.nan)
    left_out = complete.shape[1] - n
    return Outcomes(
        method="Friedman, corrected for ties",
        statistic_name="chi2",
        statistic=chi2,
        df=(np.full(n.shape, k - 1),),
        p=special.chdtrc(max(k - 1, 1), chi2),
        n=n,
        effect_name="Kendall's W",
        effect=w,
        notes=(
            *((f"{m} people with a gap left out", left_out == m) for m in np.unique(left_out[left_out > 0]).tolist()),
            ("undefined: needs two people, two treatments, and ranks that differ", np.isnan(chi2)),
        ),
    )


@dataclass(frozen=True)
class PairedTests:
    """All q pairs of the k treatments of one table; arrays (1, q), NaN where undefined.

    t : paired t test, its own SD of differences for every pair. g, g_low, g_high : mean difference over the SD of the
    differences, Hedges' correction, interval from the noncentral t. signed_rank_p : two-sided, of Wilcoxon's signed
    ranks (1945), zeros left out, ties kept; exact over all signs up to 100 people.
    """

    t: PairDifferences
    g: Floats
    g_low: Floats
    g_high: Floats
    signed_rank_p: Floats


def paired_tests(values: ArrayLike, confidence: float = 0.95) -> PairedTests:
    """Test every pair of treatments of ``values`` (n people, k treatments); NaN: no value there, for that pair only."""
    doubles, _ = shifted_doubles(np.asarray(unmasked(values)).T)
    first, second = pair_numbers(doubles.shape[1])
    # two numbers near the largest that there is may be farther apart than that
    down = 2 * (exponent_of(np.nan_to_num(doubles.ravel())) > 1022)
    doubles = np.ldexp(doubles, -down)
    differences = doubles[0, first] - doubles[0, second]
    there = np.isfinite(differences)
    unit = exponent_of(np.where(there, differences, 0.0))
    differences = np.ldexp(differences, -unit)
    values = np.where(there, np.fmax(np.abs(doubles[0, first]), np.abs(doubles[0, second])), 0.0)
    largest = np.ldexp(np.max(values, axis=1, initial=0.0), -unit[:, 0])
    n = np.count_nonzero(there, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.sum(differences, axis=1, where=there) / n
        squares = without_rounding(np.sum((differences - mean[:, None]) ** 2, axis=1, where=there), n, largest)
        se = np.sqrt(squares / (n * (n - 1.0)))
    se = np.where(se > 0, se, np.nan)
    t = student_pairs(
        "paired t",
        mean[None],
        se[None],
        np.where(np.isnan(se), np.nan, n - 1.0)[None],
        n[None],
        doubles.shape[1],
        confidence,
    )
    with np.errstate(over="ignore"):
        own = {name: np.ldexp(getattr(t, name), unit[:, 0] + down) for name in ("difference", "low", "high")}
    g, low, high = paired_g(mean / se, np.maximum(n, 2), confidence)
    return PairedTests(
        t=replace(t, **own),
        g=g[None],
        g_low=low[None],
        g_high=high[None],
        signed_rank_p=np.array([[_signed_rank_p(row[np.isfinite(row) & (row != 0)]) for row in differences]]),
    )


def _signed_rank_p(differences: Floats) -> float:
    """P(|W - mean| >= |w - mean|) over all signs of the ranks of ``differences`` (m,), none of them 0."""
    if differences.size == 0:
        return float("nan")
    doubled = np.rint(2 * midranks(np.abs(differences))).astype(np.int64)
    distance = abs(2 * int(doubled[differences > 0].sum()) - int(doubled.sum()))
    if differences.size > MOST_EXACT:
        return float(2 * special.ndtr(-distance / np.sqrt(np.sum(doubled.astype(np.float64) ** 2))))
    law = _law_of_signs(doubled)
    far = np.abs(2 * np.arange(law.size) - law.size + 1) >= distance
    return float(min(law[far].sum(), 1.0))


def _law_of_signs(doubled_ranks: Ints) -> Floats:
    """Probability of every sum 0, 1, ... of the ranks with a positive sign, each sign as likely as the other."""
    law = np.zeros(int(doubled_ranks.sum()) + 1)
    law[0] = 1.0
    for rank in doubled_ranks.tolist():
        law[rank:] = (law[rank:] + law[: law.size - rank]) / 2
        law[:rank] /= 2
    return law
