"""One press on disk as it happens: frames.tif and force.csv, as `casr.frame_files.open_frames` reads them.

The TIFF is written page by page, and is readable at any moment. tifffile either keeps the directories of a series until
the file is closed, or links a page before it is written; a program that is killed leaves one page, or a broken chain.
Here a page is written first, pixels and directory in one piece, and only then linked by changing the one offset that
ends the chain.
"""

from __future__ import annotations

from os import SEEK_END
from pathlib import Path
from struct import Struct
from struct import error as StructError
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.device_settings import LARGEST_PRESS_BYTES
from emg2vsa.durable.append_file import AppendFile
from emg2vsa.durable.writer import AT_ONCE, Writer
from emg2vsa.errors import DeviceError

_SHORT, _LONG = 3, 4
_WIDTH, _HEIGHT, _BITS, _COMPRESSION, _PHOTOMETRIC = 256, 257, 258, 259, 262
_STRIP_OFFSETS, _SAMPLES, _ROWS_PER_STRIP, _STRIP_BYTES = 273, 277, 278, 279
_NO_COMPRESSION = _BLACK_IS_ZERO = 1
_N_ENTRIES = 9
_HEADER = b"II*\0"
"""TIFF 6.0, little-endian."""
_COUNT, _ENTRY, _OFFSET = Struct("<H"), Struct("<HHII"), Struct("<I")
_START = len(_HEADER) + _OFFSET.size
"""Where the first page begins."""


class TiffPages:
    """A new TIFF of uncompressed 8-bit grey pages of one size.

    Parameters
    ----------
    path : the file, which must not be there.
    shape : (height, width), px.

    Raises
    ------
    DeviceError : the file is there or cannot be made.
    """

    def __init__(self, path: Path, shape: tuple[int, int], writer: Writer = AT_ONCE) -> None:
        self.n_pages = 0
        self._shape = shape
        self._file = AppendFile(path, writer)
        self._link_at = len(_HEADER)
        self._file.append(_HEADER + _OFFSET.pack(0))

    def append(self, image: NDArray[np.uint8]) -> None:
        """Add a page (H, W). Raises DeviceError when the disk is full, 4 GiB are reached or the image has another
        size."""
        if image.shape != self._shape or image.dtype != np.uint8:
            wanted = f"grey images of 8 bits and {self._shape[1]} x {self._shape[0]} px"
            found, do = f"{image.dtype} of shape {image.shape}", "Set the camera to one size."
            raise DeviceError(self._file.path, wanted=wanted, found=found, do=do)
        start = self._file.size_bytes
        pixels = image.tobytes() + bytes(image.size % 2)
        directory_at = start + len(pixels)
        directory = self._directory(start)
        if directory_at + len(directory) > LARGEST_PRESS_BYTES:
            do = "Choose smaller frames, or fewer."
            raise DeviceError(self._file.path, wanted="less than 4 GiB", found="a full TIFF", do=do)
        self._file.append(pixels + directory)
        self._file.patch(self._link_at, _OFFSET.pack(directory_at))
        self._link_at = self._file.size_bytes - _OFFSET.size
        self.n_pages += 1

    def close(self) -> None:
        """Give the file back; it is complete at any time."""
        self._file.close()

    def _directory(self, pixels_at: int) -> bytes:
        height, width = self._shape
        entries = [
            (_WIDTH, _LONG, width),
            (_HEIGHT, _LONG, height),
            (_BITS, _SHORT, 8),
            (_COMPRESSION, _SHORT, _NO_COMPRESSION),
            (_PHOTOMETRIC, _SHORT, _BLACK_IS_ZERO),
            (_STRIP_OFFSETS, _LONG, pixels_at),
            (_SAMPLES, _SHORT, 1),
            (_ROWS_PER_STRIP, _LONG, height),
            (_STRIP_BYTES, _LONG, height * width),
        ]
        # little-endian: a short number stands at the start of its field, as it must
        rows = b"".join(_ENTRY.pack(tag, kind, 1, value) for tag, kind, value in entries)
        return _COUNT.pack(len(entries)) + rows + _OFFSET.pack(0)


def newest_page(path: Path) -> NDArray[np.uint8] | None:
    """(H, W) grey levels of the newest page of a file of `TiffPages` that may be growing; None before the first.

    All pages have one length, so the place of the newest follows from that of the file, however many there are.
    DeviceError when the file cannot be read or is another's.
    """
    try:
        with path.open("rb") as file:
            return _newest(file)
    except (OSError, ValueError, StructError) as error:
        do = "Choose the frames.tif of a press."
        raise DeviceError(path, wanted="a TIFF of the rig", found=str(error), do=do) from error


def _newest(file: BinaryIO) -> NDArray[np.uint8] | None:
    head = file.read(_START)
    if not head.startswith(_HEADER):
        raise ValueError("another file")
    (directory_at,) = _OFFSET.unpack_from(head, len(_HEADER))
    if directory_at == 0:
        return None
    file.seek(directory_at + _COUNT.size)
    (*_, width), (*_, height) = _ENTRY.iter_unpack(file.read(2 * _ENTRY.size))
    pixels = width * height
    page_bytes = pixels + pixels % 2 + _COUNT.size + _N_ENTRIES * _ENTRY.size + _OFFSET.size
    n_pages = (file.seek(0, SEEK_END) - _START) // page_bytes
    file.seek(_START + (n_pages - 1) * page_bytes)
    return np.frombuffer(file.read(pixels), dtype=np.uint8).reshape(height, width)


class PressRecorder:
    """Writes a press; readable at any moment, also after the program was killed.

    A frame is on disk before the first force row that carries its index.

    Parameters
    ----------
    folder : made when missing; must hold no press.
    shape : (height, width) of the frames, px.

    Raises
    ------
    DeviceError : there is a press already, or no place to write.
    """

    def __init__(self, folder: Path, shape: tuple[int, int], writer: Writer = AT_ONCE) -> None:
        self._force = AppendFile(folder / "force.csv", writer)
        self._force.append(b"time_s,force_n,frame_index,frame_time_s\n")
        self._frame_time = ""
        self._frames = TiffPages(folder / "frames.tif", shape, writer)

    @property
    def n_frames(self) -> int:
        """Frames saved."""
        return self._frames.n_pages

    def frame(self, image: NDArray[np.uint8], time_s: float) -> int:
        """Save a frame (H, W) taken at ``time_s``, s; its index, from 0. Raises DeviceError, as `force`, when the disk
        is full."""
        self._frames.append(image)
        self._frame_time = f"{time_s:.6f}"
        return self.n_frames - 1

    def force(self, time_s: float, force_n: float) -> None:
        """Save the force, N, of a time, s, with index and time of the last frame saved, -1 and none before the
        first."""
        self._force.append(f"{time_s:.6f},{force_n:.6f},{self.n_frames - 1},{self._frame_time}\n".encode())

    def remark(self, text: str) -> None:
        """A comment at the end of the forces, which goes with the press wherever it is taken."""
        self._force.append(f"# {text}\n".encode())

    def close(self) -> None:
        """Give the files back."""
        self._frames.close()
        self._force.close()
