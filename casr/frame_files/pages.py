"""A folder with one image file for each frame."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np

from casr.errors import FramesError
from casr.frame_files.trouble import other_size, undecodable, unreadable
from casr.images import Grey, as_grey

# OpenCV keeps still about broken images: our errors name the file and the frame
if "OPENCV_LOG_LEVEL" not in os.environ:
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)

# suffix -> kind; a folder holds frames of one kind
PAGE_KINDS = {
    ".png": "PNG",
    ".bmp": "BMP",
    ".jpg": "JPEG",
    ".jpeg": "JPEG",
    ".tif": "TIFF",
    ".tiff": "TIFF",
}


class PageFrames:
    """Image files of one folder, in the order given, decoded when asked for.

    Raises
    ------
    FramesError : files of different kinds; on reading, a file that is no image or has another size.
    """

    def __init__(self, files: list[Path]) -> None:
        kinds = sorted({PAGE_KINDS[file.suffix.lower()] for file in files})
        if len(kinds) > 1:
            raise FramesError(
                files[0].parent,
                wanted="frames of one kind",
                found=" and ".join(kinds),
                do="Move the images that are not frames to another folder.",
            )
        self.name = files[0].parent.name
        self.notes: tuple[str, ...] = (
            ("JPEG frames carry compression errors of some grey levels",) if kinds == ["JPEG"] else ()
        )
        self._folder = files[0].parent
        self._names = [file.name for file in files]
        self.shape: tuple[int, int] = _decode(self._folder / self._names[0], 0).shape

    def __len__(self) -> int:
        return len(self._names)

    def read(self, index: int) -> Grey:
        file = self._folder / self._names[index]
        frame = _decode(file, index)
        if frame.shape != self.shape:
            raise other_size(file, index, frame.shape, self.shape)
        return frame


def _decode(file: Path, index: int) -> Grey:
    try:
        data = file.read_bytes()
    except OSError as error:
        raise unreadable(file, error) from error
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None:
        raise undecodable(file, index, f"{len(data)} bytes that do not decode" if data else "an empty file")
    return as_grey(image, where=f"{file}, frame {index}")
