"""The first page: five sentences, and every quantitative claim of the paper with a verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Claim, Quantities, Section
from emg2vsa.report.table import Column, Row, Table
from emg2vsa.report.wording import count

_KINDS = {"holds": "holds", "does not hold": "fails", "cannot be tested here": "untested"}


def claim_quantities(claims: Mapping[str, Sequence[Claim]]) -> Items:
    """``claims.<key>.ours`` and ``.verdict`` of every claim."""
    for of_section in claims.values():
        for claim in of_section:
            yield f"claims.{claim.key}.ours", claim.ours
            yield f"claims.{claim.key}.verdict", claim.verdict


def claims_table(claims: Mapping[str, Sequence[Claim]]) -> Table:
    """All claims in the order of their sections, each with a link to its own."""
    columns = (
        Column("says", "Claim of the paper"), Column("paper", "Paper"), Column("here", "Here, same test"),
        Column("companion", "Companion test"), Column("verdict", "Verdict"), Column("why", "Remark"),
    )  # fmt: skip
    every = [(name, claim) for name, of_section in claims.items() for claim in of_section]
    rows: tuple[Row, ...] = tuple({c.key: getattr(claim, c.key) for c in columns} for _, claim in every)
    return Table(
        "claims", "Quantitative claims of the paper beside this study", columns, rows,
        kinds=tuple(_KINDS[claim.verdict] for _, claim in every),
        links=tuple(f"#{name}" for name, _ in every),
    )  # fmt: skip


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"summary": list(_summary(results, q))}


def _summary(results: StudyResults, q: Quantities) -> Iterator[str]:
    """Sentences; the first says whether the data were simulated."""
    verdicts = Counter(value for key, value in q.items() if key.startswith("claims.") and key.endswith(".verdict"))
    n = sum(verdicts.values())
    yield f"Of {count(n, 'claim')}, {verdicts['holds']} hold."


_TEXT = """
{{ summary | bullets }}
{{ table("claims") }}
"""

CLAIMS = Section("claims", "Claims of the paper", _TEXT, words=_words)
