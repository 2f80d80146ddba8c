"""``casr calibrate``: pictures on disk to a camera file, and a press on a rigid plate."""

from __future__ import annotations

import json
import tomllib

import cv2
import numpy as np
import pytest

from casr.camera import Sensor
from casr.cli import main
from casr.frame_files import read_camera

BOARD = ["--charuco", "7x5", "--square-mm", "6", "--marker-mm", "4.5"]


@pytest.fixture(scope="module")
def folder(studio, tmp_path_factory):
    """Twelve pictures of a board, one of nothing, and one of the board where pins would be, 50 mm away."""
    made = tmp_path_factory.mktemp("pictures") / "board"
    made.mkdir()
    drawing, rng = studio.charuco(7, 5, 6.0, 4.5), np.random.default_rng(9)
    for number, picture in enumerate(studio.pictures(drawing, 12, seed=1)):
        cv2.imwrite(str(made / f"{number}.png"), picture)
    cv2.imwrite(str(made / "12.png"), np.full((240, 320), 90, np.uint8))
    cv2.imwrite(str(made.parent / "at_pins.png"), studio.picture(drawing, (0.02, 0, 0), np.array([1.0, 0, 50.0]), rng))
    cv2.imwrite(str(made.parent / "other.png"), np.full((200, 320), 90, np.uint8))
    (made.parent / "cut.png").write_bytes((made / "0.png").read_bytes()[:200])
    (made.parent / "none").mkdir()
    return made


def test_a_camera_file_and_what_is_said_of_it(folder, studio, tmp_path, capsys):
    out = tmp_path / "new" / "camera.toml"
    words = ["calibrate", str(folder), *BOARD, "--depth-mm", "50", "--frame-rate-hz", "30", "-o", str(out)]
    assert main(words) == 0
    said = capsys.readouterr()
    assert said.err == f"note: {folder / '12.png'} is left out: it shows no board\n"
    assert "320 x 240 px, from 12 pictures; boards cover 5" in said.out
    assert "a pixel at the pins is 0.19" in said.out
    assert said.out.count(".png") == 12
    camera = read_camera(out)
    assert camera.fx_px == pytest.approx(studio.camera.fx_px, abs=1.5)
    assert (camera.width_px, camera.height_px, camera.depth_mm, camera.frame_rate_hz) == (320, 240, 50.0, 30.0)
    assert len(camera.distortion) == 5
    told = tomllib.loads(out.read_text(encoding="utf-8"))["calibration"]
    assert told["rms_px"] < 0.3
    assert 0 < told["fx_se_px"] < 1
    assert told["pictures_used"] == len(told["pictures"]) == 12
    assert told["pictures"][0]["name"] == str(folder / "0.png")
    assert told["left_out"] == [{"name": str(folder / "12.png"), "reason": "it shows no board"}]


def test_depth_is_where_the_board_lies(folder, tmp_path, capsys):
    out = tmp_path / "camera.toml"
    at_pins = str(folder.parent / "at_pins.png")
    assert main(["calibrate", str(folder), *BOARD, "--depth-from", at_pins, "-o", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["camera"]["depth_mm"] == pytest.approx(50.0, rel=0.005)
    # the scale at the pins is that of the picture: errors of fx and of the depth cancel
    scale = found["camera"]["depth_mm"] / found["camera"]["fx_px"]
    assert scale == pytest.approx(50.0 / 262.0, rel=0.003)
    assert found["calibration"]["pictures_used"] == 13


def test_overwriting_keeps_what_is_known_of_the_sensor(folder, tmp_path, capsys):
    out = tmp_path / "camera.toml"
    words = ["calibrate", str(folder), *BOARD, "--depth-mm", "50", "-o", str(out)]
    assert main(words) == 0
    first = out.read_text(encoding="utf-8")
    out.write_text(first + "[sensor]\npin_length_mm = 1.5\n", encoding="utf-8")
    capsys.readouterr()
    assert main(words) == 2
    assert "camera.toml: expected a new file, but found an existing file" in capsys.readouterr().err
    assert main([*words, "--overwrite"]) == 0
    assert read_camera(out).sensor == Sensor(pin_length_mm=1.5)
    out.write_text("no camera", encoding="utf-8")
    assert main([*words, "--overwrite"]) == 2
    assert out.read_text(encoding="utf-8") == "no camera"


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["{b}/0.png", "{b}/1.png", *BOARD], "expected 5 or more that show the board, but found 2"),
        (["{b}/0.png", "{b}/../other.png", *BOARD], "other.png: expected 320 x 240 px like "),
        (["{b}/0.png", "{b}/../cut.png", *BOARD], "cut.png: expected an image"),
        (["{b}/gone.png", *BOARD], "gone.png: expected a file or folder that can be read"),
        (["{b}/../none", *BOARD], "none: expected images"),
        (["{b}", *BOARD[:4]], "--marker-mm: expected the size of the markers, but found none"),
        (["{b}", *BOARD, "--dictionary", "9X9_50"], "--dictionary: expected one of 4X4_50"),
        (["{b}", "--chessboard", "7x5", *BOARD[2:]], "--marker-mm: expected a ChArUco board, but found a chessboard"),
        (
            ["{b}/12.png", "--chessboard", "7x5", "--square-mm", "6"],
            "expected 5 or more that show the board, but found 0",
        ),
        (["{b}", "--chessboard", "7x1", "--square-mm", "6"], "--chessboard: expected 3 to 100 inner corners"),
    ],
)
def test_unusable_input_is_named(words, complaint, folder, tmp_path, capsys):
    words = [word.format(b=folder) for word in words]
    assert main(["calibrate", *words, "--depth-mm", "50", "-o", str(tmp_path / "camera.toml")]) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("casr: ")
    assert complaint in last
    assert list(tmp_path.iterdir()) == []


def test_depth_from_a_picture_without_a_board(folder, tmp_path, capsys):
    words = ["calibrate", str(folder), *BOARD, "--depth-from", str(folder / "12.png"), "-o", str(tmp_path / "c.toml")]
    assert main(words) == 2
    assert "--depth-from: expected a picture that shows the board" in capsys.readouterr().err
