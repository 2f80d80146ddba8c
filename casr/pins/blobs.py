"""Bright blobs of a frame: what stands out from its surroundings, with area, bounding box and brightness."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.images import Grey


@dataclass(frozen=True)
class Blobs:
    """(n,) blobs: bounding box (n, 4) x, y, width, height; area px; contrast = mean grey levels above the surroundings."""

    box: NDArray[np.int32]
    area_px: NDArray[np.int32]
    contrast: NDArray[np.float64]
    centres_px: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.area_px)

    def pick(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Blobs:
        """The blobs of these rows."""
        return Blobs(self.box[rows], self.area_px[rows], self.contrast[rows], self.centres_px[rows])


def above_surroundings(image: Grey, block_px: int, contrast: float) -> tuple[Grey, NDArray[np.uint8]]:
    """Grey levels above the mean of the ``block_px`` square around each pixel, and the mask of those above ``contrast``."""
    excess = cv2.subtract(image, cv2.blur(image, (block_px, block_px)))
    mask = cv2.compare(excess, contrast, cv2.CMP_GT)
    return excess, mask  # type: ignore[return-value]


def find_blobs(excess: Grey, mask: NDArray[np.uint8]) -> Blobs:
    """Connected pieces (8 neighbours) of ``mask`` that do not touch the border of the image."""
    n, labels, stats, centres = cv2.connectedComponentsWithStatsWithAlgorithm(mask, 8, cv2.CV_32S, cv2.CCL_GRANA)
    pixels = np.flatnonzero(mask.ravel().view(np.bool_))
    total = np.bincount(labels.ravel()[pixels], excess.ravel()[pixels], minlength=n)
    box, area = stats[:, :4], stats[:, cv2.CC_STAT_AREA]
    height, width = mask.shape
    inside = (box[:, :2] > 0).all(axis=1) & (box[:, 0] + box[:, 2] < width) & (box[:, 1] + box[:, 3] < height)
    inside[0] = False
    return Blobs(box, area, total / np.maximum(area, 1), centres).pick(inside)


def round_parts(mask: NDArray[np.uint8], box: NDArray[np.int32]) -> NDArray[np.float64]:
    """Centres (k, 2) of the round parts of the blob in ``box``: 1 for a single pin, more for pins that touch."""
    x, y, width, height = (int(v) for v in box)
    piece = np.pad(mask[y : y + height, x : x + width], 1)
    depth = cv2.distanceTransform(piece, cv2.DIST_L2, 5)
    cores = cv2.compare(depth, 0.65 * float(depth.max()), cv2.CMP_GT)
    n, _, _, centres = cv2.connectedComponentsWithStats(cores, connectivity=8)
    return np.asarray(centres[1:n]) + (x - 1.0, y - 1.0)
