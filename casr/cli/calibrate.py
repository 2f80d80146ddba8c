"""``casr calibrate``: a camera file from pictures of a board."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from casr.cli.arguments import TYPES, of_fields, say_notes
from casr.command_line import Commands, add_command, add_json, add_options, print_json

DISTORTIONS = (0, 4, 5, 8)
OUT = """
pictures [PICTURES...]  image files, or folders of them
-o --out FILE  camera file to write
--overwrite  replace a camera file that is there; its table [sensor] is kept
"""
KIND = """
--charuco COLUMNSxROWS  number of squares of a ChArUco board, columns x rows
--chessboard COLUMNSxROWS  inner corners of a chessboard, where four squares meet: one less each way than squares
"""
BOARD = """
--square-mm MM  side of a square, mm
--marker-mm MM  side of a ChArUco marker's black border, mm
--dictionary NAME  of the ChArUco markers, such as 5X5_100 or 6X6_250 (default 4X4_50)
"""
DEPTH = """
--depth-mm MM  distance along the camera's axis from its pinhole to the pins at rest, mm; a pixel there is depth/fx
    wide (eq. 5), so 1 %% of it is 2 %% of every area
--depth-from PICTURE  the same, from a picture (one more) in which the board lies where the pins are at rest
"""
CAMERA = """
--frame-rate-hz HZ = 20  of the presses (default %(default)s)
--distortion N = 5  number of OpenCV's coefficients to fit: 4 with few pictures, 8 for a wide lens (default %(default)s)
"""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "calibrate", run,
        "Make a camera file from pictures of a ChArUco board or a chessboard.",
        "Take 10 to 20 sharp pictures with the lens, focus and frame size of the presses: the board over every part of "
        "the image, tilted by 20 to 40 degrees to different sides. Refused: fewer than 5 pictures that show the board, "
        "boards over less than 40 % of the image, a focal length with a standard error above 1 %. "
        "Example: casr calibrate pictures --charuco 9x7 --square-mm 5 --marker-mm 3.75 --depth-mm 50 -o camera.toml",
    )  # fmt: skip
    add_options(parser, OUT, TYPES)
    board, camera = parser.add_argument_group("board"), parser.add_argument_group("camera")
    add_options(board.add_mutually_exclusive_group(required=True), KIND, TYPES)
    add_options(board, BOARD, TYPES)
    add_options(camera.add_mutually_exclusive_group(), DEPTH, TYPES)
    add_options(camera, CAMERA, TYPES, distortion={"choices": DISTORTIONS, "type": int, "metavar": None})
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from casr.frame_files.board_pictures import BoardPictures, write_camera_file

    settings = BoardPictures(**of_fields(arguments, BoardPictures))
    measured = write_camera_file(settings, lambda note: say_notes([note]))
    if arguments.json:
        facts = {"camera": asdict(measured.camera), "calibration": measured.facts()}
        print_json({"file": str(arguments.out)} | facts)
    else:
        print(measured.text(arguments.out))
    return 0
