"""The small study with people and an emulated rig that the tests of several folders read, run to its report."""

from __future__ import annotations

from pathlib import Path

from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from emg2vsa.cli import main

STUDY = small_study(tables=WITH_A_RIG)
RIG = small_rig("high-stiffness = [0]\nmodular = [0]\n")


def run_all(root: Path) -> None:
    """Simulate and run it in ``root``/studies/small, for the fixture ``built_once``."""
    study = root / "studies" / "small" / "study.toml"
    study.parent.mkdir(parents=True)
    study.write_text(STUDY)
    study.with_name("rig.toml").write_text(RIG)
    assert main(["tools", "simulate", str(study), "--json"]) == 0
    assert main(["run", str(study), "--jobs", "1", "--json"]) == 0
