"""``casr area`` and ``casr flow``: numbers from few frames."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from casr.cli import main

Captured = pytest.CaptureFixture[str]


def test_area_by_every_rule(presses: Path, capsys: Captured) -> None:
    assert main(["area", str(presses / "S5_00deg_01"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["areas"]) == {"hexagon", "edge", "circle", "paper", "as-printed"}
    assert found["areas"]["as-printed"] is None, "no contact is that large"
    assert found["pins"] == 127
    hexagon = found["areas"]["hexagon"]
    assert hexagon["area_mm2"] == pytest.approx(hexagon["area_px2"] / 36)


def test_a_threshold_no_pin_reaches_leaves_the_rules_that_need_none(presses: Path, capsys: Captured) -> None:
    assert main(["area", str(presses / "S5_00deg_01"), "--threshold-px", "500"]) == 0
    captured = capsys.readouterr()
    lines = {line.split()[0]: line for line in captured.out.splitlines() if line.strip()}
    assert float(lines["edge"].split()[1]) == pytest.approx(140.5, rel=0.02)
    assert "no contact" in lines["hexagon"]
    assert "no contact" in lines["paper"]
    assert "pairs of pins of the two frames that are more than 500 px apart" in captured.err


def test_area_decodes_two_frames_only(presses: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from casr.frames import FrameSequence

    read: list[int] = []
    get = FrameSequence.__getitem__
    monkeypatch.setattr(FrameSequence, "__getitem__", lambda self, index: read.append(index) or get(self, index))
    assert main(["area", str(presses / "S5_00deg_01"), "--frames", "0,12"]) == 0
    assert read == [0, 12]


def test_area_without_force_finds_the_first_contact(presses: Path, capsys: Captured) -> None:
    folder = presses / "S5_00deg_01"
    assert main(["area", str(folder / "frames.tif"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    truth = json.loads((folder / "truth.json").read_text())["truth"]
    assert found["rest_frame"] == 0
    assert 0.1 < truth["force_n"][found["contact_frame"]] < 0.7


def test_two_rest_frames_show_no_contact(presses: Path, capsys: Captured) -> None:
    assert main(["area", str(presses / "S5_00deg_01"), "--frames", "0,1", "--json"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["areas"]["hexagon"] is None


@pytest.mark.parametrize(("engine", "tolerance"), [("pin-affine", 0.05), ("dis", 0.3)])
def test_flow_over_twenty_steps_is_the_truth(
    engine: str, tolerance: float, stuck_press: Path, capsys: Captured
) -> None:
    folder = stuck_press
    truth = json.loads((folder / "truth.json").read_text())["truth"]
    i, j = truth["loading_frames"][10], truth["loading_frames"][30]
    x, y = truth["centre_px"]
    region = f"{x},{y},{0.9 * truth['semi_axes_px'][i][0]}"
    words = ["flow", str(folder), "--frames", f"{i},{j}", "--engine", engine, "--region", region, "--json"]
    assert main(words) == 0
    steps = json.loads(capsys.readouterr().out)["steps"]
    true = math.log(truth["area_px2"][j] / truth["area_px2"][i])
    assert steps[-1]["sum"] == pytest.approx(true, rel=tolerance)


def test_flow_step_by_step_adds_up(presses: Path, capsys: Captured) -> None:
    assert main(["flow", str(presses / "S1_00deg_01"), "--json"]) == 0
    steps = json.loads(capsys.readouterr().out)["steps"]
    assert steps[-1]["sum"] == pytest.approx(sum(step["log_growth"] for step in steps))
    assert [step["from"] + 1 for step in steps] == [step["to"] for step in steps]


@pytest.mark.parametrize(("engine", "name"), [("pin-affine", "spreading"), ("dis", "flow")])
def test_flow_picture(engine: str, name: str, presses: Path, tmp_path: Path) -> None:
    words = ["flow", str(presses / "S5_00deg_01"), "--frames", "20,24", "--engine", engine, "--figures", str(tmp_path)]
    assert main(words) == 0
    assert (tmp_path / f"{name}.svg").stat().st_size > 10_000


@pytest.mark.parametrize("engine", ["dis", "horn-schunck"])
def test_a_region_of_no_size_is_said_in_one_line(engine: str, presses: Path, capsys: Captured) -> None:
    words = ["flow", str(presses / "S5_00deg_01"), "--frames", "9,11", "--engine", engine, "--region", "150,150,0.1"]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert "region: expected 3 or more rows" in error
    assert len(error.splitlines()) == 1


def test_a_frame_that_is_not_there(presses: Path, capsys: Captured) -> None:
    assert main(["flow", str(presses / "S5_00deg_01"), "--frames", "0,900"]) == 2
    assert "900" in capsys.readouterr().err
