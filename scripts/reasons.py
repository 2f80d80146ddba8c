"""``python scripts/reasons.py`` in the checkout writes the tables of reasons in docs/how-to/coordinator.md anew."""

from __future__ import annotations

import re
from pathlib import Path

from emg2vsa.extraction.remedies import REMEDIES

PAGE = Path(__file__).resolve().parents[1] / "docs" / "how-to" / "coordinator.md"
HEADINGS = {True: "Reasons that reject", None: "Reasons that warn or reject", False: "Reasons and remarks that warn"}


def table(rejects: bool | None) -> str:
    """The reasons that reject, those that do not, or (None) those of which it depends on how much, as Markdown."""
    lines = ["| reason | what it means | what to do |", "|---|---|---|"]
    for remedy in REMEDIES:
        if remedy.rejects is rejects:
            lines.append(f"| `{remedy.example}` | {remedy.means} | {remedy.do or 'nothing'} |")
    return "\n".join(lines) + "\n"


def with_tables(page: str) -> str:
    """The page with the tables under their headings renewed."""
    for rejects, heading in HEADINGS.items():
        pattern = rf"(## {heading}\n\n)(?:\|.*\n)+"
        page = re.sub(pattern, lambda found, rejects=rejects: found[1] + table(rejects), page)
    return page


if __name__ == "__main__":
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
