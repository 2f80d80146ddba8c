"""The numbers of the tests of section IV.B, under the keys of results.json."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import GroupTests
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, least, most
from emg2vsa.statistics.clusters import Names
from emg2vsa.statistics.mixed import MixedModel
from emg2vsa.statistics.studentized_range import survival
from emg2vsa.statistics.trend import trend


def hypothesis_quantities(results: StudyResults) -> Items:
    if (found := results.recorded.hypotheses) is None:
        return
    yield "hypotheses.alpha", found.alpha
    yield "hypotheses.kept", ", ".join(found.kept)
    yield "hypotheses.worst_p", found.worst_p
    yield "hypotheses.worst_pair", found.worst_pair
    yield from _normality_quantities(found)
    yield from _design_quantities("between_participants", found.specimens, found.tests.between_blocks, found.alpha)
    yield from _design_quantities("between_specimens", found.participants, found.tests.between_groups, found.alpha)
    yield from _pair_quantities(found)
    yield from _over_people_quantities(found)
    yield from _stiffness_quantities(results)


def _stiffness_quantities(results: StudyResults) -> Items:
    """Does b rise with stiffness? One slope of b over ln stiffness a participant, and Student's t of these slopes."""
    fits, stiffness, used = results.recorded.fits, results.study.stiffness_n_per_mm, results.used
    log = np.array([np.log(stiffness.get(name, np.nan)) for name in fits.specimen[used].tolist()])
    one_group = np.zeros(log.size, dtype=np.str_)
    found = trend(fits.participant[used], one_group, log, fits.b_v[used])
    mean = {
        name: float(np.mean(fits.b_v[used & (fits.specimen == name)])) for name in set(fits.specimen[used].tolist())
    }
    yield "hypotheses.b_order", ", ".join(sorted(mean, key=mean.__getitem__, reverse=True))
    yield "hypotheses.b_over_log_stiffness.t", found.t
    yield "hypotheses.b_over_log_stiffness.p", found.p


def _normality_quantities(found: Hypotheses) -> Items:
    tests = found.tests.normality
    yield "hypotheses.normality.clusters", int(np.count_nonzero(found.count))
    families = {
        "standardised": tests.standardised.p, "raw": tests.raw.p, "lilliefors": tests.lilliefors.p,
        "shapiro": tests.shapiro.p,
    }  # fmt: skip
    for kind, p in families.items():
        yield from _family(f"hypotheses.normality.{kind}", p, found.alpha)
        yield f"hypotheses.normality.{kind}.smallest_p", least(p)


def _design_quantities(name: str, designs: Names, tests: GroupTests, alpha: float) -> Items:
    name, anova = f"hypotheses.{name}", tests.anova
    yield from _family(name, anova.p, alpha)
    yield f"{name}.smallest_p", least(anova.p)
    yield f"{name}.largest_p", most(anova.p)
    companions = {
        "welch": tests.welch.p, "kruskal": tests.kruskal.p, "brown_forsythe": tests.brown_forsythe.p,
    }  # fmt: skip
    for kind, p in companions.items():
        yield f"{name}.{kind}.significant", int(np.count_nonzero(p < alpha))
    numbers = {key: getattr(anova, key) for key in ("f", "df1", "df2", "p", "eta2")}
    numbers |= {"omega2": tests.omega2, "eta2_low": tests.eta2_low, "eta2_high": tests.eta2_high}
    numbers["bf01"] = tests.bayes.bf01
    for i, design in enumerate(designs[: anova.f.size].tolist()):
        yield from ((f"{name}.{design}.{key}", values[i].item()) for key, values in numbers.items())


def _pair_quantities(found: Hypotheses) -> Items:
    pairs, name = found.tests.pairs, "hypotheses.pairs"
    yield from _family(name, pairs.lsd.p, found.alpha, _chance_of_any_pair(found))
    corrected = {
        "holm": pairs.p_holm, "tukey": pairs.tukey.p, "games_howell": pairs.games_howell.p, "fdr": pairs.p_fdr,
        "dunn": pairs.dunn.p, "mann_whitney": pairs.p_rank_holm,
    }  # fmt: skip
    for kind, p in corrected.items():
        yield f"{name}.{kind}.significant", int(np.count_nonzero(p < found.alpha))
        yield f"hypotheses.worst_p.{kind}", float(p[found.worst]) if found.worst[0] >= 0 else np.nan
    for i, participant in enumerate(found.participants[: len(pairs.lsd.p)].tolist()):
        for j, (first, second) in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
            if found.specimens.size > 1:
                ends = f"{found.specimens[first]}-{found.specimens[second]}"
                yield f"{name}.{participant}.{ends}.p", pairs.lsd.p[i, j].item()


def _over_people_quantities(found: Hypotheses) -> Items:
    equality, blocks, name = found.tests.equality, found.tests.blocks, "hypotheses.over_people"
    yield "hypotheses.equality.bound_sd", most(equality.bound_sd)
    if equality.margin:
        yield "hypotheses.equality.margin_sd", equality.margin
        yield "hypotheses.equality.pairs_shown_equal", int(np.sum(equality.shown))
        yield "hypotheses.equality.pairs", int(np.sum(equality.pairs))
    if blocks is None:
        return
    repeated = blocks.repeated
    yield f"{name}.repeated.f", repeated.f[0].item()
    for key in ("p", "p_gg", "p_hf", "epsilon_gg", "epsilon_hf", "mauchly_p", "eta2_generalised"):
        yield f"{name}.repeated.{key}", getattr(repeated, key)[0].item()
    yield f"{name}.friedman.chi2", blocks.friedman.statistic[0].item()
    yield f"{name}.friedman.p", blocks.friedman.p[0].item()
    if blocks.mixed is not None:
        yield f"{name}.mixed.f", _plain(blocks.mixed.statistic)
        yield f"{name}.mixed.p", _plain(blocks.mixed.p)
        yield f"{name}.mixed.icc", _plain(blocks.mixed.effect_size)
    if isinstance(blocks.model, MixedModel):
        for key in ("sd_ratio", "ratio_low", "ratio_high"):
            yield f"{name}.mixed.{key}", getattr(blocks.model, key)
    pairs = blocks.paired.t
    for j, (first, second) in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        ends = f"{name}.pairs.{found.specimens[first]}-{found.specimens[second]}"
        for test, p in blocks.pair_families.items():
            yield f"{ends}.{test.lower().replace(' ', '_').replace('-', '_')}.p_holm", p[0, j].item()
        for key in ("g", "g_low", "g_high"):
            yield f"{ends}.{key}", getattr(blocks.paired, key)[0, j].item()


def _plain(value: float | None) -> float:
    return np.nan if value is None else value


def _family(name: str, p: Floats, alpha: float, chance: float | None = None) -> Items:
    """``chance_of_any``: that of at least one rejection where nothing differs; without one, of independent tests."""
    tested = int(np.count_nonzero(np.isfinite(p)))
    yield f"{name}.tested", tested
    yield f"{name}.significant", int(np.count_nonzero(p < alpha))
    yield f"{name}.chance_of_any", 1 - (1 - alpha) ** tested if chance is None else chance


def _chance_of_any_pair(found: Hypotheses) -> float:
    """Of Fisher's LSD without protection, independent participants: the pairs of one share their means and their SD.

    All pairs of a participant stay below the critical t as long as the studentized range of his k groups does (exact
    for groups of one size, a little too many otherwise).
    """
    anova = found.tests.between_groups.anova
    tested = np.isfinite(anova.p) & (anova.df2 > 0)
    df1, df2 = anova.df1[tested], anova.df2[tested]
    some = survival(np.sqrt(2) * -stdtrit(df2, found.alpha / 2), df1 + 1, df2)
    return float(1 - np.prod(1 - some))
