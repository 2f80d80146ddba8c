"""One table per hypothesis of section VI: the paper's test, its companion, the effect, does the verdict change?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from emg2vsa.companions.groups import GroupTests
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.area import AreaByAngle
from emg2vsa.report.companion_rows import CompanionRow, companion_table, equality_rows, evidence_row, normality_rows
from emg2vsa.report.outcome_text import range_said
from emg2vsa.report.table import Table
from emg2vsa.report.verdicts import change, how_many
from emg2vsa.report.wording import exact_p

_MANY = "designs"


def runs_verdicts(found: Discrimination) -> dict[str, Table]:
    """verdict_runs_normality, verdict_area, verdict_angle, verdict_casr."""
    alpha = found.settings.alpha
    tables = {
        "runs_normality": (
            "Gaussian samples of A_c0 and CASR: the paper's test beside its companions",
            normality_rows(found.area.normality, alpha, "samples of A_c0")
            + normality_rows(found.spread.normality, alpha, "samples of CASR"),
        ),
        "area": ("A_c0 is the same on all specimens: the paper's test beside its companions", _area(found)),
        "angle": ("A_c0 changes with the angle: the paper's test beside its companions", _angle(found)),
        "casr": ("CASR differs between specimens: the paper's test beside its companions", _casr(found)),
    }
    made = [companion_table(f"verdict_{name}", caption, rows) for name, (caption, rows) in tables.items()]
    return {table.name: table for table in made}


def _area(found: Discrimination) -> list[CompanionRow]:
    alpha, groups = found.settings.alpha, found.area.groups
    ranks = groups.kruskal.p
    paper = f"Kruskal-Wallis: {how_many(ranks, alpha, _MANY)}"
    equal = equality_rows(paper, found.area.equality, None, 100.0, "%")
    return [
        _welch_row(groups, alpha),
        evidence_row(paper, ranks, groups.bayes.bf01, alpha),
        *(replace(row, changes="no") if np.all(ranks < alpha) else row for row in equal),
    ]


def _welch_row(groups: GroupTests, alpha: float) -> CompanionRow:
    ranks = groups.kruskal.p
    return CompanionRow(
        f"Kruskal-Wallis: {how_many(ranks, alpha, _MANY)}",
        f"Welch's ANOVA: {how_many(groups.welch.p, alpha, _MANY)}",
        range_said("rank epsilon2", groups.kruskal.epsilon2),
        change(ranks, groups.welch.p, alpha),
    )


def _angle(found: Discrimination) -> list[CompanionRow]:
    if found.area_by_angle is None:
        return []
    of, alpha = found.area_by_angle, found.settings.alpha
    return [
        CompanionRow(
            f"Kruskal-Wallis and Dunn, Bonferroni, {condition}: {_worst(of, each)}",
            f"Mann-Whitney, exact, Holm: {_named(of, each, of.pairs.p_rank_holm)}",
            range_said("|r_rb|", np.abs(of.pairs.mann_whitney.rank_biserial[each])),
            change(of.pairs.dunn.p[each], of.pairs.p_rank_holm[each], alpha),
        )
        for condition in dict.fromkeys(of.conditions)
        for each in (
            [i for i, c in enumerate(of.conditions) if c == condition and not of.specimens[i]],
            [i for i, c in enumerate(of.conditions) if c == condition and of.specimens[i]],
        )
    ]


def _worst(of: AreaByAngle, rows: list[int]) -> str:
    which = "specimens pooled" if len(rows) == 1 else "each specimen"
    return f"{which}, {_named(of, rows, of.pairs.dunn.p)}"


def _named(of: AreaByAngle, rows: list[int], p: np.ndarray) -> str:
    """The worst p of some comparisons and the pair it belongs to."""
    own = p[rows]
    if not np.isfinite(own).any():
        return "not defined"
    row, pair = np.unravel_index(int(np.nanargmax(own)), own.shape)
    ends = " and ".join(f"{of.angles_deg[end[pair]]:g}°" for end in (of.pairs.first, of.pairs.second))
    specimen = of.specimens[rows[int(row)]]
    return f"worst p = {exact_p(float(own[row, pair]))} ({', '.join(filter(None, (specimen, ends)))})"


def _casr(found: Discrimination) -> list[CompanionRow]:
    alpha, spread = found.settings.alpha, found.spread
    pairs = spread.pairs
    paper = f"Dunn on mean ranks, Bonferroni: {how_many(pairs.dunn.p, alpha, 'pairs')}"
    return [
        _welch_row(spread.groups, alpha),
        *(
            CompanionRow(paper, f"{name}: {how_many(p, alpha, 'pairs')}", effect, change(pairs.dunn.p, p, alpha))
            for name, p, effect in (
                (
                    "Mann-Whitney, exact with ties, Holm", pairs.p_rank_holm,
                    range_said("|r_rb|", np.abs(pairs.mann_whitney.rank_biserial)),
                ),
                ("Games-Howell", pairs.games_howell.p, range_said("|g|", np.abs(pairs.g))),
            )
        ),
    ]  # fmt: skip
