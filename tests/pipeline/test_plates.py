"""Logs of plate indentations beside the runs come into the report; what cannot be read is told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.campaign import Campaign
from emg2vsa.pipeline.places import placed_in
from emg2vsa.pipeline.stages.report import files
from emg2vsa.study_file import load_study


def report(study: Path) -> tuple[dict[str, object], str]:
    """Numbers and page, after another run."""
    assert main(["run", str(study), "--jobs", "1", "--json"]) == 0
    folder = study.parents[2] / "reports" / study.parent.name
    return json.loads((folder / "results.json").read_text()), (folder / "index.html").read_text()


def log(folder: Path, specimen: str, kappa: float) -> Path:
    """A table of one trial with contact at 1 mm."""
    folder.mkdir(exist_ok=True)
    rows = "".join(f"{k / 20},{kappa * max(0.0, k / 20 - 1)}\n" for k in range(60))
    (folder / f"{specimen}.csv").write_text(f"indentation_mm,force_n\n{rows}")
    return folder / f"{specimen}.csv"


def test_logs_beside_the_runs_are_shown_and_the_claim_on_lines_is_tested(study: Path) -> None:
    folder = study.with_name("runs-virtual-plate")
    specimens = [name for name, _ in _stated(study)]
    for place, name in enumerate(specimens):
        log(folder, name, 2.5 + place)
    found, page = report(study)
    assert found["claims.plate_r2.verdict"] == "holds"
    assert found[f"plates.{specimens[0]}.kappa_n_per_mm.mean"] == pytest.approx(2.5, rel=1e-3)
    assert "Fig. P1." in page

    changed = log(folder, specimens[0], 5.0)
    found, _ = report(study)  # a changed log is read again
    assert found[f"plates.{specimens[0]}.kappa_n_per_mm.mean"] == pytest.approx(5.0, rel=1e-3)

    changed.write_text("depth,force\n1,2\n")
    found, page = report(study)
    assert found["claims.plate_r2.verdict"] == "not determined"
    assert f"{changed.name}" in page
    assert "indentation_mm" in page
    assert "Fig. P1." not in page


def test_the_plates_stay_where_they_are_when_the_runs_are_made_elsewhere(study: Path, tmp_path: Path) -> None:
    """As by ``verify`` and by ``run --work``."""
    path = log(study.with_name("runs-virtual-plate"), "S1", 2.5)
    placed = placed_in(load_study(study), tmp_path / "work")
    assert placed.runs_source.root.parent == tmp_path / "work"
    assert files(Campaign(placed), "study")["plates"] == [path]


def _stated(study: Path) -> list[tuple[str, float]]:
    import tomllib

    tables = tomllib.loads(study.read_text())["specimens"]
    return [(table["name"], table.get("stiffness_n_per_mm")) for table in tables]
