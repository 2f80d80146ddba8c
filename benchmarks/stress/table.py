"""The stress table as text, Markdown and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.stress.case import FEW_DIGITS, Row
from casr.atomic import write_text_atomic

HEAD = (
    "# Digits under stress\n\n"
    "Made by `emg2vsa tools bench stress`. One row is a function in a world that is hard for it. Truth: the same "
    "formula in 50 digits\nof the same doubles.\n\n"
    "- Digits: correct decimal digits of the worst number of the row. 16 is every digit of a double.\n"
    "- Allowed: what one rounding of each input leaves (15.95 less log10 of the condition number). A function that\n"
    "  takes differences exactly can have more.\n"
    "- Bound: the least digits that the function promises in this world.\n"
    "- Verdict: kept, or *says so* where the function refuses or gives NaN with a reason, or **broken**. A result of "
    f"fewer than {FEW_DIGITS:g}\n  digits without a word is broken, whatever its bound.\n\n"
)


def text(rows: Sequence[Row]) -> str:
    """The rows in columns, for a terminal."""
    lines = [f"{'':92}digits allowed  bound  verdict"]
    for row in rows:
        name = f"{row.function}: {row.world}"
        lines.append(
            f"{name[:90]:92}{row.digits:6.1f} {row.allowed:7.1f} {row.bound:6.1f}  {row.verdict}  {row.said[:60]}"
        )
    return "\n".join(lines)


def page(rows: Sequence[Row]) -> str:
    """What the columns mean, and how many rows hold; the site adds `tables`."""
    kept = sum(row.verdict == "kept" for row in rows)
    said = sum(row.verdict == "says so" for row in rows)
    parts = [HEAD, f"{len(rows)} rows: {kept} kept, {said} say so, {len(rows) - kept - said} broken.\n"]
    functions = len({row.function for row in rows})
    parts += [f"{functions} functions; the tables are in `stress.json`, and on the documentation site here.\n"]
    return "\n".join(parts) + "\n<!-- tables: stress.json -->\n"


def tables(record: Sequence[Mapping[str, Any]]) -> str:
    """Every row of ``stress.json`` as Markdown; a section a function."""
    parts, function = [], ""
    for row in record:
        if row["function"] != function:
            function = row["function"]
            parts.append(
                f"\n## {function}\n\n| world | worst number | digits | allowed | bound | verdict | what it says |\n"
                "|---|---|---:|---:|---:|---|---|\n"
            )
        said_here = row["said"].replace("|", "\\|").replace("\n", " ")
        numbers = " | ".join(f"{row[name]:.1f}" for name in ("digits", "allowed", "bound"))
        parts.append(f"| {row['world']} | {row['worst']} | {numbers} | {row['verdict']} | {said_here} |\n")
    return "".join(parts)


def write(rows: Sequence[Row], folder: Path) -> None:
    """``stress.md`` and ``stress.json`` in the folder, each whole or not at all."""
    write_text_atomic(folder / "stress.md", page(rows))
    record = [{name: value for name, value in asdict(row).items() if name != "seconds"} for row in rows]
    write_text_atomic(folder / "stress.json", json.dumps(record, indent=1, ensure_ascii=False) + "\n")
