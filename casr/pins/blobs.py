"""Bright blobs of a frame: what stands out from its surroundings, with area, bounding box and brightness."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.images import Grey

WAIST = 0.65  # where pins touch, the blob is narrower than this share of their width


@dataclass(frozen=True)
class Blobs:
    """(n,) blobs: box (n, 4) x, y, width, height; area px; mean grey level; its mean excess over the surroundings."""

    box: NDArray[np.int32]
    area_px: NDArray[np.int32]
    brightness: NDArray[np.float64]
    excess: NDArray[np.float64]
    centres_px: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.area_px)

    def pick(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Blobs:
        """The blobs of these rows."""
        return Blobs(*(getattr(self, field.name)[rows] for field in fields(self)))


def above_surroundings(image: Grey, block_px: int, contrast: float) -> tuple[Grey, NDArray[np.uint8]]:
    """Grey levels above the mean of the ``block_px`` square around each pixel, and mask of those above ``contrast``."""
    excess = cast(Grey, cv2.subtract(image, cv2.blur(image, (block_px, block_px))))
    return excess, _over(excess, contrast)


def find_blobs(image: Grey, excess: Grey, mask: NDArray[np.uint8]) -> Blobs:
    """Connected pieces (8 neighbours) of ``mask`` that do not touch the border of the image."""
    n, labels, stats, centres = cv2.connectedComponentsWithStatsWithAlgorithm(mask, 8, cv2.CV_32S, cv2.CCL_GRANA)
    pixels = np.flatnonzero(mask.ravel().view(np.bool_))
    label = labels.ravel()[pixels]
    box, area = cast(NDArray[np.int32], stats[:, :4]), cast(NDArray[np.int32], stats[:, cv2.CC_STAT_AREA])
    brightness, over = (np.bincount(label, grey.ravel()[pixels], minlength=n) / area for grey in (image, excess))
    height, width = mask.shape
    inside = (box[:, :2] > 0).all(axis=1) & (box[:, 0] + box[:, 2] < width) & (box[:, 1] + box[:, 3] < height)
    inside[0] = False
    return Blobs(box, area, brightness, over, cast(NDArray[np.float64], centres)).pick(inside)


def round_parts(mask: NDArray[np.uint8], box: NDArray[np.int32]) -> NDArray[np.float64]:
    """Centres (k, 2) of the round parts of the blob in ``box``: 1 for a single pin, more for pins that touch."""
    x, y, width, height = (int(v) for v in box)
    piece = np.pad(mask[y : y + height, x : x + width], 1)
    depth = cv2.distanceTransform(piece, cv2.DIST_L2, 5)
    cores = _over(depth, WAIST * float(depth.max()))
    n, _, _, centres = cv2.connectedComponentsWithStats(cores, connectivity=8)
    parts: NDArray[np.float64] = np.asarray(centres, np.float64)[1:n] + np.array([x - 1.0, y - 1.0])
    return parts


def _over(values: NDArray[Any], level: float) -> NDArray[np.uint8]:
    """255 where the values exceed the level, else 0."""
    return cast(NDArray[np.uint8], cv2.compare(values, level, cv2.CMP_GT))  # type: ignore[call-overload]
