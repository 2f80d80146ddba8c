"""Every reason has a remedy, and the page for coordinators lists them all."""

from __future__ import annotations

import re
from pathlib import Path

from emg2vsa.extraction.remedies import REMEDIES, remedy_of
from scripts.reasons import table

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "coordinator.md"


def test_examples_are_found_by_their_own_pattern_first():
    for remedy in REMEDIES:
        first = next(each for each in REMEDIES if re.fullmatch(each.found, remedy.example))
        assert first is remedy, remedy.example
        assert remedy.means


def test_the_cause_goes_before_what_follows_from_it():
    line = "presses 1-2, 4 rejected: its fit explains too little (adjusted R2 -0.05); EDC has spikes: 2 samples far"
    assert "plugs" in remedy_of(line)
    assert "3 s" in remedy_of("press 1 rejected: lasted 0.42 s, shorter than 0.5 s; record begins at 5.81 N")
    assert remedy_of("a reason that nobody has written") == ""


def test_the_page_for_coordinators_has_the_tables_of_the_code():
    page = PAGE.read_text(encoding="utf-8")
    for rejects in (True, None, False):
        assert table(rejects) in page, "run python scripts/reasons.py"
