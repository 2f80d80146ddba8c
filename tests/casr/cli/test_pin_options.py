"""Options that say what the pins are, bad frames and small regions on the command line, and where pages go."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import tifffile

from casr.cli import main

Captured = pytest.CaptureFixture[str]
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
def test_another_count_of_pins_is_said_or_refused(command: list[str], presses: Path, capsys: Captured) -> None:
    name, *words = command
    press = str(presses / "S5_00deg_01")
    assert main([name, press, *words, "--expect-pins", "130"]) == 0
    assert "127 pins are found at rest, not 130" in capsys.readouterr().err
    assert main([name, press, *words, "--expect-pins", "331"]) == 2
    assert "expected 331 pins (--expect-pins), but found 127" in capsys.readouterr().err


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_what_makes_no_pin_is_refused_with_the_options_that_help(
    command: list[str], presses: Path, capsys: Captured
) -> None:
    name, *words = command
    press = str(presses / "S5_00deg_01")
    for option in (["--contrast", "220"], ["--min-area", "4000"]):
        assert main([name, press, *words, *option]) == 2
        assert "--contrast" in capsys.readouterr().err
    for option in (["--contrast", "300"], ["--pitch", "1"], ["--expect-pins", "2"]):
        assert main([name, press, *words, *option]) == 2
        assert "PinSettings." in capsys.readouterr().err


def test_a_small_region_is_refused(presses: Path, capsys: Captured) -> None:
    for command in (["score"], ["flow", "--frames", "10,12"]):
        assert main([command[0], str(presses / "S5_00deg_01"), *command[1:], "--region", "150,150,2"]) == 2
        assert "region: expected 3 or more pins inside it, but found 1 " in capsys.readouterr().err


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
