"""The demo study gives the numbers of its committed reference, and finds the truth it was made from."""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import pytest

from emg2vsa.cli import main

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "reports" / "palpation" / "reference"
RELATIVE = 1e-6
"""Processors and library versions differ in the last digits; a changed method differs in the first."""
RENEW = "If the change is meant, renew it with scripts/reference and commit the diff."


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of the demo study, simulated and run afresh."""
    root = tmp_path_factory.mktemp("demo")
    folder = root / "studies" / "palpation"
    folder.mkdir(parents=True)
    shutil.copy(ROOT / "studies" / "palpation" / "study.toml", folder)
    assert main(["simulate", str(folder / "study.toml"), "--json"]) == 0
    assert main(["run", str(folder / "study.toml"), "--json"]) == 0
    return root / "reports" / "palpation"


def same(ours: object, theirs: object) -> bool:
    """Equal, or numbers (or texts of numbers) within RELATIVE of each other."""
    if ours == theirs:
        return True
    try:
        return math.isclose(float(str(ours)), float(str(theirs)), rel_tol=RELATIVE)
    except ValueError:
        return False


def test_results(report: Path) -> None:
    ours, theirs = (json.loads((folder / "results.json").read_text()) for folder in (report, REFERENCE))
    ours, theirs = ({k: v for k, v in r.items() if not k.startswith("provenance.")} for r in (ours, theirs))
    assert sorted(ours) == sorted(theirs), RENEW
    assert len(theirs) > 300
    different = {key: (ours[key], theirs[key]) for key in theirs if not same(ours[key], theirs[key])}
    assert different == {}, RENEW


@pytest.mark.parametrize("name", sorted(path.name for path in (REFERENCE / "tables").glob("*.csv")))
def test_table(report: Path, name: str) -> None:
    ours, theirs = (list(csv.reader((folder / "tables" / name).open())) for folder in (report, REFERENCE))
    assert len(ours) == len(theirs), RENEW
    different = [(a, b) for a, b in zip(ours, theirs, strict=True) if not all(map(same, a, b)) or len(a) != len(b)]
    assert different == [], RENEW


def test_no_table_is_missing_from_the_reference(report: Path) -> None:
    ours, theirs = ({p.name for p in (folder / "tables").glob("*.csv")} for folder in (report, REFERENCE))
    assert ours == theirs, RENEW


def test_the_truth_is_found(report: Path) -> None:
    results = json.loads((report / "results.json").read_text())
    assert results["recovery.n"] == 700
    assert abs(results["recovery.mean_b_error"]) <= 0.01
    assert results["recovery.mean_b_error_mcse"] < 0.004
    assert 0.92 <= results["recovery.coverage"] <= 0.98
    assert results["power.n14"] == pytest.approx(0.819421399316, abs=1e-12)
