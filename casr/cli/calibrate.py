"""``casr calibrate``: a camera file from pictures of a flat board."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.cli.arguments import positive, say_notes
from casr.command_line import Commands, add_command, add_json, print_json
from casr.errors import CameraError, SettingError

if TYPE_CHECKING:
    from casr.camera import Camera, Sensor
    from casr.camera_calibration import Board, Calibration, View

DISTORTIONS = (0, 4, 5, 8)


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "calibrate",
        run,
        "Make a camera file from pictures of a ChArUco board or a chessboard.",
        "Take 10 to 20 sharp pictures with the lens, focus and frame size of the presses: the board over every part of "
        "the image, tilted by 20 to 40 degrees to different sides. Refused: fewer than 5 pictures that show the board, "
        "boards over less than 40 % of the image, a focal length with a standard error above 1 %. "
        "Example: casr calibrate pictures --charuco 9x7 --square-mm 5 --marker-mm 3.75 --depth-mm 50 -o camera.toml",
    )
    parser.add_argument("pictures", type=Path, nargs="*", metavar="PICTURES", help="image files, or folders of them")
    parser.add_argument(
        "-o", "--out", type=Path, metavar="FILE", help="camera file to write; with --plate the one to read"
    )
    parser.add_argument(
        "--overwrite", action="store_true", help="replace a camera file that is there; its table [sensor] is kept"
    )
    board = parser.add_argument_group("board")
    kind = board.add_mutually_exclusive_group(required=True)
    kind.add_argument(
        "--charuco", type=_grid, metavar="COLUMNSxROWS", help="number of squares of a ChArUco board, columns x rows"
    )
    kind.add_argument(
        "--chessboard", type=_grid, metavar="COLUMNSxROWS",
        help="inner corners of a chessboard, where four squares meet: one less each way than squares",
    )  # fmt: skip
    kind.add_argument(
        "--plate", type=Path, metavar="PRESS",
        help="no pictures: a press on a rigid plate, to see whether a dome that casr knows moves as this sensor does; "
        "exit status 1: none does",
    )  # fmt: skip
    board.add_argument("--domes", metavar="FOLDER", help="tables of domes of your own, with --plate")
    board.add_argument("--square-mm", type=positive, metavar="MM", help="side of a square, mm")
    board.add_argument("--marker-mm", type=positive, metavar="MM", help="side of a ChArUco marker's black border, mm")
    board.add_argument(
        "--dictionary", metavar="NAME", help="of the ChArUco markers, such as 5X5_100 or 6X6_250 (default 4X4_50)"
    )
    camera = parser.add_argument_group("camera")
    depth = camera.add_mutually_exclusive_group()
    depth.add_argument(
        "--depth-mm", type=positive, metavar="MM",
        help="distance along the camera's axis from its pinhole to the pins at rest, mm; a pixel there is depth/fx "
        "wide (eq. 5), so 1 %% of it is 2 %% of every area",
    )  # fmt: skip
    depth.add_argument(
        "--depth-from", type=Path, metavar="PICTURE",
        help="the same, from a picture (one more) in which the board lies where the pins are at rest",
    )  # fmt: skip
    camera.add_argument(
        "--frame-rate-hz", type=positive, default=20.0, metavar="HZ", help="of the presses (default %(default)g)"
    )
    camera.add_argument(
        "--distortion", type=int, choices=DISTORTIONS, default=5,
        help="number of OpenCV's coefficients to fit: 4 with few pictures, 8 for a wide lens (default %(default)s)",
    )  # fmt: skip
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    if arguments.plate:
        from casr.cli.plate import check_plate

        return check_plate(arguments)
    _check(arguments)
    from casr.atomic import write_text_atomic
    from casr.camera import Camera
    from casr.camera_calibration import calibrate
    from casr.frame_files.picture import picture_files

    board = _board(arguments)
    sensor = _sensor_of(arguments.out, arguments.overwrite)
    files = picture_files([*arguments.pictures, *([arguments.depth_from] if arguments.depth_from else [])])
    views, left_out, (height_px, width_px) = _views(board, files)
    say_notes(f"{name} is left out: {reason}" for name, reason in left_out.items())
    found = calibrate(views, width_px, height_px, n_distortion=arguments.distortion)
    say_notes(found.notes)
    camera = Camera(
        width_px, height_px, found.fx_px, found.fy_px, found.cx_px, found.cy_px,
        arguments.depth_mm or _distance_mm(found, arguments.depth_from), found.distortion, arguments.frame_rate_hz,
        sensor,
    )  # fmt: skip
    facts = _facts(found, left_out)
    write_text_atomic(arguments.out, f"{camera.to_toml()}\n{_toml(facts)}")
    if arguments.json:
        print_json({"file": str(arguments.out), "camera": asdict(camera), "calibration": facts})
    else:
        _print(arguments.out, camera, found)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """What pictures of a board need, and a plate does not."""
    needed = {
        "PICTURES": arguments.pictures, "--out": arguments.out, "--square-mm": arguments.square_mm,
        "--depth-mm or --depth-from": arguments.depth_mm or arguments.depth_from,
    }  # fmt: skip
    for name, value in needed.items():
        if not value:
            raise SettingError(
                name,
                wanted="a value for a calibration from pictures",
                found="none",
                do=f"Add {name}; casr calibrate --help explains it.",
            )
    if arguments.domes:
        raise SettingError(
            "--domes",
            wanted="--plate beside this option",
            found="pictures of a board",
            do="Leave --domes out.",
        )


def _board(arguments: argparse.Namespace) -> Board:
    from casr.camera_calibration import Charuco, Chessboard

    if arguments.charuco:
        if arguments.marker_mm is None:
            raise SettingError(
                "--marker-mm",
                wanted="the size of the markers",
                found="none",
                do="Measure the outer edge of the black border of a marker.",
            )
        dictionary = (arguments.dictionary or "4X4_50").upper().removeprefix("DICT_")
        columns, rows = arguments.charuco
        return Charuco(columns, rows, arguments.square_mm, arguments.marker_mm, dictionary)
    if arguments.marker_mm or arguments.dictionary:
        option = "--marker-mm" if arguments.marker_mm else "--dictionary"
        raise SettingError(
            option,
            wanted="a ChArUco board",
            found="a chessboard",
            do="A chessboard has no markers: leave this option out.",
        )
    columns, rows = arguments.chessboard
    return Chessboard(columns, rows, arguments.square_mm)


def _sensor_of(out: Path, overwrite: bool) -> Sensor:
    """What the file to be replaced knows of the sensor."""
    from casr.camera import Sensor
    from casr.frame_files import read_camera

    if not out.exists():
        return Sensor()
    if not overwrite:
        raise CameraError(
            out,
            wanted="a new file",
            found="an existing file",
            do="Choose another name, or replace the file with --overwrite.",
        )
    return read_camera(out).sensor


def _views(board: Board, files: list[Path]) -> tuple[list[View], dict[str, str], tuple[int, int]]:
    """Pictures that show enough of the board; why others do not; (height, width) of all, px."""
    from casr.camera_calibration import View, unusable
    from casr.frame_files.picture import read_picture

    views, left_out, shapes = [], {}, {}
    for file in files:
        picture = read_picture(file)
        shapes[file] = picture.shape
        if picture.shape != shapes[files[0]]:
            (first_height, first_width), (height, width) = shapes[files[0]], picture.shape
            raise CameraError(
                file, wanted=f"{first_width} x {first_height} px like {files[0]}", found=f"{width} x {height} px",
                do="Give pictures of one camera at the frame size of the presses.",
            )  # fmt: skip
        view = View(str(file), *board.find(picture))
        if reason := unusable(view, board.n_corners):
            left_out[view.name] = reason
        else:
            views.append(view)
    return views, left_out, shapes[files[0]]


def _distance_mm(found: Calibration, picture: Path) -> float:
    for view in found.views:
        if view.name == str(picture):
            return view.distance_mm
    raise CameraError(
        "--depth-from", wanted="a picture that shows the board", found=str(picture), do="Take another one."
    )


def _facts(found: Calibration, left_out: dict[str, str]) -> dict[str, Any]:
    """What the file and ``--json`` tell of the fit, besides the camera."""
    return {
        "rms_px": found.rms_px,
        "fx_se_px": found.fx_se_px, "fy_se_px": found.fy_se_px, "cx_se_px": found.cx_se_px, "cy_se_px": found.cy_se_px,
        "covered": found.covered,
        "pictures_used": len(found.views),
        "pictures": [asdict(view) for view in found.views],
        "left_out": [{"name": name, "reason": reason} for name, reason in left_out.items()],
    }  # fmt: skip


def _toml(facts: dict[str, Any]) -> str:
    """The table ``[calibration]``; programs that need a camera do not read it."""
    lists = {key: value for key, value in facts.items() if isinstance(value, list)}
    lines = ["[calibration]", *(f"{key} = {value!r}" for key, value in facts.items() if key not in lists)]
    for key, rows in lists.items():
        for row in rows:
            lines += ["", f"[[calibration.{key}]]", *(f"{name} = {_value(value)}" for name, value in row.items())]
    return "\n".join(lines) + "\n"


def _value(value: object) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _print(out: Path, camera: Camera, found: Calibration) -> None:
    width, height = (f"{size:.4g}" for size in camera.mm_per_px)
    print(f"{out}: {camera.width_px} x {camera.height_px} px, from {len(found.views)} pictures; ", end="")
    print(f"boards cover {found.covered:.0%} of the image")
    for name in ("fx", "fy", "cx", "cy"):
        print(
            f"  {name:<11} {getattr(found, f'{name}_px'):.2f} px, standard error {getattr(found, f'{name}_se_px'):.2f}"
        )
    print(f"  distortion  {', '.join(f'{x:.4g}' for x in camera.distortion) or 'none'}")
    print(f"  depth       {camera.depth_mm:.4g} mm: a pixel at the pins is {width} x {height} mm")
    print(f"  left over   {found.rms_px:.3f} px rms")
    print(f"  {'corners':>7} {'rms, px':>8} {'tilt, deg':>9} {'distance, mm':>12}  picture")
    for view in found.views:
        print(f"  {view.corners:>7} {view.rms_px:>8.3f} {view.tilt_deg:>9.1f} {view.distance_mm:>12.1f}  {view.name}")


def _grid(text: str) -> tuple[int, int]:
    """``"9x7"``."""
    columns, _, rows = text.lower().partition("x")
    if not (columns.isdecimal() and rows.isdecimal()):
        raise argparse.ArgumentTypeError(f"expected columns and rows such as 9x7, but found {text!r}")
    return int(columns), int(rows)
