"""Folders as laboratories keep them, made by code: from ``emg2vsa new`` to a report whose b is the true one."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import folders_apart, folders_gallery
from benchmarks.folder_laboratory import Laboratory
from benchmarks.folders import MOST_COMMANDS, try_folder

QUICK = ("clock_stamps", "headerless")
APART = {each.name: each for each in folders_apart.LABORATORIES}
TRIED = [
    *(folders_gallery.LABORATORIES[name] for name in QUICK),
    *(pytest.param(each, marks=pytest.mark.slow)
      for each in (*folders_gallery.LABORATORIES.values(), APART["armband"], APART["labchart"])
      if each.name not in QUICK),
]  # fmt: skip


@pytest.mark.parametrize("laboratory", TRIED, ids=lambda laboratory: laboratory.name)
def test_a_folder_reaches_a_report_without_an_edit(laboratory: Laboratory, tmp_path: Path) -> None:
    if laboratory.name == "spike2":
        pytest.importorskip("neo", reason="the extra formats is not installed")
    outcome = try_folder(laboratory, tmp_path)
    assert outcome.reached, outcome
    assert outcome.edits == 0
    assert len(outcome.commands) <= MOST_COMMANDS
