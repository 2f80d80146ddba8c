"""The tactile camera: intrinsics, distortion and depth, from pixels to millimetres (paper, eqs 4 and 5)."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import isfinite, nan
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import CameraError

_COUNTS = ("width_px", "height_px")
_ABOVE_ZERO = (*_COUNTS, "fx_px", "fy_px", "depth_mm", "frame_rate_hz", "depth_sd_mm")
# cv2 stops after 5 rounds by default, which leaves hundredths of a pixel near the rim
_UNDISTORT_TO_THE_END = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)


@dataclass(frozen=True)
class Sensor:
    """What is known of the sensor before the camera; None where it is not.

    pin_length_mm : from the inner face of the skin to the tip of a pin; pin_length_sd_mm : its standard error.
    dome_radius_mm : outer radius of the dome.
    CameraError : a value of another type, not finite, or not above 0 where it must be.
    """

    pin_length_mm: float | None = None
    dome_radius_mm: float | None = None
    pin_length_sd_mm: float | None = None

    def __post_init__(self) -> None:
        for name, value in self.known().items():
            object.__setattr__(self, name, _number(f"sensor.{name}", value, above_zero=True))

    def known(self) -> dict[str, float]:
        """Names and values of what is set."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True)
class Camera:
    """A pinhole camera looking at the pins from ``depth_mm`` away.

    width_px, height_px : image size. fx_px, fy_px, cx_px, cy_px : the undistorted camera matrix of eq. (4).
    depth_mm : distance from camera to pins, from the depth sensor, used in eq. (5).
    distortion : OpenCV's (k1, k2, p1, p2[, k3, ...]); empty when the frames are already undistorted.
    frame_rate_hz : frames per second. sensor : what lies before the camera, as far as it is known.
    depth_sd_mm : standard error of depth_mm, or None.
    CameraError : a value of another type, not finite, or not above 0 where it must be.
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
    sensor: Sensor = Sensor()
    depth_sd_mm: float | None = None

    def __post_init__(self) -> None:
        for name in KEYS:
            # plain Python numbers, so that cameras compare, print and are written alike
            value = getattr(self, name)
            if name != "distortion" and (name, value) != ("depth_sd_mm", None):
                value = _number(f"camera.{name}", value, name in _ABOVE_ZERO, name in _COUNTS)
                object.__setattr__(self, name, value)
        object.__setattr__(self, "distortion", _coefficients(self.distortion))
        if not isinstance(self.sensor, Sensor):
            raise CameraError(
                "camera.sensor", wanted="a Sensor", found=repr(self.sensor), do="Give casr.camera.Sensor(...)."
            )

    def to_toml(self) -> str:
        """A camera.toml: the table ``[camera]``, and ``[sensor]`` if anything is known of it; reading it gives back
        the very same camera."""
        every = {name: getattr(self, name) for name in KEYS} | {"distortion": list(self.distortion)}
        values = {name: value for name, value in every.items() if value is not None}
        sensor = self.sensor.known()
        return _table("camera", values) + (f"\n{_table('sensor', sensor)}" if sensor else "")

    def sees_like(self, other: Camera | None) -> bool:
        """Whether places in its frames mean the same: all but the rate of the frames."""
        return other is not None and replace(self, frame_rate_hz=other.frame_rate_hz) == other

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

    def undistorted_px(self, points_px: ArrayLike) -> NDArray[np.float64]:
        """(N, 2) points as a distortion-free camera with the same matrix would see them, px; NaN stays NaN. The lens is
        that of OpenCV's manual (calib3d)."""
        points = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        if not self.distortion or points.size == 0:
            return points
        matrix, coefficients = self.matrix, np.array(self.distortion)
        undistorted = cv2.undistortPoints(
            np.ascontiguousarray(points)[:, None, :], matrix, coefficients, P=matrix, criteria=_UNDISTORT_TO_THE_END
        )
        return undistorted[:, 0, :].astype(np.float64)

    def distorted_px(self, points_px: ArrayLike) -> NDArray[np.float64]:
        """(N, 2) where the camera sees points (N, 2) of the undistorted image, px; undoes ``undistorted_px``. The lens
        is that of OpenCV's manual (calib3d)."""
        points = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        if not self.distortion or points.size == 0:
            return points
        centre, focal = (self.cx_px, self.cy_px), (self.fx_px, self.fy_px)
        rays = np.column_stack([(points - centre) / focal, np.ones(len(points))])
        still = np.zeros(3)
        return cv2.projectPoints(rays, still, still, self.matrix, np.array(self.distortion))[0][:, 0].astype(np.float64)


KEYS = tuple(field.name for field in fields(Camera) if field.name != "sensor")
"Keys of the table ``[camera]``."


def _table(name: str, values: dict[str, Any]) -> str:
    return f"[{name}]\n" + "".join(f"{key} = {value!r}\n" for key, value in values.items())


def undistorted(points_px: NDArray[np.float64], camera: Camera | None) -> NDArray[np.float64]:
    """Points (..., 2) px as a camera without distortion would see them; the same without a camera."""
    if camera is None or not camera.distortion:
        return points_px
    return camera.undistorted_px(points_px.reshape(-1, 2)).reshape(points_px.shape)


def distorted(points_px: NDArray[np.float64], camera: Camera | None) -> NDArray[np.float64]:
    """The inverse of ``undistorted``: points (..., 2) px as this camera sees them."""
    if camera is None or not camera.distortion:
        return points_px
    return camera.distorted_px(points_px.reshape(-1, 2)).reshape(points_px.shape)


def _number(name: str, value: object, above_zero: bool, count: bool = False) -> int | float:
    number = _float(value)
    if not isfinite(number) or (above_zero and number <= 0) or (count and not isinstance(value, (int, np.integer))):
        kind = "whole number" if count else "number"
        raise CameraError(
            name, wanted=f"a {kind} above 0" if above_zero else f"a finite {kind}", found=repr(value),
            do="Correct the camera.",
        )  # fmt: skip
    return int(number) if count else number


def _coefficients(values: object) -> tuple[float, ...]:
    numbers = tuple(map(_float, values)) if isinstance(values, (tuple, list, np.ndarray)) else (_float(values),)
    if not all(map(isfinite, numbers)) or len(numbers) not in (0, 4, 5, 8, 12, 14):
        raise CameraError(
            "camera.distortion", wanted="no or 4, 5, 8, 12 or 14 finite coefficients", found=repr(values),
            do="Give OpenCV's coefficients k1, k2, p1, p2, k3, ...",
        )  # fmt: skip
    return numbers


def _float(value: object) -> float:
    """NaN for what is no number."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        return nan
    return float(value)
