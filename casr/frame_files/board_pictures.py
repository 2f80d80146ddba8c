"""A camera from picture files of a board, and the camera file that keeps it with its fit."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.atomic import write_text_atomic
from casr.camera import Camera, Sensor
from casr.camera_calibration import Board, Calibration, Charuco, Chessboard, View, calibrate, unusable
from casr.errors import CameraError, FramesError, SettingError
from casr.frame_files.camera_file import read_camera
from casr.frame_files.folder import folder_contents
from casr.frame_files.pages import PAGE_KINDS, image_in
from casr.frame_files.trouble import check_exists


def picture_files(paths: Iterable[Path]) -> list[Path]:
    """Each file once, and for a folder the images in it in natural order.

    Raises FramesError for what is not there and for a folder without images.
    """
    found: list[Path] = []
    for path in paths:
        check_exists(path)
        inside = folder_contents(path).pages if path.is_dir() else [path]
        if not inside:
            raise FramesError(
                path, wanted=f"images ({', '.join(PAGE_KINDS)})", found="a folder without images", do="Check the path."
            )
        found += inside
    return list(dict.fromkeys(found))


def read_picture(path: Path) -> NDArray[np.uint8]:
    """(H, W) grey levels 0 to 255, as the camera's chip saw them: a note of the file on which side is up is ignored.

    Raises FramesError when it cannot be read or is no image.
    """
    image, found = image_in(path, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
    if image is None:
        raise FramesError(path, wanted="an image", found=found, do="Leave it out.")
    return image.astype(np.uint8, copy=False)


@dataclass(frozen=True, kw_only=True)
class BoardPictures:
    """What a camera file is made from.

    pictures : files, or folders of them. out : the file to write; with ``overwrite`` it may be there.
    charuco, chessboard : (columns, rows) of the one board. square_mm, marker_mm, dictionary : of `Charuco`.
    depth_mm : from the pinhole to the pins at rest. depth_from : instead, one more picture, with the board there.
    frame_rate_hz : of the presses. distortion : coefficients to fit. SettingError : one of them is missing.
    """

    pictures: Sequence[Path]
    out: Path
    overwrite: bool = False
    charuco: tuple[int, int] | None = None
    chessboard: tuple[int, int] | None = None
    square_mm: float
    marker_mm: float | None = None
    dictionary: str | None = None
    depth_mm: float | None = None
    depth_from: Path | None = None
    frame_rate_hz: float = 20.0
    distortion: int = 5

    def __post_init__(self) -> None:
        depth = self.depth_mm or self.depth_from
        needed = {"PICTURES": self.pictures, "--out": self.out, "--square-mm": self.square_mm}
        for name, value in (needed | {"--depth-mm or --depth-from": depth}).items():
            if not value:
                do = f"Add {name}; casr calibrate --help explains it."
                raise SettingError(name, wanted="a value for a calibration from pictures", found="none", do=do)

    def board(self) -> Board:
        """SettingError : as the board, or what belongs to the other kind is said."""
        if self.charuco is not None:
            if self.marker_mm is None:
                do = "Measure the outer edge of the black border of a marker."
                raise SettingError("--marker-mm", wanted="the size of the markers", found="none", do=do)
            dictionary = (self.dictionary or "4X4_50").upper().removeprefix("DICT_")
            return Charuco(*self.charuco, self.square_mm, self.marker_mm, dictionary)
        for option, value in {"--marker-mm": self.marker_mm, "--dictionary": self.dictionary}.items():
            if value:
                do = "A chessboard has no markers: leave this option out."
                raise SettingError(option, wanted="a ChArUco board", found="a chessboard", do=do)
        assert self.chessboard is not None
        return Chessboard(*self.chessboard, self.square_mm)

    def sensor(self) -> Sensor:
        """What a camera file that is replaced knows of it. CameraError : the file must not be there, or is none."""
        if not self.out.exists():
            return Sensor()
        if not self.overwrite:
            do = "Choose another name, or replace the file with --overwrite."
            raise CameraError(self.out, wanted="a new file", found="an existing file", do=do)
        return read_camera(self.out).sensor


@dataclass(frozen=True, eq=False)
class MeasuredCamera:
    """A camera. fit : where it comes from. left_out : picture to why it was not used."""

    camera: Camera
    fit: Calibration
    left_out: Mapping[str, str]

    def facts(self) -> dict[str, Any]:
        """Facts of the fit that the file tells besides the camera; JSON-ready."""
        of_fit = ("rms_px", "fx_se_px", "fy_se_px", "cx_se_px", "cy_se_px", "covered")
        return {name: getattr(self.fit, name) for name in of_fit} | {
            "pictures_used": len(self.fit.views),
            "pictures": [asdict(view) for view in self.fit.views],
            "left_out": [{"name": name, "reason": reason} for name, reason in self.left_out.items()],
        }

    def to_toml(self) -> str:
        """The camera file; programs that need a camera do not read its table ``[calibration]``."""
        facts = self.facts()
        lists = {key: value for key, value in facts.items() if isinstance(value, list)}
        lines = ["[calibration]", *(f"{key} = {value!r}" for key, value in facts.items() if key not in lists)]
        for key, rows in lists.items():
            for row in rows:
                lines += ["", f"[[calibration.{key}]]", *(f"{name} = {_value(value)}" for name, value in row.items())]
        return f"{self.camera.to_toml()}\n" + "\n".join(lines) + "\n"

    def text(self, name: object) -> str:
        """For people, a fact per line."""
        camera, fit = self.camera, self.fit
        width, height = (f"{size:.4g}" for size in camera.mm_per_px)
        facts = {
            name: f"{getattr(fit, f'{name}_px'):.2f} px, standard error {getattr(fit, f'{name}_se_px'):.2f}"
            for name in ("fx", "fy", "cx", "cy")
        }
        facts["distortion"] = ", ".join(f"{x:.4g}" for x in camera.distortion) or "none"
        facts["depth"] = f"{camera.depth_mm:.4g} mm: a pixel at the pins is {width} x {height} mm"
        facts["left over"] = f"{fit.rms_px:.3f} px rms"
        return "\n".join([
            f"{name}: {camera.width_px} x {camera.height_px} px, from {len(fit.views)} pictures; "
            f"boards cover {fit.covered:.0%} of the image",
            *(f"  {each:<11} {value}" for each, value in facts.items()),
            f"  {'corners':>7} {'rms, px':>8} {'tilt, deg':>9} {'distance, mm':>12}  picture",
            *(f"  {v.corners:>7} {v.rms_px:>8.3f} {v.tilt_deg:>9.1f} {v.distance_mm:>12.1f}  {v.name}"
              for v in fit.views),
        ])  # fmt: skip


def write_camera_file(settings: BoardPictures, say: Callable[[str], object]) -> MeasuredCamera:
    """Write the camera that took the pictures. say : hears what a reader should know, as soon as it is found.

    SettingError : no such board. FramesError : no pictures. CameraError : as `calibrate`; a file that must not be
        replaced; pictures of several sizes; no board in that of the depth.
    """
    board, sensor, at_pins = settings.board(), settings.sensor(), settings.depth_from
    files = picture_files([*settings.pictures, *([at_pins] if at_pins else [])])
    views, left_out, (height_px, width_px) = _views(board, files)
    for name, reason in left_out.items():
        say(f"{name} is left out: {reason}")
    fit = calibrate(views, width_px, height_px, n_distortion=settings.distortion)
    for note in fit.notes:
        say(note)
    depth_mm = settings.depth_mm or _distance_mm(fit, at_pins)
    matrix = (fit.fx_px, fit.fy_px, fit.cx_px, fit.cy_px)
    camera = Camera(width_px, height_px, *matrix, depth_mm, fit.distortion, settings.frame_rate_hz, sensor)
    measured = MeasuredCamera(camera, fit, left_out)
    write_text_atomic(settings.out, measured.to_toml())
    return measured


def _views(board: Board, files: Sequence[Path]) -> tuple[list[View], dict[str, str], tuple[int, int]]:
    """Pictures that show enough of the board; why others do not; (height, width) of all, px."""
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


def _distance_mm(fit: Calibration, picture: Path | None) -> float:
    for view in fit.views:
        if view.name == str(picture):
            return view.distance_mm
    wanted = "a picture that shows the board"
    raise CameraError("--depth-from", wanted=wanted, found=str(picture), do="Take another one.")


def _value(value: object) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
