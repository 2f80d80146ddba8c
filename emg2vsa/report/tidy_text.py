"""The answer of ``emg2vsa stats``: one table per hypothesis, the pairs, then one line per result."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import zip_longest
from textwrap import wrap
from typing import Any

import numpy as np

from emg2vsa.companions.tidy import TidyTests
from emg2vsa.report import companion_rows as beside
from emg2vsa.report.outcome_text import STYLES, Style, p_said, said
from emg2vsa.report.wording import NO_BREAK, aligned, count, number
from emg2vsa.statistics.outcome import Outcome

_WIDTHS = (32, 46, 40)
_ONE_BLOCK = (
    "These tests take all rows as independent. There are no tests over blocks: they take two blocks or more, and the "
    "table has one. The result holds for this block only."
)
_NO_BLOCK = (
    "These tests take all rows as independent. If a person gave several rows, name the column of people with --block."
)
_OVER_BLOCKS = (
    "The paper's test takes all rows as independent, but rows of a block are not. Trust the tests over blocks, and the "
    "repeated-measures ANOVA most: it allows for groups that scatter unequally."
)
_PAIRS_OVER_BLOCKS = (
    "LSD takes all rows as independent. Trust the pairs over blocks, and paired t most: it gives each pair its own SD. "
    "The mixed model gives all pairs one SD, and finds too many differences where the sphericity ε is far below 1."
)
_NORMALITY = (
    "The p of the standardised Kolmogorov-Smirnov test is far too large. The raw form also tests location and scale. "
    "Every test has little power in small groups. Do not choose the next test by the outcome of these."
)
_EQUAL = "A test that finds no difference does not show equality."


@dataclass(frozen=True)
class Hypothesis:
    """A question, the rows that answer it, and ``mind``: what limits the answer."""

    question: str
    rows: beside.Rows
    mind: str


def hypotheses(found: TidyTests, style: Style) -> Iterator[Hypothesis]:
    """Over all rows; then block by block, and between blocks, where there are blocks."""
    tests, alpha, table = found.together, found.alpha, found.by_block
    over = table.blocks if table else None
    cells = table.normality if table and np.isfinite(table.normality.lilliefors.p).any() else None
    each, many = ("group of each block", "cells") if cells else ("group", "groups")
    rows = beside.normality_rows(cells or tests.normality, alpha, many, style)
    yield Hypothesis(f"Is each {each} Gaussian?", rows, _NORMALITY)
    rows = beside.group_rows(tests.between_groups, alpha, "", style, over)
    yield Hypothesis("Do groups differ?", rows, _OVER_BLOCKS if over else _ONE_BLOCK if table else _NO_BLOCK)
    rows, mind, pairs = beside.pair_rows(tests.pairs, alpha, style, over), _PAIRS_OVER_BLOCKS, tests.pairs.first.size
    if not over:
        mind = f"The groups form {count(pairs, 'pair')}. LSD controls no familywise error of more than three groups."
        if floor := beside.dunn_bounds(found.count):
            mind += f" With groups of this size and no ties, the largest p of Dunn's pairs is {floor[1]:.2g} or more."
    yield Hypothesis("Which groups differ?", rows, mind)
    rows = beside.equality_rows(beside.anova_said(tests.between_groups, alpha, "", style), found.equality, style)
    yield Hypothesis("Are groups equal?", rows, f"{_EQUAL} State a margin with --margin.")
    if table and np.isfinite(table.between_groups.anova.p).any():
        rows, of = beside.group_rows(table.between_groups, alpha, "blocks", style), table.pairs
        mind = "Each block has tests of its own. Their results hold for this block only."
        yield Hypothesis("Do groups differ within each block?", [*rows, *beside.pair_rows(of, alpha, style)], mind)
    if table and np.isfinite(table.between_blocks.anova.p).any():
        paper = beside.anova_said(table.between_blocks, alpha, "groups", style)
        equal = beside.equality_rows(paper, table.equality, style, table.blocks)
        rows = beside.group_rows(table.between_blocks, alpha, "groups", style, equal=equal)
        yield Hypothesis("Are blocks equal?", rows, f"Each group has tests of its own. {_EQUAL}")


def outcomes(found: TidyTests) -> Iterator[tuple[str, Outcome]]:
    """Every test with the name of the group, pair or block that it tests."""
    for name, several in _outcomes(found):
        yield from ((name, outcome) for outcome in several)
    yield from found.of_plugins


def _outcomes(found: TidyTests) -> Iterator[tuple[str, Sequence[Outcome]]]:
    tests, table = found.together, found.by_block
    over = table.blocks if table else None
    if over:
        yield "groups over blocks", over.outcomes()
    yield from ((group, tests.normality.outcomes(i)) for i, group in enumerate(found.groups.tolist()))
    yield "groups", tests.between_groups.outcomes()
    for at, pair in enumerate(pairs := beside.pair_names(found.groups, tests.pairs.lsd)):
        yield pair, tests.pairs.outcomes(0, at)
        if over:
            yield f"{pair} over blocks", over.pair_outcomes(at)
        if found.tost is not None:
            yield pair, [found.tost.outcome(0, at)]
    if table is None:
        return
    for i, block in enumerate(found.blocks.tolist()):
        yield f"groups in {block}", table.between_groups.outcomes(i)
        yield from ((f"{pair} in {block}", table.pairs.outcomes(i, at)) for at, pair in enumerate(pairs))
    for i, group in enumerate(found.groups.tolist() if found.blocks.size > 1 else []):
        yield f"blocks in {group}", table.between_blocks.outcomes(i)


def text(found: TidyTests, style: Style, *, details: bool) -> str:
    """The whole answer for a terminal; details : every result of every group, pair and block too."""
    rows = [(name, str(n), _mean(mean, sd), number(sd)) for name, n, mean, sd in _groups(found)]
    parts = [*aligned([("group", "n", "mean", "SD"), *rows])]
    for hypothesis in hypotheses(found, style):
        parts += [f"\n{hypothesis.question}", *_grid(hypothesis.rows), *wrap(hypothesis.mind, sum(_WIDTHS) + 4)]
    parts += [*_pair_lines(found, style), "\nResults"]
    always = {"groups", "groups over blocks", *(name for name, _ in found.of_plugins)}
    shown = [(name, outcome) for name, outcome in outcomes(found) if details or name in always]
    for name, (_, outcome) in zip(beside.once(name for name, _ in shown), shown, strict=True):
        notes = f"  [{'; '.join(outcome.notes)}]" if outcome.notes else ""
        parts += [*([name] if name else []), f"  {outcome.method}: {said(outcome, style)}{notes}"]
    return "\n".join(parts).replace(NO_BREAK, " ")


def _groups(found: TidyTests) -> Iterator[tuple[str, int, float, float]]:
    """Name, number of values, mean and SD of each."""
    return zip(found.groups.tolist(), found.count.tolist(), found.mean.tolist(), found.sd.tolist(), strict=True)


def _mean(mean: float, sd: float) -> str:
    """The mean with the digits that its SD supports."""
    digits = 3 + math.ceil(math.log10(abs(mean) / sd)) if mean and sd > 0 else 3
    return f"{mean:.{min(max(digits, 3), 17)}g}"


def _pair_lines(found: TidyTests, style: Style) -> Iterator[str]:
    """Every pair: its difference, the p of each test, and the size of the difference."""
    tests, over = found.together.pairs, found.by_block.blocks if found.by_block else None
    if over is None:
        of, method, size = tests.lsd, "LSD", ("g", tests.g)
        families = {"LSD": tests.lsd.p} | {beside.CORRECTED[key]: p for key, p in tests.corrected.items()}
    else:
        of, method, size = over.paired.t, over.paired.t.method, ("g_z", over.paired.g)
        families = over.pair_families | {"LSD (rows)": tests.lsd.p}
    yield f"\nPairs: p of each test (differences and their intervals: {method})"
    rows = [("pair", "difference", *families, size[0])]
    for at, pair in enumerate(beside.pair_names(found.groups, tests.lsd)):
        difference, low, high = (number(float(each[0, at])) for each in (of.difference, of.low, of.high))
        limits = f"[{low}, {high}]" if math.isfinite(of.low[0, at]) else "[not defined]"
        shown = (p_said(float(p[0, at]), style).strip("$").replace(NO_BREAK, " ") for p in families.values())
        cells = (p.removeprefix("p ").removeprefix("= ") for p in shown)
        rows.append((pair, f"{difference} {limits}", *cells, number(float(size[1][0, at]))))
    yield from aligned(rows, left=(0, 1))


def _grid(rows: beside.Rows) -> Iterator[str]:
    """Three columns of wrapped text. The first column does not repeat the text of the row above."""
    papers = beside.once(row.paper for row in rows)
    heads = [column.head for column in beside.COLUMNS], ["-" * width for width in _WIDTHS]
    for row in (*heads, *((paper, r.companion, r.effect) for paper, r in zip(papers, rows, strict=True))):
        for line in zip_longest(*(wrap(cell, width) for cell, width in zip(row, _WIDTHS, strict=True)), fillvalue=""):
            yield "  ".join(f"{part:<{width}}" for part, width in zip(line, _WIDTHS, strict=True)).rstrip()


def lines(found: TidyTests, of: Mapping[str, str | None], style: Style, *, details: bool) -> Iterator[str]:
    """What was compared, which rows were left out, and the answer. of : the table, and its columns value, group and
    block."""
    blocks = f" in {found.blocks.size} blocks ({of['block']})" if found.blocks.size else ""
    yield (
        f"{of['table']}: {of['value']} by {of['group']}, {found.n} rows of {found.groups.size} groups{blocks}, "
        f"alpha = {found.alpha:g}"
    )
    for n, why in ((found.without_number, "without a number"), (found.without_name, "without a group or block")):
        if n:
            yield f"note: {count(n, 'row')} {why} left out"
    for names in found.alike():
        yield f"note: {names} differ in capitals or spaces only and are kept apart; write them alike if they are one"
    yield f"\n{text(found, style, details=details)}"


def as_json(found: TidyTests, style: Style) -> dict[str, Any]:
    """All of it; the residuals of the mixed model are for a QQ plot and for residuals against fitted values."""
    over = found.by_block.blocks if found.by_block else None
    return {
        "alpha": found.alpha,
        "rows": found.n,
        "alike": list(found.alike()),
        "left_out": {"without_number": found.without_number, "without_name": found.without_name},
        "groups": [dict(zip(("name", "n", "mean", "sd"), group, strict=True)) for group in _groups(found)],
        "hypotheses": [asdict(each) for each in hypotheses(found, style)],
        "outcomes": [
            {"of": of, **asdict(outcome), "text": {each: said(outcome, each) for each in STYLES}}
            for of, outcome in outcomes(found)
        ],
        "residuals": {name: values.tolist() for name, values in asdict(over.residuals).items()}
        if over and over.residuals
        else None,
    }
