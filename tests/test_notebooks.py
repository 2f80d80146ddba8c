"""The notebooks run from their first to their last cell; the site shows their outputs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parent.parent / "docs" / "notebooks").glob("*.md"))
MOST_CELLS = 40
EXPECTED = {
    "a-tactile-press": lambda names: names["press"].rate.value == pytest.approx(90.0, rel=0.1),
    "a-virtual-press": lambda names: names["soft"].log["depth_mm"].max() > names["hard"].log["depth_mm"].max() > 3,
    "is-the-session-good": lambda names: (
        set(names["presses"]["verdict"]) <= {"ok", "doubtful", "rejected"} and len(names["axes"].lines) > 3
    ),
    "numbers-for-a-paper": lambda names: names["asked"]["p"].between(0, 1).any() and len(names["tests"]) > 8,
    "first-fit-to-schedule": lambda names: set(names["modular"]["specimen"]) == {"hard", "soft"},
}


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names: dict[str, Any] = {"__name__": "notebook"}
    cells = re.findall(r"^```\{code-cell\} python\n(.*?)^```$", notebook.read_text(encoding="utf-8"), re.M | re.S)
    assert len(cells) <= MOST_CELLS
    for number, cell in enumerate(cells, 1):
        exec(compile(cell, f"{notebook.stem}, cell {number}", "exec"), names)
    assert EXPECTED[notebook.stem](names)
