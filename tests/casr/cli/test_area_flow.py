"""``casr area`` and ``casr flow``: numbers from few frames; options that say what the pins are, and bad frames."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
import tifffile

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


COMMANDS = (["score"], ["area"], ["flow", "--frames", "10,14"])


@pytest.fixture(scope="module")
def dark(presses: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A press whose pins are darker than the skin."""
    folder = tmp_path_factory.mktemp("dark") / "dark"
    shutil.copytree(presses / "S5_00deg_01", folder)
    frames = tifffile.imread(folder / "frames.tif")
    tifffile.imwrite(folder / "frames.tif", 255 - frames, photometric="minisblack")
    return folder


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_dark_pins_are_measured_like_bright_ones(
    command: list[str], presses: Path, dark: Path, capsys: Captured
) -> None:
    name, *words = command
    assert main([name, str(dark), *words, "--dark-pins", "--expect-pins", "127", "--json"]) == 0
    captured = capsys.readouterr()
    assert "not 127" not in captured.err
    found = json.loads(captured.out)
    assert main([name, str(presses / "S5_00deg_01"), *words, "--json"]) == 0
    bright = json.loads(capsys.readouterr().out)
    if name == "score":
        assert found["rate"]["value"] == pytest.approx(bright["rate"]["value"], rel=1e-3)
        assert found["settings"]["flow"]["pins"]["dark_pins"] is True
    elif name == "area":
        assert found["areas"]["edge"]["area_mm2"] == pytest.approx(bright["areas"]["edge"]["area_mm2"], rel=2e-3)
    else:
        assert found["steps"][-1]["sum"] == pytest.approx(bright["steps"][-1]["sum"], rel=2e-3)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_another_count_of_pins_is_said(command: list[str], presses: Path, capsys: Captured) -> None:
    name, *words = command
    press = str(presses / "S5_00deg_01")
    assert main([name, press, *words, "--expect-pins", "130"]) == 0
    assert "127 pins are found at rest, not 130" in capsys.readouterr().err


def test_bad_frames_are_left_out_by_score_and_flow(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    folder = tmp_path / "some_black"
    shutil.copytree(presses / "S5_00deg_01", folder)
    frames = tifffile.imread(folder / "frames.tif")
    frames[[20, 30]] = 0
    tifffile.imwrite(folder / "frames.tif", frames, photometric="minisblack")
    assert main(["score", str(folder), "--json"]) == 0
    captured = capsys.readouterr()
    assert "frames 20, 30 are skipped" in captured.err
    assert not {20, 30} & set(json.loads(captured.out)["frames"])
    assert main(["flow", str(folder), "--frames", "18,22", "--json"]) == 0
    captured = capsys.readouterr()
    assert "frame 20 is left out" in captured.err
    assert [(step["from"], step["to"]) for step in json.loads(captured.out)["steps"]] == [(18, 19), (19, 21), (21, 22)]
    frames[20:23] = 0
    tifffile.imwrite(folder / "frames.tif", frames, photometric="minisblack")
    for command in (["score"], ["flow", "--frames", "18,24"]):
        assert main([command[0], str(folder), *command[1:]]) == 2
        assert "frame 22, " in capsys.readouterr().err


def test_pages_do_not_go_among_the_raw_data(presses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("S1_00deg_01", "S5_00deg_01"):
        shutil.copytree(presses / name, tmp_path / "pr" / name)
    before = sorted(path.relative_to(tmp_path) for path in (tmp_path / "pr").rglob("*"))
    monkeypatch.chdir(tmp_path)
    assert main(["score", "pr", "--page", "pr.html"]) == 0
    assert sorted(path.relative_to(tmp_path) for path in (tmp_path / "pr").rglob("*")) == before
    pages = sorted(path.name for path in (tmp_path / "pr_pages").iterdir())
    assert pages == ["S1_00deg_01.html", "S5_00deg_01.html"]
    index = (tmp_path / "pr.html").read_text(encoding="utf-8")
    assert all(f"pr_pages/{page}" in index for page in pages)


def test_a_white_noise_film_has_no_pins(tmp_path: Path, capsys: Captured) -> None:
    noise = np.random.default_rng(0).normal(90, 25, (6, 300, 300)).clip(0, 255).astype(np.uint8)
    np.save(tmp_path / "noise.npy", noise)
    assert main(["score", str(tmp_path / "noise.npy")]) == 2
    assert "pins" in capsys.readouterr().err
