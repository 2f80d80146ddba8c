"""Video files (AVI, MP4, Matroska) through OpenCV, read forward and never by seeking."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frame_files.trouble import other_size, undecodable, unreadable
from casr.images import Grey, as_grey

# codecs that give back the grey levels they were given
_LOSSLESS = {"FFV1", "HFYU", "FFVH", "PNG ", "MPNG", "Y800", "GREY", "DIB ", "RGBA", "BGR0", "\0\0\0\0"}


def open_file(path: Path) -> VideoFrames:
    return VideoFrames(path)


class VideoFrames:
    """Frames of a video, decoded one after the other.

    The number of frames is that of the packets in the file, counted without decoding, because a container's own
    count may be wrong. Seeking is exact only for some codecs, so an earlier frame is reached from the start and a
    later one by decoding those between. A packet that does not decode is found by its missing time stamp: reading
    that frame is an error, and the frames after it keep their numbers.

    Raises
    ------
    FramesError : not a video; on reading, a frame that does not decode.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self._path = path
        self._times_ms = _packet_times(path)
        self._open()
        self.notes = self._warnings()
        self._stamped = bool(np.all(np.diff(self._times_ms) > 0))
        self.shape: tuple[int, int] = self.read(0).shape

    def __len__(self) -> int:
        return len(self._times_ms)

    def read(self, index: int) -> Grey:
        if index < self._at or (index == self._at and self._frame is None):
            self._open()
        while self._at < index:
            if not self._capture.grab():
                raise undecodable(self._path, index, f"{self._at + 1} frames that decode before it")
            self._frame = None
            self._at = self._number_of_grabbed()
        if self._at > index:
            raise undecodable(self._path, index, "data that do not decode")
        if self._frame is None:
            decoded, image = self._capture.retrieve()
            if not decoded:
                raise undecodable(self._path, index, "data that do not decode")
            self._frame = as_grey(image, where=f"{self._path}, frame {index}")
        return self._frame

