"""Multi-page TIFF and BigTIFF: tifffile for what it decodes by itself, OpenCV for the other compressions."""

from __future__ import annotations

import logging
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tifffile
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frame_files.trouble import OneSize, undecodable, unreadable
from casr.images import Grey, as_grey

Decode = Callable[[int], NDArray[Any]]
# pages decoded in one call: OpenCV walks the file from its first page every time
_BLOCK = 32


def open_file(path: Path) -> TiffFrames:
    """The frames of a file. FramesError : it cannot be read, or is no TIFF."""
    complaints = _Complaints()
    tifffile.logger().addHandler(complaints)
    try:
        file = tifffile.TiffFile(path)
        n_pages = len(file.pages)
    except OSError as error:
        raise unreadable(path, error) from error
    except (tifffile.TiffFileError, ValueError, KeyError) as error:
        raise FramesError(path, wanted="a TIFF file", found=str(error), do="Check the file.") from error
    finally:
        tifffile.logger().removeHandler(complaints)
    return TiffFrames(path, file, n_pages, tuple(complaints.said))


class _Complaints(logging.Handler):
    """What tifffile finds wrong with a file that it reads on."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append(f"the file is damaged or incomplete: {record.getMessage()}")


class TiffFrames(OneSize):
    """Pages of one TIFF file, counted without decoding, read where they lie, one at a time.

    The file stays open as long as this object lives. A file that tifffile cannot decode without further packages
    (LZW, JPEG, palettes, separate colour planes) is decoded by OpenCV.
    """

    def __init__(self, path: Path, file: tifffile.TiffFile, n_pages: int, notes: tuple[str, ...]) -> None:
        self.name, self.notes = path.stem, notes
        weakref.finalize(self, file.close)
        n_frames, self._decode = _hidden_stack(path, file) or (n_pages, _decoder(path, file, n_pages))
        super().__init__(path, n_frames)

    def _decoded(self, index: int) -> Grey:
        try:
            pixels = self._decode(index)
        except Exception as error:  # a damaged page fails anywhere in a decoder, in any way
            raise undecodable(self._path, index, str(error) or type(error).__name__) from error
        return as_grey(pixels, where=f"{self._path}, frame {index}")


def _decoder(path: Path, file: tifffile.TiffFile, n_pages: int) -> Decode:
    by_tifffile = _TifffilePages(file)
    try:
        by_tifffile(0)
    except Exception:  # the error that counts is OpenCV's, on reading
        return _OpenCvPages(path, n_pages)
    return by_tifffile


class _TifffilePages:
    """(H, W) or (H, W, 3) BGR pixels of a page."""

    def __init__(self, file: tifffile.TiffFile) -> None:
        self._pages = file.pages

    def __call__(self, index: int) -> NDArray[Any]:
        page = self._pages[index].aspage()
        pixels = page.asarray()
        if page.photometric == tifffile.PHOTOMETRIC.MINISBLACK and pixels.ndim == 2:
            return pixels
        if page.photometric == tifffile.PHOTOMETRIC.RGB and pixels.ndim == 3 and pixels.shape[2] in (3, 4):
            return pixels[:, :, 2::-1]
        raise ValueError(f"pages of {page.photometric!s} pixels with shape {pixels.shape}")


class _OpenCvPages:
    """(H, W) or (H, W, 3) BGR pixels of a page that needs OpenCV's decoders; keeps one block of pages."""

    def __init__(self, path: Path, n_pages: int) -> None:
        self._path, self._n = path, n_pages
        self._first, self._block = 0, []  # type: int, list[NDArray[Any]]

    def __call__(self, index: int) -> NDArray[Any]:
        if not self._first <= index < self._first + len(self._block):
            self._first, self._block = index, self._pages(index, min(_BLOCK, self._n - index))
        if not self._block:
            # one damaged page spoils its whole block
            self._block = self._pages(index, 1)
        if not self._block:
            raise ValueError("data that neither tifffile nor OpenCV decodes")
        return self._block[index - self._first]

    def _pages(self, first: int, count: int) -> list[NDArray[Any]]:
        _, pages = cv2.imreadmulti(str(self._path), start=first, count=count, flags=cv2.IMREAD_UNCHANGED)
        return list(pages)


def _hidden_stack(path: Path, file: tifffile.TiffFile) -> tuple[int, Decode] | None:
    """Number and decoder of frames that lie behind a single page, as ImageJ writes stacks beyond 4 GiB."""
    series = file.series[0] if len(file.pages) == 1 and (file.is_imagej or file.is_shaped) else None
    if series is None or series.ndim != 3 or series.axes.endswith("S") or series.dataoffset is None:
        return None
    n_frames, height_px, width_px = series.shape
    start, dtype = series.dataoffset, np.dtype(file.byteorder + series.dtype.char)

    def decode(index: int) -> NDArray[Any]:
        n_values = height_px * width_px
        values = np.fromfile(path, dtype, n_values, offset=start + index * n_values * dtype.itemsize)
        return values.reshape(height_px, width_px)

    return n_frames, decode
