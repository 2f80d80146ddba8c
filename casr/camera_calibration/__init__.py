"""Intrinsics and distortion of a camera from pictures of a flat board whose corners are known."""

from casr.camera_calibration.boards import DICTIONARIES, Board, Charuco, Chessboard
from casr.camera_calibration.intrinsics import Calibration, Fitted, View, calibrate, unusable

__all__ = ["DICTIONARIES", "Board", "Calibration", "Charuco", "Chessboard", "Fitted", "View", "calibrate", "unusable"]
