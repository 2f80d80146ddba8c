"""The corners of a board as one picture shows them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class View:
    """A picture in which the board was found.

    Parameters
    ----------
    name : of the picture, as messages say it.
    board_mm : (N, 3) float32, corners on the board, z = 0.
    image_px : (N, 2) float32, the same corners in the picture; the centre of the first pixel is (0, 0).
    """

    name: str
    board_mm: NDArray[np.float32]
    image_px: NDArray[np.float32]

    def hull_px(self) -> NDArray[np.float32]:
        """(K, 2) convex outline of the corners in the picture."""
        hull: NDArray[np.float32] = cv2.convexHull(self.image_px)[:, 0, :].astype(np.float32)
        return hull


LEAST_CORNERS = 8
"In a view; fewer hardly tell its pose."


def unusable(view: View, n_corners: int) -> str | None:
    """Why the view says too little; None when it does not. n_corners : of the whole board."""
    seen = len(view.image_px)
    if seen == 0:
        return "it shows no board"
    if seen < LEAST_CORNERS:
        return f"it shows {seen} of {n_corners} corners, fewer than {LEAST_CORNERS}"
    spread = np.linalg.svd(view.board_mm[:, :2] - view.board_mm[:, :2].mean(axis=0), compute_uv=False)
    return "its corners lie on one line" if spread[1] < 1e-3 * spread[0] else None


def covered(views: list[View], width_px: int, height_px: int) -> float:
    """Part of the image, 0 to 1, that lies inside the corners of at least one view."""
    mask = np.zeros((height_px, width_px), dtype=np.uint8)
    for view in views:
        cv2.fillConvexPoly(mask, np.rint(view.hull_px()).astype(np.int32), 1)
    return float(mask.mean())
