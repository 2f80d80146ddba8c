"""Multi-page TIFF written page by page, readable at any moment.

tifffile either keeps the directories of a series until the file is closed, or links a page before it is written; a
program that is killed leaves one page, or a broken chain. Here a page is written first, pixels and directory in one
piece, and only then linked by changing the one offset that ends the chain.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import SEEK_END
from pathlib import Path
from struct import Struct
from struct import error as StructError
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import DeviceError
from emg2vsa.rig.append_file import AppendFile

_SHORT, _LONG = 3, 4
_WIDTH, _HEIGHT, _BITS, _COMPRESSION, _PHOTOMETRIC = 256, 257, 258, 259, 262
_STRIP_OFFSETS, _SAMPLES, _ROWS_PER_STRIP, _STRIP_BYTES = 273, 277, 278, 279
_NO_COMPRESSION = _BLACK_IS_ZERO = 1
_N_ENTRIES = 9


@dataclass(frozen=True)
class _Format:
    """Little-endian TIFF 6.0, or BigTIFF with 64-bit offsets."""

    header: bytes
    count: Struct
    entry: Struct
    offset: Struct
    offset_type: int
    largest_bytes: int

    @property
    def start(self) -> int:
        """Where the first page begins."""
        return len(self.header) + self.offset.size

    def page_bytes(self, pixels: int) -> int:
        """Length of a page, its directory included."""
        return pixels + pixels % 2 + self.count.size + _N_ENTRIES * self.entry.size + self.offset.size


_CLASSIC = _Format(b"II*\0", Struct("<H"), Struct("<HHII"), Struct("<I"), _LONG, 2**32 - 1)
_BIG = _Format(b"II+\0\x08\0\0\0", Struct("<Q"), Struct("<HHQQ"), Struct("<Q"), 16, 2**63 - 1)


class TiffPages:
    """A new TIFF of uncompressed 8-bit grey pages of one size.

    Parameters
    ----------
    path : the file, which must not be there.
    shape : (height, width), px.
    big : as BigTIFF, for more than 4 GiB.

    Raises
    ------
    DeviceError : the file is there or cannot be made.
    """

    def __init__(self, path: Path, shape: tuple[int, int], *, big: bool = False) -> None:
        self.n_pages = 0
        self._shape = shape
        self._format = _BIG if big else _CLASSIC
        self._file = AppendFile(path)
        self._link_at = len(self._format.header)
        self._file.append(self._format.header + self._format.offset.pack(0))

    def append(self, image: NDArray[np.uint8]) -> None:
        """Add a page. Raises DeviceError when the disk is full, 4 GiB are reached or the image has another size."""
        if image.shape != self._shape or image.dtype != np.uint8:
            raise DeviceError(
                self._file.path,
                wanted=f"grey images of 8 bits and {self._shape[1]} x {self._shape[0]} px",
                found=f"{image.dtype} of shape {image.shape}",
                do="Set the camera to one size.",
            )
        start = self._file.size_bytes
        pixels = image.tobytes() + bytes(image.size % 2)
        directory_at = start + len(pixels)
        directory = self._directory(start)
        if directory_at + len(directory) > self._format.largest_bytes:
            raise DeviceError(
                self._file.path, wanted="less than 4 GiB", found="a full TIFF", do="Record as BigTIFF, or in parts."
            )
        self._file.append(pixels + directory)
        self._file.patch(self._link_at, self._format.offset.pack(directory_at))
        self._link_at = self._file.size_bytes - self._format.offset.size
        self.n_pages += 1

    def close(self) -> None:
        """Give the file back; it is complete at any time."""
        self._file.close()

    def _directory(self, pixels_at: int) -> bytes:
        height, width = self._shape
        form = self._format
        entries = [
            (_WIDTH, _LONG, width),
            (_HEIGHT, _LONG, height),
            (_BITS, _SHORT, 8),
            (_COMPRESSION, _SHORT, _NO_COMPRESSION),
            (_PHOTOMETRIC, _SHORT, _BLACK_IS_ZERO),
            (_STRIP_OFFSETS, form.offset_type, pixels_at),
            (_SAMPLES, _SHORT, 1),
            (_ROWS_PER_STRIP, _LONG, height),
            (_STRIP_BYTES, _LONG, height * width),
        ]
        # little-endian: a short number stands at the start of its field, as it must
        rows = b"".join(form.entry.pack(tag, kind, 1, value) for tag, kind, value in entries)
        return form.count.pack(len(entries)) + rows + form.offset.pack(0)


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
    head = file.read(_BIG.start)
    form = _BIG if head.startswith(_BIG.header) else _CLASSIC
    if not head.startswith(form.header):
        raise ValueError("another file")
    (directory_at,) = form.offset.unpack_from(head, len(form.header))
    if directory_at == 0:
        return None
    file.seek(directory_at + form.count.size)
    (*_, width), (*_, height) = form.entry.iter_unpack(file.read(2 * form.entry.size))
    page_bytes = form.page_bytes(width * height)
    n_pages = (file.seek(0, SEEK_END) - form.start) // page_bytes
    file.seek(form.start + (n_pages - 1) * page_bytes)
    return np.frombuffer(file.read(width * height), dtype=np.uint8).reshape(height, width)
