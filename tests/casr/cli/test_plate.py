"""``casr calibrate --plate``: a press on a rigid plate says whether the sensor is one that the library knows."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casr.cli import main
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, simulate_press, write_press

RIGID = 1e6


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    press = simulate_press(PressSettings(stiffness_n_per_mm=RIGID))
    return write_press(press, tmp_path_factory.mktemp("plate") / "press")


def test_a_dome_like_those_of_the_library_is_told(plate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "--plate", str(plate), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["fits"] is True
    assert found["misfit"] < 0.05
    lengths = {float(length): misfit for length, misfit in found["misfit_of_length"].items()}
    assert min(lengths, key=lengths.__getitem__) == 3.0


def test_a_sensor_that_is_none_of_them_ends_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    press = simulate_press(PressSettings(stiffness_n_per_mm=7.63, world=ContactWorld()))
    folder = write_press(press, tmp_path / "press")
    assert main(["calibrate", "--plate", str(folder)]) == 1
    assert "it is none of the library's" in capsys.readouterr().out


def test_the_length_of_the_pins_must_be_known(plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    camera = tmp_path / "camera.toml"
    camera.write_text((plate / "camera.toml").read_text().partition("[sensor]")[0])
    assert main(["calibrate", "--plate", str(plate), "--out", str(camera)]) == 2
    assert "sensor.pin_length_mm: expected the length of the pins" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (
            ["--charuco", "9x7"],
            "PICTURES: expected a value for a calibration from pictures, but found none. Add PICTURES",
        ),
        (
            ["board.png", "--charuco", "9x7", "-o", "c.toml", "--depth-mm", "50"],
            "--square-mm: expected a value for a calibration from pictures",
        ),
        (["board.png", "--charuco", "9x7", "-o", "c.toml", "--square-mm", "5"], "--depth-mm or --depth-from"),
        (
            ["b.png", "--charuco", "9x7", "-o", "c.toml", "--square-mm", "5", "--depth-mm", "9", "--domes", "d"],
            "--domes: expected --plate beside this option",
        ),
        (["--plate", "nowhere"], "nowhere"),
    ],
)
def test_what_is_missing_is_said(arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", *arguments]) == 2
    assert says in capsys.readouterr().err
