"""Names of the dictionaries of ChArUco boards."""

from __future__ import annotations

import cv2

from casr.camera_calibration.boards import DICTIONARIES


def test_they_are_all_square_ones_of_opencv() -> None:
    known = {
        name.removeprefix("DICT_")
        for name in dir(cv2.aruco)
        if name.startswith(("DICT_4", "DICT_5", "DICT_6", "DICT_7"))
    }
    assert set(DICTIONARIES) == known
    assert len(DICTIONARIES) == 16
