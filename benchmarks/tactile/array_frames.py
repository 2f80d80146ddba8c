"""A frame source in memory, so that reading costs nothing while scoring is timed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.images import Grey, as_grey


class ArrayFrames:
    """Frames held in memory: a (T, H, W) array, or (T, H, W, 3) in BGR order, of any type `as_grey` takes.

    Raises
    ------
    FramesError : another number of dimensions.
    """

    def __init__(self, frames: NDArray[Any], *, name: str = "frames") -> None:
        frames = np.asarray(frames)
        if frames.ndim not in (3, 4):
            raise FramesError(
                name,
                wanted="frames as a (T, H, W) or (T, H, W, 3) array",
                found=f"shape {frames.shape}",
                do="Stack the frames along the first axis.",
            )
        self.name = name
        self._frames = frames

    @property
    def shape(self) -> tuple[int, int]:
        return int(self._frames.shape[1]), int(self._frames.shape[2])

    def __len__(self) -> int:
        return len(self._frames)

    def read(self, index: int) -> Grey:
        return as_grey(self._frames[index], where=f"{self.name}, frame {index}")
