"""Rows for the analyses that count the repetitions of one person as independent, and for "they are equal"."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.blocks import BlockTests
from emg2vsa.companions.equality import EqualityTests
from emg2vsa.report.companion_rows import Row, p_of
from emg2vsa.report.outcome_text import Style, effect_said, span_said, statistic_said
from emg2vsa.report.verdicts import UNDECIDED, change_of_claim
from emg2vsa.report.wording import bounded, number
from emg2vsa.stats.outcome import Outcome


def over_people_rows(paper: str, paper_p: Floats, blocks: BlockTests, alpha: float, style: Style = "apa") -> list[Row]:
    """``paper`` (its p in ``paper_p``) beside tests whose sample is the people."""
    repeated = blocks.repeated
    epsilon = (
        f"sphericity ε: GG {bounded(float(repeated.epsilon_gg[0]), 2)}, HF {bounded(float(repeated.epsilon_hf[0]), 2)}"
    )
    corrected, ranks = repeated.outcome(), blocks.friedman.outcome()
    return [
        *([_over_people(paper, paper_p, blocks.mixed, "", alpha, style)] if blocks.mixed else []),
        _over_people(paper, paper_p, corrected, epsilon, alpha, style),
        _over_people(paper, paper_p, ranks, "", alpha, style),
    ]


def _over_people(paper: str, paper_p: Floats, found: Outcome, more: str, alpha: float, style: Style) -> Row:
    failed = "; ".join(found.notes) if np.isnan(p_of(found)) else ""
    return Row(
        paper,
        f"{found.method[0].upper()}{found.method[1:]}: {failed or statistic_said(found, style)}",
        "; ".join(filter(None, (effect_said(found, style), more))),
        change_of_claim(paper_p, p_of(found), alpha),
    )


def equality_rows(
    paper: str, equality: EqualityTests, blocks: BlockTests | None, factor: float, unit: str, style: Style = "apa"
) -> list[Row]:
    """ "No difference found" beside what would show equality. factor, unit : for people, of the bound in the data."""
    return [_margin_row(paper, equality, factor, unit, style), *([_share_row(paper, blocks, style)] if blocks else [])]


def _margin_row(paper: str, equality: EqualityTests, factor: float, unit: str, style: Style) -> Row:
    level = f"{100 * (1 - 2 * equality.alpha):g}% intervals"
    bound, in_sd = (span_said(found, style) for found in (equality.bound * factor, equality.bound_sd))
    effect = f"{level} of all differences lie within ± {f'{bound} {unit}'.rstrip()} (± {in_sd} SD)"
    if equality.tost is None or equality.margin is None:
        return Row(paper, "Equivalence (TOST): no margin stated", effect, UNDECIDED + " without a margin")
    p = equality.tost.p[np.isfinite(equality.tost.p)]
    shown = int(np.count_nonzero(p < equality.alpha))
    margin = (
        f"± {equality.margin:g} SD" if equality.tost.unit == "sd" else f"± {number(equality.margin * factor)} {unit}"
    )
    return Row(
        paper,
        f"Equivalence (TOST) within {margin.rstrip()}: {shown} of {p.size} pairs shown equal",
        effect,
        "no" if shown == p.size else f"yes: equality not shown for {p.size - shown} of {p.size} pairs",
    )


def _share_row(paper: str, blocks: BlockTests, style: Style) -> Row:
    """How much people differ, as a share of what is left unexplained."""
    mixed = blocks.mixed
    if blocks.balanced is None or mixed is None:
        found = blocks.icc.outcome(kind="ICC(3,1)")
        low = found.interval[0] if found.interval else float("nan")
        name = "Intraclass correlation of means, " + (found.estimate_name or "")
    else:
        found, low, name = mixed, float(blocks.balanced.ratio_low[0]), "Variance components of the mixed model"
    verdict = UNDECIDED if np.isnan(low) else "yes: people differ" if low > 0 else "no: the interval reaches 0"
    return Row(paper, name, effect_said(found, style), verdict)
