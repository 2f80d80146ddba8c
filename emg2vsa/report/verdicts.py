"""What a family of tests decides, whether another decides otherwise, and which p it can reach, in few words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.report.outcome_text import Style, p_said, statistic_said
from emg2vsa.statistics.kruskal import smallest_worst_p
from emg2vsa.statistics.outcome import Outcome

NO = "no"
UNDECIDED = "cannot be said"


def decided(outcomes: Sequence[Outcome], alpha: float, many: str, style: Style = "apa") -> str:
    """One test alone; of many, how many are significant and the range of their p. many : "specimens", "pairs"."""
    if len(outcomes) == 1:
        return statistic_said(outcomes[0], style)
    return how_many(np.array([outcome.p for outcome in outcomes], dtype=np.float64), alpha, many, style)


def how_many(p: Floats, alpha: float, many: str, style: Style = "apa", does: str = "significant") -> str:
    """``14 of 14 participants significant (largest p < .001)``; ``does`` : another word for significant."""
    p = p[np.isfinite(p)]
    if not p.size:
        return "not defined"
    significant = int(np.count_nonzero(p < alpha))
    which, extreme = ("largest", p.max()) if 2 * significant > p.size else ("smallest", p.min())
    return f"{significant} of {p.size} {many} {does} ({which} {p_said(float(extreme), style)})"


def change(paper: Floats, companion: Floats, alpha: float) -> str:
    """Whether test by test the companion decides as the paper's test does; p of both, of the same shape."""
    both = np.isfinite(paper) & np.isfinite(companion)
    n = int(np.count_nonzero(both))
    if n == 0:
        return UNDECIDED
    lost = int(np.count_nonzero(both & (paper < alpha) & (companion >= alpha)))
    gained = int(np.count_nonzero(both & (paper >= alpha) & (companion < alpha)))
    if lost + gained == 0:
        return NO
    if n == 1:
        return "yes: no longer significant" if lost else "yes: significant"
    parts = [f"{lost} no longer significant"] * bool(lost) + [f"{gained} newly significant"] * bool(gained)
    return f"yes, for {lost + gained} of {n}: {', '.join(parts)}"


def change_of_claim(paper: Floats, companion: float, alpha: float) -> str:
    """The same for one companion of a whole family: do all of the family, or none, decide as it does?"""
    paper = paper[np.isfinite(paper)]
    if not paper.size or np.isnan(companion):
        return UNDECIDED
    share = float(np.mean(paper < alpha))
    if share in (0.0, 1.0):
        return (
            NO
            if (share == 1.0) == (companion < alpha)
            else "yes: " + ("significant" if companion < alpha else "not significant")
        )
    says = "significant" if companion < alpha else "not significant"
    return f"the paper's tests disagree ({np.count_nonzero(paper < alpha)} of {paper.size} significant); here {says}"


def change_of_evidence(paper: Floats, bf01: Floats, alpha: float) -> str:
    """Whether a Bayes factor BF01 backs the decisions: above 3 for "equal", below 1/3 for "different"."""
    both = np.isfinite(paper) & ~np.isnan(bf01)
    n = int(np.count_nonzero(both))
    if n == 0:
        return UNDECIDED
    significant = paper < alpha
    against = both & np.where(significant, bf01 > 3, bf01 < 1 / 3)
    weak = both & (bf01 >= 1 / 3) & (bf01 <= 3)
    parts = [
        f"{what}{f' for {number}' if n > 1 else ''}"
        for what, number in (("contradicted", int(np.sum(against))), ("no evidence either way", int(np.sum(weak))))
        if number
    ]
    return NO if not parts else f"{', '.join(parts)}{f' of {n}' if n > 1 else ''}"


def dunn_bounds(count: Ints) -> tuple[float, float] | None:
    """Smallest p of the worst pair, uncorrected and with Bonferroni, for groups of ``count`` (k,) untied values.

    None where the sizes differ: the bound is that of groups in a row without overlap, which only equal sizes make best.
    """
    sizes = np.unique(count)
    if sizes.size != 1 or sizes[0] < 1 or count.size < 2:
        return None
    return smallest_worst_p(count.size, int(sizes[0]))
