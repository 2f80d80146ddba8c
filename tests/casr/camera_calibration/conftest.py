"""Pictures of boards before a camera that is known, drawn by casting a ray through every part of a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from casr.camera import Camera

# a short lens with the distortion of a real pin camera's kind
TRUE = Camera(
    width_px=320, height_px=240, fx_px=262.0, fy_px=266.0, cx_px=164.3, cy_px=115.8, depth_mm=50.0,
    distortion=(-0.28, 0.09, 0.001, -0.0008, 0.0),
)  # fmt: skip
PX_PER_MM = 16
_PARTS = 4
"Rays a pixel, each way."


@dataclass(frozen=True)
class Drawing:
    """A board as printed: grey levels, and width and height."""

    grey: np.ndarray
    size_mm: tuple[float, float]


class Studio:
    """A camera, and pictures that it takes of a drawing."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        width, height = camera.width_px * _PARTS, camera.height_px * _PARTS
        u, v = np.meshgrid((np.arange(width) + 0.5) / _PARTS - 0.5, (np.arange(height) + 0.5) / _PARTS - 0.5)
        straight = camera.undistorted_px(np.column_stack([u.ravel(), v.ravel()]))
        self._rays = np.linalg.solve(camera.matrix, np.column_stack([straight, np.ones(len(straight))]).T)
        self._shape = height, width

    @staticmethod
    def chessboard(columns: int, rows: int, square_mm: float) -> Drawing:
        """Columns and rows of squares, the first one black, on white."""
        y, x = np.mgrid[: rows * square_mm * PX_PER_MM, : columns * square_mm * PX_PER_MM] // (square_mm * PX_PER_MM)
        return Drawing(np.where((x + y) % 2, 255, 0).astype(np.uint8), (columns * square_mm, rows * square_mm))

    @staticmethod
    def charuco(columns: int, rows: int, square_mm: float, marker_mm: float, *, legacy: bool = False) -> Drawing:
        """Columns and rows of squares, by OpenCV, with markers of 4X4_50."""
        markers = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        board = cv2.aruco.CharucoBoard((columns, rows), square_mm, marker_mm, markers)
        board.setLegacyPattern(legacy)
        size_px = int(columns * square_mm * PX_PER_MM), int(rows * square_mm * PX_PER_MM)
        return Drawing(board.generateImage(size_px, marginSize=0), (columns * square_mm, rows * square_mm))

    def picture(
        self, drawing: Drawing, turn: np.ndarray, middle_mm: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        """(H, W) uint8 with blur and noise; the middle of the board is at ``middle_mm`` before the camera."""
        rotation = cv2.Rodrigues(np.asarray(turn, dtype=float))[0]
        corner_mm = middle_mm - rotation[:, :2] @ (np.array(drawing.size_mm) / 2)
        on_board = np.linalg.solve(np.column_stack([rotation[:, :2], corner_mm]), self._rays)
        at_px = (on_board[:2] / on_board[2] * PX_PER_MM - 0.5).astype(np.float32).reshape(2, *self._shape)
        fine = cv2.remap(drawing.grey, *at_px, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=255)
        seen = cv2.resize(fine, (self.camera.width_px, self.camera.height_px), interpolation=cv2.INTER_AREA)
        dimmed = cv2.GaussianBlur(0.7 * seen.astype(float) + 30, (0, 0), 0.6)
        return np.clip(np.rint(dimmed + rng.normal(0, 2, dimmed.shape)), 0, 255).astype(np.uint8)

    def pictures(
        self,
        drawing: Drawing,
        count: int,
        seed: int,
        *,
        distance_mm: float = 42.0,
        reach: float = 0.5,
        tilt_deg=(12, 32),
    ) -> list[np.ndarray]:
        """Of poses drawn at random; ``reach`` is how far from the middle of the image the board goes, of its half."""
        rng = np.random.default_rng(seed)
        taken = []
        for _ in range(count):
            way, tilt = rng.uniform(0, 2 * np.pi), np.deg2rad(rng.uniform(*tilt_deg))
            z = distance_mm * rng.uniform(0.9, 1.1)
            half_mm = z * np.array([160 / self.camera.fx_px, 120 / self.camera.fy_px])
            middle_mm = np.array([*(rng.uniform(-reach, reach, 2) * half_mm), z])
            turn = tilt * np.array([np.cos(way), np.sin(way), 0.0])
            taken.append(self.picture(drawing, turn, middle_mm, rng))
        return taken


@pytest.fixture(scope="session")
def studio() -> Studio:
    return Studio(TRUE)
