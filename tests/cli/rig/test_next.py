"""``emg2vsa rig next``: which press of an unknown specimen comes next."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.calibration.cut_presses import cut_forces
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.calibration_file import open_calibration, sha256_of, write_calibration

Rig = Callable[..., tuple[int, str, str]]
KAPPA = np.array([7.63, 3.35, 1.11])


@pytest.fixture
def known(tmp_path: Path) -> list[Path]:
    forces, rng = cut_forces(0.5, 7.0)[-2:], np.random.default_rng(0)
    rates = ((1 / KAPPA + 1 / 4) ** (2 / 3))[:, None, None] * (1 + 0.01 * rng.standard_normal((3, 6, 1))) * np.ones(2)
    calibration = OnlineCalibration(
        specimens=("S1", "S3", "S5"), kappa=KAPPA, kappa_se=np.zeros(3), quantity="front", area_unit="mm2",
        angle_deg=0.0, condition="modular", start_n=0.5, forces_n=forces, rates=rates,
        mounting=np.ones((3, 6), dtype=np.int64),
    )  # fmt: skip
    return [
        write_calibration(tmp_path / f"{condition}.json", replace(calibration, condition=condition))
        for condition in ("high-stiffness", "modular")
    ]


def judged_run(folder: Path, half_width: float = 0.3, condition: str = "modular", specimen: str = "S4") -> Path:
    folder.mkdir()
    (folder / "plan.json").write_text(
        json.dumps({"plan": {"specimen": specimen, "angle_deg": 0.0, "condition": condition}})
    )
    rows = ["repetition,force_n,kappa_n_per_mm,low_n_per_mm", "1,0.6,,"]
    rows += [f"{press},6.5,3.0,{3 / (1 + half_width)}" for press in (1, 2)]
    (folder / "kappa.csv").write_text("\n".join(rows) + "\n")
    return folder


def test_before_the_first_press_every_calibration_is_weighed(rig: Rig, known: list[Path]) -> None:
    status, out, err = rig("next", *known, "--json")
    assert status == 0, err
    found = json.loads(out)
    assert len(found["options"]) == 10
    assert all(option["remount"] for option in found["options"])
    assert found["belief"]["low_n_per_mm"] < 1.11
    assert found["belief"]["high_n_per_mm"] > 7.63
    bits = [option["bits"] for option in found["options"]]
    assert bits == sorted(bits, reverse=True)
    assert found["next"]["bits"] > 0


def test_presses_that_were_judged_count(rig: Rig, known: list[Path], tmp_path: Path) -> None:
    run = judged_run(tmp_path / "run")
    status, out, err = rig("next", *known, "--done", run, "--presses", 1)
    assert status == 0, err
    assert out.startswith("kappa so far: 3.0")
    assert "modular.json                       1      same" in out
    assert "high-stiffness.json                1       new" in out
    assert "Next: Mount the specimen anew and press by " in out


def test_a_width_that_is_reached_ends_it(rig: Rig, known: list[Path], tmp_path: Path) -> None:
    run = judged_run(tmp_path / "run", half_width=0.05)
    status, out, _ = rig("next", *known, "--done", run, "--stop-at", "20%")
    assert status == 1
    assert "No further press is needed" in out


def test_one_clear_error_for_a_calibration_or_run_that_cannot_be_used(
    rig: Rig, known: list[Path], tmp_path: Path
) -> None:
    other = judged_run(tmp_path / "other", condition="constant-min")
    status, _, err = rig("next", *known, "--done", other)
    assert status == 2
    assert (
        "other: expected one of the calibrations high-stiffness.json, modular.json, but found 0°, constant-min" in err
    )
    unjudged = judged_run(tmp_path / "unjudged")
    (unjudged / "kappa.csv").unlink()
    status, _, err = rig("next", *known, "--done", unjudged)
    assert (status, "kappa.csv: expected presses that were judged, but found none" in err) == (2, True)


def test_no_evidence_counts_twice_and_none_of_another_specimen_counts(
    rig: Rig, known: list[Path], tmp_path: Path
) -> None:
    run = judged_run(tmp_path / "run")
    calibration = open_calibration(known[1])
    again = write_calibration(tmp_path / "again.json", calibration)
    other = judged_run(tmp_path / "other", specimen="S2")
    judged_otherwise = judged_run(tmp_path / "otherwise")
    (judged_otherwise / "kappa.json").write_text(json.dumps({"sha256": "0" * 64}))
    for options, wanted in (
        ((*known, "--done", run, "--done", tmp_path / "other" / ".." / "run"), "expected every run once, but found it"),
        ((*known, "--done", run, "--done", other), "expected a run of S4, as run is, but found one of S2"),
        ((*known, again), "again.json: expected one calibration for each angle and condition, but found "),
        ((*known, "--done", judged_otherwise), "kappa.json, sha256: expected that of modular.json, "),
    ):
        status, _, err = rig("next", *options)
        assert (status, wanted in err) == (2, True), err
    (judged_otherwise / "kappa.json").write_text(json.dumps({"sha256": sha256_of(calibration)}))
    status, _, err = rig("next", *known, "--done", judged_otherwise)
    assert status in (0, 1), err
