"""Every result of section IV.B as a manuscript prints it: one row a test, in four styles; and as LaTeX macros."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.numbers_files import macro_names
from emg2vsa.report.outcome_text import STYLES, said
from emg2vsa.report.table import Column, Table
from emg2vsa.stats.outcome import Outcome

_HEADS = {"apa": "APA", "ieee": "IEEE", "latex": "LaTeX", "plain": "Plain"}


def statements(found: Hypotheses) -> Table:
    """key : what is said of what; method : with its variant; then the styles."""
    columns = (Column("key", "Of"), Column("method", "Test"), *(Column(style, _HEADS[style]) for style in STYLES))
    rows = tuple(
        (key, outcome.method, *(said(outcome, style) for style in STYLES)) for key, outcome in _outcomes(found)
    )
    return Table("statements", "Results as text", columns, rows)


def statements_tex(table: Table) -> str:
    r"""One ``\newcommand`` a statement, e.g. ``\emgTestOverPeopleFriedman``."""
    names = macro_names([f"{row[0]}.{row[1]}" for row in table.rows], "emgTest")
    latex = [column.key for column in table.columns].index("latex")
    lines = [
        rf"\newcommand{{\{name}}}{{{row[latex]}}} % {row[0]}, {row[1]}"
        for name, row in zip(names.values(), table.rows, strict=True)
    ]
    return "\n".join(["% Written by emg2vsa; include with \\input. Needs amsmath.", *lines, ""])


def _outcomes(found: Hypotheses) -> Iterator[tuple[str, Outcome]]:
    tests = found.tests
    if tests.blocks is not None:
        for outcome in tests.blocks.outcomes():
            yield "over people", outcome
    for i, specimen in enumerate(found.specimens[: tests.between_blocks.anova.f.size].tolist()):
        for outcome in tests.between_blocks.outcomes(i):
            yield f"participants on {specimen}", outcome
    for i, participant in enumerate(found.participants[: tests.between_groups.anova.f.size].tolist()):
        for outcome in tests.between_groups.outcomes(i):
            yield f"specimens of {participant}", outcome
    if found.worst[0] >= 0:
        for outcome in tests.pairs.outcomes(*found.worst):
            yield f"worst pair, {found.worst_pair}", outcome
