"""``emg2vsa rig run --adaptive``: each next run is the one that ``rig next`` would choose."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.rig.plans import known_calibration
from emg2vsa.calibration.next_press import next_press
from emg2vsa.calibration_file import open_calibration, write_calibration

Rig = Callable[..., tuple[int, str, str]]
RigFile = Callable[..., Path]
ELASTIC = ("gap_mm = 2", 'gap_mm = 2\nworld = "elastic"')
START = ("--virtual", "--specimen", "S3", "--adaptive")


@pytest.fixture
def slow_rig(rig_file: RigFile) -> Path:
    """Twenty frames a press, and areas by force alone; two angles."""
    path = rig_file(ELASTIC)
    text = path.read_text().replace("ramp_mm_per_s = 8", "ramp_mm_per_s = 3")
    path.write_text(text.replace("high-stiffness = [0]", "high-stiffness = [0, 30]"))
    return path


@pytest.fixture
def known(tmp_path: Path) -> list[Path]:
    """A calibration that tells much, and one of presses that scatter."""
    good, poor = known_calibration(), known_calibration(angle_deg=30.0)
    scattered = poor.rates.copy()
    scattered[:, ::2] *= 1.3
    return [
        write_calibration(tmp_path / "poor.json", replace(poor, rates=scattered)),
        write_calibration(tmp_path / "good.json", good),
    ]


def options(known: list[Path]) -> list[object]:
    return [word for path in known for word in ("--calibration", path)]


def test_the_next_run_is_the_one_that_rig_next_says(
    rig: Rig, slow_rig: Path, known: list[Path], tmp_path: Path
) -> None:
    first = next_press([open_calibration(path) for path in known], {}, 0.3)
    assert first is not None
    assert known[first.calibration].name == "good.json"
    status, out, err = rig("run", slow_rig, *START, *options(known), "--stop-at", 30, "--repetitions", 3)
    assert status == 0, err
    assert f"next: presses: {min(3, first.presses)}, by good.json, a new mounting; " in out
    folder = tmp_path / "runs-virtual" / "S3_0_high-stiffness"
    assert json.loads((folder / "plan.json").read_text())["plan"]["repetitions"] == min(3, first.presses)
    low, high = out.strip().splitlines()[-2].rpartition("from ")[2].split(" to ")
    assert float(low) < 3.35 < float(high)
    # what is done counts: the same command begins with what is known
    _, again, _ = rig("run", slow_rig, *START, *options(known), "--stop-at", 30, "--repetitions", 1, "--json")
    said, _ = json.JSONDecoder().raw_decode(again)
    assert said["belief"]["high_n_per_mm"] - said["belief"]["low_n_per_mm"] <= 1.05 * (float(high) - float(low))
    # presses that another calibration judged are no evidence of this one
    about = folder / "kappa.json"
    about.write_text(json.dumps(json.loads(about.read_text()) | {"sha256": "0" * 64}))
    status, _, err = rig("run", slow_rig, *START, *options(known), "--stop-at", 30, "--repetitions", 1)
    assert (status, "kappa.json, sha256: expected that of good.json" in err) == (2, True)


def test_it_ends_where_the_width_is_reached(rig: Rig, slow_rig: Path, known: list[Path]) -> None:
    status, out, err = rig("run", slow_rig, *START, "--calibration", known[1], "--stop-at", 60, "--json")
    assert status == 0, err
    said = json.loads(out)
    assert said["runs"]
    assert all(Path(run["folder"]).is_dir() for run in said["runs"])
    believed = said["belief"]
    assert believed["low_n_per_mm"] < 3.35 < believed["high_n_per_mm"]
    assert believed["high_n_per_mm"] / believed["low_n_per_mm"] < (1 + 0.6) ** 2
    status, out, _ = rig("run", slow_rig, *START, "--calibration", known[1], "--stop-at", 60, "--json")
    assert (status, json.loads(out)["runs"]) == (0, [])


def test_without_an_operator_a_change_by_hand_is_refused(
    rig: Rig, slow_rig: Path, known: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nobody() -> str:
        raise EOFError

    monkeypatch.setattr("builtins.input", nobody)
    slow_rig.write_text(f"{slow_rig.read_text()}behind_ports = true\n")
    status, _, err = rig("run", slow_rig, *START[1:], *options(known))
    assert status == 2
    assert (
        "--adaptive: expected somebody to put S3 at 0 degrees under the rigid motor, but found the end of the standard "
        "input. Run it in a terminal; the same command goes on from the presses that are done." in err
    )
    assert not (tmp_path / "runs").exists()
