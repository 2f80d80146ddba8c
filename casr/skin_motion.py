"""How far the pins are from rest, frame by frame: what tells whether frames move with the force at all."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.pins import PinSettings, PinTracker

KEPT_FRAMES = 64
"Pins are kept of so many frames, around first contact; of all others one number is."


class SkinMotion:
    """Follows all pins from a frame at rest on.

    Parameters
    ----------
    settings : of the pins.

    Attributes
    ----------
    frames : indices taken, the first at rest. moved_px : of each, the mean distance of the pins seen from where they
        are in the first; NaN where none is. same : of each, whether the image is that of the frame before it.
    kept_px : (N, 2) pins of each of the first 64 frames, NaN where lost.
    rest_px : (N, 2) pins of the first frame. away_px : (n,) how far each pin seen in the last frame is from there,
        knocks of the camera taken off.
    """

    def __init__(self, settings: PinSettings | None = None) -> None:
        self._tracker = PinTracker(settings)
        self._last: NDArray[Any] | None = None
        self.frames, self.moved_px, self.same = array("q"), array("d"), array("b")
        self.kept_px: list[NDArray[np.float64]] = []

    def take(self, index: int, image: NDArray[Any]) -> None:
        """The next frame. Raises PinsError when the first shows too few pins; later such frames have no motion."""
        if self._last is None:
            self.rest_px = now_px = self._tracker.start(image).centroids_px
        else:
            now_px = self._step(image)
        away_px = np.hypot(*(now_px - self._tracker.knock_px - self.rest_px).T)
        self.away_px = away_px[np.isfinite(away_px)]
        self.frames.append(index)
        self.moved_px.append(float(self.away_px.mean()) if self.away_px.size else float("nan"))
        self.same.append(self._last is not None and np.array_equal(self._last, image))
        if len(self.kept_px) < KEPT_FRAMES:
            self.kept_px.append(now_px)
        self._last = np.array(image)  # a camera may write its next frame into the same memory

    def _step(self, image: NDArray[Any]) -> NDArray[np.float64]:
        try:
            return self._tracker.step(image)
        except PinsError:
            return np.full_like(self.rest_px, np.nan)
