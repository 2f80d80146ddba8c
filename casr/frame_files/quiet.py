"""OpenCV and its FFmpeg keep still about broken frames: our errors name the file and the frame."""

from __future__ import annotations

import os

import cv2


def silence_opencv() -> None:
    """No lines of theirs on stderr, unless OPENCV_LOG_LEVEL or OPENCV_FFMPEG_LOGLEVEL asks for some."""
    if "OPENCV_LOG_LEVEL" not in os.environ:
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # AV_LOG_QUIET, read with the first video
