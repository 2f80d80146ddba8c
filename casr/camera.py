"""The tactile camera: intrinsics, distortion and depth, from pixels to millimetres (paper, eqs 4 and 5)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import CameraError


@dataclass(frozen=True)
class Camera:
    """A pinhole camera looking at the pins from ``depth_mm`` away.

    Parameters
    ----------
    width_px, height_px : image size.
    fx_px, fy_px, cx_px, cy_px : the undistorted camera matrix of eq. (4).
    depth_mm : distance from camera to pins, from the depth sensor, used in eq. (5).
    distortion : OpenCV's (k1, k2, p1, p2[, k3, ...]); empty when the frames are already undistorted.
    frame_rate_hz : frames per second.
    """

    width_px: int = 300
    height_px: int = 300
    fx_px: float = 300.0
    fy_px: float = 300.0
    cx_px: float = 149.5
    cy_px: float = 149.5
    depth_mm: float = 50.0
    distortion: tuple[float, ...] = ()
    frame_rate_hz: float = 20.0

    def __post_init__(self) -> None:
        for key in ("width_px", "height_px", "fx_px", "fy_px", "depth_mm", "frame_rate_hz"):
            value = getattr(self, key)
            if not (np.isfinite(value) and value > 0):
                raise CameraError(
                    f"camera.{key}", wanted="a number above 0", found=repr(value), do="Correct the camera."
                )
        if len(self.distortion) not in (0, 4, 5, 8, 12, 14) or not np.isfinite(self.distortion).all():
            raise CameraError(
                "camera.distortion",
                wanted="no or 4, 5, 8, 12 or 14 finite coefficients",
                found=repr(self.distortion),
                do="Give OpenCV's coefficients k1, k2, p1, p2, k3, ...",
            )

    @property
    def matrix(self) -> NDArray[np.float64]:
        """(3, 3) camera matrix, eq. (4), px."""
        return np.array([[self.fx_px, 0, self.cx_px], [0, self.fy_px, self.cy_px], [0, 0, 1]], dtype=np.float64)

    @property
    def mm_per_px(self) -> tuple[float, float]:
        """Size of a pixel at the pins along x and y, mm, eq. (5)."""
        return self.depth_mm / self.fx_px, self.depth_mm / self.fy_px

    @property
    def mm2_per_px2(self) -> float:
        """Area of a pixel at the pins, mm^2."""
        x_mm, y_mm = self.mm_per_px
        return x_mm * y_mm

    def undistorted_px(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 2) points as a distortion-free camera with the same matrix would see them, px."""
        points_px = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        if not self.distortion or points_px.size == 0:
            return points_px
        matrix = self.matrix
        undistorted = cv2.undistortPoints(points_px[:, None, :], matrix, np.array(self.distortion), P=matrix)
        return undistorted[:, 0, :].astype(np.float64)

    def to_mm(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 2) undistorted points from the principal point in the plane of the pins, mm, eq. (5)."""
        return (np.asarray(points_px, dtype=np.float64) - (self.cx_px, self.cy_px)) * self.mm_per_px
