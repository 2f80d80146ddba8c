"""The answer of ``emg2vsa stats``: one table per hypothesis, the pairs, then one line per result."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from textwrap import wrap
from typing import Any

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.table import BlockTests, TableTests
from emg2vsa.companions.tidy import TidyTests
from emg2vsa.report.companion_rows import (
    COLUMNS,
    CompanionRow,
    decided,
    dunn_bounds,
    equality_rows,
    group_rows,
    how_many,
    normality_rows,
    over_people_pair_rows,
    over_people_rows,
    pair_rows,
    variance_row,
)
from emg2vsa.report.outcome_text import STYLES, Style, p_said, said
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, number
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import PairDifferences

_WIDTHS = (32, 46, 40)
_SUMMARY = frozenset({"groups", "groups over blocks"})
"""Names whose results are always printed."""
_ONE_BLOCK = (
    "All rows are taken as independent. There are no tests over blocks: they take two blocks or more, and the table "
    "has one. What is found holds for this block only."
)
_NO_BLOCK = "All rows are taken as independent. If a person gave several rows, name the column of people: --block."
_OVER_BLOCKS = (
    "The paper's test takes all rows as independent, but rows of a block are not. Trust the tests over blocks, the "
    "first of them first: it allows for groups that scatter unequally."
)
_PAIRS_OVER_BLOCKS = (
    "LSD takes all rows as independent. Trust the pairs over blocks, paired t first: each pair has its own scatter. "
    "The mixed model takes one for all; it finds too many where the sphericity ε is far below 1."
)
_NORMALITY = (
    "The p of standardised KS is far too large. Raw KS also tests location and scale. Small groups have little power. "
    "Do not choose the next test by the outcome of these tests."
)
_EQUAL = "A test that finds no difference does not show equality."


@dataclass(frozen=True)
class Hypothesis:
    """A question, the rows that answer it, and ``mind``: what limits the answer."""

    question: str
    rows: Sequence[CompanionRow]
    mind: str


def hypotheses(found: TidyTests, style: Style) -> list[Hypothesis]:
    """Over all rows; then block by block, and between blocks, where there are blocks."""
    return [*_together(found, style), *_by_block(found, style)]


def _together(found: TidyTests, style: Style) -> Iterator[Hypothesis]:
    tests, alpha, blocks = found.together, found.alpha, found.by_block
    groups, over = tests.between_groups, _over_blocks(found)
    cells = blocks.normality if blocks and np.isfinite(blocks.normality.lilliefors.p).any() else None
    yield Hypothesis(
        "Is each group Gaussian?" if cells is None else "Is each group of each block Gaussian?",
        normality_rows(cells or tests.normality, alpha, "groups" if cells is None else "cells", style), _NORMALITY,
    )  # fmt: skip
    paper = f"One-way ANOVA: {decided([groups.anova_outcome()], alpha, '', style)}"
    yield Hypothesis(
        "Do groups differ?",
        [*(over_people_rows(paper, over, style) if over else []), *group_rows(groups, alpha, "", style),
         variance_row(groups, alpha, "", style)],
        _OVER_BLOCKS if over else _ONE_BLOCK if blocks else _NO_BLOCK,
    )  # fmt: skip
    if over:
        pairs, mind = over_people_pair_rows(tests.pairs, over, alpha, style), _PAIRS_OVER_BLOCKS
    else:
        pairs, floor = pair_rows(tests.pairs, alpha, style), dunn_bounds(found.count)
        mind = (
            f"{tests.pairs.first.size} pairs. With more than three groups, LSD does not control the familywise error."
        )
        if floor:
            mind += f" With groups of this size and no ties, the largest p of Dunn's pairs is {floor[1]:.2g} or more."
    yield Hypothesis("Which groups differ?", pairs, mind)
    equal = equality_rows(paper, found.equality, None, 1.0, "", style)
    yield Hypothesis("Are groups equal?", equal, f"{_EQUAL} State a margin with --margin.")


def _over_blocks(found: TidyTests) -> BlockTests | None:
    return found.by_block.blocks if found.by_block else None


def _by_block(found: TidyTests, style: Style) -> Iterator[Hypothesis]:
    tests, alpha = found.by_block, found.alpha
    if tests is None:
        return
    if np.isfinite(tests.between_groups.anova.p).any():
        yield Hypothesis(
            "Do groups differ within each block?",
            [*group_rows(tests.between_groups, alpha, "blocks", style), *pair_rows(tests.pairs, alpha, style)],
            "One analysis per block. The result of a block holds for this block only.",
        )
    across = tests.between_blocks
    if np.isfinite(across.anova.p).any():
        paper = f"One-way ANOVA: {how_many(across.anova.p, alpha, 'groups', style)}"
        equal = equality_rows(paper, tests.equality, tests.blocks, 1.0, "", style)
        rows = [*group_rows(across, alpha, "groups", style), *equal]
        yield Hypothesis("Are blocks equal?", rows, f"One analysis per group. {_EQUAL}")


def outcomes(found: TidyTests) -> Iterator[tuple[str, Outcome]]:
    """Every test with the name of the group, pair or block that it tests."""
    tests, blocks = found.together, _over_blocks(found)
    if blocks is not None:
        yield from (("groups over blocks", outcome) for outcome in blocks.outcomes())
    for i, group in enumerate(found.groups.tolist()):
        yield from ((group, outcome) for outcome in tests.normality.outcomes(i))
    yield from (("groups", outcome) for outcome in tests.between_groups.outcomes())
    for pair, (first, second) in enumerate(zip(tests.pairs.first, tests.pairs.second, strict=True)):
        name = f"{found.groups[first]} - {found.groups[second]}"
        yield from ((name, outcome) for outcome in tests.pairs.outcomes(0, pair))
        if blocks is not None:
            yield from ((f"{name} over blocks", outcome) for outcome in blocks.pair_outcomes(pair))
        if found.tost is not None:
            yield name, found.tost.outcome(0, pair)
    if found.by_block is not None:
        yield from _outcomes_by_block(found, found.by_block)
    yield from found.of_plugins


def _outcomes_by_block(found: TidyTests, tests: TableTests) -> Iterator[tuple[str, Outcome]]:
    pairs = found.together.pairs
    for i, block in enumerate(found.blocks.tolist()):
        yield from ((f"groups in {block}", outcome) for outcome in tests.between_groups.outcomes(i))
        for pair, (first, second) in enumerate(zip(pairs.first, pairs.second, strict=True)):
            name = f"{found.groups[first]} - {found.groups[second]} in {block}"
            yield from ((name, outcome) for outcome in tests.pairs.outcomes(i, pair))
    for i, group in enumerate(found.groups.tolist() if found.blocks.size > 1 else []):
        yield from ((f"blocks in {group}", outcome) for outcome in tests.between_blocks.outcomes(i))


def text(found: TidyTests, style: Style, *, details: bool) -> str:
    """The whole answer for a terminal; details : every result of every group, pair and block too."""
    parts = [_groups(found)]
    for hypothesis in hypotheses(found, style):
        parts.append(f"\n{hypothesis.question}\n" + "\n".join(_grid(hypothesis.rows)))
        parts.append("\n".join(wrap(hypothesis.mind, sum(_WIDTHS) + 4)))
    by = "LSD" if _over_blocks(found) is None else _differences(found).method
    parts += [f"\nPairs, p of each test (differences and their intervals: {by})", *_pairs(found, style), "\nResults"]
    above, shown = "", _SUMMARY.union(name for name, _ in found.of_plugins)
    for name, outcome in outcomes(found):
        if details or name in shown:
            parts += [name] if name != above else []
            parts.append(f"  {outcome.method}: {said(outcome, style)}{_notes(outcome)}")
            above = name
    return "\n".join(parts).replace(NO_BREAK, " ")


def _groups(found: TidyTests) -> str:
    width = max(map(len, (*found.groups.tolist(), "group")))
    rows = [f"{'group':<{width}}{'n':>8}{'mean':>22}{'SD':>12}"]
    for name, n, mean, sd in zip(found.groups.tolist(), found.count, found.mean, found.sd, strict=True):
        rows.append(f"{name:<{width}}{n:>8}{_mean(float(mean), float(sd)):>22}{number(float(sd)):>12}")
    return "\n".join(rows)


def _mean(mean: float, sd: float) -> str:
    """The mean with the digits that its SD supports."""
    digits = 3 + math.ceil(math.log10(abs(mean) / sd)) if mean and sd > 0 else 3
    return f"{mean:.{min(max(digits, 3), 17)}g}"


def _pairs(found: TidyTests, style: Style) -> Iterator[str]:
    tests, names = found.together.pairs, found.groups
    families, size = _families(found)
    differences = _differences(found)
    pairs = [f"{names[i]} - {names[j]}" for i, j in zip(tests.first, tests.second, strict=True)]
    width = max(map(len, (*pairs, "pair")))
    heads = "".join(f"{head:>12}" for head in families)
    yield f"{'pair':<{width}}  {'difference':<34}{heads}{'g_z' if _over_blocks(found) else 'g':>8}"
    for at, pair in enumerate(pairs):
        low, high = (number(float(end[0, at])) for end in (differences.low, differences.high))
        limits = f"[{low}, {high}]" if math.isfinite(differences.low[0, at]) else "[not defined]"
        difference = f"{number(float(differences.difference[0, at]))} {limits}"
        cells = "".join(f"{_p(float(family[0, at]), style):>12}" for family in families.values())
        yield f"{pair:<{width}}  {difference:<34}{cells}{number(float(size[0, at])):>8}"


def _differences(found: TidyTests) -> PairDifferences:
    blocks = _over_blocks(found)
    return found.together.pairs.lsd if blocks is None else blocks.paired.t


def _families(found: TidyTests) -> tuple[dict[str, Floats], Floats]:
    """p of every pair by the heads of their columns, and the size of the difference."""
    tests, blocks = found.together.pairs, _over_blocks(found)
    if blocks is not None:
        short = {"Mixed-model contrasts": "Mixed", "Paired t": "Paired t", "Signed ranks": "Signed r."}
        over = {short[name]: p for name, p in blocks.pair_families.items()}
        return over | {"LSD (rows)": tests.lsd.p}, blocks.paired.g
    return {
        "LSD": tests.lsd.p, "Holm": tests.p_holm, "Tukey": tests.tukey.p, "Games-H.": tests.games_howell.p,
        "FDR": tests.p_fdr, "Dunn": tests.dunn.p, "Mann-Wh.": tests.p_rank_holm,
    }, tests.g  # fmt: skip


def _p(p: float, style: Style) -> str:
    """p without its letter, which the head of the column has."""
    shown = p_said(p, style).replace("$", "").replace(NO_BREAK, " ")
    return shown.removeprefix("p ").removeprefix("= ").replace("not defined", UNDEFINED)


def _grid(rows: Sequence[CompanionRow]) -> Iterator[str]:
    """Three columns of wrapped text. The first column does not repeat the text of the row above."""
    heads = [column.head for column in COLUMNS]
    above = ""
    for cells in (heads, *((row.paper, row.companion, row.effect) for row in rows)):
        shown = ["" if cells[0] == above else cells[0], *cells[1:]]
        above = cells[0]
        columns = [wrap(cell, width) or [""] for cell, width in zip(shown, _WIDTHS, strict=True)]
        for i in range(max(map(len, columns))):
            line = (f"{c[i] if i < len(c) else '':<{w}}" for c, w in zip(columns, _WIDTHS, strict=True))
            yield "  ".join(line).rstrip()
        if cells is heads:
            yield "  ".join("-" * width for width in _WIDTHS)


def _notes(outcome: Outcome) -> str:
    return f"  [{'; '.join(outcome.notes)}]" if outcome.notes else ""


def lines(found: TidyTests, of: Mapping[str, str | None], style: Style, *, details: bool) -> Iterator[str]:
    """What was compared, which rows were left out, and the answer. of : the table, and its columns value, group and
    block."""
    blocks = f" in {found.blocks.size} blocks ({of['block']})" if found.blocks.size else ""
    yield (
        f"{of['table']}: {of['value']} by {of['group']}, {found.n} rows of {found.groups.size} groups{blocks}, "
        f"alpha = {found.alpha:g}"
    )
    for count, why in ((found.without_number, "without a number"), (found.without_name, "without a group or block")):
        if count:
            yield f"note: {count} row{'s' if count != 1 else ''} {why} left out"
    for names in found.alike():
        yield f"note: {names} differ in capitals or spaces only and are kept apart; write them alike if they are one"
    yield ""
    yield text(found, style, details=details)


def as_json(found: TidyTests, style: Style) -> dict[str, Any]:
    """All of it; the residuals of the mixed model are for a QQ plot and for residuals against fitted values."""
    over = _over_blocks(found)
    return {
        "alpha": found.alpha,
        "rows": found.n,
        "alike": list(found.alike()),
        "left_out": {"without_number": found.without_number, "without_name": found.without_name},
        "groups": [
            {"name": name, "n": int(n), "mean": float(mean), "sd": float(sd)}
            for name, n, mean, sd in zip(found.groups.tolist(), found.count, found.mean, found.sd, strict=True)
        ],
        "hypotheses": [asdict(each) for each in hypotheses(found, style)],
        "outcomes": [
            {"of": of, **asdict(outcome), "text": {each: said(outcome, each) for each in STYLES}}
            for of, outcome in outcomes(found)
        ],
        "residuals": {name: values.tolist() for name, values in asdict(over.residuals).items()}
        if over and over.residuals
        else None,
    }
