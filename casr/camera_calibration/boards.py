"""Boards for calibration and how their corners are found in a picture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError

Corners = tuple[NDArray[np.float32], NDArray[np.float32]]
"(N, 3) on the board, mm, and (N, 2) in the picture, px."

DICTIONARIES = tuple(
    f"{bits}X{bits}_{count}" for bits in (4, 5, 6, 7) for count in (50, 100, 250, 1000)
)  # as cv2.aruco names them, after DICT_
_REFINED_TO_THE_END = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-4)


class Board(Protocol):
    """A flat board. ``n_corners`` : that a picture of the whole board shows."""

    @property
    def n_corners(self) -> int: ...

    def find(self, picture: NDArray[np.uint8]) -> Corners:
        """The corners that a grey picture (H, W) shows; none where it shows no board."""
        ...


@dataclass(frozen=True)
class Chessboard:
    """A chessboard, found as a whole only.

    columns, rows : inner corners, where four squares meet: a board of 8 x 6 squares has 7 x 5.
    square_mm : side of a square. SettingError : fewer than 3 corners a way, or no size.
    """

    columns: int
    rows: int
    square_mm: float

    def __post_init__(self) -> None:
        _check_grid("--chessboard", "inner corners", self.columns, self.rows)
        _check_size("--square-mm", self.square_mm)

    @property
    def n_corners(self) -> int:
        return self.columns * self.rows

    def find(self, picture: NDArray[np.uint8]) -> Corners:
        """Corners on the board (N, 3) mm and in an 8-bit grey picture (H, W), (N, 2) px; none where one is hidden.

        By cv2.findChessboardCornersSB (Duda and Frese 2018).
        """
        flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
        there, found = cv2.findChessboardCornersSB(picture, (self.columns, self.rows), flags=flags)
        if not there:
            return _NOTHING
        seen_px = found.reshape(self.rows, self.columns, 2).astype(np.float32)
        steps = [np.linalg.norm(np.diff(seen_px, axis=axis), axis=-1).min() for axis in (0, 1)]
        # the window must hold no other corner; a saddle fitted to more pixels is less drawn to the pixel raster
        half = min(int(0.35 * min(steps)), 9)
        if half >= 3:
            cv2.cornerSubPix(picture, seen_px.reshape(-1, 1, 2), (half, half), (-1, -1), _REFINED_TO_THE_END)
        y, x = np.mgrid[: self.rows, : self.columns].reshape(2, -1) * self.square_mm
        return np.column_stack([x, y, np.zeros(x.size)]).astype(np.float32), seen_px.reshape(-1, 2)


@dataclass(frozen=True)
class Charuco:
    """A chessboard with a marker in every white square, which may be seen in part.

    columns, rows : squares. square_mm, marker_mm : sides of a square and of the black border of a marker.
    dictionary : of the markers, one of ``DICTIONARIES``.
    SettingError : too few squares, sizes that do not fit, an unknown dictionary or one with too few markers.
    """

    columns: int
    rows: int
    square_mm: float
    marker_mm: float
    dictionary: str = "4X4_50"

    def __post_init__(self) -> None:
        _check_grid("--charuco", "squares", self.columns, self.rows)
        _check_size("--square-mm", self.square_mm)
        _check_size("--marker-mm", self.marker_mm)
        if self.marker_mm >= self.square_mm:
            raise SettingError(
                "--marker-mm", wanted=f"less than the square, {self.square_mm:g} mm", found=f"{self.marker_mm:g} mm",
                do="Measure the black border of a marker and the side of a square.",
            )  # fmt: skip
        if self.dictionary not in DICTIONARIES:
            raise SettingError(
                "--dictionary", wanted=f"one of {', '.join(DICTIONARIES)}", found=repr(self.dictionary),
                do="Take the one that the board was made with.",
            )  # fmt: skip
        markers = self.columns * self.rows // 2
        if markers > int(self.dictionary.partition("_")[2]):
            raise SettingError(
                "--dictionary", wanted=f"at least {markers} markers, for {self.columns} x {self.rows} squares",
                found=self.dictionary, do="Take the one that the board was made with.",
            )  # fmt: skip

    @property
    def n_corners(self) -> int:
        return (self.columns - 1) * (self.rows - 1)

    def find(self, picture: NDArray[np.uint8]) -> Corners:
        """Corners on the board (N, 3) mm and in an 8-bit grey picture (H, W), (N, 2) px: those that are seen.

        By OpenCV's ArUco (Garrido-Jurado et al. 2014).
        """
        for board, detector in self._detectors:
            found, ids, _, _ = detector.detectBoard(picture)
            if ids is not None and len(ids):
                on_board = np.asarray(board.getChessboardCorners(), dtype=np.float32)
                return on_board[ids.ravel()], np.asarray(found, dtype=np.float32).reshape(-1, 2)
        return _NOTHING

    @cached_property
    def _detectors(self) -> list[tuple[Any, Any]]:
        """Today's pattern, and that of OpenCV before 4.6, which begins with a marker where rows are even."""
        made = []
        for legacy in (False, True):
            markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{self.dictionary}"))
            board = cv2.aruco.CharucoBoard((self.columns, self.rows), self.square_mm, self.marker_mm, markers)
            board.setLegacyPattern(legacy)
            made.append((board, cv2.aruco.CharucoDetector(board)))
        return made


_NOTHING: Corners = (np.empty((0, 3), dtype=np.float32), np.empty((0, 2), dtype=np.float32))


def _check_grid(option: str, what: str, columns: int, rows: int) -> None:
    if min(columns, rows) < 3 or max(columns, rows) > 100:
        raise SettingError(
            option, wanted=f"3 to 100 {what} each way", found=f"{columns}x{rows}", do=f"Count the {what} of the board."
        )


def _check_size(option: str, size_mm: float) -> None:
    if not (isfinite(size_mm) and size_mm > 0):
        raise SettingError(option, wanted="a length above 0 mm", found=f"{size_mm:g}", do="Measure the board.")
