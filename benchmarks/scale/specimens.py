"""A study of many specimens, from its recordings to its report: CPU seconds and peak memory.

Every pair of specimens is compared: 100 of them are 4 950 pairs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.scale.people import measure, run
from benchmarks.small_study import small_study

PEOPLE = ("P01", "P02", "P03", "P04")
HARDEST, SOFTEST = 10.0, 1.0
"""N/mm."""


def made(folder: Path, count: int) -> Path:
    """The study file of ``count`` specimens whose recordings are simulated; stiffness falls in equal steps of ln."""
    study = folder / "studies" / "many" / "study.toml"
    study.parent.mkdir(parents=True)
    study.write_text(_text(count))
    run("tools simulate", study)
    return study


def measured(folder: Path, count: int) -> dict[str, Any]:
    """What the whole run takes, its trials too."""
    return {"specimens": count} | measure(made(folder, count))


def _text(count: int) -> str:
    stiffness = [HARDEST * (SOFTEST / HARDEST) ** (index / max(count - 1, 1)) for index in range(count)]
    laws = {
        f"M{index:03d}": (f"{value:.4f}", f"{4e-6 * value:.4g}", f"{2e-6 * value:.4g}")
        for index, value in enumerate(stiffness, 1)
    }
    return small_study(name="many", title="Many specimens", participants=PEOPLE, laws=laws, task="press")
