"""The made worlds still make what they made: recordings of the demo study as at commit 4a6cfa7a, runs as of world 4.

``fixture`` holds that study, the schedules of its runs, the SHA-256 of each recording, log and stack of frames, and two
presses of world 1 whole, on which estimators are tried without making them. Where a world is meant to change, its
version goes up and the digests are made anew; where an estimator changes, it is judged on the stored presses.
"""

from __future__ import annotations

import hashlib
import json
import lzma
import shutil
from dataclasses import replace
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from casr.frame_files import open_frames
from casr.scoring import score
from emg2vsa.pipeline.stages.emulation import STARTED
from emg2vsa.rig.experiment import Run, plan_of
from emg2vsa.rig_file import RigFile, load_rig
from emg2vsa.schedule_files import read_json
from emg2vsa.study_file import load_study
from emg2vsa.worlds import VERSION
from emg2vsa.worlds.bench.truth import truth_text
from emg2vsa.worlds.bench.virtual_run import run_virtual
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.study import write_bids

FIXTURE = Path(__file__).parent / "fixture"
DIGESTS: dict[str, Any] = json.loads((FIXTURE / "digests.json").read_text())
RUNS = sorted(DIGESTS["runs"])


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def rig() -> RigFile:
    return load_rig(FIXTURE / "rig.toml")


def made(run: str, folder: Path, presses: int = 10) -> list[str]:
    """Digests of the frames of the first presses of a run, which is in the folder then."""
    specimen, angle_deg, condition = run.rsplit("_", 2)
    emulated = rig().emulated
    assert emulated is not None
    schedules = [read_json(path) for path in sorted((FIXTURE / "schedules").iterdir())]
    one = Run(specimen, float(angle_deg), condition, 1)
    plan = plan_of(rig().experiment, one, schedules, emulated.stiffness_n_per_mm)
    plan = replace(plan, repetitions=presses, order=DIGESTS["runs"][run]["order"])
    run_virtual(plan, rig().rig, emulated.of(specimen), folder, started=datetime.fromisoformat(STARTED))
    return [digest(press / "frames.tif") for press in sorted(folder.glob("press-*"))]


def recordings(folder: Path, *names: str) -> dict[str, str]:
    """Name to digest of recordings, all unless some are named."""
    settings, plan = plan_study(load_study(FIXTURE / "study.toml"))
    named = {f"{planned.participant} {planned.specimen}": planned for planned in plan}
    return {name: digest(write_bids(folder, named[name], named[name].make(settings))) for name in names or named}


def test_the_world_has_a_version_that_truth_files_hold() -> None:
    assert json.loads(truth_text([]))["world"] == VERSION
    assert DIGESTS["world"] <= VERSION
    assert (len(DIGESTS["recordings"]), len(RUNS)) == (70, 36)


def test_a_recording_and_two_presses_are_made_as_they_were(tmp_path: Path) -> None:
    assert recordings(tmp_path / "data", "P03 S3")["P03 S3"] == DIGESTS["recordings"]["P03 S3"]
    run = "S1_30_modular"
    assert made(run, tmp_path / "run", presses=2) == DIGESTS["runs"][run]["frames"][:2]


@pytest.mark.slow
def test_all_recordings_are_made_as_they_were(tmp_path: Path) -> None:
    assert recordings(tmp_path) == DIGESTS["recordings"]


@pytest.mark.slow
@pytest.mark.parametrize("run", RUNS)
def test_all_runs_are_made_as_they_were(run: str, tmp_path: Path) -> None:
    assert made(run, tmp_path / "run") == DIGESTS["runs"][run]["frames"]
    assert digest(tmp_path / "run" / "log.csv") == DIGESTS["runs"][run]["log.csv"]


@pytest.mark.parametrize(("run", "rate"), [("S1_0_modular", 61.42), ("S5_0_modular", 90.84)])
def test_stored_presses_are_scored_as_before_and_near_their_truth(run: str, rate: float, tmp_path: Path) -> None:
    for name in ("force.csv", "camera.toml"):
        shutil.copy(FIXTURE / run / name, tmp_path / name)
    frames = tmp_path / "frames.tif"
    frames.write_bytes(lzma.decompress((FIXTURE / run / "frames.tif.xz").read_bytes()))
    assert digest(frames) == DIGESTS["presses"][run]
    truth, found = json.loads((FIXTURE / run / "truth.json").read_text()), score(open_frames(tmp_path))
    assert found.rate is not None
    assert found.rate.value == pytest.approx(rate, rel=2e-3)
    assert found.rate.value == pytest.approx(truth["casr_mm2_per_n"], rel=0.03)
