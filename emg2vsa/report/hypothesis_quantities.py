"""The numbers of the tests on b under flat names, beginning with ``hypotheses.``."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import GroupTests
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.quantity import Items, least, most
from emg2vsa.stats.clusters import Names


def hypothesis_quantities(found: Hypotheses) -> Items:
    """Names and values; NaN where a number is not defined."""
    yield "hypotheses.alpha", found.alpha
    yield "hypotheses.kept", ", ".join(found.kept)
    yield "hypotheses.worst_p", found.worst_p
    yield "hypotheses.worst_pair", found.worst_pair
    yield from _normality(found)
    yield from _designs("between_participants", found.specimens, found.tests.between_blocks, found.alpha)
    yield from _designs("between_specimens", found.participants, found.tests.between_groups, found.alpha)
    yield from _pairs(found)
    yield from _over_people(found)


def _normality(found: Hypotheses) -> Items:
    tests = found.tests.normality
    yield "hypotheses.normality.clusters", int(np.count_nonzero(found.count))
    families = {
        "standardised": tests.standardised.p, "raw": tests.raw.p, "lilliefors": tests.lilliefors.p,
        "shapiro": tests.shapiro.p,
    }  # fmt: skip
    for kind, p in families.items():
        yield from _how_many(f"hypotheses.normality.{kind}", p, found.alpha)
        yield f"hypotheses.normality.{kind}.smallest_p", least(p)


def _designs(name: str, designs: Names, tests: GroupTests, alpha: float) -> Items:
    name, anova = f"hypotheses.{name}", tests.anova
    yield from _how_many(name, anova.p, alpha)
    yield f"{name}.smallest_p", least(anova.p)
    yield f"{name}.largest_p", most(anova.p)
    companions = {
        "welch": tests.welch.p, "kruskal": tests.kruskal.p, "brown_forsythe": tests.brown_forsythe.anova.p,
    }  # fmt: skip
    for kind, p in companions.items():
        yield f"{name}.{kind}.significant", int(np.count_nonzero(p < alpha))
    numbers = {key: getattr(anova, key) for key in ("f", "df1", "df2", "p", "eta2")}
    numbers |= {"eta2_low": tests.eta2_low, "eta2_high": tests.eta2_high, "bf01": tests.bayes.bf01}
    for i, design in enumerate(designs[: anova.f.size].tolist()):
        yield from ((f"{name}.{design}.{key}", values[i].item()) for key, values in numbers.items())


def _pairs(found: Hypotheses) -> Items:
    pairs, name = found.tests.pairs, "hypotheses.pairs"
    yield from _how_many(name, pairs.lsd.p, found.alpha)
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


def _over_people(found: Hypotheses) -> Items:
    equality, blocks, name = found.tests.equality, found.tests.blocks, "hypotheses.over_people"
    yield "hypotheses.equality.bound_sd", most(equality.bound_sd)
    if equality.tost is not None and equality.margin is not None:
        yield "hypotheses.equality.margin_sd", equality.margin
        yield "hypotheses.equality.pairs_shown_equal", int(np.count_nonzero(equality.tost.p < found.alpha))
        yield "hypotheses.equality.pairs", int(np.count_nonzero(np.isfinite(equality.tost.p)))
    if blocks is None:
        return
    repeated = blocks.repeated
    yield f"{name}.repeated.f", repeated.f[0].item()
    for key in ("p", "p_gg", "p_hf", "epsilon_gg", "epsilon_hf", "mauchly_p", "eta2_generalised"):
        yield f"{name}.repeated.{key}", getattr(repeated, key)[0].item()
    yield f"{name}.friedman.chi2", blocks.friedman.chi2[0].item()
    yield f"{name}.friedman.p", blocks.friedman.p[0].item()
    if blocks.mixed is not None:
        yield f"{name}.mixed.f", _plain(blocks.mixed.statistic)
        yield f"{name}.mixed.p", _plain(blocks.mixed.p)
        yield f"{name}.mixed.icc", _plain(blocks.mixed.effect_size)
    if blocks.balanced is not None:
        for key in ("sd_ratio", "ratio_low", "ratio_high"):
            yield f"{name}.mixed.{key}", getattr(blocks.balanced, key)[0].item()


def _plain(value: float | None) -> float:
    return np.nan if value is None else value


def _how_many(name: str, p: Floats, alpha: float) -> Items:
    """``chance_of_any``: that of at least one rejection where nothing differs and the tests are independent."""
    tested = int(np.count_nonzero(np.isfinite(p)))
    yield f"{name}.tested", tested
    yield f"{name}.significant", int(np.count_nonzero(p < alpha))
    yield f"{name}.chance_of_any", 1 - (1 - alpha) ** tested
