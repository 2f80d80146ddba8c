"""TIFF pages that need OpenCV's decoders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
from numpy.typing import NDArray

# pages decoded in one call: OpenCV walks the file from its first page every time
BLOCK = 32


class OpenCvPages:
    """(H, W) or (H, W, 3) BGR pixels of a page; keeps one block of pages."""

    def __init__(self, path: Path, n_pages: int) -> None:
        self._path, self._n = path, n_pages
        self._first, self._block = 0, []  # type: int, list[NDArray[Any]]

    def __call__(self, index: int) -> NDArray[Any]:
        if not self._first <= index < self._first + len(self._block):
            self._first, self._block = index, self._pages(index, min(BLOCK, self._n - index))
        if not self._block:
            # one damaged page spoils its whole block
            self._block = self._pages(index, 1)
        if not self._block:
            raise ValueError("data that neither tifffile nor OpenCV decodes")
        return self._block[index - self._first]

    def _pages(self, first: int, count: int) -> list[NDArray[Any]]:
        _, pages = cv2.imreadmulti(str(self._path), start=first, count=count, flags=cv2.IMREAD_UNCHANGED)
        return list(pages)
