"""Single pictures that are no frames of a press, such as those for a calibration."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frame_files.folder import folder_contents
from casr.frame_files.pages import PAGE_KINDS
from casr.frame_files.trouble import check_exists, unreadable


def picture_files(paths: Iterable[Path]) -> list[Path]:
    """Each file once, and for a folder the images in it in natural order.

    Raises FramesError for what is not there and for a folder without images.
    """
    found: list[Path] = []
    for path in paths:
        check_exists(path)
        inside = folder_contents(path).pages if path.is_dir() else [path]
        if not inside:
            raise FramesError(
                path, wanted=f"images ({', '.join(PAGE_KINDS)})", found="a folder without images", do="Check the path."
            )
        found += inside
    return list(dict.fromkeys(found))


def read_picture(path: Path) -> NDArray[np.uint8]:
    """(H, W) grey levels 0 to 255, as the camera's chip saw them: a note of the file on which side is up is ignored.

    Raises FramesError when it cannot be read or is no image.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise unreadable(path, error) from error
    how = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    image = cv2.imdecode(np.frombuffer(data, np.uint8), how) if data else None
    if image is None:
        raise FramesError(
            path, wanted="an image", found=f"{len(data)} bytes that do not decode" if data else "an empty file",
            do="Leave it out.",
        )  # fmt: skip
    return image.astype(np.uint8, copy=False)
