"""A contact's growth by patches of Lucas and Kanade, and its first area from the pins that have moved."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np

WINDOW = (15, 15)


def growth(frames: list[np.ndarray], places: np.ndarray) -> float:
    """ln of the ratio of areas over frames (h, w): the pins at ``places`` (n, 2; x, y) are followed from frame to
    frame, and each step's affine map is fitted to those that moved alike."""
    grown, here = 0.0, np.ascontiguousarray(places, dtype=np.float32)
    for before, now in pairwise(frames):
        there, held, _ = cv2.calcOpticalFlowPyrLK(before, now, here, np.empty_like(here), winSize=WINDOW, maxLevel=2)
        kept = held[:, 0] == 1
        table = np.column_stack((here[kept], np.ones(np.count_nonzero(kept))))
        moved = there[kept] - here[kept]
        affine = np.linalg.lstsq(table, moved, rcond=None)[0]
        off = np.abs(moved - table @ affine).max(axis=1)
        calm = off <= 3 * np.median(off) + 1e-3
        affine = np.linalg.lstsq(table[calm], moved[calm], rcond=None)[0]
        grown += float(np.log(np.linalg.det(np.eye(2) + affine[:2])))
        here = there[kept]
    return grown


def first_area(rest: np.ndarray, contact: np.ndarray, moved_px: float) -> float:
    """px^2 of the ellipse through the pins (n, 2) that moved: its axes from their second moments, as of a filled one,
    and a ring of half a pitch around the outermost."""
    size = np.linalg.norm(contact - rest, axis=1)
    inside = contact[size > max(moved_px, size.max() / 2)]
    if len(inside) < 3:
        return 0.0
    axes = 2 * np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(inside.T)), 0.0))
    near = np.sort(np.linalg.norm(rest[:, None] - rest[None], axis=2), axis=1)[:, 1]
    return float(np.pi * np.prod(axes + np.median(near) / 2))
