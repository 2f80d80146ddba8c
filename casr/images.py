"""What every algorithm here takes for an image: one grey channel, C-contiguous, grey levels 0 to 255."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import ImageError

Grey = NDArray[np.uint8] | NDArray[np.float32]


def as_grey(image: NDArray[Any], *, where: object = "image") -> Grey:
    """One grey channel in grey levels 0 to 255, C-contiguous; the image itself when it already is that.

    image : (H, W), (H, W, 1), (H, W, 3) or (H, W, 4) array, colour in OpenCV's BGR order, alpha ignored.
        uint8 stays uint8; bool becomes 0 and 255; uint16 is divided by 257 and floats are taken as grey levels
        already, both as float32.
    where : named in errors.
    ImageError : no pixels, another number of dimensions or another type, NaN, infinity or beyond single precision.
    """
    image = np.asarray(image)
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] not in (1, 3, 4)) or image.size == 0:
        raise ImageError(
            where, wanted="a grey (H, W) or colour (H, W, 3) image", found=f"an array of shape {image.shape}",
            do="Give one frame at a time.",
        )  # fmt: skip
    pixels = _grey_levels(image, where)
    if pixels.ndim == 3:
        pixels = _one_channel(pixels)
    return np.ascontiguousarray(pixels)


def _grey_levels(image: NDArray[Any], where: object) -> NDArray[Any]:
    # kind and width, not the dtype itself: big-endian files give '>u2' and '>f4'
    kind = image.dtype.kind, image.dtype.itemsize
    if kind == ("u", 1):
        return image
    if kind[0] == "b":
        return image.astype(np.uint8) * np.uint8(255)
    if kind == ("u", 2):
        return image.astype(np.float32) / np.float32(257.0)
    if kind[0] == "f":
        return _finite(image, where)
    raise ImageError(
        where, wanted="uint8, uint16, bool or float grey levels", found=f"type {image.dtype}",
        do="Convert the frames to 8 or 16 bits.",
    )  # fmt: skip


def _finite(image: NDArray[Any], where: object) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        pixels = image.astype(np.float32, copy=False)
    finite = np.isfinite(pixels)
    if not finite.all():
        raise ImageError(
            where, wanted="finite grey levels",
            found=f"{finite.size - int(np.count_nonzero(finite))} of {finite.size} values NaN or infinite",
            do="Repair or drop this frame.",
        )  # fmt: skip
    return pixels


def _one_channel(pixels: NDArray[Any]) -> NDArray[Any]:
    if pixels.shape[2] == 1:
        return pixels[:, :, 0]
    code = cv2.COLOR_BGR2GRAY if pixels.shape[2] == 3 else cv2.COLOR_BGRA2GRAY
    return cv2.cvtColor(np.ascontiguousarray(pixels), code)
