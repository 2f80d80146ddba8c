"""``emg2vsa tools bench stress``: digits that every function loses where its input is hard."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from benchmarks.stress.case import Case, judged
from benchmarks.stress.table import text, write

AREAS = ("signals", "curves", "tests", "laws", "calibration", "mechanics", "tactile")


def all_cases(smoke: bool = False, areas: tuple[str, ...] = AREAS) -> Iterator[Case]:
    """Every case, or those of the short table."""
    for area in areas:
        yield from (case for case in import_module(f"benchmarks.stress.{area}").cases() if case.smoke or not smoke)


def run(out: Path | None, smoke: bool, areas: tuple[str, ...] = AREAS) -> int:
    """Print the table, and write it to the folder ``out``; 1 where a row is broken.

    smoke : only the short table.
    """
    rows = [judged(case) for case in all_cases(smoke, areas)]
    print(text(rows))
    if out:
        write(rows, out)
    broken = [row for row in rows if not row.kept]
    print(f"{len(rows)} rows, {len(broken)} broken")
    return 1 if broken else 0
