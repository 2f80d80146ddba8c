"""NumPy's .npy files: (T, H, W) grey or (T, H, W, 3) colour frames, one frame read at a time."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from casr.errors import FramesError
from casr.frame_files.trouble import undecodable, unreadable
from casr.images import Grey, as_grey


def open_file(path: Path) -> NpyFrames:
    return NpyFrames(path)


class NpyFrames:
    """Reads frame by frame from the file; a memory map would count every page it touched as used memory.

    Raises
    ------
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
        n_values = math.prod(self._frame_shape)
        offset = self._start + index * n_values * self._dtype.itemsize
        try:
            values = np.fromfile(self._path, self._dtype, n_values, offset=offset)
        except OSError as error:
            raise unreadable(self._path, error) from error
        if values.size < n_values:
            raise undecodable(self._path, index, f"{values.size} of {n_values} values, then the end of the file")
        return as_grey(values.reshape(self._frame_shape), where=f"{self._path}, frame {index}")


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
            path,
            wanted="frames as a (T, H, W) or (T, H, W, 3) array in C order",
            found=f"shape {shape}, {dtype}, {'Fortran' if by_columns else 'C'} order",
            do="Stack the frames along the first axis and save np.ascontiguousarray of them.",
        )
    return shape, dtype, start
