"""``casr calibrate``: a camera file from pictures of a board, or whether a press on a plate is like a known dome's."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from math import inf

from casr.cli.arguments import TYPES, of_fields, say_notes
from casr.command_line import Commands, add_command, add_json, add_options, print_json
from casr.errors import SettingError

OWN_TABLES = "Give tables of this sensor's own: casr dome, then casr score --domes."


def check_plate(arguments: argparse.Namespace) -> int:
    """Exit status 1: the sensor is none of the library's."""
    from casr.contact_area.library_front import worlds_for
    from casr.contact_area.plate import check_on_plate
    from casr.dome.library import tables_of
    from casr.errors import CameraError
    from casr.frame_files import open_frames, read_camera
    from casr.scoring import score

    given = arguments.out if arguments.out and arguments.out.exists() else None
    sequence = open_frames(arguments.plate, camera=given)
    camera = read_camera(given) if given else sequence.camera
    if camera is None:
        wanted, do = "a camera file beside the press, or one given with --out", "Calibrate the camera first."
        raise CameraError(arguments.plate, wanted=wanted, found="none", do=do)
    if arguments.domes and all(table.stiffness_n_per_mm < inf for table in tables_of(str(arguments.domes))):
        wanted, do = "a table of a rigid plate among these", "Solve one: rigid = true in the file for casr dome."
        raise SettingError("--domes", wanted=wanted, found="tables of soft specimens alone", do=do)
    scored = score(sequence)
    found = check_on_plate(scored.rest.centroids_px, scored.pins_px, camera, worlds_for(camera, arguments.domes, None))
    if arguments.json:
        print_json(asdict(found))
        return int(not found.fits)
    verdict = "it is like" if found.fits else "it is none of the library's; nearest is"
    print(f"{arguments.plate}: {found.misfit:.1%} of the pins' motion is left over: {verdict} dome {found.dome}")
    for length, misfit in found.misfit_of_length.items():
        print(f"  with pins of {length:.2g} mm: {misfit:.1%}")
    print("  (the length is not told by this: measure it)")
    if not found.fits:
        do = "Are radius, skin and moduli in the file for casr dome right?" if arguments.domes else OWN_TABLES
        print(f"  Areas by the front depend on the dome assumed. {do}")
    return int(not found.fits)


DISTORTIONS = (0, 4, 5, 8)
OUT = """
pictures [PICTURES...]  image files, or folders of them
-o --out FILE  camera file to write; with --plate the one to read
--overwrite  replace a camera file that is there; its table [sensor] is kept
"""
KIND = """
--charuco COLUMNSxROWS  number of squares of a ChArUco board, columns x rows
--chessboard COLUMNSxROWS  inner corners of a chessboard, where four squares meet: one less each way than squares
--plate PRESS  no pictures: a press on a rigid plate, to see whether a dome that casr knows moves as this sensor does;
    exit status 1: none does
"""
BOARD = """
--domes FOLDER  tables of domes of your own, with --plate
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
