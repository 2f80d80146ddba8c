"""``casr calibrate``: a camera file from pictures of a flat board."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from casr.cli.arguments import Row, add_options, of_fields, say_notes
from casr.cli.plate import PLATE, check_plate
from casr.cli.values import FILE, FOLDER, GRID, HZ, MM, NAME, PICTURE
from casr.command_line import Commands, add_command, add_json, print_json
from casr.errors import SettingError

DISTORTIONS = (0, 4, 5, 8)
# fmt: off
OUT: tuple[Row, ...] = (
    ("-o,--out", FILE, None, "camera file to write; with --plate the one to read"),
    ("--overwrite", None, False, "replace a camera file that is there; its table [sensor] is kept"),
)
KIND: tuple[Row, ...] = (
    ("--charuco", GRID, None, "number of squares of a ChArUco board, columns x rows"),
    ("--chessboard", GRID, None,
     "inner corners of a chessboard, where four squares meet: one less each way than squares"),
    PLATE,
)
BOARD: tuple[Row, ...] = (
    ("--domes", FOLDER, None, "tables of domes of your own, with --plate"),
    ("--square-mm", MM, None, "side of a square, mm"),
    ("--marker-mm", MM, None, "side of a ChArUco marker's black border, mm"),
    ("--dictionary", NAME, None, "of the ChArUco markers, such as 5X5_100 or 6X6_250 (default 4X4_50)"),
)
DEPTH: tuple[Row, ...] = (
    ("--depth-mm", MM, None,
     "distance along the camera's axis from its pinhole to the pins at rest, mm; a pixel there is depth/fx wide "
     "(eq. 5), so 1 %% of it is 2 %% of every area"),
    ("--depth-from", PICTURE, None,
     "the same, from a picture (one more) in which the board lies where the pins are at rest"),
)
CAMERA: tuple[Row, ...] = (
    ("--frame-rate-hz", HZ, 20.0, "of the presses (default %(default)g)"),
    ("--distortion", DISTORTIONS, 5,
     "number of OpenCV's coefficients to fit: 4 with few pictures, 8 for a wide lens (default %(default)s)"),
)
# fmt: on


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "calibrate", run,
        "Make a camera file from pictures of a ChArUco board or a chessboard.",
        "Take 10 to 20 sharp pictures with the lens, focus and frame size of the presses: the board over every part of "
        "the image, tilted by 20 to 40 degrees to different sides. Refused: fewer than 5 pictures that show the board, "
        "boards over less than 40 % of the image, a focal length with a standard error above 1 %. "
        "Example: casr calibrate pictures --charuco 9x7 --square-mm 5 --marker-mm 3.75 --depth-mm 50 -o camera.toml",
    )  # fmt: skip
    parser.add_argument("pictures", type=Path, nargs="*", metavar="PICTURES", help="image files, or folders of them")
    add_options(parser, *OUT)
    board, camera = parser.add_argument_group("board"), parser.add_argument_group("camera")
    add_options(board.add_mutually_exclusive_group(required=True), *KIND)
    add_options(board, *BOARD)
    add_options(camera.add_mutually_exclusive_group(), *DEPTH)
    add_options(camera, *CAMERA)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    if arguments.plate:
        return check_plate(arguments)
    if arguments.domes and arguments.pictures:
        found, do = "pictures of a board", "Leave --domes out."
        raise SettingError("--domes", wanted="--plate beside this option", found=found, do=do)
    from casr.frame_files.board_pictures import BoardPictures, write_camera_file

    settings = BoardPictures(**of_fields(arguments, BoardPictures))
    measured = write_camera_file(settings, lambda note: say_notes([note]))
    if arguments.json:
        facts = {"camera": asdict(measured.camera), "calibration": measured.facts()}
        print_json({"file": str(arguments.out)} | facts)
    else:
        print(measured.text(arguments.out))
    return 0
