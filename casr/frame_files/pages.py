"""Frames in a folder of image files, one each, or in one .npy file of (T, H, W) grey or (T, H, W, 3) colour values."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frame_files.trouble import OneSize, undecodable, unreadable
from casr.images import Grey, as_grey


def silence_opencv() -> None:
    """OpenCV prints nothing by itself: our errors say what is wrong."""
    levels: Any = getattr(cv2.utils, "logging", cv2)  # before 4.13 they were in the package itself
    levels.setLogLevel(0)


if "OPENCV_LOG_LEVEL" not in os.environ:
    silence_opencv()

# suffix -> kind; a folder holds frames of one kind
PAGE_KINDS = {".png": "PNG", ".bmp": "BMP", ".jpg": "JPEG", ".jpeg": "JPEG", ".tif": "TIFF", ".tiff": "TIFF"}


class PageFrames(OneSize):
    """Image files of one folder, in the order given. FramesError : files of different kinds, too."""

    def __init__(self, files: list[Path]) -> None:
        kinds = sorted({PAGE_KINDS[file.suffix.lower()] for file in files})
        if len(kinds) > 1:
            raise FramesError(
                files[0].parent, wanted="frames of one kind", found=" and ".join(kinds),
                do="Move the images that are not frames to another folder.",
            )  # fmt: skip
        self.name = files[0].parent.name
        self.notes = ("JPEG frames carry compression errors of some grey levels",) if kinds == ["JPEG"] else ()
        self._names = [file.name for file in files]
        super().__init__(files[0].parent, len(files))

    def _file(self, index: int) -> Path:
        return self._path / self._names[index]

    def _decoded(self, index: int) -> Grey:
        image, found = image_in(self._file(index), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise undecodable(self._file(index), index, found)
        return as_grey(image, where=f"{self._file(index)}, frame {index}")


def image_in(file: Path, how: int) -> tuple[NDArray[Any] | None, str]:
    """Pixels (H, W) or (H, W, 3) by ``cv2.imdecode``; None where the file is no image, and what it is then.

    FramesError : unreadable.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise unreadable(file, error) from error
    image = cv2.imdecode(np.frombuffer(data, np.uint8), how) if data else None
    return image, f"{len(data)} bytes that do not decode" if data else "an empty file"


class NpyFrames:
    """Reads frame by frame from the file; a memory map would count every page it touched as used memory.

    FramesError : not an .npy file of frames in C order; on reading, a file that ends before the frame does.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self._path = path
        stack, self._dtype, self._start = _header(path)
        self._frame_shape = stack[1:]
        self._n = stack[0]
        self.shape: tuple[int, int] = stack[1], stack[2]
        self.notes = ("colour frames are taken as blue, green, red",) if len(stack) == 4 else ()

    def __len__(self) -> int:
        return self._n

    def read(self, index: int) -> Grey:
        """Frame of this index. FramesError : the file cannot be read, or ends before the frame does."""
        n_values = math.prod(self._frame_shape)
        offset = self._start + index * n_values * self._dtype.itemsize
        try:
            values = np.fromfile(self._path, self._dtype, n_values, offset=offset)
        except OSError as error:
            raise unreadable(self._path, error) from error
        if values.size < n_values:
            raise undecodable(self._path, index, f"{values.size} of {n_values} values, then the end of the file")
        return as_grey(values.reshape(self._frame_shape), where=f"{self._path}, frame {index}")


open_file = NpyFrames


def _header(path: Path) -> tuple[tuple[int, ...], np.dtype[np.generic], int]:
    """Shape, type and offset of the first value."""
    try:
        with path.open("rb") as file:
            version = np.lib.format.read_magic(file)
            read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            shape, by_columns, dtype = read(file)
            start = file.tell()
    except OSError as error:
        raise unreadable(path, error) from error
    except ValueError as error:
        raise FramesError(
            path, wanted="an .npy file", found=str(error), do="Save the frames with numpy.save."
        ) from error
    a_colour_image = len(shape) == 3 and shape[2] <= 4
    if len(shape) not in (3, 4) or a_colour_image or by_columns or dtype.hasobject or 0 in shape:
        raise FramesError(
            path, wanted="frames as a (T, H, W) or (T, H, W, 3) array in C order",
            found=f"shape {shape}, {dtype}, {'Fortran' if by_columns else 'C'} order",
            do="Stack the frames along the first axis and save np.ascontiguousarray of them.",
        )  # fmt: skip
    return shape, dtype, start
